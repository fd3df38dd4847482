"""The order and the clock of blocks stand exactly where they say; times are made by hand."""

import pytest

from hknob_cli.hardware.port import Drift
from hknob_cli.hardware.wire.answers import Samples
from hknob_cli.hardware.wire.sending import ASK_EVERY_S, GAP_PATIENCE_S, MOST_AHEAD, BlockOrder, HostClock
from tests.hardware.fake_target import made_up

BOOT, RUN, SIZE = 7, 9, 5
# By how much each of twelve blocks is late, s: the earliest of the first four is the first, of the last four the tenth.
LATE = (5.0, 5.002, 5.004, 5.006, 6.0, 6.0, 6.0, 6.0, 5.118, 5.110, 5.114, 5.122)


def heard(told: list[float], arrived: list[float]) -> HostClock:
    clock = HostClock()
    for arrived_s, told_s in zip(arrived, told, strict=True):
        clock.note(arrived_s=arrived_s, told_s=told_s)
    return clock


def test_the_earliest_of_either_third_tell_the_clocks_apart() -> None:
    """A tenth of the way to the next of four is 0.3 of its step; 10 ms are added for the way."""
    told = [100.0 + 0.1 * i for i in range(12)]
    arrived = [one + late for one, late in zip(told, LATE, strict=True)]
    drift = heard(told, arrived).drift()
    assert drift is not None
    slower = (5.110 - 5.0) / 0.9
    assert drift.share == pytest.approx(1.0 / (1.0 + slower) - 1.0, rel=1e-9)
    assert drift.uncertainty == pytest.approx((0.3 * 0.002 + 0.3 * 0.004 + 0.01) / 0.9, rel=1e-9)
    assert heard(told[:11], arrived[:11]).drift() is None


@pytest.mark.parametrize("at", [500.1, 7.3, 1e4 / 3.0])
def test_blocks_that_arrive_at_one_instant_tell_nothing(at: float) -> None:
    assert heard([100.0 + 0.1 * i for i in range(12)], [at] * 12).drift() is None


def test_blocks_of_one_time_tell_nothing() -> None:
    assert heard([100.0] * 12, [500.0 + i for i in range(12)]).drift() is None


def test_a_clock_that_is_faster_than_any_tells_nothing() -> None:
    """The earliest of both ends arrive at one instant, though the first block was before it."""
    assert heard([float(i) for i in range(12)], [7.0] + [8.0] * 11).drift() is None


def test_a_clock_of_two_and_a_half_seconds_a_second_is_told() -> None:
    drift = heard([0.1 * i for i in range(12)], [9.0 + 0.04 * i for i in range(12)]).drift()
    assert drift is not None
    assert drift.share == pytest.approx(1.5)


@pytest.mark.parametrize("begin", [0.0, 64.0])
def test_a_clock_is_looked_at_after_400_ms_of_the_target(begin: float) -> None:
    told = [begin + 0.025 * i for i in range(17)]
    arrived = [9.0 + 3.0 * (one - begin) for one in told]
    assert heard(told[:16], arrived[:16]).fault() == ""
    assert "slow by this computer's" in heard(told, arrived).fault()


def test_then_a_quarter_later_each_time() -> None:
    told = [64.0 + 0.025 * i for i in range(17)]
    clock = heard(told, told)
    assert clock.fault() == ""
    assert clock._next_s == pytest.approx(0.5)
    assert HostClock().drift() is None
    assert HostClock().fault() == ""
    assert Drift(0.5, 0.1).at_least == 0.4


def sent(number: int) -> Samples:
    return Samples(BOOT, RUN, number, made_up(number * SIZE, SIZE, 250.0, started=12))


def order() -> BlockOrder:
    return BlockOrder(boot=BOOT, run=RUN)


def test_what_comes_twice_is_dropped() -> None:
    """What is held, too."""
    blocks = order()
    for number in (2, 2, 0, 0):
        blocks.take(sent(number), now=0.0)
    assert (blocks.dropped, blocks.expected) == (2, 1)


def test_late_in_a_run_blocks_are_held_as_at_its_begin() -> None:
    blocks = order()
    for number in range(MOST_AHEAD + 10):
        assert len(blocks.take(sent(number), now=0.0)) == 1
    assert blocks.take(sent(MOST_AHEAD + 11), now=0.0) == []
    assert len(blocks.take(sent(MOST_AHEAD + 10), now=0.0)) == 2


def test_blocks_of_another_run_are_beyond_no_end() -> None:
    blocks = order()
    blocks.end(1, now=0.0)
    assert blocks.is_beyond(sent(1))
    assert not blocks.is_beyond(sent(0))
    assert not blocks.is_beyond(sent(1)._replace(run=RUN + 1))


def test_where_nothing_is_missing_nothing_is_asked_for() -> None:
    blocks = order()
    assert (blocks.gap, blocks.ask(1.0), blocks.complete) == (None, None, False)
    blocks.take(sent(0), now=1.0)
    assert (blocks.gap, blocks.ask(1.0)) == (None, None)
    blocks.end(1, now=1.0)
    assert (blocks.gap, blocks.ask(1.0), blocks.complete) == (None, None, True)


def test_what_is_asked_for_is_what_may_be_held() -> None:
    """At once, and again when the time has come to the digit; not before."""
    blocks = order()
    blocks.end(1000, now=0.0)
    assert blocks.gap == (0, 1000)
    assert blocks.ask(0.0) == (0, MOST_AHEAD)
    assert blocks.ask(0.99 * ASK_EVERY_S) is None
    assert blocks.ask(ASK_EVERY_S) == (0, MOST_AHEAD)


def test_the_end_of_a_run_gives_a_gap_no_new_time() -> None:
    blocks = order()
    blocks.take(sent(3), now=0.0)
    blocks.end(5, now=0.09)
    assert not blocks.is_overdue(GAP_PATIENCE_S)
    assert blocks.is_overdue(1.01 * GAP_PATIENCE_S)
    assert BlockOrder(boot=1, run=1).patience_s == 0.1
