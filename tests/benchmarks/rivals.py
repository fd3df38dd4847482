"""The hand-on-knob grid by other means: error and time of SciPy, NumPy and MuJoCo beside the exact engine.

    python tests/benchmarks/rivals.py [--quick]

Every rival runs trials of 0.6 s of model time in the cells of the 7 x 7 grid, under both biases (0.001 N m, and half a
quantum), with floor encoder and wall applied at each sample. All start from the exact state at the first sample.
SciPy and MuJoCo run one phase a cell, NumPy many at once. SciPy is slow, so it runs in nine of the cells (464, 1000,
2154 Hz x 256, 1024, 4096 counts); --quick takes those cells for all.

Peak-to-peak here is highest less lowest extremum of the last 0.2 s, longer than any orbit of the grid; the extrema are
taken from the states at the samples by the plant's closed form, the same for every rival and in its favour: what is
shown is the error of propagation alone. It is the relative difference from that certified orbit of the cell (found from
1, 64 and 1024 phases) whose peak-to-peak is closest. "lost" counts trials off every known orbit by more than 5 %;
"other", where one phase is run, those that end closest to another orbit than the exact trial from the same start.

Times are processor time of one thread, for the run with the set-up of a cell (matrices, MuJoCo model), without start-up
and extrema. The engine's are for the whole search, proofs included, and the measures; its samples/s are as if it had
run 0.6 s, which it cuts short. "x engine" is time per trial over the engine's at 64 phases in the same cells. "cells"
counts a cell once for each bias.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import inf

import mujoco
import numpy as np
from hand_on_knob import BIASES, COUNTS, RATES_HZ, START_RAD, Array, Cell, make_cell
from record import put
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.jit import compiled
from hknob_cli.measure.orbit import Measurer

TRIAL_S, WINDOW_S = 0.6, 0.2
PHASES = (1, 64, 1024)  # that the engine is asked for
KEPT = {
    "NumPy, exact matrices, 64 phases": "NumPy",
    "SciPy DOP853, 1e-10/1e-13": "SciPy",
    "MuJoCo RK4, 16 a sample": "MuJoCo",
}  # of the record
REPEATS = 3  # of what is quick; the least time counts
SCIPY_CELLS = {(RATES_HZ[i], counts) for i in (2, 3, 4) for counts in (256, 1024, 4096)}
LOST = 0.05
SAME_ORBIT = 1e-9
BLAS_THREADS = "OPENBLAS_NUM_THREADS"


@dataclass(frozen=True, kw_only=True)
class Rival:
    """A way to run trials of a cell: states (2, phases) in, those of the last samples (n, 2, phases) out."""

    name: str
    run: Callable[[Cell, Array], Array]
    phases: int = 1
    everywhere: bool = True
    repeats: int = 1


def window(cell: Cell) -> int:
    """Number of states that the last part of a trial has."""
    return round(WINDOW_S / cell.period) + 1


def trial_samples(cell: Cell) -> int:
    """Samples of a trial."""
    return round(TRIAL_S / cell.period)


def run_scipy(cell: Cell, start: Array, *, method: str, rtol: float, atol: float, whole_step: bool) -> Array:
    """``solve_ivp`` from sample to sample; ``whole_step`` spares it the search for a first step."""
    state = start[:, 0]
    states = [state]
    first = cell.period if whole_step else None
    for _ in range(trial_samples(cell)):
        u = cell.torque(state[0])

        def slope(_t: float, y: Array, u: float = u) -> list[float]:
            return [y[1], (u - cell.b * y[1] - cell.k * y[0]) / cell.j]

        solution = solve_ivp(slope, (0.0, cell.period), state, method=method, rtol=rtol, atol=atol, first_step=first)
        state = solution.y[:, -1]
        states.append(state)
    return np.array(states[-window(cell) :])[:, :, None]


def run_numpy(cell: Cell, start: Array) -> Array:
    """All phases at once by the transition matrix over one sample."""
    generator = np.zeros((3, 3))
    generator[0, 1] = 1.0
    generator[1] = -cell.k / cell.j, -cell.b / cell.j, 1.0 / cell.j
    step = expm(generator * cell.period)
    phi, gamma = step[:2, :2], step[:2, 2:]
    state = start
    states = np.empty((window(cell), *start.shape))
    keep_from = trial_samples(cell) + 1 - len(states)
    for i in range(trial_samples(cell) + 1):
        if i >= keep_from:
            states[i - keep_from] = state
        level = np.minimum(np.floor(state[0] / cell.quantum), 0.0)
        state = phi @ state + gamma * (-cell.wall * cell.quantum * level - cell.g)
    return states


def run_mujoco(cell: Cell, start: Array, *, integrator: str, substeps: int) -> Array:
    """One hinge with stiffness and damping, a motor commanded at each sample, ``substeps`` steps in between."""
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco>
        <option timestep="{cell.period / substeps!r}" integrator="{integrator}">
            <flag gravity="disable" contact="disable" constraint="disable"/>
        </option>
        <worldbody><body>
            <inertial pos="0 0 0" mass="1e-3" diaginertia="{cell.j!r} {cell.j!r} {cell.j!r}"/>
            <joint name="knob" type="hinge" axis="0 0 1" damping="{cell.b!r}" stiffness="{cell.k!r}"/>
        </body></worldbody>
        <actuator><motor joint="knob"/></actuator>
        </mujoco>"""
    )
    data = mujoco.MjData(model)
    angle, velocity, command = data.qpos, data.qvel, data.ctrl
    angle[0], velocity[0] = start[:, 0]
    states = [(angle[0], velocity[0])]
    for _ in range(trial_samples(cell)):
        command[0] = cell.torque(angle[0])
        mujoco.mj_step(model, data, substeps)
        states.append((angle[0], velocity[0]))
    return np.array(states[-window(cell) :])[:, :, None]


def peak_to_peak(cell: Cell, states: Array) -> Array:
    """Highest less lowest extremum of each trial, rad; infinite where it never turned. In closed form."""
    theta, omega = states[:-1, 0], states[:-1, 1]
    level = np.minimum(np.floor(theta / cell.quantum), 0.0)
    a = 0.5 * cell.b / cell.j
    w = np.sqrt(cell.k / cell.j - a * a)
    y = (-cell.wall * cell.quantum * level - cell.g - cell.k * theta) / cell.j
    rate = (y - a * omega) / w
    turns = (omega > 0.0) != (states[1:, 1] > 0.0)
    t = np.where(turns, np.arctan2(np.abs(omega), -np.sign(omega) * rate), 0.0) / w
    size = np.exp(-a * t) * np.hypot(omega, rate) * w
    extremum = theta + (y + np.copysign(size, omega)) * cell.j / cell.k
    highest = np.where(turns & (omega > 0.0), extremum, -inf).max(axis=0)
    lowest = np.where(turns & (omega <= 0.0), extremum, inf).min(axis=0)
    return np.abs(highest - lowest)


def run_engine(cell: Cell, phases: int, engine: Engine) -> Array:
    """The engine's whole job in a cell: peak-to-peak of its orbits, most frequent first."""
    x = cell.knob.position(START_RAD)
    found = engine.search(cell.knob.loop, x=x, v=0.0, phases=phases, delay_line=0, max_samples=None)
    measurer = Measurer(cell.knob, engine)
    measures = [measurer.measure(one) for one in found.attractors]
    assert all(one.certified for one in found.attractors)
    return np.array([one.max_rad - one.min_rad for one in measures])


def contenders(quick: bool) -> Iterator[Rival]:
    """All rivals, from the dissertation's to the best setting found of each."""
    for phases in (64, 1024):
        yield Rival(name=f"NumPy, exact matrices, {phases} phases", run=run_numpy, phases=phases, repeats=REPEATS)
    settings = [("RK23", 1e-3, 1e-6, False), ("RK23", 1e-6, 1e-9, False), ("RK23", 1e-9, 1e-12, False)]
    settings += [("DOP853", 1e-10, 1e-13, False), ("DOP853", 1e-10, 1e-13, True)]
    for method, rtol, atol, whole_step in settings:
        if quick and rtol < 1e-6 and method == "RK23":
            continue
        run = partial(run_scipy, method=method, rtol=rtol, atol=atol, whole_step=whole_step)
        name = f"SciPy {method}, {rtol:.0e}/{atol:.0e}{', first step T' if whole_step else ''}"
        yield Rival(name=name, run=run, everywhere=False)
    for integrator, counts in (("Euler", (1, 16, 128)), ("implicitfast", (1, 16)), ("RK4", (1, 4, 16))):
        for substeps in counts:
            run = partial(run_mujoco, integrator=integrator, substeps=substeps)
            yield Rival(name=f"MuJoCo {integrator}, {substeps} a sample", run=run)


def timed(job: Callable[[], Array], repeats: int) -> tuple[float, Array]:
    """Least seconds of ``repeats`` runs, and the result."""
    seconds = inf
    for _ in range(repeats):
        began = time.process_time()
        result = job()
        seconds = min(seconds, time.process_time() - began)
    return seconds, result


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="The grid by SciPy, NumPy and MuJoCo beside the exact engine.")
    parser.add_argument("--quick", action="store_true", help="nine cells only, slowest setting left out")
    quick = parser.parse_args().quick
    if os.environ.get(BLAS_THREADS) != "1":  # after `expm`, idle threads spin for a while, and NumPy runs at half speed
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, BLAS_THREADS: "1"})
    grid = [(rate_hz, counts) for rate_hz in RATES_HZ for counts in COUNTS]
    keys = [(*key, which) for key in grid if not quick or key in SCIPY_CELLS for which in range(len(BIASES))]
    cells = {key: make_cell(key[0], key[1], BIASES[key[2]]) for key in keys}
    engine = Engine(compiled())
    exact: dict[int, dict[tuple[float, int, int], tuple[float, Array]]] = {}
    for phases in PHASES:
        run_engine(cells[keys[0]], phases, engine)
        exact[phases] = {key: timed(partial(run_engine, cells[key], phases, engine), REPEATS) for key in keys}
    known = {key: np.concatenate([exact[phases][key][1] for phases in PHASES]) for key in keys}

    print(f"{'':42} cells trials  median    worst  lost other  s/trial  samples/s  x engine")

    def line(name: str, on: list[tuple[float, int, int]], phases: int, seconds: float, shown: str) -> None:
        trials = phases * len(on)
        samples = phases * sum(trial_samples(cells[key]) for key in on)
        base = sum(exact[64][key][0] for key in on) / 64 / len(on)
        each = seconds / trials
        print(f"{name:42} {len(on):5d} {trials:6d} {shown:30} {each:9.2e} {samples / seconds:9.2e} {each / base:9.1f}")
        if name in KEPT:
            put(KEPT[name], each / base)

    nine = [key for key in keys if key[:2] in SCIPY_CELLS]
    for on in (keys,) if quick else (keys, nine):
        for phases in PHASES:
            seconds = sum(exact[phases][key][0] for key in on)
            line(f"engine, {phases} phase{'s' if phases > 1 else ''}", on, phases, seconds, "  proven")
    for rival in contenders(quick):
        on = keys if rival.everywhere else nine
        seconds, errors, other = 0.0, [], 0
        for key in on:
            took, states = timed(partial(rival.run, cells[key], cells[key].starts(rival.phases)), rival.repeats)
            seconds += took
            p2p = peak_to_peak(cells[key], states)
            off = np.abs(p2p[:, None] / known[key] - 1.0)
            errors += list(off.min(axis=1))
            nearest = known[key][off.argmin(axis=1)]
            other += int(np.sum(np.abs(nearest / exact[1][key][1][0] - 1.0) > SAME_ORBIT))
        shown = f"{np.median(errors):8.1e} {max(errors):8.1e} {np.sum(np.array(errors) > LOST):5d}"
        line(rival.name, on, rival.phases, seconds, f"{shown} {other if rival.phases == 1 else '-':>5}")


if __name__ == "__main__":
    main()


# Results, 2026-11-21, 2-core AMD EPYC (Zen 4) virtual machine, Python 3.11 (NumPy 2.4, SciPy 1.17, MuJoCo 4.0)
#
#                                            cells trials  median    worst  lost other  s/trial  samples/s  x engine
# engine, 1 phase                               98     98   proven                        2.44e-04  6.52e+06      22.0
# engine, 64 phases                             98   6272   proven                        1.11e-05  1.44e+08       1.0
# engine, 1024 phases                           98 100352   proven                        4.34e-06  3.67e+08       0.4
# engine, 1 phase                               18     18   proven                        2.21e-04  3.28e+06      26.2
# engine, 64 phases                             18   1152   proven                        8.42e-06  8.60e+07       1.0
# engine, 1024 phases                           18  18432   proven                        1.79e-06  4.04e+08       0.2
# NumPy, exact matrices, 64 phases              98   6272  5.8e-14  2.1e-03     0     -   1.22e-04  1.30e+07      11.0
# NumPy, exact matrices, 1024 phases            98 100352  5.9e-14  2.1e-03     0     -   1.29e-05  1.23e+08       1.2
# SciPy RK23, 1e-03/1e-06                       18     18  5.1e-05  7.5e-04     0     0   5.81e-02  1.25e+04    6903.1
# SciPy RK23, 1e-06/1e-09                       18     18  4.5e-07  1.5e-06     0     0   1.42e-01  5.09e+03   16901.7
# SciPy RK23, 1e-09/1e-12                       18     18  4.6e-10  4.4e-09     0     0   1.01e+00  7.16e+02  120050.9
# SciPy DOP853, 1e-10/1e-13                     18     18  6.0e-13  5.9e-09     0     0   7.84e-02  9.24e+03    9307.4
# SciPy DOP853, 1e-10/1e-13, first step T       18     18  6.3e-13  5.9e-09     0     0   6.38e-02  1.13e+04    7578.4
# MuJoCo Euler, 1 a sample                      98     98  5.7e-01  9.4e-01    91    38   4.37e-03  3.65e+05     393.9
# MuJoCo Euler, 16 a sample                     98     98  4.4e-03  6.2e-01    10    17   3.34e-02  4.77e+04    3012.9
# MuJoCo Euler, 128 a sample                    98     98  2.4e-04  3.9e-03     0     3   2.50e-01  6.37e+03   22525.6
# MuJoCo implicitfast, 1 a sample               98     98  5.7e-01  9.4e-01    91    38   4.56e-03  3.49e+05     411.0
# MuJoCo implicitfast, 16 a sample              98     98  4.4e-03  6.2e-01    10    17   3.52e-02  4.52e+04    3177.0
# MuJoCo RK4, 1 a sample                        98     98  3.1e-06  1.0e+00     5     2   9.56e-03  1.67e+05     862.2
# MuJoCo RK4, 4 a sample                        98     98  1.3e-08  1.5e-04     0     0   3.02e-02  5.27e+04    2724.8
# MuJoCo RK4, 16 a sample                       98     98  5.8e-11  6.6e-06     0     0   1.13e-01  1.41e+04   10201.4
#
# The worst errors of NumPy and DOP853 are transients not over after 0.6 s: after 1.2 s NumPy's 100352 trials are all
# within 3e-14 of a certified orbit. MuJoCo's semi-implicit integrators (equal here: joint damping is implicit in both)
# are of first order; RK4 at one step a sample is lost at 100 Hz only.
