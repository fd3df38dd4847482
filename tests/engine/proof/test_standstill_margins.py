"""Rest in the general loop, exactly on its margins: held by friction, or settling under a command that stays."""

import random
from fractions import Fraction
from math import inf, nextafter
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general import standstill
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller, command, read
from hknob_cli.engine.general.standstill import SETTLING, find_balance, rest_rounding, settles, stays_held, steady
from hknob_cli.engine.rest import AT_REST, LEAVES, MOVING, REST_ON_EDGE, RINGS
from hknob_cli.scene.general_knob import make_body
from hknob_cli.specs.scene import SceneSpec

WALL = Controller(1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, inf, 0.0)
UNIT = 64.0 * EPSILON


def body(alpha: float = 1.0, beta: float = 1.0, friction: float = 0.0, push: float = 0.0) -> Body:
    """Of second order, in counts and samples."""
    scene = {
        "knob": {"inertia": 1.0, "damping": alpha, "coulomb_torque": friction},
        "hand": {"stiffness": beta},
        "wall": {"stiffness": 0.0},
    }
    plain = SceneSpec.model_validate(scene).plain()
    one = make_body(plain, period=1.0, quantum=1.0, shift=0.0, split=0.0)[0]
    return one._replace(push=abs(push), drive=-push)


LAGGING = body(friction=2.0)._replace(order=3, beta=0.5, drive=-1.0, lag=0.5)
# Fingerpad and finger in series: 4 * 2 + 8 = 16. At 1.5 counts, neutral at -0.5, the finger is at 8 * 2 / 16 = 1.
FINGER = LAGGING._replace(
    order=5,
    ratio=4.0,
    pad_stiffness=2.0,
    finger_stiffness=8.0,
    pad_damping=0.25,
    finger_damping=0.0,
    shift=0.5,
    push=0.5,
    friction=9.5,
)
# 2 counts off at 6 a sample: a root of energy of 5, 0.25 * 2 + 2 / 2 on the knob for each; 4 - 0.5 - 2 = 1.5; 0.5 late.
SWINGING = [1.5, 0.0, 3.0, 6.0, 4.5]


def fate(
    z: list[float], one: Body, wall: Controller = WALL, ring: tuple[float, ...] = (), before: float | None = None
) -> tuple[int, float, list[float]]:
    shown = read(z[0], wall)
    orbit, away = [7.0] * one.order, [7.0] * one.order
    found, gap = settles(z, shown, shown if before is None else before, list(ring), one, wall, orbit, away)
    return found, gap, orbit


# Held by friction.


def test_every_command_under_way_must_be_the_same() -> None:
    assert steady([], 1.0)
    assert steady([1.0, 1.0], 1.0)
    assert not steady([1.0, 0.0], 1.0)
    assert not steady([0.0, 1.0], 1.0)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_friction_holds_up_to_its_level(sign: float) -> None:
    """-1 + 4 - 0.5 * 2 = 2."""
    one = body(beta=0.5, friction=2.0, push=sign)
    assert stays_held([sign * 2.0, 0.0], sign * 4.0, one)
    assert not stays_held([sign * 2.0, 0.0], sign * nextafter(4.0, 5.0), one)
    assert not stays_held([sign * 2.0, 1e-300], sign * 4.0, one)
    assert not stays_held([sign * 2.0, -1e-300], sign * 4.0, one)


@pytest.mark.parametrize("late", [-1.5, 1.5])
def test_what_the_lag_still_brings_counts(late: float) -> None:
    """-1 + 2 - 0.5 * 1 = 0.5, and 1.5 late."""
    assert stays_held([1.0, 0.0, 2.0 + late], 2.0, LAGGING)
    assert not stays_held([1.0, 0.0, 2.0 + 1.001 * late], 2.0, LAGGING)
    assert stays_held([7.0, 0.0, -2.0 + 0.0 * late], -2.0, LAGGING._replace(drive=5.0, friction=0.5))
    assert not stays_held([7.0, 0.0, -2.0], -2.0, LAGGING._replace(drive=5.0, friction=0.49))


@pytest.mark.parametrize("turn", [-3.0, 3.0])
def test_what_a_winding_remembers_counts(turn: float) -> None:
    """-1 + 2 - 0.5 * 1 = 0.5, and 0.5 * 3 of the current; 0.25 of it late with a lag."""
    wound = LAGGING._replace(lag=0.0, coil=0.5)
    assert stays_held([1.0, 0.0, turn], 2.0, wound)
    assert not stays_held([1.0, 0.0, 1.001 * turn], 2.0, wound)
    driven = LAGGING._replace(order=4, coil=0.5, friction=2.25)
    assert stays_held([1.0, 0.0, turn, 2.25], 2.0, driven)
    assert not stays_held([1.0, 0.0, turn, 2.251], 2.0, driven)


def test_what_a_finger_that_swings_may_pull_counts() -> None:
    """1.5 of its rest, 7.5 of its swing, 0.5 late."""
    assert stays_held(SWINGING, 4.0, FINGER)
    assert not stays_held(SWINGING, 4.0, FINGER._replace(friction=nextafter(9.5, 0.0)))
    for change in ([1.5, 0.0, -1.0, 6.0, 4.5], [1.5, 0.0, 3.0, -6.0, 4.5], [1.5, 0.0, 3.0, 6.0, 3.5]):
        assert stays_held(change, 4.0, FINGER)
        assert not stays_held(change, 4.0, FINGER._replace(friction=nextafter(9.5, 0.0)))
    assert stays_held(SWINGING, 4.0, FINGER._replace(push=3.5))  # 4 - 3.5 - 2 = -1.5
    assert not stays_held(SWINGING, 4.0, FINGER._replace(push=3.5, friction=nextafter(9.5, 0.0)))
    prompt = FINGER._replace(order=4, lag=0.0, friction=9.0)
    assert stays_held(SWINGING[:4], 4.0, prompt)
    assert not stays_held(SWINGING[:4], 4.0, prompt._replace(friction=nextafter(9.0, 0.0)))


@pytest.mark.parametrize("pull", [-0.25, 0.25])
def test_cogging_pulls_where_the_knob_stands(pull: float) -> None:
    """As a command that is so much larger would; the lag's is as late as before."""
    one = body(beta=0.5, friction=2.0, push=1.0)
    prompt = FINGER._replace(order=4, lag=0.0, friction=9.0)
    for still, u, held in (([2.0, 0.0], 4.0, one), ([1.0, 0.0, 3.5], 2.0, LAGGING), (SWINGING[:4], 4.0, prompt)):
        cogs = [1.0, 8.0, still[0] + pull, 4.0, 1.0, 0.0]  # a slope of 1 about a place of rest
        z = [*still[:2], *(x - pull if held is LAGGING else x for x in still[2:])]
        assert stays_held(z, u - pull, held._replace(cogs=cogs))
        assert not stays_held(z, u - pull, held._replace(cogs=cogs, friction=nextafter(held.friction, 0.0)))


@pytest.mark.parametrize("play", [5e-324, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("stays", [True, False])
def test_where_there_is_play_the_teeth_decide(monkeypatch: pytest.MonkeyPatch, play: float, stays: bool) -> None:
    """However little play there is; without any the teeth are not asked."""
    monkeypatch.setattr(standstill, "held_in_teeth", lambda *given: stays)
    one = body(friction=1.0)._replace(play=play)
    assert stays_held([0.0, 0.0], 0.0, one) == stays
    assert stays_held([0.0, 0.0], 0.0, one._replace(play=0.0))
    assert not stays_held([0.0, 1e-300], 0.0, one)


def test_a_finger_that_nothing_damps_or_holds_is_not_proven_to_settle() -> None:
    still = [1.5, 0.0, 1.0, 0.0, 4.0]
    assert stays_held(still, 4.0, FINGER)
    assert stays_held(still, 4.0, FINGER._replace(pad_damping=0.0, finger_damping=0.25))
    assert stays_held(still, 4.0, FINGER._replace(finger_damping=0.25))
    assert not stays_held(still, 4.0, FINGER._replace(pad_damping=0.0))
    assert not stays_held(still, 4.0, FINGER._replace(pad_stiffness=0.0, finger_stiffness=0.0))
    assert stays_held([0.0, 0.0, 0.5, 0.0, 4.0], 4.0, FINGER._replace(pad_stiffness=0.0, finger_stiffness=0.5))


def test_a_knob_that_friction_holds_is_at_rest_but_for_an_edge() -> None:
    """64 units of a count and of its place."""
    one = body(friction=5.0)
    assert fate([0.5, 0.0], one) == (AT_REST, 0.5, [0.5, 0.0])
    assert fate([UNIT, 0.0], one)[0] == REST_ON_EDGE
    assert fate([-1e-20, 0.0], one)[0] == REST_ON_EDGE
    exactly = UNIT
    for _ in range(5):
        exactly = UNIT * (1.0 + exactly)
    assert fate([exactly, 0.0], one)[0] == REST_ON_EDGE
    assert fate([nextafter(exactly, 1.0), 0.0], one)[0] == AT_REST
    assert fate([nextafter(UNIT * (1.0 + UNIT), 1.0), 0.0], one)[0] == AT_REST
    deep = body(beta=1e-9, friction=5.0, push=1000.0)
    for part, found in ((0.98, REST_ON_EDGE), (1.02, AT_REST)):
        assert fate([-1000.0 + part * 1001.0 * UNIT, 0.0], deep)[0] == found
    assert fate([3.0, 0.0], one, WALL._replace(damping=0.1))[0] == REST_ON_EDGE
    for place, found in ((4.0 * UNIT, REST_ON_EDGE), (4.01 * UNIT, REST_ON_EDGE), (4.1 * UNIT, AT_REST)):
        assert fate([3.0 + place, 0.0], one, WALL._replace(damping=0.1))[0] == found
    assert fate([-1e-20, 0.0], one, WALL._replace(analog=1.0))[0] == AT_REST  # no edge that it could pass
    for x in (0.0, 1e-20):
        assert fate([x, 0.0], one, WALL._replace(analog=1.0))[0] == REST_ON_EDGE
    assert fate([0.5, 0.1], one)[0] == SETTLING
    assert fate([0.5, 9.0], one)[0] == MOVING


def test_what_is_under_way_may_still_move_it() -> None:
    one = body(friction=5.0)
    assert fate([0.5, 0.0], one, ring=(0.0, 0.0))[0] == AT_REST
    assert fate([0.5, 0.0], one, ring=(0.0, 1.0))[0] == MOVING
    damped = WALL._replace(damping=0.1)
    assert fate([0.5, 0.0], one, damped, before=0.0)[0] == AT_REST
    assert fate([0.5, 0.0], one, damped, before=1.0)[0] == MOVING
    assert fate([0.5, 0.0], one, before=1.0)[0] == AT_REST


# Settling without friction.


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_spring_brings_it_to_rest_inside_its_count(side: float) -> None:
    """At 1 - 1.5 counts: half a count less 64 units of 1 + 0.5 + its own place + the torques, 2.5."""
    one = body(push=1.5)
    assert fate([-0.5, 0.0], one) == (AT_REST, 0.5, [-0.5, 0.0])
    farthest = 0.5 - UNIT * (1.0 + 0.5 + (0.5 - side * 0.5) + 2.5)
    assert fate([-0.5 + side * (farthest - 2.0 * EPSILON), 0.0], one)[0] == AT_REST
    assert fate([-0.5 + side * (farthest + 2.0 * EPSILON), 0.0], one)[0] == MOVING
    if side > 0.0:  # where the place is the bound itself, both can be exact
        bound = UNIT * 4.0
        for _ in range(5):
            bound = UNIT * (1.0 + 0.5 + bound + 2.5)
        assert fate([-bound, 0.0], one)[0] == MOVING
        assert fate([-bound - EPSILON, 0.0], one)[0] == AT_REST
    assert fate([-0.5, side * 0.49], one)[0] == AT_REST
    assert fate([-0.5, side * 0.51], one)[0] == MOVING
    assert fate([-0.5 + side * 0.25, 0.0], body(alpha=0.0, push=1.5))[0] == RINGS
    assert fate([-0.5, 0.0], one, WALL._replace(analog=1.0))[0] == MOVING  # the command would follow it


def test_a_rest_point_is_off_by_the_torques_that_cancel_over_the_stiffness() -> None:
    """A soft hand, a thousand counts deep in a stiff wall: what is called rest must be inside the count, exactly."""
    chance, called = random.Random(1), 0
    for _ in range(1000):
        kappa, beta, level = chance.uniform(0.3, 3.0), 10.0 ** chance.uniform(-6.0, -3.0), -1000.0
        wall = WALL._replace(kappa=kappa)
        aim = Fraction(level) + Fraction(chance.choice([-1.0, 1.0]) * 10.0 ** chance.uniform(-11.0, -1.0))
        one = body(beta=beta, push=float(Fraction(kappa) * 1000 - Fraction(beta) * aim))
        exact = (Fraction(kappa) * 1000 + Fraction(one.drive)) / Fraction(beta)
        found, _, orbit = fate([max(float(exact), level), 0.0], one, wall)
        assert abs(Fraction(orbit[0]) - exact) <= Fraction(UNIT) * (
            1 + abs(exact) + (abs(exact) + 2000) * 3 / Fraction(beta)
        )
        assert found != AT_REST or level < exact < level + 1
        called += found == AT_REST
    assert called > 20


def test_outside_the_wall_a_continuous_sensor_changes_nothing() -> None:
    """It is pulled out to half a count; at the wall's edge it would be on the edge."""
    wall = WALL._replace(analog=1.0)
    assert fate([0.5, 0.0], body(push=-0.5), wall) == (AT_REST, 0.5, [0.5, 0.0])
    assert fate([0.0, 0.0], body(), wall)[0] == REST_ON_EDGE


def test_a_stiffer_hand_rests_where_the_torques_over_its_stiffness_say() -> None:
    """(1 - 3) / 4, known to 64 units of 1 + (1 + 1) / 4 where both torques are 1."""
    assert fate([-0.5, 0.0], body(beta=4.0, push=3.0)) == (AT_REST, 0.5, [-0.5, 0.0])
    for part, found in ((0.99, REST_ON_EDGE), (1.01, MOVING)):
        assert fate([-1e-8, 0.0], body(beta=4.0, push=1.0 + part * 4.0 * 1.5 * UNIT))[0] == found


def test_a_rest_point_within_rounding_of_an_edge_is_on_it() -> None:
    """At the edge at 0, where both torques are 1: 64 units of 1 + 0 + 2, and of its own place."""
    for x, found in ((-1e-7, REST_ON_EDGE), (-2e-6, MOVING)):
        assert fate([x, 0.0], body(push=1.0))[:2] == (found, 0.0)
    near = UNIT * 3.0
    for off, found in ((0.99 * near, REST_ON_EDGE), (1.01 * near, MOVING)):
        assert fate([-1e-8, 0.0], body(push=1.0 + off))[0] == found
        assert fate([-1e-8, 0.0], body(push=1.0 - off))[0] == found
    for v, found in ((0.9e-6, REST_ON_EDGE), (1.1e-6, MOVING)):
        assert fate([-1e-20, v], body(push=1.0))[0] == found


def test_a_lag_settles_where_the_command_is() -> None:
    one = body(push=1.5)._replace(order=3, lag=0.5)
    assert fate([-0.5, 0.0, 1.0], one) == (AT_REST, 0.5, [-0.5, 0.0, 1.0])
    for late, found in ((0.24, AT_REST), (0.26, MOVING)):
        assert fate([-0.5, 0.0, 1.0 + late], one)[0] == found
        assert fate([-0.5, 0.0, 1.0 - late], one)[0] == found


def held(push: float, **more: float) -> Body:
    """A finger of stiffness 8 behind a pad of 2, weighing a quarter of the knob: 1/2 + 4/8 counts for a torque of 1."""
    return FINGER._replace(order=4, lag=0.0, friction=0.0, push=push, reach=1.0, damped=True)._replace(**more)


def test_a_finger_settles_where_its_springs_balance() -> None:
    """u - push = 0.25 gives 0.125 in the pad and 0.125 more in the finger, from -0.5: at -0.25."""
    one = held(0.75)
    assert fate([-0.25, 0.0, 0.125, 0.0], one) == (AT_REST, 0.25, [-0.25, 0.0, 0.125, 0.0])
    assert fate([-0.25, 0.2, 0.125, 0.2], one)[0] == AT_REST
    assert fate([-0.25, 0.3, 0.125, 0.3], one)[0] == MOVING
    assert fate([-0.25, 0.0, 0.125, 0.0], one._replace(damped=False))[0] == RINGS
    for missing in ("pad_stiffness", "finger_stiffness"):
        assert fate([-0.25, 0.0, 0.125, 0.0], held(0.75, **{missing: 0.0}))[0] == MOVING


@pytest.mark.parametrize(("pad", "finger", "ratio"), [(0.001, 1000.0, 4.0), (1000.0, 0.001, 0.25)])
def test_the_rounding_of_a_fingers_rest_is_that_of_its_torques_over_both_springs(
    pad: float, finger: float, ratio: float
) -> None:
    """Near an edge at 64 units of 1 + 2 (1 / pad + ratio / finger), and its neutral angle."""
    one = held(1.0, pad_stiffness=pad, finger_stiffness=finger, ratio=ratio, shift=0.0)
    size = 2.0 * (1.0 / pad + ratio / finger)
    for part, found in ((0.99, REST_ON_EDGE), (1.01, MOVING)):
        moved = one._replace(shift=-part * UNIT * (1.0 + size))
        assert fate([-1e-300, 0.0, 0.0, 0.0], moved)[0] == found


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_neutral_angle_of_a_finger_is_rounded_too(sign: float) -> None:
    """A million counts from the wall's edge, at an edge of counts, which matter to a damped wall outside, too."""
    wall = WALL._replace(kappa=1e-6, damping=0.1)
    for part, found in ((0.9, REST_ON_EDGE), (1.1, AT_REST)):
        off = part * UNIT * 3e6
        one = held(1.0 if sign < 0.0 else 0.0, shift=-(sign * 1e6 + off))
        assert fate([sign * 1e6 + off, 0.0, 0.0, 0.0], one, wall)[0] == found


FREE = body(beta=0.0, push=1.0)  # balanced by the wall at level -1


def test_without_a_spring_it_runs_out() -> None:
    assert fate([-0.625, 0.125], FREE) == (AT_REST, 0.5, [-0.5, 0.0])
    assert fate([-0.625, 0.25], body(alpha=2.0, beta=0.0, push=1.0)) == (AT_REST, 0.5, [-0.5, 0.0])
    assert fate([-0.75, 1.0], FREE)[0] == MOVING
    assert fate([-0.625, 0.125], body(beta=0.0, push=0.5))[0] == MOVING
    assert fate([-0.625, 0.125], body(beta=0.0, push=1.5))[0] == MOVING
    late = FREE._replace(order=3, lag=0.5, reach=1.0)
    assert fate([-0.625, 0.125, 1.0], late)[0] == AT_REST
    assert fate([-0.625, 0.125, 0.999], late)[0] == MOVING
    assert fate([-0.625, 0.125, 1.001], late)[0] == MOVING


@pytest.mark.parametrize(
    ("x", "v", "push", "found"),
    [
        (-0.5, 0.0, 1.0, AT_REST),
        (-0.5, 0.5, 1.0, MOVING),
        (-0.5, -1.0, 1.0, MOVING),
        (2.0, 0.0, 0.0, AT_REST),
        (2.0, 1e-9, 0.0, LEAVES),
        (2.0, 1.0, 0.0, LEAVES),
        (0.5, 1.0, 0.0, LEAVES),
        (2.0, -0.5, 0.0, MOVING),
        (2.0, -1.0, 0.0, MOVING),
    ],
)
def test_without_spring_and_damping_it_goes_on_as_it_goes(x: float, v: float, push: float, found: int) -> None:
    free = body(alpha=0.0, beta=0.0, push=push)
    assert fate([x, v], free) == (found, x if x > 0.0 else 0.5, [x, 0.0])


def test_a_held_finger_never_moves_the_knob() -> None:
    """What `stays_held` promises, in 400 samples of random states of a finger behind a pad."""
    from hknob_cli.engine.general.interval import advance
    from hknob_cli.engine.general.search import make_space
    from tests.engine.general.bodies import knob

    chance, promised = random.Random(5), 0
    pad: dict[str, Any] = {
        "finger": {"inertia": 3.0e-7, "damping": 2.9e-3, "stiffness": 0.4},
        "fingerpad": {"damping": 3.8e-4, "stiffness": 0.05},
    }
    loop = knob(hand=pad, knob={"inertia": 1.9e-6, "coulomb_torque": 2.0e-3})
    for _ in range(600):
        x = chance.uniform(-8.0, 4.0)
        z = [x, 0.0, chance.gauss(0.0, 0.5), chance.gauss(0.0, 0.05)]
        shown = read(x, loop.wall)
        if not stays_held(z, command(shown, shown, loop.wall), loop.body):
            continue
        promised += 1
        space = make_space(4, 0, lambda count: [0.0] * count)
        before = shown
        for _ in range(400):
            before, _ = advance(z, before, [], 0, loop.body, loop.wall, space.pad)
        assert z[:2] == [x, 0.0]
    assert promised > 10


@pytest.mark.parametrize("u", [-3.0, 3.0])
def test_the_rounding_of_a_rest_counts_its_torques_over_its_stiffness(u: float) -> None:
    """64 units of 1, both places and (3 + 2) / 4; of a finger 3.5 (1/2 + 4/8) + 0.5; nothing holds the third."""
    held = body(beta=4.0)._replace(drive=-2.0)
    assert rest_rounding([-5.0, 0.0], -7.0, u, held) == UNIT * (1.0 + 7.0 + 5.0 + 1.25)
    assert rest_rounding([5.0, 0.0], 7.0, u, held) == UNIT * (1.0 + 7.0 + 5.0 + 1.25)
    assert rest_rounding([5.0, 0.0, 0.0, 0.0, 0.0], 7.0, u, FINGER) == UNIT * (1.0 + 7.0 + 5.0 + 4.0)
    assert rest_rounding([5.0, 0.0], 7.0, u, body(beta=0.0)) == UNIT * (1.0 + 7.0 + 5.0)


def test_a_winding_that_nothing_springs_back_is_not_said_to_rest() -> None:
    """The knob goes on while the current fades; without a winding it goes its 0.5 counts and stands."""
    free = body(alpha=2.0, beta=0.0)
    assert fate([3.25, 1.0], free)[0] == AT_REST
    assert fate([3.5, 0.01, 0.0], free._replace(order=3, coil=0.5))[0] == MOVING
    # Without damping it would neither go on as it goes, nor stand: the winding's current turns it.
    loose = body(alpha=0.0, beta=0.0)._replace(order=3, coil=0.5, reach=inf)
    for z in ([3.25, 1.0, 0.0], [3.25, 0.0, 0.5]):
        assert fate(z, loose)[0] == MOVING


# Where a body stands.


def test_a_body_stands_where_its_torques_balance() -> None:
    """A spring of a quarter under 0.5 - 1; a finger behind its pad; a lag with its torque."""
    orbit = [7.0] * 2
    assert find_balance(0.5, body(beta=0.25, push=1.0), orbit)
    assert orbit == [-2.0, 0.0]
    assert not find_balance(0.5, body(beta=0.0), [7.0] * 2)
    orbit = [7.0] * 3
    assert find_balance(0.5, LAGGING, orbit)
    assert orbit == [-1.0, 0.0, 0.5]  # (0.5 - 1) / 0.5
    orbit = [7.0] * 5
    # 2.5 - 0.5 over 2 and, of four times the inertia, over 8; less the neutral angle.
    assert find_balance(2.5, FINGER, orbit)
    assert orbit == [1.0 + 4.0 * 2.0 / 8.0 - 0.5, 0.0, 1.0, 0.0, 2.5]
    assert not find_balance(2.5, FINGER._replace(pad_stiffness=0.0), [7.0] * 5)
    assert not find_balance(2.5, FINGER._replace(finger_stiffness=0.0), [7.0] * 5)


def test_a_light_knob_stands_behind_its_finger_too() -> None:
    orbit = [7.0] * 5
    assert find_balance(2.5, FINGER._replace(ratio=0.5), orbit)
    assert orbit == [1.0 + 0.5 * 2.0 / 8.0 - 0.5, 0.0, 1.0, 0.0, 2.5]
