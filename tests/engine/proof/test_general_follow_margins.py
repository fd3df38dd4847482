"""When a trial is said to reach a known orbit, to repeat, or to come to rest: each condition on its margin."""

from math import inf, nextafter
from typing import Any, ClassVar

import pytest

from hknob_cli.engine.certificate import DIFFERENT, NOT_CAPTURED, PROVEN
from hknob_cli.engine.follow import CYCLE_ON_EDGE, CYCLE_PROVEN
from hknob_cli.engine.general import follow, looks
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.captured import FIELDS, captured, has_period, may_be_captured
from hknob_cli.engine.general.controller import Controller, read
from hknob_cli.engine.general.follow import closes_in
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.looks import contracts_to_rest
from hknob_cli.engine.general.search import make_space
from tests.engine.trial_space import trial_of

from .test_standstill_margins import WALL, body

DAMPED = WALL._replace(damping=0.1)

COGS = [0.0, 1e9, 0.0, 0.0, 0.0, 0.0]  # without a torque, and corners far away


def row(
    fate: int = CYCLE_PROVEN, period: int = 6, margin: float = 0.375, bound: float = 0.125, before: float = -3.0
) -> list[float]:
    return [float(fate), float(period), margin, 9.0, 9.0, bound, 9.0, 9.0, 9.0, before]


def found(
    z: list[float],
    rows: list[list[float]],
    states: list[list[float]],
    one: Body | None = None,
    wall: Controller = WALL,
    *,
    before: float = -3.0,
    ring: tuple[float, ...] = (),
    head: int = 0,
    lines: tuple[tuple[float, ...], ...] = (),
) -> int:
    space = make_space(2, len(ring), lambda count: [7.0] * count)
    trial = trial_of(z, list(ring), space, rows, states, list(lines))
    return captured(trial, before, head, one or body(beta=0.25), wall)


def test_a_trial_within_the_margin_less_its_bound_has_reached_the_orbit() -> None:
    """A quarter of a count, in position, or half as much in speed, whose energy is in a spring of a quarter."""
    near = nextafter(0.25, 0.0)
    place = [-2.5, 0.5]
    for off, reached in (
        ((near, 0.0), True),
        ((-near, 0.0), True),
        ((0.25, 0.0), False),
        ((-0.25, 0.0), False),
        ((0.0, 0.124), True),
        ((0.0, -0.124), True),
        ((0.0, 0.125), False),
        ((0.0, -0.126), False),
        ((0.2, 0.07), True),
        ((0.2, 0.08), False),
    ):
        z = [off[0], off[1]]
        assert found(z, [row()], [[0.0, 0.0]]) == (0 if reached else -1)
        if abs(off[0]) in (0.0, 0.2):
            assert found([place[0] + off[0], place[1] + off[1]], [row()], [place]) == (0 if reached else -1)
    assert len(row()) == FIELDS


def test_only_proven_orbits_are_reached_and_the_nearest_row_is_found() -> None:
    far, here = [-9.0, 0.0], [-2.5, 0.5]
    assert found(here, [row(fate=CYCLE_ON_EDGE)], [here]) == -1
    assert found(here, [], []) == -1
    assert found(here, [row(), row()], [far, here]) == 1
    assert found(here, [row(), row()], [here, far]) == 0
    assert found(here, [row(fate=CYCLE_ON_EDGE), row()], [here, here]) == 1
    assert found(here, [row(margin=0.125), row()], [here, here]) == 1  # no margin is left
    assert found(here, [row(bound=0.5), row()], [here, here]) == 1


def test_a_damped_wall_must_have_read_the_same_before() -> None:
    here = [-2.5, 0.5]
    rows, states = [row(before=-2.0), row(before=-3.0)], [here, here]
    assert found(here, rows, states, wall=DAMPED, before=-3.0) == 1
    assert found(here, rows, states, wall=DAMPED, before=-2.0) == 0
    assert found(here, rows, states, wall=DAMPED, before=-1.0) == -1
    assert found(here, rows, states, wall=WALL, before=-3.0) == 0
    assert found(here, rows, states, wall=WALL._replace(damping=1e-9), before=-3.0) == 1


def test_the_same_commands_must_be_under_way() -> None:
    """Oldest first, from wherever the trial's line begins."""
    here = [-2.5, 0.5]
    rows, states, lines = [row(), row()], [here, here], ((1.0, 2.0, 3.0), (3.0, 1.0, 2.0))
    for ring, head, at in (
        ((1.0, 2.0, 3.0), 0, 0),
        ((1.0, 2.0, 3.0), 2, 1),
        ((3.0, 1.0, 2.0), 1, 0),
        ((1.0, 2.0, 3.0), 1, -1),
        ((1.0, 2.0, 4.0), 0, -1),
        ((4.0, 2.0, 3.0), 0, -1),
        ((1.0, 4.0, 3.0), 0, -1),
    ):
        assert found(here, rows, states, ring=ring, head=head, lines=lines) == at


def test_a_multiple_of_a_proven_period_is_known() -> None:
    table = [*row(period=6), *row(fate=CYCLE_ON_EDGE, period=5), *row(period=7)]
    assert [n for n in range(1, 22) if has_period(n, 3, table)] == [6, 7, 12, 14, 18, 21]
    assert [n for n in range(1, 22) if has_period(n, 1, table)] == [6, 12, 18]
    assert not has_period(6, 0, table)


def repeats(
    z: list[float],
    period: int,
    gap: float,
    one: Body,
    *,
    trail: list[float] | None = None,
    delay: int = 0,
    wall: Controller = WALL,
) -> bool:
    space = make_space(2, delay, lambda count: [7.0] * count)
    ring = [0.0] * delay
    before = read(z[0], wall)
    if trail is None:
        state, line, head, shown, trail = list(z), list(ring), 0, before, []
        for _ in range(period):
            trail.append(read(state[0], wall))
            shown, head = advance(state, shown, line, head, one, wall, space.pad)
    for k in range(len(space.trail)):
        space.trail[k] = trail[k] if k < len(trail) else 5.0
    kept = list(z), list(ring)
    result = bool(closes_in(trial_of(z, ring, space), before, 0, period, gap, one, wall))
    assert (z, ring) == kept
    return result


@pytest.mark.parametrize("delay", [0, 2])
@pytest.mark.parametrize("friction", [0.0, 0.01])
def test_a_candidate_must_read_the_same_and_come_no_less_close(friction: float, delay: int) -> None:
    """Inside one count under a spring, it comes near in six samples by what is simulated here, sample by sample."""
    one = body(alpha=0.1, beta=1.0, friction=friction, push=2.5)
    z, period = [-0.55, 0.05], 6
    state, line, head, shown, readings = list(z), [0.0] * delay, 0, -1.0, []
    for _ in range(period):
        readings.append(read(state[0], WALL))
        shown, head = advance(state, shown, line, head, one, WALL, [0.0] * 4)
    gap = ((state[0] - z[0]) ** 2 + (state[1] - z[1]) ** 2) ** 0.5
    assert repeats(z, period, gap * (1.0 + 1e-12), one, delay=delay)
    assert not repeats(z, period, gap * (1.0 - 1e-12), one, delay=delay)
    for k in range(period):
        other = list(readings)
        other[k] = -7.0
        assert not repeats(z, period, 1.01 * gap, one, trail=other, delay=delay)
    halted = one._replace(halt=[1.0])
    assert not repeats(z, period, inf, halted, delay=delay)
    assert not repeats(z, period, inf, one._replace(halt=[1e-9]), delay=delay)


def test_readings_beyond_those_kept_are_not_compared() -> None:
    one, z = body(alpha=0.1, beta=1.0, push=1.5), [-0.5, 0.0]  # at rest, where it comes back to the last bit
    assert repeats(z, 6, 0.0, one)
    space = make_space(2, 0, lambda count: [7.0] * count)._replace(trail=[-1.0] * 3)
    assert closes_in(trial_of(z, [], space), -1.0, 0, 6, 0.0, one, WALL)
    other = space._replace(trail=[-1.0, -1.0, -2.0])
    assert not closes_in(trial_of(z, [], other), -1.0, 0, 6, 0.0, one, WALL)


def test_readings_outside_the_wall_are_one() -> None:
    one = body(alpha=0.1, beta=1.0, push=-2.5)
    assert repeats([2.5, 0.0], 3, inf, one, trail=[0.0, 7.0, 1.0])
    assert not repeats([2.5, 0.0], 3, inf, one, trail=[0.0, 7.0, -1.0])


def contracts(
    monkeypatch: pytest.MonkeyPatch, status: int, x: float, wall: Controller
) -> tuple[bool, list[float], list[float], list[Any]]:
    asked: list[Any] = []
    space = make_space(2, 2, lambda count: [7.0] * count)

    def certify(
        z: Any, before: float, ring: Any, head: int, period: int, one: Body, wall: Controller, room: Any
    ) -> Any:
        asked.append((list(z), before, list(ring), head, period))
        room.orbit[:], room.orbit_line[:] = [-1.5, 0.25], [3.0, 4.0]
        return status, 0.5, 0.5, 0.0, 0.0

    z, ring = [x, 0.125], [1.0, 2.0]
    with monkeypatch.context() as patch:
        patch.setattr(looks, "certify", certify)
        whether = contracts_to_rest(trial_of(z, ring, space), read(x, wall), -2.0, 1, body(), wall)
    return bool(whether), z, ring, asked


def test_a_fixed_point_of_one_sample_inside_the_wall_is_a_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a continuous sensor alone; it is left where it was otherwise."""
    continuous = WALL._replace(analog=1.0)
    whether, z, ring, asked = contracts(monkeypatch, PROVEN, -2.5, continuous)
    assert (whether, z, ring) == (True, [-1.5, 0.0], [3.0, 4.0])
    assert asked == [([-2.5, 0.125], -2.0, [1.0, 2.0], 1, 1)]
    assert contracts(monkeypatch, PROVEN, -1e-9, continuous)[0]
    for status, x, wall in (
        (NOT_CAPTURED, -2.5, continuous),
        (DIFFERENT, -2.5, continuous),
        (PROVEN, 0.0, continuous),
        (PROVEN, 0.5, continuous),
        (PROVEN, 2.5, continuous),
        (PROVEN, -2.5, WALL),
        (PROVEN, -2.5, continuous._replace(clock=[1.0, 0.9, 0.1, 0.0, 0.0, 0.95])),  # no interval is like another
    ):
        whether, z, ring, _ = contracts(monkeypatch, status, x, wall)
        assert (whether, z, ring) == (False, [x, 0.125], [1.0, 2.0])


def test_with_hysteresis_the_same_count_goes_on() -> None:
    """Inside the wall, where counts act; what a row of the table keeps is the orbit's reading before."""
    wall, rows = WALL._replace(hysteresis=0.5), [row(before=-3.0)]
    assert found([-2.5, 0.5], rows, [[-2.5, 0.5]], wall=wall, before=-3.0) == 0
    assert found([-2.5, 0.5], rows, [[-2.5, 0.5]], wall=wall, before=-2.0) == -1
    outside = [row(before=0.0)]
    assert found([-2.5, 0.5], outside, [[-2.5, 0.5]], wall=wall, before=4.0) == 0


@pytest.mark.parametrize(("more", "parts"), [({}, False), ({"play": 0.5}, True), ({"cogs": COGS}, True)])
def test_where_motions_may_part_a_return_need_not_be_as_close(
    more: dict[str, Any], parts: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Under a spring and a damper, six samples from one end of a swing; only the readings are compared there."""

    def without_cogs(z: Any, before: float, ring: Any, head: int, one: Body, wall: Controller, pad: Any) -> Any:
        return advance(z, before, ring, head, one._replace(cogs=None), wall, pad)

    monkeypatch.setattr(follow, "advance", without_cogs)
    one = body(alpha=0.1, beta=1.0, push=2.5)._replace(**more)
    assert repeats([-0.55, 0.05], 6, 0.0, one, trail=[-1.0, -1.0, -2.0, -2.0, -1.0, 0.0]) is parts


def test_only_a_proven_orbit_may_capture_and_only_within_its_margin() -> None:
    """Two rows of two states: one proven at -1.5, one that is not at 2."""

    class Ends:
        counts: ClassVar = [2.0]
        states: ClassVar = [-1.5, 0.0, 2.0, 0.0]
        table: ClassVar = [float(CYCLE_PROVEN), 12.0, 0.25, *[0.0] * 7, float(CYCLE_ON_EDGE), 12.0, 0.25, *[0.0] * 7]

    class Two:
        order = 2

    for x, may in ((-1.5, True), (-1.26, True), (-1.25, False), (-1.75, False), (2.0, False), (9.0, False)):
        assert may_be_captured(x, Ends(), Two()) is may
