"""Tests of `specs.capability_parts`: pairs that are less together, some of them unless a third part is there."""

import pytest

from hknob_cli.specs.capabilities import (
    COLUMNS,
    EXCEPTIONS,
    LOWEST_FIRST,
    PARTS,
    PHASES,
    RANGES,
    VERDICTS,
    takes,
    verdict_of,
)


def engine_for(parts: set[str], engines: tuple[str, ...]) -> str:
    return next(one for one in engines if takes(one, parts))


def test_a_pair_is_less_than_each_of_its_parts() -> None:
    """And of parts and columns that there are."""
    for (one, other, column), lower in EXCEPTIONS.items():
        assert column in COLUMNS
        assert {one, other, *lower.unless} <= set(PARTS)
        for part in (one, other):
            assert LOWEST_FIRST.index(lower.verdict) < LOWEST_FIRST.index(VERDICTS[part, column])
        assert verdict_of({one, other}, column)[0] == lower.verdict


@pytest.mark.parametrize("engines", [PHASES, RANGES])
@pytest.mark.parametrize("part", ["hysteresis", "backlash"])
def test_all_starts_with_friction_are_followed_behind_hysteresis(part: str, engines: tuple[str, ...]) -> None:
    """By the sets with friction, and without it by those that followed them before."""
    for others in ({"delay"}, {"lag"}, {"current_loop"}, {"detents"}, {"controller"}, {"virtual_damping"}):
        assert engine_for({part, "friction", *others}, engines) == "friction_sets"
        engine = engine_for({part, *others}, engines)
        assert engine == ("law_sets" if others & {"controller", "virtual_damping"} else "general_sets")
    assert engine_for({part, "controller", "several_readings"}, engines) == "friction_sets"
    arcs = engines == PHASES
    assert engine_for({part, "controller", "several_readings", "lag"}, engines) == ("friction_arcs" if arcs else "laws")
    assert engine_for({part, "friction", "finger"}, engines) == ("friction_arcs" if arcs else "general")
