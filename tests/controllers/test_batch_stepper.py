"""Lanes, laps, the search for repeats, and recordings: each against the plain step it is made of."""

from itertools import islice
from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.batch_stepper import BatchStepper, take
from hknob_cli.controllers.controller import make_control_law
from hknob_cli.controllers.period_run import run_lap, trace_lap
from hknob_cli.controllers.plant_batch import count_at, flow_over, moved
from hknob_cli.controllers.proof import prove
from hknob_cli.controllers.repeat import SearchBudget, find_repeats
from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.specs.plan import Starts
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.stages.sweep.law_record import follow_law
from tests.controllers.batches import Batch, make_batch, search
from tests.controllers.laws import CONTROLLERS
from tests.controllers.reference import Rig, law_of

SCENE: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
}


def setting(name: str, *, counts: int = 360, phases: int = 4) -> tuple[Any, Batch]:
    plan = SceneSpec.model_validate({**SCENE, "controller": CONTROLLERS[name]}).plain()
    assert plan.controller
    cell = {"sample_rate_hz": 1000.0, "counts_per_rev": counts}
    return make_control_law(plan.controller), make_batch(plan, [cell], Starts(angle=0.02, velocity=0.0, phases=phases))


@pytest.mark.parametrize(("sense", "found"), [(1.0, [-2, -1, 0, 1]), (-1.0, [-1, 0, 1, 2]), (0.0, [-1, 0, 0, 1])])
def test_counts_of_each_rounding(sense: float, found: list[int]) -> None:
    x = np.array([-1.5, -0.25, 0.25, 1.5])
    assert count_at(x, np.full(4, sense)).tolist() == found


def test_a_hold_in_parts_is_a_hold() -> None:
    _, batch = setting("impulse, short")
    lanes, drive = batch.lanes, batch.lanes.gamma * 3.0
    x, v = moved(batch.x, batch.v, drive, lanes.beta, flow_over(lanes, 1.0))
    y, w = batch.x, batch.v
    for part in (0.025, 0.475, 0.5):
        y, w = moved(y, w, drive, lanes.beta, flow_over(lanes, part))
    # three roundings in place of one, of some units in the last place
    np.testing.assert_allclose(y, x, rtol=1e-14)
    np.testing.assert_allclose(w, v, rtol=1e-12)


@pytest.mark.parametrize("name", ["impulse, timed", "bounded lag"])
def test_lanes_of_different_periods_end_each_after_its_own(name: str) -> None:
    remedy, batch = setting(name, phases=3)
    mover = BatchStepper(remedy, batch.lanes)
    start, period = mover.start(batch.x, batch.v), np.array([7, 3, 7])
    lap, path = trace_lap(mover, start, period)
    state = start
    for i in range(1, 8):
        state = mover.step(state).state
        np.testing.assert_array_equal(path.rows[i], state.rows)
        ended = np.flatnonzero(period == i)
        np.testing.assert_array_equal(lap.end.stacked[:, ended], state.stacked[:, ended])
    np.testing.assert_array_equal(run_lap(mover, start, period).end.stacked, lap.end.stacked)
    assert len(path.drive) == 7 * len(remedy.parts)


def test_repeats_are_periods() -> None:
    remedy, batch = setting("first-order hold")
    mover = BatchStepper(remedy, batch.lanes)
    found = find_repeats(
        mover, mover.start(batch.x, batch.v), SearchBudget(settle=8.0, patience=8.0, fewest=512, near=1e-9)
    )
    assert (found.period > 0).all()
    again = run_lap(mover, found.state, found.period).end
    np.testing.assert_allclose(again.rows, found.state.rows, atol=1e-7)
    # half a period is none
    half = run_lap(mover, found.state, np.maximum(1, found.period // 2)).end
    assert (np.abs(half.rows - found.state.rows).max(axis=0) > 1e-3).all()


def test_no_proof_of_a_state_that_does_not_come_back() -> None:
    remedy, batch = setting("first-order hold")
    mover = BatchStepper(remedy, batch.lanes)
    start = mover.start(batch.x, batch.v)
    assert not prove(mover, start, np.array([1, 2, 5, 9])).proven.any()


def test_a_trial_far_from_its_orbit_is_not_captured_by_it() -> None:
    """The proof is of a trial, not of an orbit: the same orbit says nothing of a start that may go elsewhere."""
    remedy, batch = setting("first-order hold", phases=1)
    mover = BatchStepper(remedy, batch.lanes)
    effort = SearchBudget(settle=20.0, patience=8.0, fewest=512, near=1e-9)
    found = find_repeats(mover, mover.start(batch.x, batch.v), effort)
    near = take(found.state, [0])
    assert prove(mover, near, found.period).proven.all()
    near.x[0] += 0.4
    assert not prove(mover, near, found.period).proven.any()


def test_each_trial_comes_to_its_end() -> None:
    remedy, batch = setting("half sample", phases=8)
    ends = search(remedy, batch)
    assert sorted(end.lane for end in ends) == list(range(8))
    for end in ends:
        assert end.outcome is Outcome.CYCLE
        assert end.reason is Reason.NONE
        assert end.closure < 1e-12 * np.abs(end.x).max()


@pytest.mark.parametrize("name", ["impulse, short", "phase, both"])
def test_a_recording_is_the_references_motion(name: str) -> None:
    plan = SceneSpec.model_validate({**SCENE, "controller": CONTROLLERS[name]}).plain()
    made = make_law(plan, sample_rate_hz=1000.0, counts_per_rev=360)
    knob = made.knob
    points = list(follow_law(made, knob.start(0.02, 0.0), phase=0.375, until=40.0, every=0.3))
    rig = Rig(SCENE, 1000.0, 360)
    trial = list(islice(rig.trial(law_of(rig, CONTROLLERS[name]), 0.02, 0.0, 1.5 / 4), 41))
    samples = [point for point in points if point.event == "sample"]
    assert len(samples) == 40
    for point, (theta, _, pieces) in zip(samples, trial, strict=False):
        # floats against floats: some roundings a sample
        assert knob.angle_rad(point.state[0]) == pytest.approx(theta, abs=1e-12)
        assert point.torque * knob.torque_nm == pytest.approx(pieces[0][0], abs=1e-10)
    times = [point.time for point in points]
    assert times == sorted(times)
    between = [point for point in points if not point.event and point.time > 10.0]
    assert between
    for point in between[:20]:
        n = int(point.time - 0.375)
        theta, omega, pieces = trial[n]
        state, left = (theta, omega), (point.time - 0.375 - n) * 1e-3
        for torque, duration in pieces:
            state, left = rig.move(state, torque, min(left, duration)), left - min(left, duration)
        assert knob.angle_rad(point.state[0]) == pytest.approx(state[0], abs=1e-12)
