"""Tests of `search.as_compiled`: one compiled code has all parts, and a part that is empty there is as none."""

from collections.abc import Callable
from math import inf
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general import (
    cog_rest,
    cogging,
    columns,
    hysteresis,
    interval,
    slope_columns,
    slopes,
    torque_curve,
    torque_table,
)
from hknob_cli.engine.general.search import as_compiled
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.scene import SceneSpec
from tests.verification.general_scenes import scene

from .bodies import fresh_marks, knob

ONE = knob()
HELD = cog_rest.LastTorque(0.1, 0.0, 0.0)
PARTS: dict[str, dict[str, Any]] = {
    "cogs": {"cogging": {"torque": 1e-4, "per_revolution": 24}},
    "table": {"detents": {"per_revolution": 24, "torque": 2e-3}},
    "clock": {"clock": {"jitter": 0.1}},
    "curve": {"detents": {"per_revolution": 24, "torque": 2e-3}, "encoder": "none"},
}
# Each function that is given a part which may be absent, and what it says without it.
ABSENT: dict[str, tuple[Callable[[Any], Any], Any]] = {
    "is_there": (torque_table.is_there, False),
    "command_at": (lambda table: torque_table.command_at(3.0, table), 0.0),
    "run_at": (lambda table: torque_table.run_at(3.0, table), (-inf, inf)),
    "jitters": (interval.jitters, False),
    "next_span": (interval.next_span, 1.0),
    "meant_pace": (lambda clock: interval.meant_pace(0.5, clock), 0.5),
    "begin_clock": (lambda clock: interval.begin_clock(clock, 1.0), None),
    "has_curve": (torque_curve.has_curve, False),
    "curve_at": (lambda curve: torque_curve.curve_at(3.0, curve), (0.0, 0.0, inf, 0.0, 0.0)),
    "bend_of": (torque_curve.bend_of, 0.0),
    "rounded_size": (lambda curve: torque_curve.rounded_size(3.0, curve), 0.0),
    "place_at": (lambda curve: torque_curve.place_at(3.0, curve), 0.0),
    "has_cogs": (cogging.has_cogs, False),
    "has_gone": (lambda cogs: cogging.has_gone(cogs, [9.0, 1e9], 10.0), False),
    "cog_pull": (lambda cogs: cogging.cog_pull(cogs, 3.0), 0.0),
    "cog_number": (lambda cogs: cogging.cog_number(cogs, cogging.PEAK), 0.0),
    "slope_of": (lambda cogs: cogging.slope_of(cogs, 3.0), 0.0),
    "slope_pull": (lambda cogs: cogging.slope_pull(cogs, 3.0, 1.0), 0.0),
    "cog_room": (lambda cogs: cogging.cog_room(cogs, 3.0, 1.0), inf),
    "least_share": (lambda cogs: cogging.least_share(cogs, 1.0, 1.0), 1.0),
    "corner_told": (lambda cogs: cogging.corner_told(cogs, 3.0, 1.0, 1.0, 1.0, 1, 1.0), True),
    "corner_passed": (lambda cogs: cogging.corner_passed(cogs, 3.0, 1.0, 1.0), 0),
    "hold_stiffness": (lambda cogs: cogging.hold_stiffness(cogs, 3.0, ONE.body), inf),
    "far_apart": (
        lambda cogs: cogging.far_apart(cogs, [1.0, 0.5], 3.0, ONE.body),
        cogging.distance([1.0, 0.5], ONE.body),
    ),
    "far_around": (
        lambda cogs: cogging.far_around(cogs, [1.0, 0.5], 3.0, ONE.body),
        cogging.distance([1.0, 0.5], ONE.body),
    ),
    "reach_on": (lambda cogs: cogging.reach_on(cogs, 3.0, ONE.body), ONE.body.reach),
    "gap_apart": (
        lambda cogs: cogging.gap_apart(cogs, [1.0, 0.5], ONE.body),
        cogging.distance([1.0, 0.5], ONE.body),
    ),
    "cog_many": (lambda cogs: slopes.cog_many(cogs, [1.0, 0.5], 0.1, 1.0, ONE.body, [0.0] * 4), None),
    "cog_columns": (
        lambda cogs: slope_columns.cog_columns(
            cogs, [1.0, 0.5], 0.1, 1.0, ONE.body, [0.0] * 4, columns.Columns([0.0] * 9, 0, 1, 3), fresh_marks()
        ),
        None,
    ),
    "cog_chart": (lambda cogs: slopes.cog_chart(cogs, [1.0, 0.5], 0.1, 1.0, ONE.body, [0.0] * 4, 5, None), 5),
    "settles_free": (
        lambda cogs: cog_rest.settles_free(cogs, [1.0, 0.5], HELD, 1.0, ONE.body, ONE.wall, [0.0] * 2, None),
        (cog_rest.MOVING, 0.0),
    ),
    "keeps_to_slope": (
        lambda cogs: cog_rest.keeps_to_slope(cogs, [1.0, 0.5], HELD, 1.0, ONE.body, ONE.wall, [0.0] * 2, None),
        (False, 0.0),
    ),
    "turn_on_cogs": (
        lambda cogs: hysteresis.turn_on_cogs(cogs, [1.0, 0.5], 0.1, 1.0, 1.0, ONE.body, ONE.wall, [0.0] * 4),
        (1.0, inf),
    ),
}


def cell_of(part: str) -> GeneralKnob:
    """A knob with one of the parts."""
    parts = SceneSpec.model_validate(scene(**PARTS[part])).plain()
    return sample_general(parts, sample_rate_hz=1000.0, counts_per_rev=None if part == "curve" else 1024)


@pytest.mark.parametrize("name", ABSENT)
def test_an_empty_part_is_as_none(name: str) -> None:
    ask, said = ABSENT[name]
    assert ask(None) == said
    assert ask([]) == said
    assert ask(np.zeros(0)) == said


def test_a_scene_without_any_part_has_none_of_them() -> None:
    body, wall = as_compiled(ONE.body, ONE.wall)
    assert (body.cogs, wall.table, wall.clock, wall.curve) == (None,) * 4


@pytest.mark.parametrize("part", PARTS)
def test_beside_one_part_the_others_are_empty(part: str) -> None:
    cell = cell_of(part)
    body, wall = as_compiled(cell.body, cell.wall)
    found = {"cogs": body.cogs, "table": wall.table, "clock": wall.clock, "curve": wall.curve}
    given = {"cogs": cell.body.cogs, "table": cell.wall.table, "clock": cell.wall.clock, "curve": cell.wall.curve}
    for name, value in found.items():
        assert value.dtype == np.float64, name
        assert list(value) == (list(given[name]) if name == part else []), name
