"""Cogging on one slope: its torque is a triangle wave, and the energies that its proofs rest on do what they say."""

from math import asin, exp, pi, sin, sqrt
from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general import cog_rest
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cogging import (
    CENTRE,
    LENGTH,
    PEAK,
    ROOT,
    SLOPE,
    cog_pull,
    energy_apart,
    far_apart,
    gap_apart,
    has_gone,
    hold_stiffness,
    middle_of,
    reach_on,
    room_on,
    slope_at,
    spring_of,
)
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.slopes import cog_many
from hknob_cli.engine.rest import AT_REST, MOVING
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.verification.general_scenes import TWO_PARTS, scene

WEAK = {"torque": 2e-4, "per_revolution": 84, "centre": 0.01}
STRONG = {"torque": 6e-3, "per_revolution": 84, "centre": 0.01}
COIL = {"torque_constant": 0.0234, "resistance": 2.32, "inductance": 2.38e-4, "winding": "shorted"}
BODIES: dict[str, dict[str, Any]] = {
    "weak": scene(cogging=WEAK),
    "strong": scene(cogging=STRONG),
    "finger": scene(hand=TWO_PARTS, cogging=WEAK),
    "strong, finger, lag": scene(hand=TWO_PARTS, actuator={"time_constant": 3e-4}, cogging=STRONG),
    "winding, lag": scene(motor=COIL, actuator={"time_constant": 3e-4}, cogging=STRONG),
    "no spring of a hand": scene(hand={"inertia": 3e-7, "damping": 3e-4, "stiffness": 0.0}, cogging=STRONG),
}


def body_of(name: str) -> Body:
    """The body of a scene at 1 kHz and 1024 counts."""
    plain = reduced(SceneSpec.model_validate(BODIES[name]).plain())
    return sample_general(plain, sample_rate_hz=1000.0, counts_per_rev=1024).body


def cogs_of(body: Body) -> list[float]:
    """Its numbers of cogging."""
    found: list[float] = body.cogs
    return found


def test_the_torque_is_a_triangle_wave() -> None:
    """Of arcsine of sine, towards its centre, to a rounding of its angle."""
    cogs, chance = cogs_of(body_of("strong")), Random(0)
    for _ in range(1000):
        x = chance.uniform(-300.0, 300.0)
        turned = pi * (x - cogs[CENTRE]) / cogs[LENGTH]
        assert cog_pull(cogs, x) == pytest.approx(-cogs[PEAK] * 2.0 / pi * asin(sin(turned)), abs=1e-11 * cogs[PEAK])
    assert cogs[ROOT] == sqrt(cogs[SLOPE])
    assert cog_pull(cogs, cogs[CENTRE]) == 0.0


def test_slopes_meet_at_their_corners() -> None:
    cogs = cogs_of(body_of("strong"))
    for slope in (-3.0, 0.0, 4.0):
        corner = middle_of(slope, cogs) + 0.5 * cogs[LENGTH]
        assert room_on(corner, slope, cogs) == pytest.approx(0.0, abs=1e-12)
        assert room_on(corner, slope + 1.0, cogs) == pytest.approx(0.0, abs=1e-12)
        assert spring_of(slope, cogs) == -spring_of(slope + 1.0, cogs)
        assert slope_at(corner - 1e-6, cogs) == slope
        assert slope_at(corner + 1e-6, cogs) == slope + 1.0


def start_of(body: Body, chance: Random, slope: float) -> list[float]:
    """A state near the middle of a slope, so slow that it stays on it for a while."""
    state = [chance.uniform(-0.05, 0.05) for _ in range(body.order)]
    state[0] += middle_of(slope, cogs_of(body))
    return state


@pytest.mark.one_in(7)
@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("slope", [0.0, 1.0, -3.0])
def test_the_energy_of_a_difference_never_grows_where_springs_hold(name: str, slope: float) -> None:
    """And bounds how far two motions are apart; the bound of a rounding is left to `energy_apart`."""
    body, chance = body_of(name), Random(f"{name} {slope}")
    cogs, pad = cogs_of(body), [0.0] * (2 * body.order)
    holds = hold_stiffness(cogs, middle_of(slope, cogs), body) > 0.0
    assert holds == (slope == 0.0 or name in ("weak", "finger"))
    for _ in range(20):
        one, other = start_of(body, chance, slope), start_of(body, chance, slope)
        dz = [a - b for a, b in zip(one, other, strict=True)]
        bound = far_apart(cogs, dz, middle_of(slope, cogs), body)
        assert holds == (bound < float("inf"))
        before = energy_apart(cogs, dz, middle_of(slope, cogs), body)
        u = -cog_pull(cogs, one[0])  # under which neither leaves the slope soon
        for _ in range(60):
            for z in (one, other):
                cog_many(cogs, z, u, 0.05, body, pad)
            if slope_at(one[0], cogs) != slope or slope_at(other[0], cogs) != slope:
                break
            dz = [a - b for a, b in zip(one, other, strict=True)]
            if holds:
                assert abs(dz[0]) <= bound * (1.0 + 1e-12)
                now = energy_apart(cogs, dz, middle_of(slope, cogs), body)
                assert now <= before * (1.0 + 1e-9)
                before = now


@pytest.mark.parametrize("name", BODIES)
def test_the_energy_of_rates_grows_by_the_root_of_a_slope_at_most(name: str) -> None:
    """By that the steps are chosen; with the spring of a stable slope, from matrices by halves of a sample."""
    body, chance = body_of(name), Random(name)
    n, cogs = body.order, cogs_of(body)
    a = np.array(body.matrices[: n * n]).reshape(n, n)
    entry = np.array(body.vectors[2 * n : 3 * n])
    for spring, rate in ((cogs[SLOPE], 0.0), (-cogs[SLOPE], cogs[ROOT])):
        beside = a.copy()
        beside[:, 0] -= spring * entry
        for _ in range(50):
            y = np.array([chance.uniform(-1.0, 1.0) for _ in range(n)])
            size = energy_apart(cogs, y.tolist(), cogs[CENTRE], body)
            for step in (0.1, 0.4, 0.7):
                values, vectors = np.linalg.eig(beside)
                moved = (vectors @ np.diag(np.exp(values * step)) @ np.linalg.inv(vectors) @ y).real
                grown = energy_apart(cogs, moved.tolist(), cogs[CENTRE], body)
                assert grown <= size * exp(rate * step) * (1.0 + 1e-8)


def test_reach_is_that_of_springs_together() -> None:
    body = body_of("weak")
    cogs = cogs_of(body)
    assert reach_on(cogs, cogs[CENTRE], body) == pytest.approx(1.0 / sqrt(body.beta + cogs[SLOPE]))
    assert reach_on(cogs, middle_of(1.0, cogs), body) == pytest.approx(1.0 / sqrt(body.beta - cogs[SLOPE]))
    strong = body_of("strong")
    own = cogs_of(strong)
    assert reach_on(own, middle_of(1.0, own), strong) == reach_on(own, own[CENTRE], strong)
    assert gap_apart(own, [1.0, 0.0], strong) >= 1.0


WALL = Controller(
    kappa=0.0, damping=0.0, sense=1.0, truncate=0.0, offset=0.0, analog=0.0, step=0.0, limit=float("inf"), split=0.0
)


@pytest.mark.parametrize(("slope", "fate"), [(0.0, AT_REST), (1.0, MOVING)])
def test_rest_is_where_springs_hold_and_nowhere_else(slope: float, fate: int) -> None:
    """Of a knob that stands in the middle of a slope, at a balance of all torques; above the wall's edge."""
    body = body_of("strong")
    cogs = cogs_of(body)
    x = middle_of(slope, cogs)
    assert x > 0.0
    u = body.push + body.beta * (x + body.shift)
    orbit, away = [0.0, 0.0], [0.0, 0.0]
    torque = cog_rest.LastTorque(u, 0.0, 0.0)
    found, gap = cog_rest.settles_free(cogs, [x, 0.0], torque, x // 1.0, body, WALL, orbit, away)
    assert found == fate
    if fate == AT_REST:
        assert orbit[0] == pytest.approx(x, abs=1e-12)
        assert gap == pytest.approx(x)


def test_rest_is_proven_up_to_the_corner_and_no_further() -> None:
    """A speed that carries the knob to the corner, by the energy of both springs, less or more than a millionth."""
    body = body_of("strong")
    cogs = cogs_of(body)
    middle = middle_of(2.0, cogs)
    u = body.push + body.beta * (middle + body.shift)
    most = 0.5 * cogs[LENGTH] * sqrt(body.beta + cogs[SLOPE])
    for part, fate in ((1.0 - 1e-6, AT_REST), (1.0 + 1e-6, MOVING)):
        z, orbit, away = [middle, part * most], [0.0, 0.0], [0.0, 0.0]
        found, _ = cog_rest.settles_free(
            cogs, z, cog_rest.LastTorque(u, 0.0, 0.0), middle // 1.0, body, WALL, orbit, away
        )
        assert found == fate


def test_what_torque_may_still_do_counts() -> None:
    """An impulse that is still to come, and a torque that is known to within so much, both up to the corner.

    Under a torque that is off by so much the knob may swing to twice as far as it then rests.
    """
    body = body_of("strong")
    cogs = cogs_of(body)
    middle, hold = middle_of(2.0, cogs), body.beta + cogs[SLOPE]
    u = body.push + body.beta * (middle + body.shift)
    room = 0.5 * cogs[LENGTH]
    for part, fate in ((1.0 - 1e-6, AT_REST), (1.0 + 1e-6, MOVING)):
        for wrong, push in ((0.5 * part * room * hold, 0.0), (0.0, part * room * sqrt(hold))):
            orbit, away = [0.0, 0.0], [0.0, 0.0]
            found, _ = cog_rest.settles_free(
                cogs, [middle, 0.0], cog_rest.LastTorque(u, wrong, push), middle // 1.0, body, WALL, orbit, away
            )
            assert found == fate


def test_a_trial_has_left_past_its_limit_or_far_and_too_fast_to_be_followed() -> None:
    """A thousandth of the limit, and 1024 corners between two samples, both; without cogging, the limit alone."""
    cogs, limit = [0.75, 8.0, -20.5, 3.0, sqrt(0.75), 28.5], 1000.0
    for side in (1.0, -1.0):
        assert has_gone(cogs, [side * limit, 0.0], limit)
        assert has_gone(None, [side * limit, 0.0], limit)
        assert not has_gone(cogs, [side * 999.0, 8192.0], limit)
        for way in (1.0, -1.0):
            assert has_gone(cogs, [side * 1.001, way * 8193.0], limit)
            assert not has_gone(cogs, [side * 1.001, way * 8192.0], limit)
            assert not has_gone(cogs, [side, way * 8193.0], limit)
            assert not has_gone(None, [side * 999.0, way * 1e300], limit)
