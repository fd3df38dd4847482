"""A grip that follows its push, against every rest that wall and hand have at 60 digits; there is one.

The tolerance, in roundings u = 2^-53. The package looks for the depth d at which h(d) = T + k d is the push g. T is
computed within 6 u, the grip F = p T within 11 u. A relative error of F is at most 2.5 times as large in k: that is
the most that F dk/dF is of k in Tables 1-5. With the roundings of the line and of the sum, h is wrong by 38 u at most,
and d is a bisection's, exact within 2 u. T grows at most as d^2, and h at least as T and as d: a relative error of h is
at most doubled in F. So F is within 2 (38 + 2) + 11 = 91 u. A number of the hand is on the line of its rows: within its
slope times that, and 8 u of the larger row.

Behind a gear that yields, h = T + k (d + T / c). The twist T / c is within 7 u, its sum with d within 8 u, and h within
46 u. It still grows at least as T and as d. So F is within 2 (46 + 2) + 11 = 107 u.
"""

from itertools import pairwise
from typing import Any

import hypothesis.strategies as st
import mpmath
import pytest
from hypothesis import Phase, assume, event, example, given, settings

from hknob_cli.specs.motor import Cogging
from hknob_cli.specs.plan import placed
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.specs.squeeze import grip_of, left_out, squeezed

from .squeeze_reference import DIGITS, SAME, Number, Push, Rest, at_grip, rests, rows_of, walls

U = mpmath.mpf(2) ** -53
OF_GRIP, OF_GRIP_BEHIND_A_MESH, OF_ROW = 91 * U, 107 * U, 8 * U
RATIO = 4.0  # of gears: a power of 2, by which a torque limit is divided without a rounding
SETTINGS = settings(
    max_examples=100,
    deadline=None,
    derandomize=True,
    database=None,
    phases=[Phase.explicit, Phase.generate, Phase.shrink],
)
SMALL = {"friction": 0.7, "radius": 8.9e-3, "margin": 1.5}


def scene(push: Push, **parts: Any) -> Any:
    """The package's scene. The push is put in afterwards: specs refuse one that asks for more than the table has."""
    least = float(rows_of(push.table)[push.least][0])
    given: dict[str, Any] = {
        "knob": {"inertia": 1.9e-6},
        "hand": {"table": push.table, "grip_n": least},
        "wall": {"stiffness": push.stiffness},
        "bias": {"torque": 0.0},
        "squeeze": {"friction": push.friction, "radius": push.radius, "margin": push.margin},
        **parts,
    }
    if push.surface < 1.0:
        given["controller"] = {"kind": "stiffening", "surface": push.surface, "depth": push.depth}
    if push.mesh is not None and not parts:
        given["gear"] = {"ratio": RATIO, "motor_inertia": 1e-8, "stiffness": push.mesh}
    if push.most is not None and not parts:
        given["actuator"] = {"torque_limit": push.most / RATIO if push.mesh is not None else push.most}
    return placed(SceneSpec.model_validate(given).plain(), {"bias.torque": push.torque})


def logs(low: float, high: float) -> st.SearchStrategy[float]:
    """Positive numbers evenly spread in decades."""
    return st.floats(low, high).map(lambda power: float(10.0**power))


@st.composite
def pushes(draw: st.DrawFn) -> Push:
    """Tiny pushes to large, soft walls and gears to hard; in some the grip stands on a row, or next to one."""
    stiffens, limited, yields = draw(st.booleans()), draw(st.booleans()), draw(st.booleans())
    push = Push(
        table=draw(st.integers(1, 5)),
        least=draw(st.integers(0, 5)),
        torque=draw(logs(-9, 1)),
        friction=draw(st.floats(0.05, 3.0)),
        radius=draw(st.floats(2e-3, 0.1)),
        margin=draw(st.floats(1.0, 10.0)),
        stiffness=draw(logs(-3, 1)),
        surface=draw(st.one_of(st.floats(0.01, 0.99), st.just(2.0**-30))) if stiffens else 1.0,
        depth=draw(logs(-4, 1)) if stiffens else 1.0,
        most=draw(logs(-4, 0.5)) if limited else None,
        mesh=draw(logs(-3, 4)) if yields else None,
    )
    if draw(st.booleans()):
        row = draw(st.integers(push.least, 5))
        balance = _on_row(push, row)
        push = Push(**{**vars(push), "torque": balance * (1.0 + draw(st.integers(-3, 3)) * 2.0**-52)})
    return push


def _on_row(push: Push, row: int) -> float:
    """The push at which the grip is that of a row of the table, without a limit: the depth is that of its torque."""
    grip, _, _, stiffness = rows_of(push.table)[row]
    torque, k = grip / push.per_torque, mpmath.mpf(push.stiffness)
    a, b = k * push.surface, k * (1 - mpmath.mpf(push.surface)) / push.depth
    d = torque / k if b == 0 else (mpmath.sqrt(a * a + 4 * b * torque) - a) / (2 * b)
    if d > push.depth:
        d = torque / k
    return float(torque + stiffness * (d + push.twist * torque))


def only(push: Push) -> Rest:
    """The one rest of a push; all that is found more than once is the same."""
    found = rests(push)
    assert found, push
    with mpmath.workdps(DIGITS):
        assert all(abs(one.depth - found[0].depth) <= 1000 * SAME * found[0].depth for one in found), push
    return found[0]


def agree(push: Push, made: Any) -> None:
    """The package's scene has the grip and the hand of the only rest."""
    rest, of_grip = only(push), OF_GRIP if push.mesh is None else OF_GRIP_BEHIND_A_MESH
    with mpmath.workdps(DIGITS):
        assert abs(mpmath.mpf(grip_of(made)) - rest.grip) <= of_grip * rest.grip
        rows = rows_of(push.table)
        near = [
            (one, other)
            for one, other in pairwise(rows)
            if one[0] * (1 - of_grip) <= rest.grip * (1 + of_grip) and rest.grip <= other[0] * (1 + of_grip)
        ] or [(rows[-1], rows[-1])]
        hand = squeezed(made).hand
        assert hand is not None
        for place, (found, wanted) in enumerate(zip(hand[:3], rest.hand, strict=True), start=1):
            slope = max(abs(b[place] - a[place]) / (b[0] - a[0]) if b is not a else 0 for a, b in near)
            largest = max(abs(row[place]) for pair in near for row in pair)
            assert abs(mpmath.mpf(found) - wanted) <= slope * of_grip * rest.grip + OF_ROW * largest


@pytest.mark.parametrize("table", range(1, 6))
def test_there_is_one_rest_because_a_firmer_grip_is_never_softer(table: int) -> None:
    """T(d) rises with the depth, the grip with T, and the stiffness with the grip: so T + k (d + T / c) rises."""
    stiffness = [row[3] for row in rows_of(table)]
    assert stiffness == sorted(stiffness)
    assert stiffness[0] > 0


@pytest.mark.parametrize("table", range(1, 6))
def test_a_relative_error_of_the_grip_is_at_most_two_and_a_half_times_that_in_the_stiffness(table: int) -> None:
    """F dk/dF over k, which is largest at an end of a piece."""
    rows = rows_of(table)
    for one, other in pairwise(rows):
        slope = (other[3] - one[3]) / (other[0] - one[0])
        assert max(slope * row[0] / row[3] for row in (one, other)) <= 2.5


@SETTINGS
@given(pushes())
@example(Push(1, 0, 1e-3, **SMALL, stiffness=0.27))
@example(Push(1, 0, 6e-3, **SMALL, stiffness=0.27))
@example(Push(1, 0, 4e-2, **SMALL, stiffness=0.27))
@example(Push(1, 0, 4e-2, **SMALL, stiffness=0.27, surface=0.3, depth=0.2))
@example(Push(5, 0, 2.0, **SMALL, stiffness=0.27))
@example(Push(3, 5, 1e-9, **SMALL, stiffness=0.27, surface=0.01, depth=1e-3))
@example(Push(2, 0, 4e-2, **SMALL, stiffness=0.27, most=0.01))
@example(Push(1, 0, 4e-2, **SMALL, stiffness=0.27, mesh=0.1))
@example(Push(1, 0, 4e-2, **SMALL, stiffness=0.27, surface=0.3, depth=0.2, mesh=0.1))
@example(Push(2, 0, 4e-2, **SMALL, stiffness=0.27, most=0.01, mesh=0.1))
@example(Push(1, 0, 1e-3, **SMALL, stiffness=0.27, mesh=1e-3))
def test_grip_wall_and_hand_hold_the_push_together(push: Push) -> None:
    """Any table, wall and push, from one that no grip follows to one that asks for more than the table has."""
    rest, rows = only(push), rows_of(push.table)
    event(
        "the least grip"
        if rest.grip == rows[push.least][0]
        else "in the table"
        if rest.grip < rows[-1][0]
        else "beyond"
    )
    event("the limit" if push.most is not None and rest.torque == mpmath.mpf(push.most) else "the wall")
    event("rigid" if push.mesh is None else "a gear that yields")
    agree(push, scene(push))


@pytest.mark.parametrize("surface", [1.0, 0.3])
@pytest.mark.parametrize(
    ("parts", "most", "mesh"),
    [
        ({"actuator": {"torque_limit": 0.002}, "gear": {"ratio": 4.0, "motor_inertia": 1e-8}}, 0.008, None),
        (
            {"actuator": {"torque_limit": 0.002}, "gear": {"ratio": 4.0, "motor_inertia": 1e-8, "stiffness": 0.5}},
            0.008,
            0.5,
        ),
        (
            {"motor": {"torque_constant": 0.02, "resistance": 5.0, "winding": "voltage", "supply_voltage": 2.0}},
            0.02 * 2.0 / 5.0,
            None,
        ),
    ],
)
def test_limits_of_motors_and_behind_gears_hold_for_the_wall(
    parts: dict[str, Any], most: float, mesh: float | None, surface: float
) -> None:
    """All give 8 mN·m on the knob, less than the wall would of a push of 20 mN·m."""
    push = Push(2, 0, 0.02, **SMALL, stiffness=0.27, surface=surface, depth=0.1, most=most, mesh=mesh)
    agree(push, scene(push, **parts))
    assert grip_of(scene(push, **parts)) < grip_of(scene(Push(**{**vars(push), "most": None})))


def balanced(push: Push, depth: float, more: float) -> tuple[Push, Number]:
    """The push that rests with the motor at a depth (rad) where cogging or friction adds ``more`` (N·m); its grip."""
    rows, d = rows_of(push.table), mpmath.mpf(depth)
    pieces = [(a, b) for a, b, low, high in walls(push) if low <= max(d, 0) <= high]
    torque = max(d, 0) * pieces[0][0] + max(d, 0) ** 2 * pieces[0][1]
    held = (torque if push.most is None else min(torque, mpmath.mpf(push.most))) + mpmath.mpf(more)
    grip = max(push.per_torque * abs(held), rows[push.least][0])
    total = held + at_grip(rows, grip)[2] * (d + push.twist * held)
    return Push(**{**vars(push), "torque": float(total)}), grip


@SETTINGS
@given(pushes(), logs(-6, 1), st.sampled_from([1, 1, 1, -1]), st.floats(-1.0, 1.0), logs(-5, 0))
def test_friction_and_cogging_move_the_grip_by_no_more_than_is_said(
    push: Push, depth: float, inside: int, share: float, most: float
) -> None:
    """At any rest with such a torque. A place and the torque are drawn, and the push is the one that rests there."""
    with mpmath.workdps(DIGITS):
        push, grip = balanced(push, inside * depth, share * most)
        assume(push.torque > 0.0)
        made = scene(push)
        bound = push.per_torque * mpmath.mpf(most)
        cogging = Cogging(per_revolution=84, torque=most / (1.0 if push.mesh is None else RATIO))
        assert left_out(made._replace(cogging=cogging)) == pytest.approx(float(bound), rel=1e-14)
        found = mpmath.mpf(grip_of(made))
        event("pulled away from the wall" if share > 0 else "into it")
        assert abs(found - grip) <= bound * abs(share) + OF_GRIP_BEHIND_A_MESH * found + 4 * U * (grip + found)


@pytest.mark.parametrize("more", [1e-3, -1e-3])
def test_cogging_moves_the_grip_by_all_that_is_said_where_the_wall_gives_its_limit(more: float) -> None:
    with mpmath.workdps(DIGITS):
        push, grip = balanced(Push(1, 0, 1.0, **SMALL, stiffness=0.27, most=0.02), 0.2, more)
        change = grip - mpmath.mpf(grip_of(scene(push)))
        assert abs(change - push.per_torque * more) <= OF_GRIP * grip
