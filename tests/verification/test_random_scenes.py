"""A few of the random scenes of `random_scenes`: trials, outcomes, proven cycles and energy against 60 digits."""

import pytest

from hknob_cli.specs.capabilities import PARTS

from .random_scenes import LEAST_PARTS, MAKERS, NOT_DRAWN, Verdict, compare, draw

FEW = 12


def run(numbers: range, *, in_code: bool = True) -> list[Verdict]:
    """What was compared of the scenes of these numbers."""
    return [compare(draw(number), in_code=in_code) for number in numbers]


def test_every_part_of_the_table_is_drawn_or_has_a_reason() -> None:
    assert {*MAKERS, *NOT_DRAWN} == set(PARTS)
    assert not MAKERS.keys() & NOT_DRAWN.keys()


def test_a_number_is_one_scene_of_three_parts_or_more() -> None:
    assert draw(7) == draw(7)
    assert all(len(draw(number).parts) >= LEAST_PARTS for number in range(FEW))


def test_a_few_scenes() -> None:
    """Interpreted: a compiler would take longer for a controller beside a part over the angle than all of them."""
    found = run(range(FEW), in_code=False)
    assert sum(one.samples > 0 for one in found) >= FEW - 2
    assert sum(one.settled for one in found) >= FEW // 2
    assert sum(one.cycles for one in found) >= 3


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("first", range(FEW, FEW + 480, 20))
def test_many_scenes(first: int) -> None:
    found = run(range(first, first + 20))
    assert sum(one.settled for one in found) >= 5
    assert sum(one.cycles for one in found) >= 2
