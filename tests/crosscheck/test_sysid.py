"""`hknob sysid` against SciPy on the same Parquet file: prepared, simulated and fitted by hand.

SciPy's side shares nothing: pandas reads, the mean of the trials is cut here, `solve_ivp` moves J a + B v + K x =
T - T_c sign(v) with stick, from event to event, and `least_squares` fits with differences for derivatives.
"""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from hknob_cli.apparatus.experiment import Schedule, record_experiments
from hknob_cli.apparatus.hand_recording import Rig
from hknob_cli.recordings.files import table

BEFORE, AFTER, REST = 20, 300, 200  # samples at 10 kHz: 2 ms before the onset, 30 ms after it, 20 ms of rest
RELATIVE, ABSOLUTE, STEP = 1e-11, 1e-14, 1e-3
SPEC = "kind: sysid\nname: same\nrecordings: [same.parquet]\nestimators: [{}]\n"
COLUMNS = ("inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad", "coulomb_nm")
SIZES = np.array([2e-6, 5e-4, 0.1, 5e-4, 1e-4])  # of the four, and of the rest angle


def mean_trial(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time s, torque N m and angle rad of the mean of all trials in a file, aligned at the onset and from rest."""
    cuts = []
    for _, trial in pd.read_parquet(path).groupby("trial"):
        torque, angle = trial["torque_nm"].to_numpy(), trial["angle_rad"].to_numpy()
        onset = int(np.flatnonzero(torque)[0])
        kept = slice(onset - BEFORE, onset + AFTER + 1)
        cuts.append((torque[kept], angle[kept] - angle[max(onset - REST, 0) : onset + 1].mean()))
    torque, angle = np.mean(cuts, axis=0)
    return 1e-4 * np.arange(-BEFORE, AFTER + 1), torque, angle


def moved(hand: np.ndarray, times: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Angle (n,) rad at ``times`` of inertia, damping, stiffness, friction, at rest while there is no torque yet."""
    inertia, damping, stiffness, friction = hand
    found, state, way = np.zeros(len(times)), np.zeros(2), 0.0
    edges = [*np.flatnonzero(np.diff(torque)) + 1, len(times) - 1]
    for first, last in pairwise(edges):
        at, push, end = times[first], torque[first], times[last]
        while at < end:
            net = push - stiffness * state[0]
            if way == 0.0:
                if abs(net) <= friction:
                    found[(times > at) & (times <= end)] = state[0]
                    break
                way = float(np.sign(net))
            inside = times[(times > at) & (times <= end)]
            turn = lambda _, y, way=way: y[1] * way if friction else 1.0  # noqa: E731
            turn.terminal, turn.direction = True, -1.0
            rate = lambda _, y, push=push, way=way: (  # noqa: E731
                y[1],
                (push - friction * way - damping * y[1] - stiffness * y[0]) / inertia,
            )
            done = solve_ivp(
                rate, (at, end), state, "DOP853", np.append(inside, [] if inside[-1] == end else end),
                events=turn, rtol=RELATIVE, atol=ABSOLUTE,
            )  # fmt: skip
            reached = len(done.t) if done.status == 0 else int(np.sum(inside <= done.t_events[0][0]))
            if reached:
                found[np.searchsorted(times, inside[:reached])] = done.y[0, :reached]
            if done.status == 0:
                at, state = end, done.y[:, -1]
            else:
                at, state, way = done.t_events[0][0], np.array([done.y_events[0][0][0], 0.0]), 0.0
    return found


@pytest.mark.parametrize(("grip", "friction"), [(0.71, False), (14.2, True)])
def test_scipy_finds_the_same_hand(hknob, spec_file, tmp_path: Path, grip: float, friction: bool) -> None:
    """Within what the solver's tolerance may move the optimum, and the end of the search."""
    rig = Rig(counts_per_rev=0, amplifier_s=0.0, coulomb_nm=0.56e-3 if friction else 0.0, angle_noise_rad=1e-5)
    trials = record_experiments(rig, Schedule(experiments=(1,), subjects=1, blocks=1, grips=(grip,)))
    pq.write_table(table(trials), tmp_path / "same.parquet")
    name = "output_error_friction" if friction else "output_error"
    done = hknob("sysid", spec_file(SPEC.format(name)), "-o", "out")
    assert done.returncode == 0, done.stderr
    ours = pq.read_table(tmp_path / "out" / "trials.parquet").to_pylist()[0]
    times, torque, angle = mean_trial(tmp_path / "same.parquet")
    free = [0, 1, 2, 3, 4] if friction else [0, 1, 2, 4]

    def misses(p: np.ndarray) -> np.ndarray:
        whole = np.zeros(5)
        whole[free] = p * SIZES[free]
        return moved(whole[:4], times, torque) + whole[4] - angle

    start = [1.0, 1.0, 1.0, *([1.0] if friction else []), 0.0]
    best = least_squares(misses, start, jac="3-point", diff_step=STEP, xtol=1e-12, ftol=1e-14, gtol=1e-14)
    # The solver is off by its tolerance, at each of some hundred steps, of the largest angle; a difference over 2 STEP
    # by that over STEP, and by some STEP^2 of itself. So is the gradient, and so the place where it is zero.
    off = 100.0 * RELATIVE * float(np.max(np.abs(angle)))
    curve, left = np.linalg.inv(best.jac.T @ best.jac), np.sqrt(2.0 * best.cost)
    pull = left * (np.sqrt(len(angle)) * off / STEP + STEP**2 * np.linalg.norm(best.jac, axis=0))
    slack = np.sum(np.abs(np.linalg.pinv(best.jac)), axis=1) * off + np.abs(curve) @ pull
    for column, size, theirs, wide in zip(np.array(COLUMNS)[free[:-1]], SIZES[free[:-1]], best.x, slack, strict=False):
        print(column, ours[column] / size, theirs, wide, ours[f"{column}_std"] / size)
        assert wide < 0.1 * ours[f"{column}_std"] / size  # or agreement says little
        assert ours[column] / size == pytest.approx(theirs, abs=wide), column
