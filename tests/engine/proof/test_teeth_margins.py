"""Teeth on one flank, on their margins: how near a motion must be so that they do not part, and what is proven then."""

from math import inf, nextafter, sqrt

import numpy as np
import pytest

from hknob_cli.engine.certificate import DIFFERENT, NOT_CAPTURED, PROVEN
from hknob_cli.engine.general.body import norm
from hknob_cli.engine.general.flank_rest import flank_room
from hknob_cli.engine.general.orbit_proof import PARTS
from hknob_cli.engine.general.standstill import settles
from hknob_cli.engine.general.teeth import pressing
from hknob_cli.engine.general.teeth_ends import Bounds, Mode, press, stuck_told, told
from hknob_cli.engine.rest import AT_REST, MOVING
from hknob_cli.scene.general_knob import GeneralKnob, follow_knob, sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec

from .test_period_map_margins import Stage, prove
from .test_standstill_margins import FINGER, WALL

MESH = FINGER._replace(order=4, lag=0.0, friction=0.0, reach=0.5, play=3.0, push=0.0)
PLACE = np.array([-2.5, 0.25, 1.0, 0.25, 0.0])
STAGE = Stage(np.diag([0.5, 0.5, 0.5, 0.5]), PLACE)
STIFF = sqrt(2.0) + 0.25 * (1.0 + 2.0)  # of the torque, by a unit of the energy's root: spring, and damper


def test_teeth_that_carry_a_torque_stay_on_their_flank_that_far() -> None:
    """From above: no difference of that energy takes more. From below: one takes half of it."""
    assert flank_room(0.0, MESH) == flank_room(-0.5, MESH) == flank_room(-1.0, MESH) == 0.0
    assert flank_room(STIFF, MESH) == pytest.approx(MESH.reach, rel=1e-15)
    chance = np.random.default_rng(7)
    most = 0.0
    for _ in range(4000):
        dz = chance.normal(size=4) * np.exp(chance.normal(size=4) * 2.0)
        dz /= norm(dz.tolist(), MESH)
        for side in (1, -1):
            most = max(most, abs(pressing(dz, 0, side, MESH._replace(play=0.0))))
    assert 0.5 * STIFF < most <= STIFF


@pytest.mark.parametrize(("torque", "margin"), [(inf, 0.4), (0.81 * STIFF, 0.4), (0.6 * STIFF, 0.3)])
def test_a_cycle_on_one_flank_is_proven_as_far_as_teeth_do_not_part(
    monkeypatch: pytest.MonkeyPatch, torque: float, margin: float
) -> None:
    stage = STAGE._replace(marks=(inf, inf, torque))
    for part, status in ((0.999, PROVEN), (1.001, NOT_CAPTURED)):
        off = np.array([0.0, 0.0, 1.0, 0.0])
        near = PLACE[:4] + part * margin / (MESH.reach * norm(off.tolist(), MESH)) * off
        found = prove(monkeypatch, stage, near, MESH)
        assert (found.status, found.margin) == (status, pytest.approx(margin, rel=1e-12))
    # Without play there are no teeth that could part.
    assert (
        prove(monkeypatch, STAGE._replace(marks=(inf, inf, -1.0)), PLACE[:4], MESH._replace(play=0.0)).status == PROVEN
    )


def test_a_cycle_whose_teeth_part_is_not_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    bound = prove(monkeypatch, STAGE, PLACE[:4], MESH).bound
    assert 0.0 < bound < 1e-12
    for part, status in ((1.001, PROVEN), (0.999, PARTS), (-1.0, PARTS)):
        torque = part * bound / MESH.reach * STIFF
        found = prove(monkeypatch, STAGE._replace(marks=(inf, inf, torque)), PLACE[:4], MESH)
        # A trial as near as a rounding to it is within half of that room only where the room is larger.
        assert found.status == status or (status == PROVEN and found.status == NOT_CAPTURED)
        assert (found.status == PARTS) == (status == PARTS)
    apart = STAGE._replace(matrix=np.diag([1.5, 0.5, 0.5, 0.5]), marks=(inf, inf, -1.0))
    assert prove(monkeypatch, apart, PLACE[:4], MESH).status == DIFFERENT


def test_rest_on_one_flank_needs_room_from_the_other() -> None:
    """At rest the mesh is 1 count deep, and carries 2: as far off as that lets go of the flank, all else lets it."""
    body = MESH._replace(finger_stiffness=8.0, shift=-1.0)
    orbit, away = [0.0] * 4, [0.0] * 4
    wall = WALL._replace(kappa=0.0)
    assert settles([0.5, 0.0, 0.0, 0.0], 0.0, 0.0, [], body, wall, orbit, away)[0] == MOVING  # nothing presses
    driven = body._replace(push=-2.0)  # out of the wall, as the wall's torque would
    fate, gap = settles([2.5, 0.0, 1.0, 0.0], 0.0, 0.0, [], driven, wall, orbit, away)
    assert fate == AT_REST
    assert orbit == [1.0 + 4.0 * 2.0 / 8.0 + 1.0, 0.0, 1.0, 0.0]
    room = flank_room(2.0, driven)
    for part, expected in ((0.99, AT_REST), (1.01, MOVING)):
        speed = part * room / driven.reach  # of both bodies alike: the energy is that of both
        z = [orbit[0], speed / sqrt(1.25), 1.0, 0.0]
        assert norm([0.0, z[1], 0.0, 0.0], driven) == pytest.approx(speed, rel=1e-12)
        assert settles(z, 0.0, 0.0, [], driven, wall, orbit, away)[0] == expected
    assert gap > room


def lone(friction: float = 0.0) -> GeneralKnob:
    """A geared knob that nobody holds and nothing pushes."""
    gear = {"ratio": 7.4, "motor_inertia": 1e-8, "stiffness": 10.0, "mesh_damping": 2e-3, "backlash": 0.005}
    made = {
        "knob": {"inertia": 1.9e-6},
        "wall": {"stiffness": 0.27},
        "gear": {**gear, "motor_coulomb_torque": friction},
    }
    plain = reduced(SceneSpec.model_validate(made).plain())
    return sample_general(plain, sample_rate_hz=1000.0, counts_per_rev=360)


@pytest.mark.parametrize("toward", [0, 1, -1])
def test_teeth_that_nothing_moves_stay_where_they_are(toward: int) -> None:
    """Where they only just touch, too: a knob without hand and bias begins its trials so."""
    one = lone().body
    for d in (0.0, -0.5 * one.play, -one.play):
        z = [3.0, 0.0, d, 0.0]
        assert told(z, 0.0, [0.0] * 8, Mode(0, toward, 0.0), 1.0, Bounds(0.0, 0.0, 0.0), one)
        assert press(list(z), 0.0, Mode(0, toward, 0.0), 1.0, False, one, [0.0] * 8) == (1.0, 0, inf)
        # Once anything moves, teeth that only just touch cannot be told.
        assert told(z, 0.0, [0.0] * 8, Mode(0, 0, 0.0), 1.0, Bounds(2.0**-20, 0.0, 0.0), one) == (-one.play < d < 0.0)


@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_a_knob_that_nobody_holds_goes_on_as_it_goes(speed: float) -> None:
    found = follow_knob(lone(), angle_rad=0.02, velocity_rad_s=speed, phase=0.5, samples=4)
    np.testing.assert_allclose(found.angle_rad, 0.02 + speed * found.time_s, rtol=1e-12)


def test_a_motor_at_the_very_level_of_friction_stays_held_while_nothing_changes() -> None:
    """However long. Where its torque changes, by a knob that moves, it may be released at once."""
    one = lone(1e-5).body
    z = [3.0, 0.0, -0.5 * one.play, 0.0]
    assert stuck_told(z, one.friction, [0.0] * 8, 0, 9.0, one)
    assert stuck_told([3.0, 0.0, 0.5, 0.0], -one.friction, [0.0] * 8, 0, 9.0, one)
    assert not stuck_told(z, one.friction, [0.0, 0.0, 1.0, -one.pad_stiffness / one.pad_damping], 1, 1e-9, one)


@pytest.mark.parametrize("friction", [0.25, 1.0, 4.0])
def test_a_motor_that_friction_may_let_go_is_not_told(friction: float) -> None:
    """At its very level, of whatever size, while the torque of the mesh is about to change; in the gap it is."""
    one = lone().body._replace(friction=friction, pad_stiffness=2.0, pad_damping=0.25)
    rates = [0.0, 0.0, 0.125, -1.0, *[0.0] * 4]
    z = [3.0, 0.0, 0.5, 0.0]
    n = one.order
    matrix = list(one.matrices)
    matrix[n + 2], matrix[n + 3] = -2.0, -0.25
    one = one._replace(matrices=matrix)
    assert not told(z, friction + 1.0, rates, Mode(1, 0, 0.0), 1e-6, Bounds(1.0, 1.0, 1.0), one)
    assert told(z, friction + 0.9, rates, Mode(1, 0, 0.0), 1e-6, Bounds(1.0, 1.0, 1.0), one)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_held_motor_is_released_once_or_not(sign: float) -> None:
    """By a lag of a quarter: a torque that changes by 1 a sample, and that by a quarter, is monotone for 4 samples."""
    zeros = [0.0] * 5
    rates, gap = [zeros, [0.0, 0.0, -2.0, -0.25, 1.0], *[zeros] * 3], [zeros, [0.0, 0.0, 0.0, 0.0, 1.0], *[zeros] * 3]
    one = lone().body._replace(
        order=5,
        lag=0.25,
        friction=2.0,
        pad_stiffness=2.0,
        pad_damping=0.25,
        play=3.0,
        matrices=[x for row in [*rates, *gap] for x in row],
        vectors=[0.0] * 15,
    )
    z = [3.0, 0.0, -1.0, 0.0, 1.25 * sign]
    for way in (1.0, -1.0):
        for h, clear in ((nextafter(4.0, 0.0), True), (4.0, False), (9.0, False)):
            assert stuck_told(z, 7.0, [0.0, 0.0, 0.0, 0.0, way], 0, h, one) == clear
        for rate, clear in ((0.125, False), (0.1249, True)):  # 4 rates, and a half of 16 quarters of one
            assert stuck_told(z, 7.0, [0.0, 0.0, 0.0, 0.0, way * rate], 0, 4.0, one) == clear
        at_level = [3.0, 0.0, -1.0, 0.0, 2.0 * sign]
        assert not stuck_told(at_level, 7.0, [0.0, 0.0, 0.0, 0.0, 0.1 * way], 0, 4.0, one)
        # A mesh that moves changes the torque where teeth press, and nothing in the gap.
        for side, d, pull in ((1, 0.5, -1.0), (0, -1.0, 0.0), (-1, -3.5, 1.0)):
            at_level = [3.0, 0.0, d, 0.0, 2.0 * sign - pull]
            assert stuck_told(at_level, 7.0, [0.0, 0.0, way, 0.0, 0.0], side, 2.0**-10, one) == (side != 0)
