"""Ranges: every item is handed out once, in pieces that respect the parts, whatever is lost on the way."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.spread.ranges import Range, Ranges


@given(st.integers(0, 200), st.integers(1, 50), st.integers(1, 5), st.data())
def test_every_item_once(total: int, parts: int, unit: int, data: st.DataObject) -> None:
    part = parts * unit
    cuts = sorted(unit * cut for cut in data.draw(st.sets(st.integers(0, total // unit), max_size=6)))
    done = [pair for i, pair in enumerate(pairwise(cuts)) if i % 2 == 0]
    left = Ranges(total, done=done, part=part, unit=unit)
    assert len(left) == total - sum(stop - start for start, stop in done)
    seen: list[int] = []
    lost = 0
    while len(left):
        asked = data.draw(st.integers(1, 60))
        one = left.take(asked)
        assert 0 < one.items <= max(2 * asked, unit)
        assert one.start % unit == 0
        assert one.stop % unit == 0 or one.stop == total
        assert one.start // part == (one.stop - 1) // part
        if lost < 5 and data.draw(st.booleans()):
            lost += 1
            left.give_back([one])
            continue
        seen += range(one.start, one.stop)
    assert sorted(seen) == [i for i in range(total) if not any(start <= i < stop for start, stop in done)]


def test_lost_items_come_back_first_and_in_halves() -> None:
    left = Ranges(10)
    first = left.take(4)
    left.give_back([first])
    assert left.take(10) == Range(0, 2, 1)
    assert left.take(10) == Range(2, 4, 1)
    assert left.take(10) == Range(4, 10, 0)
    with pytest.raises(IndexError):
        left.take(1)


def test_what_nobody_is_at_comes_back_as_it_was() -> None:
    left = Ranges(10)
    one, other = left.take(3), left.take(3)
    left.put_back([one, other])
    assert left.deaths == 0
    assert [left.take(5), left.take(5), left.take(9)] == [one, other, Range(6, 10)]
    assert left.deaths == 0


def test_the_lowest_items_come_first_whatever_came_back_before() -> None:
    left = Ranges(20)
    one, other = left.take(4), left.take(4)
    left.give_back([one])
    left.put_back([other])
    assert left.deaths == 1
    assert [left.take(4) for _ in range(4)] == [Range(0, 2, 1), Range(2, 4, 1), other, Range(8, 12)]


def test_what_is_nearly_all_of_a_part_is_taken_whole() -> None:
    left = Ranges(26, part=10)
    found = [left.take(most) for most in (5, 4, 2, 2)]
    assert found == [Range(0, 10), Range(10, 14), Range(14, 16), Range(16, 20)]
    assert left.take(3) == Range(20, 26)
