"""Rest that is approached for ever: what holds the knob in the end, and a region that it never leaves."""

from math import sqrt
from typing import Any

import pytest

from hknob_cli.engine.attractors import Patience, Search
from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller, command, read
from hknob_cli.engine.general.inner_region import come_to_rest, hold_zone, keeps_reading, stands
from hknob_cli.engine.general.search import GeneralEngine, make_space
from hknob_cli.engine.general.slide_two import step_with_friction
from hknob_cli.engine.outcome import Outcome
from hknob_cli.scene.general_knob import GeneralKnob, make_body
from hknob_cli.specs.scene import SceneSpec

from .bodies import knob

FIRM = {"inertia": 3.0e-7, "damping": 1.0e-2, "stiffness": 0.5}  # overdamped
PAD = {
    "finger": {"inertia": 3.0e-7, "damping": 2.9e-3, "stiffness": 0.4},
    "fingerpad": {"damping": 3.8e-4, "stiffness": 0.05},
}
EXHAUSTIVE = Patience(samples=10**9)


def search(one: GeneralKnob, max_samples: int | None = None, angle: float = 0.02) -> Search:
    """By the interpreter, however long it takes."""
    return GeneralEngine(patience=EXHAUSTIVE).search(
        one.body,
        one.wall,
        one.start(angle, 0.0),
        rate=one.rate,
        phases=4,
        delay_line=one.delay_line,
        max_samples=max_samples,
    )


def rests(found: Search) -> int:
    return sum(one.trials for one in found.attractors if one.outcome is Outcome.REST and one.certified)


def body(alpha: float, beta: float, friction: float, push: float = 0.0) -> Body:
    """Of second order, in counts and samples."""
    scene = {
        "knob": {"inertia": 1.0, "damping": alpha, "coulomb_torque": friction},
        "hand": {"stiffness": beta},
        "wall": {"stiffness": 0.0},
    }
    plain = SceneSpec.model_validate(scene).plain()
    one = make_body(plain, period=1.0, quantum=1.0, shift=0.0, split=0.0)[0]
    return one._replace(push=abs(push), drive=-push)


WALL = Controller(
    kappa=0.0, damping=0.0, sense=1.0, truncate=0.0, offset=0.0, analog=0.0, step=0.0, limit=float("inf"), split=0.0
)


def keeps(
    z: list[float], u: float, one: Body, wall: Controller = WALL, delay: int = 0
) -> tuple[bool, float, list[float]]:
    orbit, away = [0.0] * one.order, [0.0] * one.order
    found, gap = keeps_reading(z, read(z[0], wall), u, one, wall, delay, orbit, away)
    return found, gap, orbit


# What a user sees


def test_an_overdamped_hand_that_creeps_to_the_edge_of_the_stick_zone_is_at_rest() -> None:
    firm = knob(
        counts=8192,
        knob={"inertia": 1.9e-6, "coulomb_torque": 5.6e-4},
        hand={"inertia": 9.1e-6, "damping": 1.02e-2, "stiffness": 1.29},
        bias={"half_quantum": True},
    )
    found = search(firm)
    assert rests(found) == 4, found
    assert found.samples < 4 * 20_000  # of 65,536 each that it may take
    zone = (2.0 * firm.body.friction) / firm.body.beta
    for one in found.attractors:
        low, high = one.span
        assert high - low < zone


@pytest.mark.parametrize("counts", [1024, 2048, 8192])
def test_where_a_creeping_knob_ends_is_the_edge_of_the_zone(counts: int) -> None:
    loop = knob(counts=counts, hand=FIRM, knob={"inertia": 1.9e-6, "coulomb_torque": 2.0e-3})
    for one in search(loop).attractors:
        assert one.outcome is Outcome.REST
        u = command(read(one.x, loop.wall), 0.0, loop.wall)
        low = (u + loop.body.drive - loop.body.friction) / loop.body.beta
        high = (u + loop.body.drive + loop.body.friction) / loop.body.beta
        assert low - 1e-9 <= one.x <= high + 1e-9
        for x in one.span:
            assert min(abs(x - low), abs(x - high)) < 1e-9 * (1.0 + abs(x))


@pytest.mark.parametrize("rate_hz", [1000.0, 20_000.0])
def test_a_continuous_sensor_with_friction_comes_to_rest(rate_hz: float) -> None:
    loop = knob(rate_hz=rate_hz, counts=None, encoder="none", hand=FIRM)
    assert rests(search(loop)) == 4


@pytest.mark.long
def test_the_share_at_rest_never_falls_with_the_limit() -> None:
    """A slow loop with a continuous sensor, |lambda| = 0.9998."""
    loop = knob(
        rate_hz=10_000.0,
        counts=None,
        encoder="none",
        knob={"inertia": 1.9e-6},
        hand={"inertia": 3.0e-7, "damping": 0.1, "stiffness": 0.02},
        wall={"stiffness": 0.18},
        bias={"torque": 0.004},
    )
    shares = [rests(search(loop, limit, angle=0.0)) for limit in range(500, 40_000, 4000)]
    assert shares == sorted(shares), shares
    assert shares[-1] == 4
    assert rests(search(loop, angle=0.0)) == 4


def test_a_slow_hand_with_friction_is_at_rest_before_its_limit() -> None:
    hand = {"inertia": 3.0e-7, "damping": 0.05, "stiffness": 0.02}
    loop = knob(rate_hz=10_000.0, knob={"inertia": 1.9e-6, "coulomb_torque": 2.0e-3}, hand=hand)
    shares = [rests(search(loop, limit)) for limit in range(2000, 30_000, 4000)]
    assert shares == sorted(shares), shares
    assert shares[-1] == 4


# The zone in which friction holds


def test_zone_is_where_the_springs_pull_less_than_the_friction() -> None:
    stiffness, low, high = hold_zone(3.0, 0.0, body(1.0, 0.5, 2.0, push=1.0), WALL)
    assert stiffness == 0.5
    slack = 64.0 * EPSILON * (3.0 + 1.0 + 2.0)
    assert (low, high) == ((3.0 - 1.0 - 2.0 + slack) / 0.5, (3.0 - 1.0 + 2.0 - slack) / 0.5)
    assert low > 0.0
    assert high < 8.0


def test_zone_of_no_spring_and_of_no_friction_is_empty() -> None:
    for stiffness, low, high in (
        hold_zone(0.0, 0.0, body(1.0, 0.0, 2.0), WALL),
        hold_zone(1.0, 0.0, body(1.0, 0.5, 0.0), WALL),
    ):
        assert low > high, stiffness


def test_zone_of_a_finger_is_that_of_its_springs_in_series() -> None:
    """0.05 and 0.4 N m/rad behind each other: 0.0444."""
    loop = knob(hand=PAD)
    one = loop.body
    stiffness, low, high = hold_zone(0.0, 0.0, one, loop.wall)
    assert stiffness == pytest.approx(0.05 * 0.4 / 0.45 * 1e-6 / 1.9e-6, rel=1e-12)
    assert 0.5 * (low + high) == pytest.approx(-one.push / stiffness, rel=1e-9)
    assert 0.5 * (high - low) == pytest.approx(one.friction / stiffness, rel=1e-9)
    shifted = knob(hand=PAD, encoder={"rounding": "nearest"})
    _, lower, higher = hold_zone(0.0, 0.0, shifted.body, shifted.wall)
    assert lower - low == pytest.approx(-shifted.shift, rel=1e-9)
    assert higher - high == pytest.approx(-shifted.shift, rel=1e-9)
    soft = knob(hand={**PAD, "finger": {"inertia": 3.0e-7, "damping": 2.9e-3, "stiffness": 0.0}})
    _, low, high = hold_zone(0.0, 0.0, soft.body, soft.wall)
    assert low > high
    softer = knob(hand={**PAD, "fingerpad": {"damping": 3.8e-4, "stiffness": 0.0}})
    _, low, high = hold_zone(0.0, 0.0, softer.body, softer.wall)
    assert low > high


def test_zone_of_a_continuous_sensor_has_the_wall_for_a_spring() -> None:
    wall = WALL._replace(analog=1.0, kappa=1.5)
    stiffness, low, high = hold_zone(3.0, -2.0, body(1.0, 0.5, 0.5, push=4.0), wall)
    assert stiffness == 2.0
    assert 0.5 * (low + high) == pytest.approx(-2.0)  # 2 x = -4
    assert high - low == pytest.approx(0.5)
    stiffness, _, _ = hold_zone(3.0, -2.0, body(1.0, 0.5, 0.5, push=4.0), wall._replace(limit=2.9))
    assert stiffness == 0.5  # saturated


# The region


def test_a_motion_nearer_to_a_rest_than_the_next_count_keeps_its_reading() -> None:
    """Friction holds it from 0.1 to 0.3 counts: at 0.3, the next reading is 0.3 below, with a wall just there."""
    one = body(1.0, 1.0, 0.1, push=-0.2)
    wall = WALL._replace(kappa=1.0)
    found, gap, orbit = keeps([0.5, 0.0], 0.0, one, wall)
    assert found
    assert gap == pytest.approx(0.3)
    assert orbit == [pytest.approx(0.3), 0.0]
    assert keeps([0.3, 0.29], 0.0, one, wall)[0]
    assert not keeps([0.3, 0.31], 0.0, one, wall)[0]
    assert keeps([0.5, -0.22], 0.0, one, wall)[0]  # sqrt(0.2^2 + 0.22^2) = 0.297
    assert not keeps([0.5, -0.23], 0.0, one, wall)[0]  # 0.305
    assert keeps([0.05, 0.0], 0.0, one, wall)[2][0] == pytest.approx(0.1)
    assert keeps([0.2, 0.1], 0.0, one, wall)[2][0] == 0.2


def test_a_rest_at_the_edge_of_a_count_to_within_rounding_is_not_claimed() -> None:
    wall = WALL._replace(kappa=1.0)
    assert not keeps([0.1 + 1e-15, 1e-16], 0.0, body(1.0, 1.0, 0.1, push=0.1), wall)[0]
    near = 40.0 * EPSILON
    assert not keeps([near, 0.0], 0.0, body(1.0, 1.0, 0.1, push=0.0), wall)[0]
    assert keeps([400.0 * EPSILON, 0.0], 0.0, body(1.0, 1.0, 0.1, push=0.0), wall)[0]


def test_a_continuous_sensor_needs_damping_of_half_a_sample_of_the_wall() -> None:
    """b >= KT/2. The rest zone is 2 counts deep; the energy has the wall's spring in it."""
    wall = WALL._replace(analog=1.0, kappa=1.0)
    shown = [-2.4, 0.0]
    assert keeps(shown, command(-2.4, -2.4, wall), body(0.5, 0.25, 0.1, push=2.5), wall)[0]
    assert not keeps(shown, command(-2.4, -2.4, wall), body(0.4999999, 0.25, 0.1, push=2.5), wall)[0]
    assert not keeps(shown, 2.4, body(0.5, 0.25, 0.1, push=2.5), wall, 1)[0]
    assert not keeps(shown, 2.4, body(0.5, 0.25, 0.1, push=2.5), wall._replace(damping=1e-9))[0]
    one = body(0.5, 0.25, 0.1, push=2.5)  # held from -2.08 to -1.92
    edge = sqrt(1.25) * 1.92
    assert keeps([-1.92, edge - 1e-3], 1.92, one, wall)[0]
    assert not keeps([-1.92, edge + 1e-3], 1.92, one, wall)[0]
    _, gap, orbit = keeps([-1.5, 0.0], 1.5, one, wall)
    assert (gap, orbit[0]) == (pytest.approx(1.92), pytest.approx(-1.92))


def test_a_command_that_steps_is_constant_up_to_the_step() -> None:
    """D/A steps of 1: at a rest of 2.1 counts the command is 2 as at -2.2, at 2.6 it is not."""
    wall = WALL._replace(analog=1.0, kappa=1.0, step=1.0)
    one = body(0.1, 1.0, 0.05, push=4.1)
    found, gap, orbit = keeps([-2.2, 0.0], command(-2.2, -2.2, wall), one, wall)
    assert found
    assert orbit[0] == pytest.approx(-2.15)
    assert gap == pytest.approx(0.35)
    assert not keeps([-2.2, 0.0], command(-2.2, -2.2, wall), body(0.1, 1.0, 0.05, push=4.8), wall)[0]


def test_a_finger_that_nothing_damps_never_settles() -> None:
    def held(damping: float, pad: float) -> bool:
        loop = knob(
            hand={
                "finger": {"inertia": 3.0e-7, "damping": damping, "stiffness": 0.4},
                "fingerpad": {"damping": pad, "stiffness": 0.05},
            }
        )
        one = loop.body
        stiffness, low, high = hold_zone(0.0, 0.0, one, loop.wall)
        x = 0.5 * (low + high)
        z = [x, 1e-6, stiffness * (x + one.shift) / one.pad_stiffness, 1e-6]
        shown = read(x, loop.wall)
        assert shown < 0.0
        u = command(shown, shown, loop.wall)
        _, low, high = hold_zone(u, shown, one, loop.wall)
        orbit, away = [0.0] * 4, [0.0] * 4
        z[0] = min(max(0.5 * (low + high), shown + 0.3), shown + 0.7)
        z[2] = stiffness * (z[0] + one.shift) / one.pad_stiffness
        return bool(keeps_reading(z, shown, u, one, loop.wall, 0, orbit, away)[0])

    assert not held(0.0, 0.0)
    assert held(1e-4, 0.0) is held(0.0, 1e-4)


def test_the_lag_counts_by_what_it_can_still_push() -> None:
    one = knob(hand=FIRM, actuator={"time_constant": 1.0e-3}).body
    one = one._replace(push=10.0 * one.push, drive=10.0 * one.push)
    assert one.order == 3
    wall = WALL._replace(kappa=1.0)
    _, _, high = hold_zone(0.0, 0.0, one, wall)
    found, margin, orbit = keeps([high + 0.1, 0.0, 0.0], 0.0, one, wall)
    assert (found, margin, orbit[2]) == (True, pytest.approx(high), 0.0)
    most = (high - 0.1) / one.reach * one.lag
    assert keeps([high + 0.1, 0.0, 0.999 * most], 0.0, one, wall)[0]
    assert not keeps([high + 0.1, 0.0, 1.001 * most], 0.0, one, wall)[0]
    assert not keeps([high + 0.1, 0.0, -1.001 * most], 0.0, one, wall)[0]


# Where it ends


@pytest.mark.parametrize(("alpha", "x", "v"), [(3.0, 4.0, 0.0), (0.2, 9.0, 0.0), (3.0, -4.0, 1.0), (0.01, 2.0, 3.0)])
def test_end_in_closed_form_is_where_the_samples_lead(alpha: float, x: float, v: float) -> None:
    one = body(alpha, 2.0, 0.5, push=1.0)
    orbit = [0.0, 0.0]
    come_to_rest([x, v], 0.0, 0.0, one, WALL, orbit)
    z, space = [x, v], make_space(2, 0, lambda count: [0.0] * count)
    from hknob_cli.engine.general.interval import advance

    for _ in range(4000):
        advance(z, 0.0, [], 0, one, WALL, space.pad)
    assert orbit[0] == pytest.approx(z[0], abs=1e-12)
    assert (-1.0 - 0.5) / 2.0 - 1e-12 <= orbit[0] <= (-1.0 + 0.5) / 2.0 + 1e-12


def test_a_motion_stands_only_where_not_a_bit_changes() -> None:
    one = body(3.0, 2.0, 0.5, push=1.0)
    space: Any = make_space(2, 0, lambda count: [0.0] * count)
    assert stands([-0.5, 0.0], 0.0, [], 0, one, WALL, space)
    assert not stands([-0.5, 1e-300], 0.0, [], 0, one, WALL, space)
    assert not stands([0.5, 0.0], 0.0, [], 0, one, WALL, space)


SLOW = {  # of a first count the wall's torque hardly moves the knob against friction: it creeps for 27 samples
    "knob": {"inertia": 5.4e-6, "damping": 6.3e-5, "coulomb_torque": 0.002},
    "hand": {"inertia": 5.6e-7, "damping": 7.7e-4, "stiffness": 0.034},
    "bias": {"torque": 0.0013},
}


@pytest.mark.parametrize("over", [1e-6, 1e-4, 1e-2, 1.0])
@pytest.mark.parametrize("speed", [0.0, 7e-5, -0.1])
def test_an_end_is_where_the_samples_lead_though_a_turn_is_many_samples_away(over: float, speed: float) -> None:
    """A scene's body has the series of one sample, which says nothing of 27 of them."""
    one = knob(250.0, **SLOW).body
    assert one.terms > 0
    assert one.spacing > 20.0
    u = one.beta * -0.04 - one.drive + one.friction * (1.0 + over)
    orbit = [0.0, 0.0]
    come_to_rest([-0.04, speed], 0.0, u, one, WALL, orbit)
    x, v = -0.04, speed
    for _ in range(400):
        x, v = step_with_friction(x, v, u, 1.0, one.s2, one.g2, one.f2, one)
    assert v == 0.0
    assert orbit[0] == pytest.approx(x, abs=1e-12)
