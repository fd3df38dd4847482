"""Tests of `engine.general.sets.friction_step`: no state of a set is lost over a hold with friction."""

from math import sqrt

import numpy as np
import pytest
from hypothesis import Phase, assume, example, given, settings
from hypothesis import strategies as st

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.sets.convex import MOST_CORNERS, keep_side, radius_of
from hknob_cli.engine.general.sets.friction_step import (
    CUT,
    ENCLOSED,
    HELD,
    MOST_CUTS,
    SLID,
    Hold,
    Room,
    Shape,
    move_set,
    parts_of_hold,
)
from hknob_cli.engine.general.slide_two import coefficients, step_with_friction
from hknob_cli.scene.general_knob import make_body
from hknob_cli.specs.plan import Actuator, Bias, Hand, Knob, Scene, Wall
from tests.engine.sets.loops import zeros
from tests.engine.sets.test_polygon import convex, inside, states_of

ROOM = 8 * (MOST_CORNERS + 6)


def body_of(alpha: float, beta: float, friction: float, push: float, lag: float = 0.0) -> Body:
    """A body with these numbers, ``lag`` in sample periods over its time: unit inertia, period and quantum."""
    scene = Scene(
        knob=Knob(inertia=1.0, damping=alpha, coulomb_torque=friction),
        wall=Wall(stiffness=1.0),
        hand=Hand(stiffness=beta),
        bias=Bias(torque=push),
        encoder=None,
        actuator=Actuator(time_constant=1.0 / lag) if lag else None,
    )
    return make_body(scene, period=1.0, quantum=1.0, shift=0.0, split=0.0)[0]


bodies = st.builds(
    body_of,
    alpha=st.floats(0.0, 3.0),
    beta=st.floats(1e-5, 2.0),
    friction=st.floats(1e-3, 2.0),
    push=st.floats(0.0, 1.0),
)


def move(
    x: float, v: float, u: float, hold: Hold, work: list[float], count: int, least: float, body: Body, line: list[float]
) -> tuple[int, float, float, int]:
    """Move a set by `move_set`, with work space of its own."""
    return move_set(Shape(x, v, work, count), u, hold, least, body, Room(zeros(ROOM + 8), line, None, None))


def move_all(
    x: float, v: float, u: float, corners: list[float], body: Body, least: float
) -> list[tuple[int, float, float, list[float]]]:
    """Move a set over one period, cut where that is asked for: ``(fate, x, v, corners)`` of each part."""
    n = parts_of_hold(1.0, body)
    assert n > 0
    hold = Hold(1.0 / n, *coefficients(1.0 / n, body))
    waiting, done = [(0, 0, SLID, x, v, list(corners))], []
    while waiting:
        part, cuts, fate, x, v, own = waiting.pop()
        if part == n:
            done.append((fate, x, v, own))
            continue
        count = len(own) // 2
        work = own + zeros(ROOM)
        line = zeros(3)
        limit = least if cuts < MOST_CUTS else float("inf")
        fate, to_x, to_v, after = move(x, v, u, hold, work, count, limit, body, line)
        if fate != CUT:
            waiting.append((part + 1, 0, fate, to_x, to_v, work[: 2 * after]))
            continue
        assert work[: 2 * count] == pytest.approx(own, abs=1e-12)
        a, b, c = line
        sides = []
        for sign in (1.0, -1.0):
            out = zeros(2 * count + 4)
            kept = keep_side(own, count, sign * a, sign * b, sign * c, out)
            assert kept <= count + 1
            sides.append(out[: 2 * kept])
        if all(sides):
            waiting += [(part, cuts + 1, fate, x, v, side) for side in sides]
        else:
            # Within rounding of the line: the enclosure is taken as it is.
            fate, to_x, to_v, after = move(x, v, u, hold, work, count, float("inf"), body, line)
            assert fate in (ENCLOSED, HELD)
            waiting.append((part + 1, 0, fate, to_x, to_v, work[: 2 * after]))
        assume(len(waiting) + len(done) < 5000)  # a stiff hold may take more, for it is cut without end here
    return done


@st.composite
def shapes(draw: st.DrawFn) -> list[float]:
    """Corners of a convex polygon, a segment, also one that stands, or a point."""
    kind = draw(st.sampled_from(["polygon", "polygon", "segment", "standing", "point"]))
    if kind == "point":
        return [0.0, 0.0]
    size = 10.0 ** draw(st.floats(-8.0, 0.5))
    chance = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    if kind == "standing":
        return [-size, 0.0, size, 0.0]
    if kind == "segment":
        dx, dv = size * chance.uniform(-1, 1, 2)
        return [-dx, -dv, dx, dv]
    points = chance.uniform(-1.0, 1.0, (draw(st.integers(3, 9)), 2)) * [size, size * chance.uniform(0.01, 1.0)]
    return convex(points - points.mean(axis=0))


@pytest.mark.long
@settings(deadline=None, max_examples=400, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(
    body=bodies,
    corners=shapes(),
    x=st.floats(-3.0, 1.0),
    v=st.one_of(st.just(0.0), st.floats(-1.0, 1.0), st.floats(-0.01, 0.01)),
    u=st.floats(0.0, 3.0),
    seed=st.integers(0, 2**32 - 1),
)
@example(  # a line along an edge of a flat part
    body=body_of(
        alpha=0.38273000559479275, beta=1.3827208544823129, friction=0.658632993729025, push=0.4283391797019368
    ),
    corners=[
        *(-2.5841266032244783, -1.9123106551682645, 1.1569316421510896, -1.9694854165501543),
        *(1.1444596062099015, 1.8037757695072194, -0.15736588685838626, 1.8963095173344642),
    ],
    x=2.1213184036923945e-106,
    v=0.0,
    u=0.38273000559479275,
    seed=252144462,
)
@example(  # a speed whose quotients underflow
    body=body_of(
        alpha=2.4621018577656297, beta=1.0489031798441713, friction=1.2818516438932714, push=0.633125267386721
    ),
    corners=[-1.0, 0.0, 1.0, 0.0],
    x=-1.18e-130,
    v=-5e-324,
    u=2.4621018577656297,
    seed=4294967295,
)
def test_no_state_is_lost(body: Body, corners: list[float], x: float, v: float, u: float, seed: int) -> None:
    """Every state of the set, moved by itself, lies in a part of the set that has moved."""
    size = radius_of(corners, len(corners) // 2, 1.0)
    done = move_all(x, v, u, corners, body, 1e-3 * size + 1e-9)
    s, g, f = coefficients(1.0, body)
    slack = 1e-11 * (1.0 + abs(x) + abs(v) + u + size) * (1.0 + 1.0 / sqrt(body.beta))
    for dx, dv in states_of(corners, 24, seed):
        at_x, at_v = step_with_friction(x + dx, v + dv, u, 1.0, s, g, f, body)
        assert any(inside_of(at_x - to_x, at_v - to_v, own, slack) for _, to_x, to_v, own in done)


def inside_of(dx: float, dv: float, corners: list[float], slack: float) -> bool:
    """As `inside`, for points, segments and what is as thin as one, too."""
    points = np.array(corners).reshape(-1, 2)
    apart = [k for k in range(len(points)) if np.abs(points[k] - points[k - 1]).max() > slack]
    if len(apart) > 2 and inside(dx, dv, points[apart].ravel().tolist(), slack):
        return True
    return any(near_segment(dx, dv, points[[k - 1, k]], 2.0 * slack) for k in range(len(points)))


def near_segment(dx: float, dv: float, points: np.ndarray, slack: float) -> bool:
    """Whether a point is no farther than ``slack`` from a segment, or a point."""
    a, b = points[0], points[-1]
    along = b - a
    length = float(along @ along)
    part = float(np.clip((np.array([dx, dv]) - a) @ along / length, 0.0, 1.0)) if length > 0.0 else 0.0
    return bool(np.hypot(*(a + part * along - [dx, dv])) <= slack)


@settings(deadline=None, max_examples=150, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(
    body=bodies,
    corners=shapes(),
    x=st.floats(-3.0, 1.0),
    v=st.one_of(st.just(0.0), st.floats(-1.0, 1.0)),
    u=st.floats(0.0, 3.0),
    seed=st.integers(0, 2**32 - 1),
)
def test_no_state_is_lost_without_a_cut(
    body: Body, corners: list[float], x: float, v: float, u: float, seed: int
) -> None:
    """The enclosure holds all states of any set, however much of it stops: cutting only makes it narrower."""
    n = parts_of_hold(1.0, body)
    s, g, f = coefficients(1.0 / n, body)
    count = len(corners) // 2
    work = corners + zeros(ROOM)
    hold = Hold(1.0 / n, s, g, f)
    fate, to_x, to_v, after = move(x, v, u, hold, work, count, float("inf"), body, zeros(3))
    assert fate != CUT
    size = radius_of(corners, count, 1.0)
    slack = 1e-11 * (1.0 + abs(x) + abs(v) + u + size) * (1.0 + 1.0 / sqrt(body.beta))
    for dx, dv in states_of(corners, 24, seed):
        at_x, at_v = step_with_friction(x + dx, v + dv, u, 1.0 / n, s, g, f, body)
        assert inside_of(at_x - to_x, at_v - to_v, work[: 2 * after], slack)
        if fate == HELD:
            assert at_v == 0.0


def test_what_slides_moves_by_one_matrix() -> None:
    """Corners go by the free response, and the area shrinks by its determinant."""
    body = body_of(0.2, 0.05, 0.1, 0.0)
    s, g, f = coefficients(0.5, body)
    work = [-0.1, -0.1, 0.1, -0.1, 0.1, 0.1, -0.1, 0.1, *zeros(ROOM)]
    fate, x, v, count = move(0.0, 3.0, 0.0, Hold(0.5, s, g, f), work, 4, 0.0, body, zeros(3))
    assert (fate, count) == (SLID, 4)
    assert (x, v) == step_with_friction(0.0, 3.0, 0.0, 0.5, s, g, f, body)
    expected = [0.1 * (a * (1.0 - 0.05 * g) + b * s) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    assert work[:8:2] == pytest.approx(expected)


def test_what_sticks_has_no_velocity_and_stays() -> None:
    """A set that stops within the hold becomes a segment at exactly 0, which the next hold leaves alone."""
    body = body_of(0.2, 0.05, 1.0, 0.0)
    hold = Hold(0.5, *coefficients(0.5, body))
    work = [-0.1, -0.01, 0.1, -0.01, 0.1, 0.01, -0.1, 0.01, *zeros(ROOM)]
    fate, x, v, count = move(0.0, 0.1, 0.0, hold, work, 4, 0.0, body, zeros(3))
    assert (fate, v, count) == (HELD, 0.0, 2)
    assert work[1:4:2] == [0.0, 0.0]
    again = list(work)
    assert move(x, v, 0.0, hold, again, 2, 0.0, body, zeros(3)) == (HELD, x, 0.0, 2)
    assert again == work


def test_the_enclosure_of_a_small_set_is_narrow() -> None:
    """Of a set that reverses, a thousand times smaller, the excess is a million times smaller."""
    body = body_of(0.2, 0.05, 0.1, 0.0)
    s, g, f = coefficients(0.25, body)
    excess = []
    for size in (1e-2, 1e-5):
        work = [-size, -size, size, -size, size, size, -size, size, *zeros(ROOM)]
        x, v = -8.0, -0.03
        fate, _, _, count = move(x, v, 0.0, Hold(0.25, s, g, f), work, 4, float("inf"), body, zeros(3))
        assert fate == ENCLOSED
        ends = [
            step_with_friction(x + a * size, v + b * size, 0.0, 0.25, s, g, f, body) for a in (-1, 1) for b in (-1, 1)
        ]
        true = max(end[0] for end in ends) - min(end[0] for end in ends)
        excess.append(max(work[: 2 * count : 2]) - min(work[: 2 * count : 2]) - true)
    assert 0.0 <= excess[1] < 2e-6 * excess[0]
