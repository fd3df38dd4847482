"""Controllers beside friction, finger, delay, lag, limits and steps, against the 60-digit model under the same law.

Random scenes with three features each or more. A trial has the model's angle at every sample, as far as no sample of
the model comes so near to an edge that rounding may decide. A proven cycle is derived again: the law's memory from the
readings of its period, gone on until 40 digits no longer change, and the plant's periodic motion under those torques by
Newton's method. Where the law senses the velocity, the motion and the torques under way are solved for together.
It must have those readings, and the package's positions lie within its own bound of it.
"""

from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.ensemble import begin
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past
from hknob_cli.engine.general.search import as_list
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.general_orbit import LawMeasurer
from tests import digits as mp
from tests.controllers.laws import CONTROLLERS, LOOP_ONLY

from .general_orbits import CLOSED_OVER_CORNERS, NEAR, NEAR_CORNERS, to_si, unknowns
from .general_reference import build
from .law_reference import Firmware, periodic_wave, run_closed, run_period, simulate_law
from .law_scenes import Drawn, draw, reduce, search
from .reference_friction import Friction

LONGEST = 40  # samples of a period, for the time that 60 digits take
SAMPLES = 60
CLEAR = 1e-6  # counts from an edge within which rounding may decide, far beyond the roundings of so many samples
WITHIN = 1e-9  # counts, relative to the largest
CLOSED = mp.mpf(10) ** -30
ROUNDINGS = 16.0 * 2.0**-53
ORDER = [*sorted(CONTROLLERS), *sorted(LOOP_ONLY)]


def scenes(controller: str, count: int, seed: int = 0) -> list[Drawn]:
    """Random scenes under a controller."""
    numbers = np.random.default_rng([seed, ORDER.index(controller)])
    return [draw(numbers, controller) for _ in range(count)]


def run(made: Any, state: Any, past: Any, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """States at samples, (samples + 1, n), and counts at each and at the looks after it, (samples, 1 + looks).

    Interpreted: so few samples do not repay a compiler.
    """
    body, wall, law = made.knob.body, as_list(made.knob.wall), made.law
    z, memory = [float(value) for value in state], [float(value) for value in past]
    states, looks, pad = [z.copy()], [], [0.0] * (2 * body.order)
    for _ in range(samples):
        advance_with_law(z, memory, body, wall, law, pad)
        states.append(z.copy())
        looks.append(memory[law.rows : law.rows + 1 + law.looks])
    return np.array(states), np.array(looks)


def check_trial(one: Drawn) -> float:
    """The largest error of a trial's position over its size; NaN where rounding may decide from the start."""
    made = reduce(one)
    knob, order, phase = made.knob, made.knob.body.order, 0.37
    z, past = [0.0] * order, [0.0] * len(made.law.beside)
    begin(z, knob.start(0.02, -0.5), phase, knob.body, [0.0] * (2 * order))
    begin_past(past, read(z[0], as_list(knob.wall)), made.law)
    states, _ = run(made, z, past, SAMPLES)
    trial = simulate_law(one.scene, one.rate_hz, one.counts, angle=0.02, velocity=-0.5, phase=phase)
    worst, size = float("nan"), float(np.abs(states[:, 0]).max())
    for i in range(SAMPLES):
        theta, _, clear = next(trial)
        if clear < CLEAR:
            break
        off = abs(float(theta / mp.mpf(knob.quantum_rad)) - knob.shift - states[i, 0]) / (1.0 + size)
        worst = off if not off <= worst else worst
        assert off <= WITHIN, f"sample {i} is {off:.3g} off: {one}"
    return worst


def check_orbit(one: Drawn, made: Any, orbit: Attractor) -> tuple[float, float]:
    """Derive a proven cycle again: the largest error of a position, counts, and that over the bound it was given."""
    knob, n = made.knob, orbit.period
    bodies, control = build(one.scene, sample_rate_hz=one.rate_hz, counts_per_rev=one.counts)
    state = [orbit.x, orbit.v, *orbit.state]
    states, between_counts = run(made, state, orbit.line, n)
    seen = states[:, 0]
    z = to_si(knob, control, state, bodies)
    corners = 0
    detections = (one.scene.get("controller") or {}).get("detections", 1)
    counts = [[(mp.mpf(float(count)) + control.offset) * control.quantum for count in row] for row in between_counts]
    if control.hysteresis:
        shown = [row[0] for row in counts]
    else:
        shown = [control.measured((mp.mpf(float(x)) + mp.mpf(knob.shift)) * control.quantum) for x in seen[:n]]
    # What is seen between the samples is part of what the law reads: at each sample that of the interval before.
    angles = [row[1:] for row in counts]
    looks = [angles[-1], *angles[:-1]]
    torque = mp.mpf(knob.torque_nm)
    current = torque / bodies.torque_constant if bodies.torque_constant else mp.one
    units = [*[control.quantum, control.quantum / control.period] * 2, torque, torque, mp.one, current]
    free = unknowns(knob, bodies)
    values = [z[i] / units[i] for i in free]

    law = made.law
    under_way = [mp.mpf(u) * units[4] for u in orbit.line[law.line + 1 : law.line + law.ages]] if law.senses else []
    values += [u / units[4] for u in under_way]

    def residual(given: list[Any], wave: Any) -> tuple[list[Any], list[Any], list[list[Any]]]:
        nonlocal corners
        at = list(z)
        for value, i in zip(given, free, strict=False):
            at[i] = value * units[i]
        motion = Friction(bodies, control.period, tuple(at), find_turns=control.hysteresis > 0)
        if law.senses:
            before = [u * units[4] for u in given[len(free) :]]
            firmware = Firmware(one.scene, one.rate_hz, one.counts, control)
            thetas, torques = run_closed(motion, firmware, shown[-1], before, n)
            late = torques[len(torques) - len(before) :]
            ends = [motion.z[i] / units[i] for i in free] + [u / units[4] for u in late]
            return [end - value for end, value in zip(ends, given, strict=True)], thetas, angles
        thetas, seen_between = run_period(motion, wave, control, detections)
        corners = motion.parted
        return [motion.z[i] / units[i] - value for value, i in zip(given, free, strict=True)], thetas, seen_between

    energy = None
    if law.drifts >= 0 and not one.scene["controller"].get("reset", True):
        energy = mp.mpf(orbit.line[law.drifts]) * control.stiffness * control.quantum**2
    wave = None
    if not law.senses:
        wave = periodic_wave(one.scene, one.rate_hz, one.counts, control, shown, looks, energy)
    off, thetas, between = residual(values, wave)
    near, closed = NEAR, CLOSED
    if bodies.cogs and corners and not bodies.play:
        near, closed = NEAR_CORNERS, 10 * CLOSED_OVER_CORNERS
    elif bodies.cogs:  # it is proven on one slope
        bodies = bodies.on(bodies.slope(z[0]))
        off, thetas, between = residual(values, wave)
    for _ in range(6):
        if max(map(abs, off)) < closed:
            break
        slopes = mp.matrix(len(values), len(values))
        for j in range(len(values)):
            nudged = [v + (near if i == j else 0) for i, v in enumerate(values)]
            for i, value in enumerate(residual(nudged, wave)[0]):
                slopes[i, j] = (value - off[i]) / near
        change = mp.lu_solve(slopes, mp.matrix([-value for value in off]))
        values = [v + change[i] for i, v in enumerate(values)]
        off, thetas, between = residual(values, wave)
    assert max(map(abs, off)) < closed, f"does not close, {float(max(map(abs, off))):.3g}: {one}"
    worst = 0.0
    for x, theta in zip(seen, thetas, strict=True):
        exact = theta / control.quantum - mp.mpf(knob.shift)
        worst = max(worst, float(abs(mp.mpf(float(x)) - exact)))
    allowed = orbit.bound + ROUNDINGS * n * float(np.ptp(seen) + np.abs(seen).max())
    assert worst <= allowed, f"{worst:.3g} counts off, bound {orbit.bound:.3g}: {one}"
    if control.hysteresis:
        at, readings = list(z), []
        for value, i in zip(values, free, strict=False):
            at[i] = value * units[i]
        motion = Friction(bodies, control.period, tuple(at), find_turns=True)
        between = run_period(motion, wave, control, detections, readings)[1][n:]
        assert readings == shown, one
    else:
        assert [control.measured(theta) for theta in thetas[:n]] == shown, one
    assert detections == 1 or [between[-1], *between[:-1]] == looks, one
    return worst, worst / orbit.bound


@pytest.mark.one_in(6)
@pytest.mark.parametrize("controller", ORDER)
def test_trials(controller: str) -> None:
    errors = [check_trial(one) for one in scenes(controller, 3)]
    assert np.isfinite(errors).any(), "rounding could decide in all scenes: nothing was tested"


def proven(controller: str, count: int, seed: int = 0) -> list[tuple[float, float]]:
    """Errors of all proven cycles of random scenes."""
    found = []
    for one in scenes(controller, count, seed):
        made = reduce(one)
        engine, attractors = search(one, made)
        for orbit in attractors:
            if orbit.outcome is Outcome.CYCLE and orbit.certified and orbit.period <= LONGEST:
                found.append(check_orbit(one, made, orbit))
                balance(made, engine, orbit, one)
    return found


def balance(made: Any, engine: LawEngine, orbit: Attractor, one: Drawn) -> None:
    """The torque's work over a cycle is what dampers and friction take."""
    found = LawMeasurer(made.knob, engine).measure(orbit)
    lost = found.damping_loss_j + (found.friction_loss_j if made.knob.body.friction > 0.0 else 0.0)
    assert abs(found.wall_work_j - lost) <= 1e-9 * abs(lost), one


@pytest.mark.one_in(12)
@pytest.mark.parametrize("controller", sorted(CONTROLLERS))
def test_proven_cycles(controller: str) -> None:
    assert proven(controller, 4), "no proven cycle: nothing was tested"


@pytest.mark.one_in(3)
@pytest.mark.parametrize("controller", ["bounded lag", "damping, sensor", "matched wall", "speed, tracked"])
@pytest.mark.parametrize("winding", ["shorted", "voltage"])
def test_a_winding_beside_a_controller(controller: str, winding: str) -> None:
    """The coil is a state more beside the memory; a voltage drives it through the lag of the same winding."""
    found: list[Any] = []
    for one in scenes(controller, 8, seed=3):
        if found:
            break
        actuator = {name: value for name, value in one.scene["actuator"].items() if name != "time_constant"}
        motor = {"torque_constant": 0.0234, "resistance": 2.32, "inductance": 2.38e-4, "winding": winding}
        wound = one._replace(scene={**one.scene, "actuator": actuator, "motor": motor})
        check_trial(wound)
        made = reduce(wound)
        _, attractors = search(wound, made)
        for orbit in attractors:
            if orbit.outcome is Outcome.CYCLE and orbit.certified and orbit.period <= LONGEST:
                found.append(check_orbit(wound, made, orbit))
    assert found, "no proven cycle: nothing was tested"


@pytest.mark.one_in(3)
@pytest.mark.parametrize("controller", ["bounded lag", "damping, sensor", "speed, tracked", "angle, filtered"])
def test_a_dead_band(controller: str) -> None:
    """Of a part of the torque of a count to a few of them."""
    found, clear = [], []
    for k, one in enumerate(scenes(controller, 4, seed=2)):
        count = one.scene["wall"]["stiffness"] * 2.0 * np.pi / one.counts
        actuator = {**one.scene.get("actuator", {}), "dead_band": float(0.7 + 0.6 * k) * count}
        banded = one._replace(scene={**one.scene, "actuator": actuator})
        clear.append(check_trial(banded))
        made = reduce(banded)
        _, attractors = search(banded, made)
        for orbit in attractors:
            if orbit.outcome is Outcome.CYCLE and orbit.certified and orbit.period <= LONGEST:
                found.append(check_orbit(banded, made, orbit))
    assert np.isfinite(clear).any()
    assert found, "no proven cycle: nothing was tested"


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("controller", ORDER)
def test_many_scenes(controller: str) -> None:
    for one in scenes(controller, 12, seed=1):
        check_trial(one)
    proven(controller, 12, seed=1)
