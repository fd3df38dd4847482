"""The count of an encoder with hysteresis at turning points, with teeth and without, and of what has settled."""

from math import inf
from random import Random

import numpy as np
import pytest

from hknob_cli.engine.general import flanks, hysteresis, slopes
from hknob_cli.engine.general.advance import UNKNOWN, rub_many
from hknob_cli.engine.general.body import FIRST, Body
from hknob_cli.engine.general.cogging import FALLEN, RISEN, TURNED
from hknob_cli.engine.general.controller import Controller, edge_gap, read_after
from hknob_cli.engine.general.flank_rest import flank_room
from hknob_cli.engine.general.flanks import still_in_teeth
from hknob_cli.engine.general.hysteresis import pass_still, turn_and_count, way_at_most
from hknob_cli.engine.general.slopes import cog_many
from hknob_cli.engine.general.teeth import flank, pressing
from hknob_cli.engine.general.teeth_ends import Mode

from .bodies import knob
from .cogs import SCENES, Cogged, body_of
from .cogs import begun as cogs_begun
from .gears import Gear, begun, geared

WIDE = Controller(1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, inf, 0.0, hysteresis=0.1)
TWO_PARTS = {
    "finger": {"inertia": 3.0e-7, "damping": 2.9e-3, "stiffness": 0.4},
    "fingerpad": {"damping": 3.8e-4, "stiffness": 0.05},
}
FREE = knob(knob={"inertia": 1.9e-6}, hand=TWO_PARTS).body
TEETH: dict[str, Body] = {
    "plain": geared(),
    "undamped": geared(mesh_damping=0.0),
    "rubs": geared(2e-5),
    "rubs, lag": geared(1e-5, lag=2e-4),
}


def counted(
    case: Gear, z: list[float], u: float, steps: int, shown: float, wall: Controller
) -> tuple[float, float, int]:
    """Count and margin by the model's own turning points: where its motor ends a way, and goes the other or stops."""
    margin, turns = inf, 0
    start = Gear(case.body)
    start.move(z, u, 0)
    way = start.now[1]
    _, events = case.move(z, u, steps)
    for one in events:
        if way not in (0, one.way):
            before, shown = shown, read_after(float(one.state[0]), shown, wall)
            margin = min(margin, edge_gap(float(one.state[0]), shown, before, wall))
            turns += 1
        way = one.way
    return shown, margin, turns


@pytest.mark.parametrize("name", TEETH)
def test_the_count_goes_by_the_motors_turning_points(name: str) -> None:
    """On any flank and on none; nothing else has a margin."""
    body, turns = TEETH[name], 0
    for seed in range(8):
        chance = Random(f"{name} {seed}")
        z, u = begun(body, chance)
        z[1] *= 0.1
        steps = chance.choice([24, 64, 64])
        for wall in (WIDE, WIDE._replace(hysteresis=2.5)):
            shown = read_after(z[0], np.floor(z[0]), wall)
            expected, margin, seen = counted(Gear(body), z, u, steps, shown, wall)
            turns += seen
            moved, pad = list(z), [0.0] * (2 * body.order)
            found, room = turn_and_count(moved, u, steps / 64.0, shown, body, wall, pad)
            other = list(z)
            rub_many(other, u, steps / 64.0, body, pad)
            assert moved == pytest.approx(other, rel=1e-9, abs=1e-9)
            if margin > 1e-6:
                assert found == expected
                assert room == pytest.approx(margin, abs=1e-8)
    assert turns >= 4


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", SCENES)
def test_beside_cogging_the_count_goes_by_turning_points_from_corner_to_corner(name: str) -> None:
    """A corner is no turning point, nor is the end of being held."""
    body, turns = body_of(name), 0
    for seed in range(12):
        chance = Random(f"{name} {seed}")
        z, u = cogs_begun(body, chance)
        at = Cogged(body, [z[0], 0.0, *z[2:]], u)
        z[1] = -chance.choice([0.0, 0.1, 0.3, 0.5]) * float(at.pull() @ at.z)  # so fast that it turns round in a while
        steps = chance.choice([24, 64, 64])
        for wall in (WIDE, WIDE._replace(hysteresis=2.5)):
            first = shown = read_after(z[0], np.floor(z[0]), wall)
            known, margin = Cogged(body, z, u, ways=True), inf
            mode = known.mode
            for one in known.move(steps):
                if one.end == TURNED and mode != 0:
                    before, shown = shown, read_after(float(one.state[0]), shown, wall)
                    margin = min(margin, edge_gap(float(one.state[0]), shown, before, wall))
                    turns += 1
                mode = one.mode
            moved, pad = list(z), [0.0] * (2 * body.order)
            found, room = turn_and_count(moved, u, steps / 64.0, first, body, wall, pad)
            other = list(z)
            cog_many(body.cogs, other, u, steps / 64.0, body, pad)
            assert moved == pytest.approx(other, rel=1e-9, abs=1e-9)
            if margin > 1e-6:
                assert found == shown
                assert room == pytest.approx(margin, abs=1e-8)
    assert turns >= 4


def test_what_has_settled_beside_cogging_has_no_turning_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """It moves a fourth of (1 + 3), and a count at most; its slope is longer, and nothing rubs."""
    body = body_of("strong")._replace(friction=0.0)
    z, u, shown, passed = [-3.0, 0.0], 0.5, -3.0, []
    wall = WIDE._replace(hysteresis=8.0)

    def settled(far: float, span: float, room: float, one: Body = body, at: float = -3.0) -> float | None:
        """The margin of what is passed over; None where it is followed from end to end."""
        passed.clear()
        monkeypatch.setattr(slopes, "STILL", 0.25)
        monkeypatch.setattr(slopes, "far_apart", lambda *_: far)
        monkeypatch.setattr(slopes, "room_on", lambda *_: room)
        monkeypatch.setattr(hysteresis, "roll", lambda *_: (1.0, 0))
        monkeypatch.setattr(hysteresis, "cog_many", lambda *given: passed.append(given))
        found, margin = hysteresis.turn_on_cogs(one.cogs, [at, 0.0], u, span, shown, one, wall, [0.0] * 4)
        assert found == shown
        assert (len(passed) == 1) == (margin < inf)
        return margin if margin < inf else None

    gap = edge_gap(z[0], shown, shown, wall)
    assert gap > 2.0
    assert settled(1.0, 1.0, 1.5) == gap - 1.0
    assert settled(4.0, 0.25, 1.5) == gap - 1.0
    assert settled(1.0, 0.5, 1.5) == gap - 0.5
    assert settled(1.0 + 2.0**-50, 1.0, 1.5) is None
    assert settled(1.0, 1.0, 1.0) is None
    assert settled(1.0, 1.0, 1.0 + 2.0**-50) == gap - 1.0
    assert settled(1.0, 1.0, 1.5, at=3.0) == edge_gap(3.0, shown, shown, wall) - 1.0
    assert settled(0.9, 1.0, 1.5, at=0.0) is None
    assert settled(0.25, 1.0, 1.5, at=0.0) == edge_gap(0.0, shown, shown, wall) - 0.25
    for friction in (1e-300, 1.0):
        assert settled(1.0, 1.0, 1.5, body._replace(friction=friction)) is None


def test_turning_points_beside_cogging_are_gone_through_end_by_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """A motion is fresh where it begins still, or has just ended a mode: its speed is 0 to a rounding there."""
    body, script, asked = body_of("rubs"), [], []

    def roll(z: list[float], u: float, slope: float, mode: int, left: float, fresh: bool, *_: object) -> object:
        asked.append((mode, left, fresh))
        time, end, z[0] = script.pop(0)
        return time, end

    def followed(mode: int, speed: float, *ends: tuple[float, int, float], then: int = -1) -> tuple[float, float]:
        script[:], asked[:] = ends, []
        monkeypatch.setattr(hysteresis, "way_from", lambda *_: mode)
        monkeypatch.setattr(hysteresis, "pass_on", lambda z, u, slope, *_: (slope, then))
        found = hysteresis.turn_on_cogs(body.cogs, [-0.5, speed], 0.0, 1.0, -1.0, body, WIDE, [0.0] * 4)
        assert not script
        return found

    monkeypatch.setattr(hysteresis, "roll", roll)
    for mode, speed, fresh in ((1, 0.0, True), (-1, 0.0, True), (0, 0.0, False), (1, 1.0, False), (-1, -1.0, False)):
        assert followed(mode, speed, (1.0, 0, -0.75)) == (-1.0, inf)
        assert asked == [(mode, 1.0, fresh)]
    # Released, over a corner, and round: the first turn is nearer to where its count would be another.
    near, far = (0.25, TURNED, -3.04), (0.25, TURNED, -2.5)
    gaps = [edge_gap(-3.04, -3.0, -1.0, WIDE), edge_gap(-2.5, -3.0, -3.0, WIDE)]
    assert 0.0 < gaps[0] < gaps[1]
    for ends in ((near, far), (far, near)):
        _, margin = followed(1, 0.5, *ends, (0.5, 0, -1.5))
        assert margin <= gaps[0]
    assert followed(1, 0.5, near, far, (0.5, 0, -1.5)) == (-3.0, pytest.approx(gaps[0], abs=1e-12))
    assert [one[1:] for one in asked] == [(1.0, False), (0.75, True), (0.5, True)]
    assert followed(0, 0.0, (0.5, TURNED, -3.04), (0.5, 0, -3.04)) == (-1.0, inf)
    assert followed(1, 0.5, (0.5, RISEN, -3.04), (0.5, 0, -3.04)) == (-1.0, inf)
    assert followed(1, 0.5, (0.5, RISEN, -3.04), (0.5, FALLEN, -3.04)) == (-1.0, inf)  # no time is left


# What has settled.


def at_rest(body: Body, still: float) -> tuple[list[float], float]:
    """A state near its balance, 30 counts in, and the torque that holds it."""
    u = 40.0
    d = u / body.pad_stiffness
    x = d + body.ratio * u / body.finger_stiffness - body.shift
    return [x + still, still, d, -still], u


def test_how_far_a_body_without_friction_moves_is_bounded_by_its_rates() -> None:
    pad = [0.0] * 8
    z = [0.25, 0.5, -0.25, 0.125]
    one = way_at_most(z, 3.0, 1.0, FREE, pad)
    assert 0.0 < one < inf
    assert way_at_most(z, 3.0, 0.25, FREE, pad) == pytest.approx(0.25 * one, rel=1e-12)
    far = 0.0
    for steps in range(1, 40):
        moved = list(z)
        pass_still(moved, 3.0, steps / 40.0, FREE, pad)
        far = max(far, abs(moved[0] - z[0]))
    assert 0.05 * one < far <= one
    for friction in (1e-300, 0.5, 2.0):
        assert way_at_most(z, 3.0, 1.0, FREE._replace(friction=friction), pad) == inf
    assert way_at_most(z[:2], 3.0, 1.0, knob(knob={"inertia": 1.9e-6}).body, [0.0] * 4) == inf


def test_it_is_passed_over_by_the_digits_of_the_time() -> None:
    """To a rounding: in one part or in many; a whole sample is one matrix, and nothing is no time."""
    pad = [0.0] * 8
    z = [0.25, 0.5, -0.25, 0.125]
    for span in (1.0, 0.5, 0.75, 0.3, 1.0 / 3.0, 2.0**-20):
        whole, parts = list(z), list(z)
        pass_still(whole, 3.0, span, FREE, pad)
        for _ in range(4):
            pass_still(parts, 3.0, 0.25 * span, FREE, pad)
        assert whole == pytest.approx(parts, rel=1e-12)
        assert whole != z
    none = list(z)
    pass_still(none, 3.0, 0.0, FREE, pad)
    assert none == z
    by_matrix: list[int] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hysteresis, "advance_hold", lambda z, u, which, *_: by_matrix.append(which - FIRST - 2))
        for span, digits in ((1.0, [0]), (0.625, [1, 3]), (0.0, []), (2.0**-52, [52]), (2.0**-53, [])):
            by_matrix.clear()
            pass_still(none, 3.0, span, FREE, pad)
            assert by_matrix == digits


@pytest.mark.parametrize("side", [1, -1])
def test_how_far_a_body_moves_whose_teeth_stay_on_their_flank(side: int) -> None:
    """By its rates there; not where they may part, where they do not touch, and not with friction."""
    body, pad = TEETH["plain"], [0.0] * 8
    z, u = at_rest(body, 1e-3)
    if side < 0:
        z[2], u = -body.play - z[2], -u
        z[0] = z[2] + body.play + body.ratio * u / body.finger_stiffness - body.shift - body.play
    assert flank(z, body) == side
    moved = still_in_teeth(z, u, side, 0.0, 0.5, body, pad)
    assert 0.0 < moved < 0.5
    assert still_in_teeth(z, u, side, 0.0, 0.25, body, pad) == pytest.approx(0.5 * moved, rel=1e-12)
    far, gear = 0.0, Gear(body)
    for steps in (4, 8, 16, 24, 32):
        end, events = gear.move(z, u, steps)
        assert not [one for one in events if one.flank != side]
        far = max(far, abs(end[0] - z[0]))
    assert 0.02 * moved < far <= moved
    room = flank_room(pressing(z, 0, side, body), body)
    for part, told in ((0.99, True), (1.01, False)):
        span = 0.5 * room / moved * part
        assert (still_in_teeth(z, u, side, 0.0, span, body, pad) < inf) is told
    for friction in (1e-300, 0.5, 2.0):
        assert still_in_teeth(z, u, side, 0.0, 0.5, body._replace(friction=friction), pad) == inf
    assert still_in_teeth(z, u, 0, 0.0, 0.5, body, pad) == inf


@pytest.mark.parametrize(("body", "places"), [(FREE, 4), (TEETH["plain"], 4)])
def test_what_moves_less_than_its_roundings_is_passed_over(body: Body, places: int) -> None:
    """Below 1e-11 of one and its place its turning points are not looked for, and its margin is the way that it has."""
    pad, asked = [0.0] * 8, []
    wall, size = WIDE._replace(hysteresis=0.5), 1.0
    for still in (1e-14, 3e-13, 3e-12, 1e-10, 1e-9):
        if body is FREE:
            z, u = [still, -still, still, still], body.push
        else:
            z, u = at_rest(body, still)
        side = flank(z, body)
        most = way_at_most(z, u, 1.0, body, pad) if body is FREE else still_in_teeth(z, u, side, 0.0, 1.0, body, pad)
        size = 1.0 + abs(z[0])
        shown = read_after(z[0], np.floor(z[0]), wall)
        with pytest.MonkeyPatch.context() as patch:
            for name in ("slide", "press"):
                real = getattr(hysteresis, name)
                patch.setattr(hysteresis, name, lambda *given, real=real: asked.append(1) or real(*given))
            moved = list(z)
            asked.clear()
            found, margin = turn_and_count(moved, u, 1.0, shown, body, wall, pad)
        assert found == shown
        assert bool(asked) == (most > 1e-11 * size)
        assert 0.7 < most / (1e-11 * size) < 1.4 or bool(asked) == (most > 1.4e-11 * size)
        if not asked:
            assert margin == edge_gap(z[0], shown, shown, wall) - most
        other = list(z)
        rub_many(other, u, 1.0, body, pad)
        assert moved == pytest.approx(other, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("x", [0.0, -2.0, 3.0])
def test_still_is_so_much_of_one_and_the_place(monkeypatch: pytest.MonkeyPatch, x: float) -> None:
    """Exactly that much still is; and so with teeth."""
    asked: list[str] = []
    edge = hysteresis.STILL * (1.0 + abs(x))
    assert hysteresis.STILL == 1e-11
    monkeypatch.setattr(hysteresis, "pass_still", lambda *_: asked.append("over"))
    monkeypatch.setattr(hysteresis, "play_many", lambda *_: asked.append("over"))
    monkeypatch.setattr(hysteresis, "slide", lambda *_: asked.append("events") or (1.0, False, UNKNOWN))
    monkeypatch.setattr(hysteresis, "press", lambda *_: asked.append("events") or (1.0, 0, inf))
    for body, name in ((FREE, "way_at_most"), (TEETH["plain"], "still_in_teeth")):
        for play in (body.play, 0.5 * body.play):
            for moved, how in ((edge, "over"), (np.nextafter(edge, 1.0), "events"), (0.0, "over")):
                monkeypatch.setattr(hysteresis, name, lambda *_, moved=moved: moved)
                asked.clear()
                z = [x, 0.0, 0.0, 0.0]
                _, margin = turn_and_count(z, 0.0, 1.0, x, body._replace(play=play), WIDE, [0.0] * 8)
                assert asked == [how]
                assert margin == (edge_gap(x, x, x, WIDE) - moved if how == "over" else inf)


@pytest.mark.parametrize("play", [5e-324, 0.5, 2.0])
def test_the_count_is_taken_where_the_motors_way_ends(monkeypatch: pytest.MonkeyPatch, play: float) -> None:
    """And not where teeth part or friction lets go; what follows an end is fresh, and no time is no mode."""
    body = TEETH["rubs"]._replace(play=play)
    course = [  # time, where the motor then is, and its way
        (0.25, -2.0625, 1),  # teeth part while it goes on
        (0.25, -1.4375, 0),
        (0.125, -1.4375, -1),  # it is let go
        (0.125, -2.5625, 1),
        (0.25, -1.0625, -1),
    ]
    asked: list[tuple[int, float, bool]] = []

    def press(z: list[float], u: float, mode: Mode, left: float, fresh: bool, *_: object) -> tuple[float, int, float]:
        asked.append((mode.toward, left, fresh))
        t, z[0], _ = course[len(asked) - 1]
        return t, 1, inf

    monkeypatch.setattr(hysteresis, "still_in_teeth", lambda *_: inf)
    monkeypatch.setattr(hysteresis, "press", press)
    monkeypatch.setattr(hysteresis, "pass_any_end", lambda *_: (0, course[len(asked) - 1][2], 0.0))
    for first, v, friction, fresh in (
        (1, 0.0, 2.0, True),
        (1, 0.0, 0.5, True),
        (-1, 0.0, 2.0, True),
        (1, 0.5, 2.0, False),
        (0, 0.0, 2.0, False),
        (1, 0.0, 0.0, False),
    ):
        monkeypatch.setattr(hysteresis, "direction", lambda *_, first=first: first)
        asked.clear()
        shown, margin, way = -2.0, inf, first
        for _, x, then in course:
            if way != 0 and then != way:
                before, shown = shown, read_after(x, shown, WIDE)
                margin = min(margin, edge_gap(x, shown, before, WIDE))
            way = then
        z = [-2.5, v, 0.0, 0.0]
        found = turn_and_count(z, 1.0, 1.0, -2.0, body._replace(friction=friction), WIDE, [0.0] * 8)
        assert found == (shown, margin)
        ways, left = [first, *(then for *_, then in course)], [1.0, 0.75, 0.5, 0.375, 0.25]
        assert asked == [(ways[k], left[k], fresh or k > 0) for k in range(5)]


def test_which_flank_a_body_that_is_still_is_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its rates are those without friction on that flank; exactly the room is too far."""
    body, told = TEETH["plain"], []
    monkeypatch.setattr(flanks, "teeth_rate", lambda z, u, side, way, *_: told.append((side, way)))
    monkeypatch.setattr(flanks, "far_apart", lambda *_: 0.5)
    for room, found in ((0.25, inf), (np.nextafter(0.25, 1.0), 0.25), (0.125, inf)):
        monkeypatch.setattr(flanks, "flank_room_on", lambda *_, room=room: room)
        for side in (1, -1):
            told.clear()
            assert still_in_teeth([0.0, 0.0, 0.5, 0.0], 0.0, side, 0.0, 0.5, body, [0.0] * 8) == found
            assert told == [(side, 0)]
        told.clear()
        assert still_in_teeth([0.0, 0.0, 0.5, 0.0], 0.0, 0, 0.0, 0.5, body, [0.0] * 8) == inf
        assert told == []
