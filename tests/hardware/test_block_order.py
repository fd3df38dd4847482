"""Blocks in order: for any order, loss and doubling, every sample once, or a gap that is asked for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.wire.answers import Samples
from hknob_cli.hardware.wire.sending import ASK_EVERY_S, GAP_PATIENCE_S, MOST_AHEAD, BlockOrder
from tests.hardware.fake_target import made_up

BOOT, RUN, SIZE = 7, 9, 5


def sent(number: int) -> Samples:
    return Samples(BOOT, RUN, number, made_up(number * SIZE, SIZE, 250.0, started=12))


def order() -> BlockOrder:
    return BlockOrder(boot=BOOT, run=RUN)


@settings(deadline=None)
@given(st.lists(st.integers(0, 30)))
def test_any_arrivals_give_the_longest_run_from_the_first_on(numbers: list[int]) -> None:
    blocks, handed = order(), []
    for number in numbers:
        handed += blocks.take(sent(number), now=0.0)
    whole = next(n for n in range(32) if n not in numbers)
    index = [int(at) for block in handed for at in range(block.first, block.first + SIZE)]
    assert index == list(range(whole * SIZE))
    assert blocks.expected == whole


@settings(deadline=None)
@given(st.lists(st.integers(0, 30)), st.integers(0, 30))
def test_sending_again_what_is_asked_for_completes_any_run(numbers: list[int], last: int) -> None:
    blocks, handed, now = order(), [], 0.0
    for number in numbers:
        if number <= last:
            handed += blocks.take(sent(number), now=now)
    blocks.end(last + 1, now=now)
    while not blocks.complete:
        now += 1.01 * ASK_EVERY_S  # a little more, for rounding
        asked = blocks.ask(now)
        assert asked is not None
        for number in range(asked[0], asked[0] + asked[1]):
            handed += blocks.take(sent(number), now=now)
    assert [block.first for block in handed] == [SIZE * number for number in range(last + 1)]


@pytest.mark.parametrize("other", [{"boot": BOOT + 1}, {"run": RUN + 1}])
def test_another_boot_or_run_is_dropped(other: dict[str, int]) -> None:
    blocks = order()
    assert blocks.take(sent(0)._replace(**other), now=0.0) == []
    assert (blocks.dropped, blocks.expected, blocks.gap) == (1, 0, None)


def test_what_lies_beyond_the_end_is_dropped() -> None:
    blocks = order()
    blocks.end(1, now=0.0)
    assert blocks.take(sent(1), now=0.0) == []
    assert len(blocks.take(sent(0), now=0.0)) == 1
    assert blocks.complete


def test_a_gap_is_asked_for_at_once_then_every_20_ms_and_given_up_after_100() -> None:
    blocks = order()
    blocks.take(sent(2), now=1.0)
    assert blocks.ask(1.0) == (0, 2)
    assert blocks.ask(1.0 + 0.9 * ASK_EVERY_S) is None
    assert blocks.ask(1.0 + 1.1 * ASK_EVERY_S) == (0, 2)
    assert not blocks.is_overdue(1.0 + 0.9 * GAP_PATIENCE_S)
    assert blocks.is_overdue(1.0 + 1.1 * GAP_PATIENCE_S)


def test_progress_gives_a_gap_new_time() -> None:
    blocks = order()
    blocks.take(sent(3), now=0.0)
    blocks.take(sent(0), now=0.09)
    assert not blocks.is_overdue(0.15)
    assert blocks.is_overdue(0.2)
    blocks.take(sent(1), now=0.2)
    blocks.take(sent(2), now=0.2)
    assert blocks.gap is None
    assert not blocks.is_overdue(9.0)


def test_memory_is_bounded_by_how_far_ahead_a_block_may_be() -> None:
    blocks = order()
    for number in range(1, 5 * MOST_AHEAD):
        blocks.take(sent(number), now=0.0)
    assert len(blocks._ahead) == MOST_AHEAD - 1
    assert len(blocks.take(sent(0), now=0.0)) == MOST_AHEAD


def test_samples_that_skip_an_index_are_a_fault() -> None:
    blocks = order()
    spoilt = sent(0)
    with pytest.raises(DeviceError, match="begins with sample 1, where sample 0 follows"):
        blocks.take(spoilt._replace(samples=spoilt.samples._replace(first=1)), now=0.0)


@pytest.mark.parametrize("within", [True, False])
def test_a_clock_that_runs_backwards_is_a_fault(within: bool) -> None:
    blocks = order()
    blocks.take(sent(0), now=0.0)
    spoilt = sent(1)
    times = spoilt.samples.time_us
    wrong = times[::-1] if within else np.zeros_like(times)
    with pytest.raises(DeviceError, match="clock runs backwards near sample 5"):
        blocks.take(spoilt._replace(samples=spoilt.samples._replace(time_us=wrong)), now=0.0)


@pytest.mark.parametrize("within", [True, False])
def test_a_time_that_is_repeated_is_a_fault(within: bool) -> None:
    blocks = order()
    first = sent(0)
    blocks.take(first, now=0.0)
    spoilt = sent(1)
    times = spoilt.samples.time_us.copy()
    times[0 if not within else 3] = first.samples.time_us[-1] if not within else times[2]
    with pytest.raises(DeviceError, match=r"two samples have the same time near sample 5: .* 1 us"):
        blocks.take(spoilt._replace(samples=spoilt.samples._replace(time_us=times)), now=0.0)
