"""The states of an interval of clock phases as a piece: no phase of it lies outside, and what is told of it adds up."""

from math import inf, nextafter, sqrt
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.general.sets import friction_phases
from hknob_cli.engine.general.sets.convex import area_of
from hknob_cli.engine.general.sets.friction_phases import HALVINGS, NARROWEST, STRAIGHT, fly, is_narrow, put_chord
from hknob_cli.engine.general.sets.piece import STATE, piece_size
from hknob_cli.engine.general.sets.room import make_piece_room
from hknob_cli.engine.general.slide_two import coefficients, step_with_friction

from .friction_work import body_of, cell_of, drift_of, law_of, room_of, wall_of, work_of, zeros
from .test_friction_piece_margins import Piece
from .test_friction_rounding import apart
from .test_friction_rounding import body_of as real_body_of

# It rests at 2, with no torque but its bias. From 10 at a speed of 3 its energy is that of a speed of 5: the pull is
# 2.5 at most, and with friction and damping a rate is 0.25 + 2.5 + 2.5.
BODY = SimpleNamespace(**{**body_of(0.25).__dict__, "alpha": 0.5, "drive": 0.5, "spacing": 0.75})
ANGLE, VELOCITY, FASTEST, RATE = 10.0, 3.0, 5.0, 5.25
JOLT = 0.25 * FASTEST + 0.5 * RATE  # by how much that rate changes while it slides one way


def chord(
    monkeypatch: pytest.MonkeyPatch, ends: list[tuple[float, float]], low: float, high: float, *, body: Any = BODY,
    drift: Any = None, damping: float = 0.0, velocity: float = VELOCITY, delay: int = 0, pieces: int = 32,
    law: Any = None, angle: float = ANGLE,
) -> tuple[int, list[Piece]]:  # fmt: skip
    """Let an interval of phases wait whose first and last states are ``ends``."""
    flown = []

    def flies(at: float, speed: float, phase: float, its: Any) -> tuple[float, float]:
        flown.append((at, speed, phase, its))
        return ends[phase == high]

    monkeypatch.setattr(friction_phases, "fly", flies)
    monkeypatch.setattr(friction_phases, "begin_memory", lambda its, level, ring: ring.__setitem__(slice(None), ring))
    room, work = room_of(pieces, delay), work_of(delay=delay)
    work.corners[:8] = [1e6] * 8  # of the last set
    cell = cell_of(body, drift or drift_of(), wall_of(damping=damping), law)
    waiting = put_chord((angle, velocity), (low, high), 0.5, room, work, cell)
    assert flown == [(angle, velocity, low, body), (angle, velocity, high, body)]
    return waiting, [Piece(room, k, delay) for k in range(max(waiting, 0))]


def test_a_torque_that_lags_has_not_begun_before_the_first_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """States fly as without a lag, and by that body's turns; there is no torque at the first sample."""
    ends = [(1.0, 1.0), (2.0, 3.0)]
    plain = chord(monkeypatch, ends, 0.25, 0.75)[1][0]
    late = SimpleNamespace(**{**BODY.__dict__, "order": 3, "lag": 0.5, "spacing": 1e-3})
    flown: list[Any] = []

    def flies(at: float, speed: float, phase: float, its: Any) -> tuple[float, float]:
        flown.append(its)
        return ends[phase == 0.75]

    monkeypatch.setattr(friction_phases, "fly", flies)
    room, work = make_piece_room(zeros, 3, 0, lattice=8, deep=8), work_of(plane=BODY, z=[9.0, 9.0, 9.0])
    assert put_chord((ANGLE, VELOCITY), (0.25, 0.75), 0.5, room, work, cell_of(late, drift_of(), wall_of())) == 1
    assert flown == [BODY, BODY]
    x, v, a, *corners = room.stack[STATE : STATE + 3 + 8]
    assert a == 0.0
    assert [(x + corners[2 * k], v + corners[2 * k + 1]) for k in range(4)] == plain.ends[:4]


def sides(piece: Piece) -> tuple[float, float, float, float]:
    """Least and largest position, least and largest speed."""
    xs, vs = [x for x, _ in piece.ends], [v for _, v in piece.ends]
    return min(xs), max(xs), min(vs), max(vs)


# Of how the states lie.


@pytest.mark.parametrize(
    ("part", "speeds", "turns"),
    [
        (0.5, (1.0, 3.0), 0.0),
        (0.5, (-1.0, -3.0), 0.0),
        (0.5, (1.0, -3.0), 0.5 * 0.5 * 0.25),
        (0.5, (0.0, 3.0), 0.5 * 0.5 * 0.25),
        (0.5, (3.0, 0.0), 0.5 * 0.5 * 0.25),
        (nextafter(0.75, 0.0), (1.0, 3.0), 0.0),
        (0.75, (1.0, 3.0), 0.5 * 0.75 * RATE),
        (0.75, (1.0, -3.0), 0.5 * 0.75 * RATE),
        (0.875, (1.0, 3.0), 0.5 * 0.875 * RATE),
        (0.25, (0.25, 0.5), 0.0),
        (0.25, (1.0, 1.0), 0.0),
    ],
)
def test_a_piece_is_a_chord_and_what_the_states_may_bulge_from_it(
    part: float, speeds: tuple[float, float], turns: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An eighth of the square of the interval, times a bound on the rate of the rate. Where the knob turns, its rate
    jumps by twice the friction at most; where it may turn twice, all that the rate may be is in either direction.
    """
    bulge, bulge_v = part * part / 8.0 * RATE, part * part / 8.0 * JOLT + turns
    for first, last in (((4.0, speeds[0]), (5.0, speeds[1])), ((5.0, speeds[0]), (4.0, speeds[1]))):
        waiting, found = chord(monkeypatch, [first, last], 0.125, 0.125 + part)
        assert waiting == 1
        right = 4.0 - 1.001 * bulge, 5.0 + 1.001 * bulge
        right_v = min(speeds) - 1.001 * bulge_v, max(speeds) + 1.001 * bulge_v
        assert sides(found[0]) == pytest.approx((*right, *right_v), rel=1e-14, abs=1e-14)
        assert found[0].state == pytest.approx([4.5, 0.5 * sum(speeds)], abs=1e-14)
        along, across = 1.0, abs(speeds[1] - speeds[0])
        area = 4.0 * bulge * bulge_v * 1.001**2 + 2.0 * 1.001 * (along * bulge_v + across * bulge)
        assert area_of(found[0].corners, len(found[0].corners) // 2) == pytest.approx(area, rel=1e-12)


def test_energy_bounds_speed_and_pull(monkeypatch: pytest.MonkeyPatch) -> None:
    """From either side of the rest, and either way; the damping and the friction of a body of their own."""
    for angle, velocity in ((10.0, -3.0), (-6.0, 3.0), (-6.0, -3.0), (12.0, 0.0), (2.0, 5.0)):
        _, found = chord(monkeypatch, [(0.0, 1.0), (0.0, 1.0)], 0.0, 0.5, angle=angle, velocity=velocity)
        right = 1.001 / 32.0 * RATE, 1.001 / 32.0 * JOLT
        assert sides(found[0])[1] == pytest.approx(right[0], rel=1e-14)
        assert sides(found[0])[3] - 1.0 == pytest.approx(right[1], rel=1e-12)


def test_no_piece_of_one_phase_is_one_state(monkeypatch: pytest.MonkeyPatch) -> None:
    """It would have no area, of which a part is a share."""
    _, found = chord(monkeypatch, [(0.0, 0.0), (0.0, 0.0)], 0.0, 0.0)
    low_x, high_x, low_v, high_v = sides(found[0])
    assert low_x < 0.0 < high_x < 1e-290
    assert low_v < 0.0 < high_v < 1e-290


@pytest.mark.one_in(5)
@pytest.mark.parametrize("turn", [0.05, 0.7, 3.0, 9.0])
@pytest.mark.parametrize("friction", [0.0, 0.02, 0.3])
@pytest.mark.parametrize("alpha", [0.0, 0.3, 4.0])
def test_every_phase_is_in_its_piece(turn: float, friction: float, alpha: float) -> None:
    """Followed by itself: phases at which the knob slides, turns round, or stands for the rest."""
    body = real_body_of(alpha, turn * turn, friction, 0.25 * turn * turn, 0.0)
    cell = cell_of(body, drift_of(), wall_of())
    for angle, velocity in ((3.0, 0.0), (-2.0, 1.0), (0.25, -0.5), (0.0, 0.0)):
        for parts in (1, 2, 16):
            for k in {0, parts // 2, parts - 1}:
                room, work = room_of(), work_of()
                low, high = k / parts, (k + 1) / parts
                assert put_chord((angle, velocity), (low, high), 0.0, room, work, cell) == 1
                ends = Piece(room, 0).ends
                for j in range(7):
                    x, v = fly(angle, velocity, low + j / 6 / parts, body)
                    assert apart(x, v, ends, body.beta) <= 1e-12 * (1.0 + abs(angle) * sqrt(body.beta) + abs(velocity))


def test_the_knob_flies_without_a_command() -> None:
    body = real_body_of(0.3, 0.5, 0.1, 0.2, 0.0)
    for phase in (0.0, 0.25, 1.0):
        right = step_with_friction(3.0, -1.0, 0.0, phase, *coefficients(phase, body), body)
        assert fly(3.0, -1.0, phase, body) == right


# What is told of it.


def test_its_roundings_are_those_of_three_positions_and_a_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four times, of what always acts, of the start and of the middle, and of the largest speed."""
    for once, right in (
        ((0.5, 0.0, 0.0, 0.0), 2.0), ((0.0, 0.5, 0.0, 0.0), 0.0), ((0.0, 0.0, 0.5, 0.0), 29.0),
        ((0.0, 0.0, 0.0, 0.5), 10.0), ((1.0, 1.0, 1.0, 1.0), 4.0 + 58.0 + 20.0),
    ):  # fmt: skip
        _, found = chord(monkeypatch, [(-4.0, 1.0), (-5.0, 1.0)], 0.0, 0.5, drift=drift_of(once))
        assert found[0].error == right
    _, found = chord(monkeypatch, [(1.0, 1.0), (1.0, 1.0)], 0.0, 0.5, drift=drift_of((0.0, 0.0, 0.5, 0.0)), angle=-6.0)
    assert found[0].error == 4.0 * 0.5 * (6.0 + 1.0)


def test_it_waits_at_the_first_sample_and_acts_as_nothing_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    _, found = chord(monkeypatch, [(-4.0, 1.0), (-5.0, 1.0)], 0.0, 0.5, delay=2)
    one = found[0]
    assert (one.level, one.sample, one.before, one.weight, one.ring) == (0.0, 0.0, 0.0, 0.5, [0.0, 0.0])


# With virtual damping, of which the first difference is none.

NO_BULGE = SimpleNamespace(**{**BODY.__dict__, "friction": 0.0, "alpha": 0.0, "beta": 2.0**-80, "drive": 0.0})


def test_with_damping_it_is_a_piece_for_each_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which it remembers as its last; outside of the wall, too. Each counts by its area."""
    for ends in ([(-1.75, 1.0), (2.25, 1.0)], [(2.25, 1.0), (-1.75, 1.0)]):
        waiting, found = chord(monkeypatch, ends, 0.0, 0.5, body=NO_BULGE, damping=0.5, velocity=0.0, angle=0.0)
        assert waiting == 5
        for one, level in zip(found, (-2.0, -1.0, 0.0, 1.0, 2.0), strict=True):
            assert (one.before, one.level, one.sample) == (level, 0.0, 0.0)
            low, high = max(level, -1.75), min(level + 1.0, 2.25)
            assert sides(one)[:2] == pytest.approx((low, high), abs=1e-12)
            assert one.weight == pytest.approx(0.5 * (high - low) / 4.0, rel=1e-9)
    waiting, found = chord(monkeypatch, [(2.25, 1.0), (6.25, 1.0)], 0.0, 0.5, body=NO_BULGE, damping=0.5)
    assert [one.before for one in found] == [2.0, 3.0, 4.0, 5.0, 6.0]
    law = law_of(0, wall_of(damping=0.5))
    waiting, found = chord(monkeypatch, [(-1.5, 1.0), (0.5, 1.0)], 0.0, 0.5, law=law, body=NO_BULGE)
    assert (waiting, [one.before for one in found]) == (3, [0.0] * 3)  # a law has a memory of its own


def test_each_piece_goes_beyond_its_edges_by_what_rounding_may_come_to(monkeypatch: pytest.MonkeyPatch) -> None:
    drift = drift_of((2.0**-6, 0.0, 0.0, 0.0))  # four times that in energy, twice in position
    kwargs: dict[str, Any] = {"body": NO_BULGE, "damping": 0.5, "velocity": 0.0, "angle": 0.0, "drift": drift}
    _, found = chord(monkeypatch, [(-1.5, 1.0), (0.5, 1.0)], 0.0, 0.5, **kwargs)
    for one, low, high in zip(found, (-1.5, -1.125, -0.125), (-0.875, 0.125, 0.5), strict=True):
        assert sides(one)[:2] == pytest.approx((low, high), abs=1e-12)
    for ends, readings in (
        ((-0.87, -0.13), [-1.0]), ((-0.88, -0.13), [-2.0, -1.0]), ((-0.87, -0.12), [-1.0, 0.0]),
        ((-0.5, -0.5), [-1.0]),
    ):  # fmt: skip
        for way in (1, -1):
            _, found = chord(monkeypatch, [(x, 1.0) for x in ends[::way]], 0.0, 0.5, **kwargs)
            assert [one.before for one in found] == readings


def test_no_room_for_its_pieces_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = [(-1.75, 1.0), (2.25, 1.0)]
    for pieces, waiting in ((6, 5), (5, 5), (4, -1), (1, -1)):
        found = chord(
            monkeypatch, ends, 0.0, 0.5, body=NO_BULGE, damping=0.5, velocity=0.0, angle=0.0, pieces=pieces, delay=1
        )
        assert found[0] == waiting
    assert piece_size(2, 1) > piece_size(2, 0)
    monkeypatch.setattr(friction_phases, "within", lambda *given: 0)
    assert chord(monkeypatch, ends, 0.0, 0.5, body=NO_BULGE, damping=0.5, pieces=1) == (0, [])


def test_a_piece_of_one_state_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(friction_phases, "within", lambda *given: 1)
    waiting, _ = chord(monkeypatch, [(-1.75, 1.0), (2.25, 1.0)], 0.0, 0.5, body=NO_BULGE, damping=0.5)
    assert waiting > 0


# When an interval is not halved any more.


def test_an_interval_is_halved_until_it_is_told_no_better() -> None:
    """With friction each boundary is found; without, what is nearly straight is shared by areas."""
    assert NARROWEST == 2.0**-HALVINGS / 16 == 2.0**-32
    assert STRAIGHT == 2.0**-16
    for friction, least in ((0.0, STRAIGHT), (5e-324, NARROWEST), (1.0, NARROWEST), (-0.0, STRAIGHT)):
        body = body_of(friction)
        assert is_narrow(0.5, 0.5 + least, body)
        assert is_narrow(0.5, 0.5 + 0.5 * least, body)
        assert not is_narrow(0.5, 0.5 + 1.5 * least, body)
        assert not is_narrow(0.0, 1.0, body)
        assert not is_narrow(0.5, inf, body)
