"""The table of torque over the angle, against the sum that it stands for, and runs against a search count by count."""

from math import inf

import numpy as np
import pytest

from hknob_cli.engine.general.controller import edge_gap, goes_on, inside, read
from hknob_cli.engine.general.torque_table import HEAD, command_at, run_at
from hknob_cli.scene.torque_over_angle import _runs

from .test_controller import wall


def table(
    command: list[float], *, first: int = 0, turn: int = 1, below: float = 0.0, above: float = 0.0
) -> list[float]:
    """A table of these commands from the count ``first``."""
    lows, highs = _runs(np.array(command), first, turn, below, above)
    return [float(first), float(turn), below, above, *command, *lows.tolist(), *highs.tolist()]


def searched(shown: int, one: list[float], far: int = 60) -> tuple[float, float]:
    """The run around a count, looked for one count at a time; infinite where none ends within ``far``."""
    low = high = shown
    while shown - low < far and command_at(float(low - 1), one) == command_at(float(shown), one):
        low -= 1
    while high - shown < far and command_at(float(high + 1), one) == command_at(float(shown), one):
        high += 1
    return (-inf if shown - low == far else low), (inf if high - shown == far else high)


STEPPED = [0.0, 0.0, 1.0, 1.0, 1.0, -2.0]  # a turn of six counts
TABLES = {
    "wall": table([3.0, 2.0, 1.0, 0.0, 0.0], first=-3, below=-1.0),
    "constant ends": table([5.0, 5.0, 5.0, 0.0, -1.0, -1.0, -1.0], first=-4),
    "pattern": table(STEPPED * 4, first=-9, turn=6),
    "pattern in a run over the turn": table([1.0, 1.0, 0.0, 0.0, 1.0, 1.0] * 4, first=2, turn=6),
    "pattern and springs": table(
        [s + max(0.0, 12.0 - i) for i, s in enumerate(STEPPED * 6)], first=-20, turn=6, below=-6.0
    ),
    "one run": table([2.0] * 4),
}


@pytest.mark.parametrize("name", TABLES)
def test_runs_end_where_the_command_changes(name: str) -> None:
    one = TABLES[name]
    for shown in range(-45, 46):
        assert run_at(float(shown), one) == searched(shown, one), shown


def test_a_table_goes_on_beyond_its_ends() -> None:
    one = TABLES["pattern and springs"]
    for shown in range(-100, 100):
        expected = STEPPED[(shown + 20) % 6] + max(0.0, -8.0 - shown)
        assert command_at(float(shown), one) == expected


def test_springs_on_both_sides() -> None:
    one = table([2.0, 1.0, 0.0, 0.0, -3.0, -6.0], first=-2, below=-1.0, above=-3.0)
    for shown in range(-40, 40):
        assert command_at(float(shown), one) == max(0.0, -shown) - 3.0 * max(0.0, shown - 1)


@pytest.mark.parametrize("name", TABLES)
def test_positions_that_no_double_tells_apart_have_a_command(name: str) -> None:
    one = TABLES[name]
    chance = np.random.default_rng(1)
    for size in [1e300, *(10.0 ** chance.uniform(16.0, 22.0, 300)).round().tolist()]:
        for shown in (size, -size):
            assert abs(command_at(shown, one)) <= 10.0 + 2.0 * size
            assert run_at(shown, one)[0] <= run_at(shown, one)[1]


def test_a_turn_changes_nothing() -> None:
    one = TABLES["pattern"]
    for shown in range(-40, 40):
        low, high = run_at(float(shown), one)
        for turns in (-7, 1, 12):
            there = shown + 6.0 * turns
            assert command_at(there, one) == command_at(float(shown), one)
            assert run_at(there, one) == (low + 6.0 * turns, high + 6.0 * turns)


@pytest.mark.parametrize(("rounding", "ends"), [("floor", (0.0, 1.0)), ("ceil", (-1.0, 0.0))])
def test_gap_is_to_where_the_command_changes(rounding: str, ends: tuple[float, float]) -> None:
    sense = 1.0 if rounding == "floor" else -1.0
    one = wall(sense=sense)._replace(table=TABLES["pattern"])
    for x in np.linspace(-13.9, 13.9, 173):
        shown = read(float(x), one)
        low, high = run_at(shown, TABLES["pattern"])
        assert edge_gap(float(x), shown, shown, one) == min(x - (low + ends[0]), high + ends[1] - x)


def test_gap_of_an_encoder_that_truncates() -> None:
    """The count 0 is two counts wide: from -1 to 1."""
    one = wall(sense=-1.0, truncate=1.0)._replace(table=table([1.0, 1.0, 0.0, 2.0, 2.0], first=-2))
    assert edge_gap(0.25, 0.0, 0.0, one) == 0.75
    assert edge_gap(-0.25, 0.0, 0.0, one) == 0.75
    assert edge_gap(1.5, 1.0, 1.0, one) == 0.5
    assert edge_gap(-1.5, -1.0, -1.0, one) == 0.5


def test_with_virtual_damping_every_count_matters() -> None:
    one = wall(damping=1.0)._replace(table=TABLES["one run"])
    assert edge_gap(7.25, 7.0, 7.0, one) == 0.25
    assert edge_gap(7.25, 7.0, 7.0, one._replace(damping=0.0)) == inf


def test_nothing_ahead_is_told_by_the_way_it_turns() -> None:
    one = wall()._replace(table=TABLES["wall"])
    assert goes_on(1.0, 4.0, one)
    assert not goes_on(-1.0, 4.0, one)
    assert not goes_on(1.0, -2.0, one)
    assert not goes_on(1.0, 4.0, one._replace(table=TABLES["pattern"]))


def test_virtual_damping_lies_ahead_below_0() -> None:
    """On the way into the wall, and on the way out of it; not outside."""
    for table in (None, TABLES["one run"]):
        one = wall(damping=1.0)._replace(table=table)
        assert not goes_on(-1.0, 4.0, one)
        assert not goes_on(1.0, -4.0, one)
        assert goes_on(1.0, 4.0, one)


def test_levels_of_a_wall_are_those_of_its_table() -> None:
    one = wall()
    tabled = one._replace(table=TABLES["wall"])
    for shown in range(-9, 9):
        assert inside(float(shown), one) == inside(float(shown), tabled)


def test_without_a_table_nothing_ends_a_run() -> None:
    assert wall().table is None
    assert command_at(3.0, None) == 0.0
    assert run_at(3.0, None) == (-inf, inf)
    assert len(TABLES["wall"]) == HEAD + 3 * 5
