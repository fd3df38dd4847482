"""The exact motion of one trial under a controller in the general loop, row by row."""

from collections.abc import Iterator
from itertools import accumulate, pairwise
from math import ceil
from typing import NamedTuple

from hknob_cli.controllers.scalar_law import LawKnob
from hknob_cli.engine.general.advance import advance_span
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import read, read_after
from hknob_cli.engine.general.hysteresis import turn_and_count
from hknob_cli.engine.general.interval import begin_clock, jitters, next_span
from hknob_cli.engine.general.laws.law import LOOK, PIECE, SPAN, TORQUE
from hknob_cli.engine.general.laws.step import begin_past, sense

DUE, RELEASE = -1, -2  # beside the pieces of an interval: a point that was asked for, and the end of a pulse


class LawPoint(NamedTuple):
    """A moment: time (sample periods), what happens then, state, and the torque that acts after it (acceleration)."""

    time: float
    event: str
    state: list[float]
    torque: float


class Stop(NamedTuple):
    """A moment at which a motion stops, and what happens then.

    ``piece``: number of the piece of an interval that begins, or `DUE`, or `RELEASE`; ``event``: its name, if any.
    """

    time: float
    piece: int
    event: str


def follow_law(
    made: LawKnob,
    start: list[float],
    *,
    phase: float,
    until: float,
    every: float,
    pulse: tuple[Body, float] | None = None,
    trial: int = 0,
) -> Iterator[LawPoint]:
    """A motion from ``start`` (state): every sample, every change of torque, and points ``every`` so many periods.

    The first sample comes ``phase`` of a period after the start; ``until``: length, in periods. ``pulse``: the body
    while a torque pulse acts on it, and when that ends, in periods; the end is a point, too. ``trial``: its number, by
    which a clock that jitters has its intervals, whose pieces are longer or shorter with them.
    """
    knob, law = made.knob, made.law
    body, release = pulse or (knob.body, until + 1.0)
    numbers = [law.sched[i * PIECE : (i + 1) * PIECE] for i in range(law.pieces)]
    z, past, held = list(start), [0.0] * len(law.beside), law.line - 1
    acting, time, begun = 0.0, 0.0, False
    for at, piece, event in _stops(made, release, phase, until, every, trial):
        _move(z, past, acting, (time, at), body, made)
        time = max(time, at)
        if piece >= 0:
            look = int(numbers[piece - 1][LOOK])
            if begun and look >= 0:
                past[look] = read_after(z[0], past[held], knob.wall)
            if piece == 0:
                if not begun:
                    begin_past(past, read(z[0], knob.wall), law)
                    begun = True
                sense(z[0], z[1], past, knob.wall, law)
            acting = past[int(numbers[piece][TORQUE])]
        elif piece == RELEASE:
            body = knob.body
        if event or piece < 0:
            yield LawPoint(at, event, list(z), z[-1] if body.lag > 0.0 else acting)


def _stops(made: LawKnob, release: float, phase: float, until: float, every: float, trial: int) -> list[Stop]:
    """All stops as far as ``until``, in order; no point is due where something is named."""
    law = made.law
    numbers = [law.sched[i * PIECE : (i + 1) * PIECE] for i in range(law.pieces)]
    begins = [0.0, *accumulate(piece[SPAN] for piece in numbers)]
    # A piece that has the torque of the one before it begins with a look of the encoder alone.
    events = ["sample", *("command" if k[TORQUE] != j[TORQUE] else "" for j, k in pairwise(numbers))]
    stops = [
        Stop(at + begins[k] * span, k, events[k])
        for at, span in _intervals(made, phase, until, trial)
        for k in range(law.pieces)
    ]
    stops.append(Stop(release, RELEASE, "pulse ends"))
    named = {stop.time for stop in stops if stop.event}
    due = (min(i * every, until) for i in range(int(until / every * (1.0 + 1e-12)) + 1))
    stops += [Stop(at, DUE, "") for at in due if at not in named]
    return sorted(stop for stop in stops if stop.time <= until)


def _move(
    z: list[float], past: list[float], acting: float, between: tuple[float, float], body: Body, made: LawKnob
) -> None:
    """Move a state from one time to another, a period at most at once; with hysteresis the count with it."""
    wall, held, pad = made.knob.wall, made.law.line - 1, [0.0] * (2 * body.order)
    time, until = between
    while time < until:
        step = min(until - time, 1.0)
        if wall.hysteresis > 0.0:
            past[held], _ = turn_and_count(z, acting, step, past[held], body, wall, pad)
        else:
            advance_span(z, acting, step, body, pad)
        time = until if step == until - time else time + step


def _intervals(made: LawKnob, phase: float, until: float, trial: int) -> Iterator[tuple[float, float]]:
    """When each interval begins, and how long it is, in periods, as far as ``until``."""
    clock = made.knob.wall.clock
    if not jitters(clock):
        yield from ((phase + i, 1.0) for i in range(ceil(until) + 1))
        return
    begin_clock(clock, float(trial))
    at = phase
    while at <= until:
        span = next_span(clock)
        yield at, span
        at += span
