"""A clock that jitters: its random numbers by whole numbers, its intervals, and where a trial begins."""

import pytest

from hknob_cli.engine.general.interval import (
    MEANT,
    SEED,
    SHORTEST,
    SPREAD,
    STATE,
    TRIAL,
    begin_clock,
    jitters,
    meant_pace,
    next_span,
)

MODULUS = 2**31 - 1


def clock_of(seed: int, first: int = 0, shortest: float = 0.5) -> list[float]:
    clock = [0.0] * 6
    clock[STATE], clock[SHORTEST], clock[SPREAD] = 1.0, shortest, 1.0 - shortest
    clock[SEED], clock[TRIAL] = float(seed), float(first)
    return clock


def numbers(seed: int, trial: int, count: int) -> list[int]:
    """Park & Miller's, by whole numbers, the first eight left out."""
    state, found = (65539 * seed + 30269 * trial) % (MODULUS - 1) + 1, []
    for k in range(8 + count):
        state = state * 16807 % MODULUS
        found += [state] if k >= 8 else []
    return found


@pytest.mark.parametrize("seed", [0, 1, 12345, MODULUS - 1])
@pytest.mark.parametrize("trial", [0, 1, 63, 4095])
@pytest.mark.parametrize("first", [0, 3, 1000])
def test_a_trial_has_its_own_numbers_to_the_last_bit(seed: int, trial: int, first: int) -> None:
    """By seed and number of the trial, those before this run's included; the intervals are even in what they are of."""
    clock = clock_of(seed, first)
    begin_clock(clock, float(trial))
    expected = numbers(seed, trial + first, 50)
    for state in expected:
        assert next_span(clock) == 0.5 + 0.5 * (state / MODULUS)
        assert clock[STATE] == state
    assert clock[SHORTEST:] == clock_of(seed, first)[SHORTEST:]


def test_the_ten_thousandth_number_is_the_published_one() -> None:
    """Park & Miller 1988, p. 1195: from 1 on, 1043618065."""
    clock = clock_of(0)
    for _ in range(10_000):
        next_span(clock)
    assert clock[STATE] == 1043618065.0


def test_intervals_are_between_the_shortest_and_one() -> None:
    for shortest in (0.0, 0.25, 0.9):
        clock = clock_of(7, shortest=shortest)
        begin_clock(clock, 2.0)
        spans = [next_span(clock) for _ in range(2000)]
        assert shortest < min(spans) < shortest + 0.01 * (1.0 - shortest)
        assert 1.0 - 0.01 * (1.0 - shortest) < max(spans) < 1.0
        assert abs(sum(spans) / 2000 - 0.5 * (1.0 + shortest)) < 0.03 * (1.0 - shortest)


def test_without_a_clock_every_interval_is_one() -> None:
    begin_clock(None, 3.0)
    assert next_span(None) == 1.0
    assert not jitters(None)
    assert jitters(clock_of(0))


def test_a_pace_is_that_of_the_period_meant() -> None:
    clock = clock_of(0)
    clock[MEANT] = 0.75
    assert meant_pace(2.0, clock) == 1.5
    assert meant_pace(2.0, None) == 2.0
