"""The command law, against values worked out by hand; K = 2, levels are counts."""

from math import inf

import pytest

from hknob_cli.engine.general.controller import Controller, command, depth_level, edge_gap, read, slopes


def wall(**changes: float) -> Controller:
    """A wall of stiffness 2 on floor counts, with ``changes``."""
    plain = Controller(
        kappa=2.0, damping=0.0, sense=1.0, truncate=0.0, offset=0.0, analog=0.0, step=0.0, limit=inf, split=0.0
    )
    return plain._replace(**changes)


@pytest.mark.parametrize(
    ("changes", "x", "shown"),
    [
        ({}, -0.25, -1.0),
        ({}, 0.75, 0.0),
        ({}, -2.0, -2.0),
        ({"sense": -1.0}, -0.25, 0.0),
        ({"sense": -1.0}, -1.25, -1.0),
        ({"sense": -1.0}, 1.25, 2.0),
        ({"sense": -1.0, "truncate": 1.0}, 1.25, 1.0),
        ({"sense": -1.0, "truncate": 1.0}, -1.25, -1.0),
        ({"analog": 1.0}, -0.25, -0.25),
    ],
)
def test_reading(changes: dict[str, float], x: float, shown: float) -> None:
    assert read(x, wall(**changes)) == shown


@pytest.mark.parametrize(
    ("changes", "shown", "before", "u"),
    [
        ({}, -3.0, -1.0, 6.0),
        ({}, 0.0, -1.0, 0.0),
        ({}, 4.0, -1.0, 0.0),
        ({"offset": 0.25}, -3.0, -3.0, 5.5),
        ({"offset": 0.25}, 0.0, 0.0, 0.0),
        ({"damping": 0.5}, -3.0, -1.0, 7.0),  # 6 - 0.5 (-3 + 1): pushes out while it goes in
        ({"damping": 0.5}, -3.0, -5.0, 5.0),
        ({"damping": 4.0}, -1.0, -3.0, -6.0),  # pulls in: the wall is not one-sided
        ({"step": 4.0}, -3.0, -3.0, 8.0),  # 6/4 = 1.5 rounds up
        ({"step": 4.0}, -1.0, -1.0, 4.0),  # 0.5 rounds up
        ({"step": 5.0}, -1.0, -1.0, 0.0),
        ({"limit": 5.0}, -3.0, -3.0, 5.0),
        ({"band": 6.0}, -3.0, -3.0, 6.0),  # as large as the band: sent
        ({"band": 6.5}, -3.0, -3.0, 0.0),
        ({"band": 6.5, "damping": 8.0}, -1.0, -3.0, -14.0),
        ({"band": 1.5, "step": 4.0}, -1.0, -1.0, 4.0),  # the converter comes after the dead band
        ({"band": 2.5, "step": 4.0}, -1.0, -1.0, 0.0),
        ({"limit": 5.0, "damping": 4.0}, -1.0, -3.0, -5.0),
        ({"limit": 5.0, "step": 4.0}, -3.0, -3.0, 5.0),  # the amplifier comes after the converter
        ({"analog": 1.0}, -0.75, -0.5, 1.5),
    ],
)
def test_command(changes: dict[str, float], shown: float, before: float, u: float) -> None:
    assert command(shown, before, wall(**changes)) == u


@pytest.mark.parametrize(
    ("changes", "x", "before", "gap"),
    [
        ({}, -1.25, -1.0, 0.25),
        ({}, 7.5, 0.0, 7.5),  # outside, only the wall's edge matters
        ({"sense": -1.0}, 7.5, 0.0, 8.5),
        ({"damping": 1.0}, 7.25, 7.0, 0.25),  # the reading there still counts at the next sample
        ({"damping": 1.0, "sense": -1.0, "truncate": 1.0}, 0.25, 0.0, 0.75),
        ({"damping": 1.0, "sense": -1.0, "truncate": 1.0}, -0.25, 0.0, 0.75),
        ({"analog": 1.0}, -1.25, -1.0, 1.25),
        ({"analog": 1.0, "limit": 2.0}, -1.25, -1.0, 0.25),
        ({"analog": 1.0, "step": 1.0}, -0.625, -1.0, 0.125),  # 1.25 rounds to 1; 1.5 is the next jump
        ({"analog": 1.0, "band": 2.0}, -1.25, -1.0, 0.25),
        ({"analog": 1.0, "band": 2.0}, -0.875, -1.0, 0.125),  # from below
        ({"analog": 1.0, "band": 2.0, "step": 1.0}, -0.625, -1.0, 0.375),  # below the band no step is sent
        ({"analog": 1.0, "band": 1.0, "step": 1.0}, -0.625, -1.0, 0.125),
    ],
)
def test_gap(changes: dict[str, float], x: float, before: float, gap: float) -> None:
    one = wall(**changes)
    assert edge_gap(x, read(x, one), before, one) == gap


def test_saturation_by_virtual_damping_is_in_the_gap() -> None:
    """u = 2 * 1 + 3 (1 - 0.5) = 3.5 of 4: while x and the reading before move by less than 0.5 / (2 + 2 * 3)."""
    one = wall(analog=1.0, damping=3.0, limit=4.0)
    gap = edge_gap(-1.0, -1.0, -0.5, one)
    assert gap == 0.5 / 8.0
    assert command(-1.0 - 0.99 * gap, -0.5 + 0.99 * gap, one) < 4.0
    assert command(-1.0 - 1.01 * gap, -0.5 + 1.01 * gap, one) == 4.0


@pytest.mark.parametrize(("shown", "before"), [(-1.0, -0.5), (-0.25, -0.75), (0.5, 1.0), (-9.0, -1.0)])
def test_slopes_are_differences(shown: float, before: float) -> None:
    """The law is piecewise linear: differences are slopes except for rounding."""
    one, h = wall(analog=1.0, damping=0.5, limit=8.0), 2.0**-20
    first = (command(shown + h, before, one) - command(shown - h, before, one)) / (2 * h)
    second = (command(shown, before + h, one) - command(shown, before - h, one)) / (2 * h)
    assert slopes(shown, before, one) == (first, second)


@pytest.mark.parametrize(("shown", "found"), [(-0.4, (0.0, 0.0)), (-0.5, (-2.5, 0.5)), (-4.0, (0.0, 0.0))])
def test_a_torque_that_is_not_sent_has_no_slope(shown: float, found: tuple[float, float]) -> None:
    one = wall(analog=1.0, damping=0.5, band=1.0, limit=8.0)
    assert slopes(shown, shown, one) == found


@pytest.mark.parametrize(
    ("changes", "levels"),
    [
        ({}, [0.0, 0.0, -1.0, -1.0, -1.0, -1.0]),
        ({"band": 1.0}, [0.0, 0.0, -1.0, -2.0, -2.0, -2.0]),
        ({"step": 1.0}, [0.0, 0.0, -2.0, -3.0, -3.0, -4.0]),
        ({"band": 1.5, "step": 1.0}, [0.0, 0.0, -1.0, -1.0, -1.0, -4.0]),
    ],
)
def test_levels_on_the_way_into_the_wall(changes: dict[str, float], levels: list[float]) -> None:
    """The torques at these places are 0, 0, 0.25, 1, 1.25 and 2."""
    places = [0.5, 0.0, -0.125, -0.5, -0.625, -1.0]
    assert [depth_level(x, wall(analog=1.0, **changes)) for x in places] == levels
    assert [depth_level(x, wall(**changes)) for x in (2.0, -1.0, -2.0)] == [0.0, -1.0, -2.0]
