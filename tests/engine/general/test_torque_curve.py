"""The curve of torque over the angle against the 60-digit words of its parts, and its rooms against their insides."""

from itertools import pairwise
from math import inf
from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.controller import (
    bends,
    command,
    count_gap,
    edge_gap,
    follows,
    goes_on,
    slopes,
    table_size,
)
from hknob_cli.engine.general.torque_curve import (
    DETENT,
    POINTS,
    bend_of,
    curve_at,
    curve_torque,
    has_curve,
    place_at,
    rounded_size,
)
from hknob_cli.engine.general.torque_range import torque_range
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.scene import SceneSpec
from tests import digits as mp
from tests.verification.general_scenes import scene
from tests.verification.over_angle_reference import along_angle, jumps
from tests.verification.test_over_angle import random_part

ROUNDINGS = 16.0 * 2.0**-53
ANGLES = 400  # tried of a curve
SEEDS = range(60)


def made(parts: dict[str, Any], **more: Any) -> GeneralKnob:
    plain = SceneSpec.model_validate(scene(encoder="none", **parts, **more)).plain()
    return sample_general(plain, sample_rate_hz=1000.0, counts_per_rev=None)


def tried(seed: int) -> tuple[GeneralKnob, Any, Any, list[float]]:
    """A cell without a wall, the model's torque and jumps, and angles: some of all, more near where something ends."""
    chance = Random(f"curve {seed}")
    parts = random_part(chance)
    whole = scene(wall={"stiffness": 0.0}, encoder="none", **parts)
    knob = made(parts, wall={"stiffness": 0.0})
    near = [float(one) for one in knob.wall.curve if abs(one) < 1e4]
    at = [chance.uniform(-700.0, 700.0) for _ in range(ANGLES)]
    at += [one + chance.uniform(-1.0, 1.0) * 10.0 ** chance.uniform(-8.0, 1.0) for one in near for _ in range(4)]
    return knob, along_angle(whole), jumps(whole), at


@pytest.mark.one_in(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_torque_is_that_of_the_words(seed: int) -> None:
    """To some roundings of the size of what it is made of; a jump is as near as the rounding of its place."""
    knob, exact, jump, angles = tried(seed)
    for x in angles:
        theta = mp.mpf(x) * mp.mpf(knob.quantum_rad)
        if jump(theta) < 1e-12:
            continue
        off = abs(mp.mpf(curve_torque(x, knob.wall.curve)) - exact(theta) / mp.mpf(knob.torque_nm))
        assert off <= ROUNDINGS * rounded_size(x, knob.wall.curve), (x, float(off))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_within_its_room_a_torque_goes_on_by_its_slope(seed: int) -> None:
    """Off the line by no more than the bend allows, and nowhere steeper than the steepest slope."""
    knob, _, _, angles = tried(seed)
    curve, chance = knob.wall.curve, Random(seed)
    for x in angles:
        u, slope, room, steepest, _ = curve_at(x, curve)
        assert room >= 0.0
        assert abs(slope) <= steepest * (1.0 + 1e-12)
        for _ in range(4):
            step = chance.uniform(-1.0, 1.0) * min(room, 1000.0) * (1.0 - 1e-9)
            there = curve_torque(x + step, curve)
            rounding = 4.0 * ROUNDINGS * (rounded_size(x, curve) + rounded_size(x + step, curve))
            assert abs(there - (u + slope * step)) <= 0.5 * bend_of(curve) * step * step + rounding, (x, step)
            assert abs(curve_at(x + step, curve)[1] - slope) <= bend_of(curve) * abs(step) + 1e-9 * steepest


def test_a_room_ends_where_something_changes() -> None:
    """At the nearer knee or step of all parts: it is not shorter than it must be."""
    parts = {
        "profile": {"points": [[-0.2, 0.001], [-0.1, 0.003], [0.3, -0.004]]},
        "end_stops": {"low": -0.15, "high": 0.25, "stiffness": 0.3},
    }
    curve = made(parts, wall={"stiffness": 0.0}).wall.curve
    ends = [-200.0, -150.0, -100.0, 250.0, 300.0]
    for x in np.linspace(-400.0, 400.0, 161) + 0.3:
        assert curve_at(float(x), curve)[2] == pytest.approx(min(abs(x - end) for end in ends), rel=1e-12)
    spring = made({"dead_zone": {"width": 0.0, "stiffness": 0.3}}, wall={"stiffness": 0.0}).wall.curve
    assert curve_at(0.0, spring)[2] == inf  # without a width a zone is a spring, and has no knee
    whole = made({"detents": {"per_revolution": 12, "torque": 0.01, "shape": "spring"}}).wall.curve
    assert curve_at(0.0, whole)[2] == pytest.approx(500.0 * np.pi / 6.0, rel=1e-12)


def test_the_wall_ends_a_room_too() -> None:
    """Its spring, and its damping by the last reading, are in the command and its slopes."""
    walled = made({"dead_zone": {"width": 0.1, "stiffness": 0.2}}, wall={"stiffness": 0.27, "damping": 1e-5}).wall
    assert edge_gap(3.0, 3.0, 3.0, walled) == count_gap(3.0, walled) == 3.0
    assert command(3.0, 9.0, walled) == 0.0
    assert slopes(3.0, 9.0, walled) == (0.0, 0.0)
    assert command(-3.0, -2.0, walled) == walled.kappa * 3.0 + walled.damping
    assert slopes(-3.0, -2.0, walled) == (-walled.kappa - walled.damping, walled.damping)
    assert follows(-3.0, walled)
    assert not follows(3.0, walled)
    assert not goes_on(1.0, 3.0, walled)
    assert table_size(3.0, walled) == 0.0
    limited = walled._replace(limit=walled.kappa, damping=0.0)
    assert not follows(-3.0, limited)
    assert slopes(-3.0, -3.0, limited) == (0.0, 0.0)
    assert edge_gap(-3.0, -3.0, -3.0, limited) == pytest.approx(2.0)
    assert edge_gap(-0.25, -0.25, -0.25, limited) == 0.25
    stepped = walled._replace(step=walled.kappa, damping=0.0)
    assert not follows(-3.25, stepped)
    assert edge_gap(-3.25, -3.25, -3.25, stepped) == pytest.approx(0.25)


def test_only_sine_detents_bend() -> None:
    for shape in ("sine", "triangle", "spring"):
        wall = made({"detents": {"per_revolution": 12, "torque": 0.01, "shape": shape}}).wall
        wave = 12.0 * 1e-3
        expected = 0.01 * wave * wave if shape == "sine" else 0.0
        assert bends(wall) * made({}).torque_nm == pytest.approx(expected, rel=1e-12)
        assert bends(wall._replace(step=1e-3)) == 0.0  # a converter's steps are flat


@pytest.mark.parametrize("seed", SEEDS)
def test_a_place_is_higher_the_further_up(seed: int) -> None:
    knob, _, _, angles = tried(seed)
    places = [place_at(x, knob.wall.curve) for x in sorted(angles)]
    assert all(one <= other for one, other in pairwise(places))


def test_detents_are_a_place_each() -> None:
    curve = made({"detents": {"per_revolution": 12, "torque": 0.01}}).wall.curve
    spacing = 1000.0 * 2.0 * np.pi / 12
    for n in (-2, 0, 3):
        for part in (-0.4, 0.4):
            assert place_at(spacing * (n + part), curve) - place_at(0.0, curve) == n


def test_without_a_curve_there_is_none() -> None:
    assert not has_curve(None)
    assert curve_at(1.0, None) == (0.0, 0.0, inf, 0.0, 0.0)
    assert (curve_torque(1.0, None), bend_of(None), place_at(1.0, None), rounded_size(1.0, None)) == (
        0.0,
        0.0,
        0.0,
        0.0,
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_the_range_of_torques_has_all_of_them(seed: int) -> None:
    """And is no wider than the sum of the parts; infinite where a spring grows."""
    knob, _, _, angles = tried(seed)
    found = torque_range(knob.wall)
    torques = [command(x, x, knob.wall) for x in angles]
    assert found.least <= min(torques)
    assert max(torques) <= found.most
    grows = [abs(command(2.0 * x, 2.0 * x, knob.wall) - command(x, x, knob.wall)) > 1e4 for x in (-1e7, 1e7)]
    assert [found.most == inf, found.least == -inf] == grows
    if found.turn > 0.0 and knob.wall.curve[POINTS] * knob.wall.curve[DETENT] == 0.0:
        beyond = found.span + 1.0
        assert command(beyond, beyond, knob.wall) == pytest.approx(
            command(beyond + found.turn, beyond + found.turn, knob.wall), abs=1e-6
        )
