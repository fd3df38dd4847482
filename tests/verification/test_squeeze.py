"""A grip that follows its push, against every rest that wall and hand have at 60 digits; there is one.

The tolerance, in roundings u = 2^-53. The package looks for the depth d at which h(d) = T + k d is the push g. T is
computed within 6 u, the grip F = p T within 11 u. A relative error of F is at most 2.5 times as large in k: that is
the most that F dk/dF is of k in Tables 1-5. With the roundings of the line and of the sum, h is wrong by 38 u at most,
and d is a bisection's, exact within 2 u. T grows at most as d^2, and h at least as T and as d: a relative error of h is
at most doubled in F. So F is within 2 (38 + 2) + 11 = 91 u. A number of the hand is on the line of its rows: within its
slope times that, and 8 u of the larger row.
"""

from itertools import pairwise
from typing import Any

import hypothesis.strategies as st
import mpmath
import pytest
from hypothesis import Phase, event, example, given, settings

from hknob_cli.specs.plan import placed, scene_at
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.specs.squeeze import grip_of

from .squeeze_reference import DIGITS, SAME, Push, Rest, rests, rows_of

U = mpmath.mpf(2) ** -53
OF_GRIP, OF_ROW = 91 * U, 8 * U
SETTINGS = settings(
    max_examples=300,
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
    if push.most is not None and not parts:
        given["actuator"] = {"torque_limit": push.most}
    return placed(SceneSpec.model_validate(given).plain(), {"bias.torque": push.torque})


def logs(low: float, high: float) -> st.SearchStrategy[float]:
    """Positive numbers evenly spread in decades."""
    return st.floats(low, high).map(lambda power: float(10.0**power))


@st.composite
def pushes(draw: st.DrawFn) -> Push:
    """Tiny pushes to large, soft walls to hard; some are such that the grip stands on a row, or next to one."""
    stiffens, limited = draw(st.booleans()), draw(st.booleans())
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
    return float(torque + stiffness * d)


def only(push: Push) -> Rest:
    """The one rest of a push; all that is found more than once is the same."""
    found = rests(push)
    assert found, push
    with mpmath.workdps(DIGITS):
        assert all(abs(one.depth - found[0].depth) <= 1000 * SAME * found[0].depth for one in found), push
    return found[0]


def agree(push: Push, made: Any) -> None:
    """The package's scene has the grip and the hand of the only rest."""
    rest = only(push)
    with mpmath.workdps(DIGITS):
        assert abs(mpmath.mpf(grip_of(made)) - rest.grip) <= OF_GRIP * rest.grip
        rows = rows_of(push.table)
        near = [
            (one, other)
            for one, other in pairwise(rows)
            if one[0] * (1 - OF_GRIP) <= rest.grip * (1 + OF_GRIP) and rest.grip <= other[0] * (1 + OF_GRIP)
        ] or [(rows[-1], rows[-1])]
        hand = scene_at(made, {}).hand
        assert hand is not None
        for place, (found, wanted) in enumerate(zip(hand[:3], rest.hand, strict=True), start=1):
            slope = max(abs(b[place] - a[place]) / (b[0] - a[0]) if b is not a else 0 for a, b in near)
            largest = max(abs(row[place]) for pair in near for row in pair)
            assert abs(mpmath.mpf(found) - wanted) <= slope * OF_GRIP * rest.grip + OF_ROW * largest


@pytest.mark.parametrize("table", range(1, 6))
def test_there_is_one_rest_because_a_firmer_grip_is_never_softer(table: int) -> None:
    """T(d) rises with the depth, the grip with T, and the stiffness with the grip: so T + k d rises."""
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
    agree(push, scene(push))


@pytest.mark.parametrize("surface", [1.0, 0.3])
@pytest.mark.parametrize(
    ("parts", "most"),
    [
        ({"actuator": {"torque_limit": 0.002}, "gear": {"ratio": 4.0, "motor_inertia": 1e-8}}, 0.008),
        (
            {"motor": {"torque_constant": 0.02, "resistance": 5.0, "winding": "voltage", "supply_voltage": 2.0}},
            0.02 * 2.0 / 5.0,
        ),
    ],
)
def test_limits_of_motors_and_behind_gears_hold_for_the_wall(
    parts: dict[str, Any], most: float, surface: float
) -> None:
    """Both give 8 mN·m on the knob, less than the wall would of a push of 20 mN·m."""
    push = Push(2, 0, 0.02, **SMALL, stiffness=0.27, surface=surface, depth=0.1, most=most)
    agree(push, scene(push, **parts))
    assert grip_of(scene(push, **parts)) < grip_of(scene(Push(**{**vars(push), "most": None})))
