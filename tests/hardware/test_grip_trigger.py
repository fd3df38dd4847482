"""The state machine that fires a pulse at a grip: against the rule, written once more over whole arrays."""

import numpy as np
import pytest

from hknob_cli.hardware.control import GripTrigger, Phase
from hknob_cli.hardware.port import PulseOrder

DT = 1e-3
ORDER = PulseOrder(grip_n=2.0, band_n=0.2, dwell_s=0.0, release_n=0.6, torque_nm=0.01, width_s=0.005)
ZERO = 7


def torques(order: PulseOrder, grip: np.ndarray, zero_n: float = 0.0) -> tuple[np.ndarray, GripTrigger]:
    """Torque at each sample of a grip, after some of an empty cell that shows ``zero_n``."""
    trigger = GripTrigger(order, DT)
    cell = np.concatenate([np.full(ZERO, zero_n), grip + zero_n])
    found = trigger.follow(cell, np.arange(cell.size) >= ZERO)
    assert not found[:ZERO].any()
    return found[ZERO:], trigger


def by_the_rule(order: PulseOrder, grip: np.ndarray) -> np.ndarray:
    """The same from the words: relaxed once, then at the target, or in the band for the dwell; one pulse."""
    n, dwell = grip.size, round(order.dwell_s / DT)
    relaxed = np.maximum.accumulate(grip < order.release_n)
    if dwell:
        inside = (np.abs(grip - order.grip_n) <= order.band_n) & relaxed
        ready = np.array([i >= dwell and inside[i - dwell : i + 1].all() for i in range(n)])
    else:
        ready = (grip >= order.grip_n) & relaxed
    out = np.zeros(n)
    if ready.any():
        first = int(np.argmax(ready))
        out[first : first + round(order.width_s / DT)] = order.torque_nm
    return out


@pytest.mark.parametrize("dwell", [0.0, 0.001, 0.03])
def test_the_pulse_is_that_of_the_rule(dwell: float) -> None:
    rng = np.random.default_rng(5)
    fired = 0
    for _ in range(200):
        steps = rng.normal(0.003, 0.03, 800)
        grip = np.clip(rng.uniform(-0.5, 2.5) + np.cumsum(steps), -0.5, 2.3)
        order = ORDER._replace(dwell_s=dwell)
        expected = by_the_rule(order, grip)
        fired += bool(expected.any())
        assert np.array_equal(torques(order, grip)[0], expected)
    assert 20 < fired < 190


def test_it_fires_once_at_the_first_sample_at_the_target_for_the_width() -> None:
    grip = np.concatenate([np.linspace(0.0, 3.0, 31), np.full(10, 3.0), np.zeros(5), np.linspace(0.0, 3.0, 31)])
    torque, trigger = torques(ORDER, grip)
    assert np.flatnonzero(torque).tolist() == [20, 21, 22, 23, 24]
    assert trigger.phase is Phase.DONE


def test_the_zero_of_the_cell_is_taken_off() -> None:
    grip = np.linspace(0.0, 3.0, 301)
    assert np.array_equal(torques(ORDER, grip, zero_n=-0.25)[0], torques(ORDER, grip)[0])


def test_a_hand_that_was_not_relaxed_fires_nothing() -> None:
    torque, trigger = torques(ORDER, np.full(500, 2.0))
    assert not torque.any()
    assert trigger.phase is Phase.RELAX


def test_a_grip_that_leaves_the_band_begins_its_dwell_anew() -> None:
    order = ORDER._replace(dwell_s=0.01)
    grip = np.concatenate([[0.0], np.full(10, 2.0), [2.3], np.full(30, 2.0)])
    torque, _ = torques(order, grip)
    assert int(np.flatnonzero(torque)[0]) == 12 + 10


def test_phases_in_their_order() -> None:
    trigger = GripTrigger(ORDER._replace(dwell_s=0.003), DT)
    seen = [trigger.phase]
    grip = [0.0, 1.0, 2.0, 2.0, 2.0, 2.0, *[2.0] * 6, 0.1]
    for cell, running in [(0.0, False), *((one, True) for one in grip)]:
        trigger.step(cell, running=running)
        seen += [trigger.phase] if trigger.phase is not seen[-1] else []
    assert seen == [Phase.ZERO, Phase.SQUEEZE, Phase.HOLD, Phase.PULSE, Phase.RELEASE, Phase.DONE]


def test_a_pulse_shorter_than_a_sample_takes_one() -> None:
    torque, _ = torques(ORDER._replace(width_s=1e-5), np.linspace(0.0, 3.0, 301))
    assert np.count_nonzero(torque) == 1
