"""The exact motion of one trial under a controller in the general loop, row by row."""

from collections.abc import Iterator
from itertools import accumulate, pairwise
from math import ceil
from typing import NamedTuple

from hknob_cli.controllers.scalar_law import LawKnob
from hknob_cli.engine.general.advance import advance_span
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.laws.law import LOOK, PIECE, SPAN, TORQUE
from hknob_cli.engine.general.laws.step import begin_past, decide


class LawPoint(NamedTuple):
    """A moment: time (sample periods), what happens then, state, and the torque that acts after it (acceleration)."""

    time: float
    event: str
    state: list[float]
    torque: float


def follow_law(made: LawKnob, start: list[float], *, phase: float, until: float, every: float) -> Iterator[LawPoint]:
    """A motion from ``start`` (state): every sample, every change of torque, and points ``every`` so many periods.

    The first sample comes ``phase`` of a period after the start; ``until``: length, in periods.
    """
    knob, law = made.knob, made.law
    body, wall = knob.body, knob.wall
    numbers = [law.sched[i * PIECE : (i + 1) * PIECE] for i in range(law.pieces)]
    begins = [0.0, *accumulate(piece[SPAN] for piece in numbers[:-1])]
    # A piece that has the torque of the one before it begins with a look of the encoder alone.
    events = ["sample", *("command" if k[TORQUE] != j[TORQUE] else "" for j, k in pairwise(numbers))]
    pieces = [(phase + i + begin, k) for i in range(ceil(until) + 1) for k, begin in enumerate(begins)]
    told = {time for time, piece in pieces if events[piece]}
    z, pad, past = list(start), [0.0] * (2 * body.order), [0.0] * len(law.beside)
    acting, time, begun = 0.0, 0.0, False
    for at, piece in sorted([*(one for one in pieces if one[0] <= until), *_between(until, every, told)]):
        while time < at:
            step = min(at - time, 1.0)
            advance_span(z, acting, step, body, pad)
            time = at if step == at - time else time + step
        if piece >= 0:
            shown = read(z[0], wall)
            look = int(numbers[piece - 1][LOOK])
            if begun and look >= 0:
                past[look] = shown
            if piece == 0:
                if not begun:
                    begin_past(past, shown, law)
                    begun = True
                decide(shown, z[1], past, wall, law)
            acting = past[int(numbers[piece][TORQUE])]
        event = events[piece] if piece >= 0 else ""
        if event or piece < 0:
            yield LawPoint(at, event, list(z), z[-1] if body.lag > 0.0 else acting)


def _between(until: float, every: float, told: set[float]) -> list[tuple[float, int]]:
    """Points in between, as a piece -1, where nothing is ``told`` anyway."""
    due = (min(i * every, until) for i in range(int(until / every * (1.0 + 1e-12)) + 1))
    return [(time, -1) for time in due if time not in told]
