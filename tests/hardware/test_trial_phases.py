"""When a trial is held, buzzes, rests and ends: by blocks made by hand, at each bound and a sample before it."""

import numpy as np
import pytest

from hknob_cli.hardware.port import Block
from hknob_cli.hardware.trial_phases import Ended, Phase, TrialPhases
from hknob_cli.specs.campaign import Course, Grip

INTERVAL = 1.0 / 64.0  # s: sums of it are exact
IDLE, HELD = 0.25, 0.75  # N that the cell shows where nobody holds the knob, and where it is held as asked
PLAN = Course(zero=1.0, settle=1.0, buzz=(2.0, 3.0), longest=100.0, grip=Grip(target=0.5, band=0.125))


def block(steps: int, count: int = 16, *, cell: float = HELD, on: bool = True) -> Block:
    """Samples whose torque changes so often, the first time from 0, and is 0 at the end if that is even."""
    torques = np.where(np.arange(count) < steps, np.arange(count) % 2 == 0, steps % 2 == 1).astype(float)
    zeros = np.zeros(count, dtype=np.int64)
    return Block(0, zeros, zeros, torques, np.full(count, cell), np.full(count, on), 0)


def begun(plan: Course = PLAN, interval_s: float = INTERVAL) -> TrialPhases:
    """A trial whose cell was read, and that is held for long enough."""
    phases = TrialPhases(plan, interval_s)
    count = round(1.0 / interval_s)
    phases.follow(block(0, count, cell=IDLE, on=False))
    phases.follow(block(0, count))
    assert phases.settled_sample == count
    return phases


def test_the_cell_is_read_before_the_start_for_as_long_as_told() -> None:
    phases = TrialPhases(PLAN, INTERVAL)
    assert (phases.zero_n, phases.zeroed, phases.phase) == (0.0, False, Phase.ZERO)
    assert (phases.grip_n, phases.torque_nm, phases.running_s, phases.settled_sample) == (0.0, 0.0, 0.0, None)
    assert phases.follow(block(0, 63, cell=IDLE, on=False)) is None
    assert (phases.zero_n, phases.zeroed) == (IDLE, False)
    begins = block(0, 4, cell=IDLE)._replace(running=np.array([False, True, True, True]))
    phases.follow(begins)
    assert (phases.zero_n, phases.zeroed, phases.running_s) == (IDLE, True, 3 * INTERVAL)
    assert (phases.grip_n, phases.phase) == (0.0, Phase.GRIP)
    phases.follow(block(0, 9, cell=7.0, on=False))
    assert (phases.zero_n, phases.running_s) == (IDLE, 3 * INTERVAL)


def test_only_samples_with_the_wall_on_are_of_the_grip() -> None:
    phases = TrialPhases(PLAN, INTERVAL)
    phases.follow(block(0, 4, cell=IDLE, on=False))
    mixed = block(0, 4)._replace(grip_n=np.array([IDLE, IDLE, HELD, HELD]), running=np.arange(4) > 1)
    phases.follow(mixed)
    assert phases.grip_n == HELD - IDLE


def test_a_trial_is_settled_when_it_was_held_for_as_long_as_told() -> None:
    """The sample is the one after the block; a block out of the band begins it anew."""
    phases = TrialPhases(PLAN, INTERVAL)
    phases.follow(block(0, 64, cell=IDLE, on=False))
    phases.follow(block(0, 63))
    phases.follow(block(0, 1, cell=HELD + 0.1875))
    phases.follow(block(0, 32)._replace(first=200))
    phases.follow(block(0, 31)._replace(first=232))
    assert phases.settled_sample is None
    phases.follow(block(0, 1)._replace(first=263))
    assert (phases.settled_sample, phases.phase) == (264, Phase.GRIP)
    at_once = TrialPhases(PLAN._replace(settle=0.0), INTERVAL)
    at_once.follow(block(0, 64, cell=IDLE, on=False))
    at_once.follow(block(0, 1, cell=IDLE))
    assert at_once.settled_sample is None
    at_once.follow(block(0, 1))
    assert at_once.settled_sample == 1


@pytest.mark.parametrize(("steps", "phase"), [(4, Phase.REST), (5, Phase.BUZZ)])
def test_it_buzzes_from_twenty_steps_a_second_on(steps: int, phase: Phase) -> None:
    """Five in a quarter of a second."""
    phases = begun()
    phases.follow(block(steps))
    assert (phases.phase, phases.phase_s) == (phase, 0.25)


def test_a_step_from_block_to_block_is_one() -> None:
    phases = begun()
    phases.follow(block(5))
    assert phases.torque_nm == 1.0
    up = block(0)._replace(torque_nm=np.array([0.0, 1.0] + [0.0] * 14))
    phases.follow(up)  # down, up, down
    assert phases.phase is Phase.REST
    phases.follow(up._replace(torque_nm=np.array([1.0, 0.0, 1.0, 0.0, 1.0] + [1.0] * 11)))
    assert phases.phase is Phase.BUZZ


def test_the_torque_before_the_first_sample_is_none() -> None:
    phases = TrialPhases(PLAN._replace(settle=0.125, grip=None), INTERVAL)
    phases.follow(block(0, 8))
    phases.follow(block(4, 8))
    assert phases.phase is Phase.REST


def test_steps_are_counted_over_a_fifth_of_a_second() -> None:
    """In whole blocks: the oldest goes as soon as the others last as long."""
    fifth = 0.2 / 16  # 16 of which are 0.2 s to the last digit
    phases = begun(interval_s=fifth)
    phases.follow(block(16))
    phases.follow(block(2))
    assert phases.phase is Phase.REST
    eighth = begun()
    rest, buzz = Phase.REST, Phase.BUZZ
    for steps, phase in ((0, rest), (0, rest), (5, buzz), (0, buzz), (0, rest), (5, buzz), (0, buzz)):
        eighth.follow(block(steps, 8)._replace(torque_nm=block(steps, 8).torque_nm + eighth.torque_nm))
        assert eighth.phase is phase


@pytest.mark.parametrize(
    ("steps", "seconds", "ended"), [(6, 3.0, Ended.BUZZ), (0, 2.0, Ended.REST), (4, 2.0, Ended.REST)]
)
def test_it_ends_when_it_has_buzzed_or_rested_for_as_long_as_told(steps: int, seconds: float, ended: Ended) -> None:
    phases = begun()
    before = [phases.follow(block(steps)) for _ in range(round(seconds / 0.25) - 1)]
    assert before == [None] * len(before)
    assert phases.follow(block(steps)) is ended
    assert phases.phase_s == seconds


def test_rest_is_rest_however_long_a_block_is() -> None:
    assert begun().follow(block(0, 64 * 4)) is Ended.REST


def test_another_phase_begins_anew() -> None:
    phases = begun()
    assert [phases.follow(block(6)) for _ in range(11)] == [None] * 11
    assert [phases.follow(block(0)) for _ in range(7)] == [None] * 7
    assert (phases.phase, phases.phase_s) == (Phase.REST, 1.75)
    assert phases.follow(block(6)) is None
    assert (phases.phase, phases.phase_s) == (Phase.BUZZ, 0.25)


def test_it_ends_at_the_longest_whatever_it_does() -> None:
    """What it has shown till then counts first."""
    phases = begun(PLAN._replace(longest=1.5))
    assert phases.follow(block(0, 31)) is None
    assert phases.follow(block(0, 1)) is Ended.LONGEST
    short = begun(PLAN._replace(longest=3.0))
    assert [short.follow(block(0)) for _ in range(8)] == [None] * 7 + [Ended.REST]
    never = TrialPhases(PLAN._replace(longest=0.5), INTERVAL)
    assert never.follow(block(0, 32, cell=9.0)) is Ended.LONGEST
