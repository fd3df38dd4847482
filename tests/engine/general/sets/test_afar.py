"""What a wall of the general loop is taken for from far out: its torque is never outside the limits."""

from math import inf
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hknob_cli.engine.general.controller import Controller, command, read
from hknob_cli.engine.general.sets.afar import look_from_afar
from hknob_cli.engine.sets.absorbing import pushes
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.scene import SceneSpec
from tests.verification.general_scenes import scene

FREE: dict[str, Any] = {"wall": {"stiffness": 0.0}}
STEP = 0.27 * 2.0 * np.pi / 1024  # the wall's torque at one count


KINDS: list[dict[str, Any]] = [
    {"detents": {"per_revolution": 60, "torque": 4e-3}},
    {"profile": {"points": [[-0.05, 4e-3], [0.0, 1e-3], [0.04, -2e-3]]}},
    {"end_stops": {"low": -0.02, "high": 0.03, "stiffness": 0.3}},
    {"dead_zone": {"width": 0.06, "stiffness": 0.2}},
]


def knob_of(**more: Any) -> GeneralKnob:
    return sample_general(SceneSpec.model_validate(scene(**more)).plain(), sample_rate_hz=1000.0, counts_per_rev=1024)


def within(knob: GeneralKnob, x: float) -> bool:
    """Whether the torque at a position is that of the spring and a push between the limits.

    The edge itself goes both ways (`engine.sets.region.advance`): with some roundings its reading is inside.
    """
    afar = look_from_afar(knob.body, knob.wall)
    loop, limits = afar
    shown = read(x, knob.wall)
    total = command(shown, shown, knob.wall) + knob.body.drive
    slack = 1e-12 * (abs(total) + max(loop.kappa, limits.outside) * abs(x))
    inside = limits.least_inside - slack <= total + loop.kappa * x <= limits.most_inside + slack
    outside = limits.least_outside - slack <= total + limits.outside * x <= limits.most_outside + slack
    return inside if x < limits.edge else outside if x > limits.edge else inside or outside


@given(
    x=st.floats(-1e6, 1e6) | st.floats(-5.0, 5.0) | st.integers(-50, 50).map(float),
    rounding=st.sampled_from(["floor", "ceil", "nearest", "truncate"]),
    actuator=st.fixed_dictionaries(
        {},
        optional={
            "torque_limit": st.floats(0.1 * STEP, 100.0 * STEP),
            "torque_step": st.floats(0.01 * STEP, 5.0 * STEP),
            "dead_band": st.floats(0.01 * STEP, 5.0 * STEP),
        },
    ),
)
@example(-1.0, "ceil", {})
def test_the_torque_of_a_wall_is_within_the_limits(x: float, rounding: str, actuator: dict[str, float]) -> None:
    assert within(knob_of(actuator=actuator, encoder={"rounding": rounding}), x)


@given(
    x=st.floats(-3000.0, 3000.0) | st.floats(-5.0, 5.0) | st.integers(-2000, 2000).map(float),
    limit=st.none() | st.floats(1e-4, 1e-2),
    kind=st.sampled_from(KINDS),
    free=st.booleans(),
    rounding=st.sampled_from(["floor", "ceil", "nearest", "truncate"]),
)
def test_the_torque_over_the_angle_is_within_the_limits(
    x: float, limit: float | None, kind: dict[str, Any], free: bool, rounding: str
) -> None:
    """With the wall, which is a spring below 0, or without."""
    more = {"actuator": {"torque_limit": limit}} if limit else {}
    assert within(knob_of(**(FREE if free else {}), **kind, **more, encoder={"rounding": rounding}), x)


def test_a_limited_wall_pushes_outward_only() -> None:
    """The bounds are met: at rest outside by the bias alone, deep inside by all that there is."""
    knob = knob_of(actuator={"torque_limit": 3.0 * STEP})
    afar = look_from_afar(knob.body, knob.wall)
    drive, most = knob.body.drive, knob.wall.limit
    assert afar.loop.kappa == 0.0
    assert afar.limits[1:] == (drive, drive, drive, drive + most, 0.0)


def test_a_step_and_a_band_add_what_they_hide() -> None:
    for actuator, hidden in (({"torque_step": STEP}, 0.5), ({"dead_band": STEP}, 1.0)):
        knob = knob_of(actuator=actuator)
        afar = look_from_afar(knob.body, knob.wall)
        slack = pushes(afar.loop).least_inside - afar.limits.least_inside
        unit = max(knob.wall.step, knob.wall.band)
        assert slack == pytest.approx(hidden * unit, rel=1e-8)
        assert slack > hidden * unit


STOPS: dict[str, Any] = {"end_stops": {"low": -0.02, "high": 0.03, "stiffness": 0.3}}


def test_stops_are_springs_to_both_sides_unless_a_limit_holds_them() -> None:
    knob = knob_of(**FREE, **STOPS)
    loop, limits = look_from_afar(knob.body, knob.wall)
    assert loop.kappa == pytest.approx(limits.outside, rel=1e-12)
    assert loop.kappa * knob.torque_nm / knob.quantum_rad == pytest.approx(0.3, rel=1e-9)
    held = knob_of(**FREE, **STOPS, actuator={"torque_limit": 3e-3})
    loop, limits = look_from_afar(held.body, held.wall)
    assert (loop.kappa, limits.outside) == (0.0, 0.0)
    assert limits.most_inside - limits.least_inside == pytest.approx(2.0 * held.wall.limit)


def test_a_wall_beside_detents_is_a_spring_and_what_they_add() -> None:
    knob = knob_of(detents={"per_revolution": 60, "torque": 4e-3})
    afar = look_from_afar(knob.body, knob.wall)
    assert afar.loop.kappa == pytest.approx(knob.wall.kappa, rel=1e-12)
    outside = afar.limits.most_outside - afar.limits.least_outside
    assert outside * knob.torque_nm == pytest.approx(8e-3, rel=0.1)
    inside = afar.limits.most_inside - afar.limits.least_inside
    assert inside * knob.torque_nm == pytest.approx(8e-3 + 2.0 * STEP, rel=0.1)


def test_a_profile_is_as_large_as_it_is() -> None:
    """Of a torque without a limit: its own least and most."""
    knob = knob_of(**FREE, detents={"per_revolution": 60, "torque": 4e-3})
    assert isinstance(knob.wall, Controller)
    assert knob.wall.limit == inf
    afar = look_from_afar(knob.body, knob.wall)
    width = afar.limits.most_inside - afar.limits.least_inside
    assert width * knob.torque_nm == pytest.approx(8e-3, rel=0.05)
