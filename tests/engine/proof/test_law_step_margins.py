"""One sample interval under a law, by hand: what is sensed, decided and remembered, and which motion that makes."""

from math import floor, inf
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.general.controller import Controller, read_after
from hknob_cli.engine.general.laws import step
from hknob_cli.engine.general.laws.law import LOOK, MATRIX, PIECE, SPAN, TORQUE, F, G, S
from hknob_cli.engine.general.laws.step import (
    FREE,
    advance_jittering_with_law,
    advance_with_law,
    begin_past,
    chart_with_law,
    count_piece,
    decide,
    depth_of,
    driven_slope,
    move_piece,
)


def wall_of(**more: Any) -> Controller:
    return Controller(0.25, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, inf, 0.0)._replace(**more)


def law_of(guard: float = 9.0, out: tuple[float, ...] = (1.0, -2.0, 0.5, -0.25), **more: Any) -> Any:
    """Two numbers, the last reading, one look; then two torques each of three samples."""
    told: list[Any] = []

    def act(*given: Any) -> float:
        told.append((*given[:2], list(given[2]), given[3]))
        given[4][:] = out
        return guard

    one = {
        "act": act, "told": told, "unit": 0.5, "fixed": [0.25], "rows": 2, "line": 4, "parts": 2, "ages": 3,
        "senses": False, "cuts": False, "weight": 0.0, "out": [0.0] * 4, "pieces": 2, "sched": [0.0] * (2 * PIECE),
    }  # fmt: skip
    return SimpleNamespace(**(one | more))


PAST = [7.0, 8.0, -5.0, -4.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]


def test_how_deep_a_count_is() -> None:
    assert [depth_of(count, 0.25) for count in (-3.0, -1.0, 0.0, 2.0)] == [2.75, 0.75, 0.0, 0.0]


# Slopes by the speed.


def test_a_slope_holds_until_what_is_sent_changes_its_kind() -> None:
    """At a limit, in a dead band and between two steps nothing is sent of it."""
    for u, slope, wall, found in (
        (0.25, 0.0, wall_of(band=0.5, step=0.5, limit=4.0), (0.0, FREE)), (0.25, 1.0, wall_of(), (1.0, FREE)),
        (1.0, -0.5, wall_of(limit=4.0), (-0.5, 6.0)), (-1.0, 0.5, wall_of(limit=4.0), (0.5, 6.0)),
        (5.0, 0.5, wall_of(limit=4.0), (0.0, 2.0)), (-5.0, 0.5, wall_of(limit=4.0), (0.0, 2.0)),
        (4.0, 0.5, wall_of(limit=4.0), (0.0, 0.0)), (0.25, -0.5, wall_of(band=0.5), (0.0, 0.5)),
        (-0.25, 0.5, wall_of(band=0.5), (0.0, 0.5)), (0.5, 0.5, wall_of(band=0.5), (0.5, 0.0)),
        (2.0, -0.5, wall_of(band=0.5), (-0.5, 3.0)), (2.0, 0.5, wall_of(band=0.5, limit=4.0), (0.5, 3.0)),
        (3.0, 0.5, wall_of(band=0.5, limit=4.0), (0.5, 2.0)), (0.3125, 0.25, wall_of(step=0.5), (0.0, 0.25)),
        (0.3125, -0.25, wall_of(step=0.5, limit=4.0), (0.0, 0.25)), (-0.3125, 0.25, wall_of(step=0.5), (0.0, 0.25)),
        (0.3125, 0.25, wall_of(step=0.5, band=0.125), (0.0, 0.25)),
        (0.5, 0.25, wall_of(step=0.5, band=0.375), (0.0, 0.5)),
        (0.0625, 0.25, wall_of(step=0.5, band=0.125), (0.0, 0.25)), (1.5, 0.25, wall_of(step=2.0), (0.0, 2.0)),
    ):  # fmt: skip
        assert driven_slope(u, slope, wall) == found


# What a law decides.


def test_a_law_acts_and_what_it_remembers_moves_on() -> None:
    """The oldest torques go, the newest come; the look is left alone."""
    for guard in (9.0, -9.0):
        law, past = law_of(guard), list(PAST)
        assert decide(-3.0, 0.125, past, wall_of(), law) == guard
        assert law.told == [(-3.0, 0.125, PAST, [0.25])]
        assert past == [7.0, 8.0, -3.0, -4.0, 3.0, 4.0, 5.0, 6.0, 0.5, -1.0]
        assert law.out == [1.0, -2.0, 0.5, -0.25]


def test_virtual_damping_acts_beside_a_law_inside_the_wall() -> None:
    """On the way since the last reading, -5."""
    for shown, brake in ((-3.0, 0.5), (-7.0, -0.5), (-5.0, 0.0), (0.0, 0.0), (1.0, 0.0), (-1.0, 1.0)):
        past = list(PAST)
        decide(shown, 0.0, past, wall_of(damping=0.25), law_of())
        assert past[8:] == [0.5 - brake, -1.0 - brake]


def test_what_is_sent_goes_through_converter_and_amplifier() -> None:
    for wall, sent in (
        (wall_of(limit=0.75), [0.5, -0.75]), (wall_of(step=0.75), [0.75, -0.75]), (wall_of(band=0.625), [0.0, -1.0])
    ):  # fmt: skip
        past = list(PAST)
        decide(-3.0, 0.0, past, wall, law_of())
        assert past[8:] == sent


def test_a_guard_is_the_least_of_all_changes() -> None:
    """In a number that fades, of which a difference of 1 moves a torque by its weight: to a dead band, to a step."""
    # Torques of 1/2 and -1.
    for wall, weight, guard in (
        (wall_of(), 0.5, 9.0), (wall_of(band=0.375), 0.5, 0.25), (wall_of(band=0.875), 0.5, 0.25),
        (wall_of(band=0.375), 0.25, 0.5), (wall_of(band=0.375), 0.0, 9.0), (wall_of(band=0.375), -0.5, 9.0),
        (wall_of(step=0.375), 0.5, 0.125), (wall_of(step=0.375), 0.25, 0.25), (wall_of(step=0.375), 0.0, 9.0),
        # What the band takes away is 0, half a step from any edge.
        (wall_of(step=0.75, band=0.625), 0.5, 0.25), (wall_of(step=1.0, band=0.75), 0.25, 1.0),
        (wall_of(step=2.0, band=0.5), 0.25, 0.0), (wall_of(step=1.0), 0.25, 0.0),
        (wall_of(step=2.0, band=0.375), 0.25, 0.0), (wall_of(step=0.75, band=2.0), 0.5, 0.75),
    ):  # fmt: skip
        assert decide(-3.0, 0.0, list(PAST), wall, law_of(weight=weight)) == pytest.approx(guard, rel=1e-14)
        assert decide(-3.0, 0.0, list(PAST), wall, law_of(-1.0, weight=weight)) == -1.0


def test_slopes_of_a_law_that_senses_are_those_of_what_is_driven() -> None:
    """Each by its own torque: 1/2 and -1 with slopes of 1/4 and -1/8."""
    for wall, slopes, guard in (
        (wall_of(), [0.25, -0.125], 9.0), (wall_of(limit=0.75), [0.25, 0.0], 1.0),
        (wall_of(band=0.625), [0.0, -0.125], 0.5), (wall_of(step=0.375), [0.0, 0.0], 0.25),
    ):  # fmt: skip
        law = law_of(senses=True)
        assert decide(-3.0, 0.0, list(PAST), wall, law) == pytest.approx(guard, rel=1e-14)
        assert law.out == [1.0, -2.0, *slopes]


def test_a_law_that_cuts_off_commands_nothing_where_its_guard_is_negative() -> None:
    """Which is told without its sign; the wall's own damping goes on."""
    for guard, cuts, told in ((-2.0, True, 2.0), (2.0, True, 2.0), (-2.0, False, -2.0), (0.0, True, 0.0)):
        past = list(PAST)
        assert decide(-3.0, 0.0, past, wall_of(damping=0.25), law_of(guard, cuts=cuts)) == told
        assert past[8:] == [0.0, -1.5]


# How it moves.


def pieces() -> list[float]:
    """Of a whole interval: numbers that tell each apart."""
    sched = [0.0] * (2 * PIECE)
    for piece in range(2):
        at = piece * PIECE
        sched[at + SPAN], sched[at + S], sched[at + G], sched[at + F] = 0.5 + piece, 0.25, 0.125, 0.75
        sched[at + TORQUE], sched[at + LOOK], sched[at + MATRIX] = 6.0 + piece, -1.0, 3.0 + piece
    return sched


@pytest.mark.parametrize(("order", "friction", "play"), [(3, 0.0, 0.0), (3, 0.5, 0.0), (4, 0.0, 0.5)])
def test_a_piece_moves_under_its_own_torque(
    monkeypatch: pytest.MonkeyPatch, order: int, friction: float, play: float
) -> None:
    """By the matrix of its length without friction and play; else from event to event."""
    told: list[Any] = []
    monkeypatch.setattr(step, "rub_many", lambda *given: told.append(("many", *given)))
    monkeypatch.setattr(step, "advance_hold", lambda *given: told.append(("hold", *given)))
    body: Any = SimpleNamespace(order=order, friction=friction, play=play, cogs=None, drive=0.5, beta=2.0)
    for piece, u in ((0, 3.0), (1, 4.0)):
        z, law = [1.5, -2.0], law_of(sched=pieces())
        move_piece(z, PAST, piece, body, law, "pad")
        if friction or play:
            assert told.pop() == ("many", z, u, 0.5 + piece, body, "pad")
        else:
            assert told.pop() == ("hold", z, u, 3 + piece, body, "pad")
        assert told == []


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize(("order", "wide", "cogs"), [(2, 0.0, None), (3, 0.0, None), (2, 0.5, None), (2, 0.0, "cogs")])
def test_angle_and_speed_go_through_all_pieces_in_closed_form(
    monkeypatch: pytest.MonkeyPatch, order: int, wide: float, cogs: Any, friction: float
) -> None:
    """Each under its own torque, and with a look at its end; not beside cogging or hysteresis, or of more numbers."""
    told: list[Any] = []
    monkeypatch.setattr(
        step, "step_with_friction", lambda x, v, *rest: told.append((x, v, *rest)) or (x - 8.0, v + 1.0)
    )
    monkeypatch.setattr(step, "move_piece", lambda *_: told.append("piece"))
    monkeypatch.setattr(step, "turn_and_count", lambda *given: told.append("piece") or (given[3], 0.0))
    body: Any = SimpleNamespace(order=order, friction=friction, cogs=cogs, drive=0.5, beta=2.0)
    law, past, z = law_of(sched=pieces(), parts=0), list(PAST), [1.5, -2.0]
    law.sched[LOOK], law.sched[PIECE + LOOK] = 3.0, 0.0
    assert advance_with_law(z, past, body, wall_of(hysteresis=wide), law, "pad") == 9.0
    if order > 2 or wide or cogs:
        assert told == ["piece"] * 2
    elif friction:
        coefficients = (0.25, 0.125, 0.75, body)
        assert told == [(1.5, -2.0, 3.0, 0.5, *coefficients), (-6.5, -1.0, 4.0, 1.5, *coefficients)]
        assert (z, past[3], past[0]) == ([-14.5, 0.0], -7.0, -15.0)
    else:
        y = 3.0 + 0.5 - 2.0 * 1.5
        x, v = 1.5 - 0.25 * 2.0 + 0.125 * y, -0.75 * 2.0 + 0.25 * y
        assert past[3] == float(floor(x))
        y = 4.0 + 0.5 - 2.0 * x
        assert z == [x + 0.25 * v + 0.125 * y, 0.75 * v + 0.25 * y]
        assert past[0] == float(floor(z[0]))


ANY: Any = SimpleNamespace(order=3, cogs=None)  # a body of more than angle and speed


@pytest.mark.parametrize("look", [-1, 0, 3])
def test_an_interval_is_a_decision_and_all_its_pieces(monkeypatch: pytest.MonkeyPatch, look: int) -> None:
    """A look at the end of one is remembered where the law has it."""
    told: list[Any] = []

    def move(z: Any, past: Any, piece: int, *rest: Any) -> None:
        told.append(("move", piece, *rest))
        z[0] -= 1.0

    monkeypatch.setattr(step, "decide", lambda *given: told.append(given) or 7.0)
    monkeypatch.setattr(step, "move_piece", move)
    law, z, past = law_of(sched=pieces()), [-2.5, 0.125], list(PAST)
    law.sched[PIECE + LOOK] = float(look)
    assert advance_with_law(z, past, ANY, wall_of(), law, "pad") == 7.0
    assert told == [(-3.0, 0.125, past, wall_of(), law), ("move", 0, ANY, law, "pad"), ("move", 1, ANY, law, "pad")]
    expected = list(PAST)
    if look >= 0:
        expected[look] = -5.0
    assert (z[0], past) == (-4.5, expected)


@pytest.mark.parametrize("look", [-1, 0, 3])
def test_a_chart_is_that_of_all_pieces(monkeypatch: pytest.MonkeyPatch, look: int) -> None:
    told: list[Any] = []

    def chart(z: Any, u: float, span: float, *rest: Any) -> int:
        told.append((u, span, *rest))
        z[0] -= 1.0
        return int(rest[2]) + 2

    monkeypatch.setattr(step, "decide", lambda *given: told.append(given))
    monkeypatch.setattr(step, "chart", chart)
    law, z, past = law_of(sched=pieces()), [-2.5, 0.125], list(PAST)
    law.sched[LOOK] = float(look)
    assert chart_with_law(z, past, 2, "body", wall_of(), law, "pad", "pieces") == 8
    assert told == [
        (-3.0, 0.125, past, wall_of(), law),
        (3.0, 0.5, "body", "pad", 0, "pieces"), (4.0, 1.5, "body", "pad", 2, "pieces"),
        (-5.0, 0.125, past, wall_of(), law),
        (3.0, 0.5, "body", "pad", 4, "pieces"), (4.0, 1.5, "body", "pad", 6, "pieces"),
    ]  # fmt: skip
    expected = list(PAST)
    if look >= 0:
        expected[look] = -6.0
    assert past == expected


WIDE = wall_of(hysteresis=0.5)


def clock_by_hand(spans: list[float], begun: list[float], monkeypatch: pytest.MonkeyPatch) -> str:
    """A clock whose intervals are written down; ``begun`` has the trials that it was set to."""
    left = list(spans)

    def begin(clock: Any, trial: float) -> None:
        assert clock == "clock"
        begun.append(trial)

    monkeypatch.setattr(step, "begin_clock", begin)
    monkeypatch.setattr(step, "next_span", lambda clock: left.pop(0) if clock == "clock" else 1.0)
    monkeypatch.setattr(step, "meant_pace", lambda speed, clock: 3.0 * speed if clock == "clock" else speed)
    return "clock"


@pytest.mark.parametrize("wide", [0.0, 0.5, 1.25])
@pytest.mark.parametrize("look", [-1, 0, 3])
def test_an_interval_of_a_clock_that_jitters_has_longer_or_shorter_pieces(
    monkeypatch: pytest.MonkeyPatch, look: int, wide: float
) -> None:
    """All by the same factor, three quarters; the law decides by the speed over the interval that is meant."""
    told: list[Any] = []

    def move(z: Any, u: float, span: float, *rest: Any) -> None:
        told.append((u, span, *rest))
        z[0] -= 1.0

    def count(z: Any, u: float, span: float, shown: float, body: Any, wall: Any, pad: Any) -> tuple[float, float]:
        move(z, u, span, body, pad)
        return shown - 1.0, 9.0

    monkeypatch.setattr(step, "decide", lambda shown, speed, *_: told.append((shown, speed)) or 7.0)
    monkeypatch.setattr(step, "advance_span", move)
    monkeypatch.setattr(step, "turn_and_count", count)
    law, z, past, begun = law_of(sched=pieces()), [-2.5, 0.125], list(PAST), list[float]()
    law.sched[PIECE + LOOK] = float(look)
    wall = wall_of(hysteresis=wide, clock=clock_by_hand([0.75], begun, monkeypatch))
    assert advance_jittering_with_law(z, past, "body", wall, law, "pad") == 7.0
    shown = read_after(-2.5, -4.0, wall)
    assert told == [(shown, 0.375), (3.0, 0.375, "body", "pad"), (4.0, 1.125, "body", "pad")]
    expected, last = list(PAST), shown - 2.0 if wide else -4.0
    expected[3] = last
    if look >= 0:
        expected[look] = read_after(-4.5, last, wall)
    assert (z[0], past, begun) == (-4.5, expected, [])


def test_a_chart_under_a_clock_that_jitters_is_that_of_the_trial_before_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Number -1; its intervals one after the other, and all pieces as long as they."""
    told: list[Any] = []
    begun: list[float] = []
    monkeypatch.setattr(step, "decide", lambda *_: 7.0)
    monkeypatch.setattr(step, "chart", lambda z, u, span, *rest: told.append(span) or rest[2] + 1)
    wall: Any = wall_of(clock=clock_by_hand([0.75, 0.5], begun, monkeypatch))
    law = law_of(sched=pieces())
    assert chart_with_law([-2.5, 0.125], list(PAST), 2, "body", wall, law, "pad", "pieces") == 4
    assert told == [0.375, 1.125, 0.25, 0.75]
    assert begun == [-1.0]


@pytest.mark.parametrize("look", [-1, 0])
def test_with_hysteresis_the_count_goes_through_every_piece(monkeypatch: pytest.MonkeyPatch, look: int) -> None:
    """From that of the sample on, beside the readings; a piece's own torque and time move it. Other walls are moved."""
    told: list[Any] = []

    def count(z: Any, u: float, span: float, shown: float, *rest: Any) -> tuple[float, float]:
        told.append((u, span, shown, *rest))
        z[0] -= 1.0
        return shown - 1.0, 0.25 + len(told)

    def move(z: Any, past: Any, *given: Any) -> None:
        z[0] -= 1.0

    monkeypatch.setattr(step, "decide", lambda *given: told.append(given[0]) or 7.0)
    monkeypatch.setattr(step, "turn_and_count", count)
    monkeypatch.setattr(step, "move_piece", move)
    law, z, past = law_of(sched=pieces()), [-2.5, 0.125], list(PAST)
    law.sched[PIECE + LOOK] = float(look)
    assert advance_with_law(z, past, ANY, WIDE, law, "pad") == 7.0
    # The count of before, -4, is a quarter above the place.
    shown = read_after(-2.5, -4.0, WIDE)
    assert told == [shown, (3.0, 0.5, shown, ANY, WIDE, "pad"), (4.0, 1.5, shown - 1.0, ANY, WIDE, "pad")]
    expected = list(PAST)
    expected[3] = shown - 2.0
    if look >= 0:
        expected[look] = read_after(-4.5, shown - 2.0, WIDE)
    assert (z[0], past) == (-4.5, expected)
    told.clear()
    plain = list(PAST)
    advance_with_law([-2.5, 0.125], plain, ANY, wall_of(), law, "pad")
    assert told == [-3.0]
    assert plain[3] == -4.0
    for piece, u in ((0, 3.0), (1, 4.0)):
        one = list(PAST)
        assert count_piece([0.0, 0.0], one, piece, "body", WIDE, law, "pad") == 0.25 + len(told)
        assert one == [*PAST[:3], -5.0, *PAST[4:]]
        assert told[-1][:3] == (u, 0.5 + piece, -4.0)


def test_with_hysteresis_a_chart_keeps_the_count_of_every_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    """A row's place is one that the count has seen; the last one is the next sample's, which reads it itself."""

    def chart(z: Any, u: float, span: float, body: Any, pad: Any, rows: int, to: Any) -> int:
        for k in range(2):
            to.states[(rows + k) * 2] = (-2.875, -3.125)[k] + 0.25 * rows
        z[0] -= 1.0
        return rows + 2

    shown: list[float] = []
    monkeypatch.setattr(step, "decide", lambda what, *given: shown.append(what))
    monkeypatch.setattr(step, "chart", chart)
    for wall in (WIDE, wall_of(hysteresis=1.25), wall_of()):
        law, z, past = law_of(sched=pieces()), [-2.5, 0.125], list(PAST)
        law.sched[LOOK] = 0.0
        to: Any = SimpleNamespace(states=[0.0] * 40)
        assert chart_with_law(z, past, 2, SimpleNamespace(order=2), wall, law, "pad", to) == 8
        last, at = -4.0, [-2.5, -3.5, -4.5, -5.5]
        for k, x in enumerate(at):
            if k % 2 == 0:
                last = read_after(x, last, wall)
                assert shown.pop(0) == last
            for row in range(2 * k, 2 * k + 2):
                last = read_after(to.states[2 * row], last, wall)
            if k == 2:
                assert past[0] == read_after(-5.5, last, wall)
        assert past[3] == (last if wall.hysteresis else -4.0)


def test_before_the_first_sample_no_torque_is_under_way() -> None:
    """Places begin where the encoder shows the knob, and so do the readings."""
    law = law_of(first=[5.0, 6.0], places=1)
    past = [9.0] * 10
    begin_past(past, -3.0, law)
    assert past == [-2.75, 6.0, -3.0, -3.0, *[0.0] * 6]
    begin_past(past, -3.0, law_of(first=[5.0, 6.0], places=0))
    assert past == [5.0, 6.0, -3.0, -3.0, *[0.0] * 6]
