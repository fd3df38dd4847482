"""A motion of the general loop written down: sample by sample, or piece by piece between events."""

from typing import Any, NamedTuple

from hknob_cli.engine.general.advance import UNKNOWN, next_mode, slide
from hknob_cli.engine.general.body import acceleration
from hknob_cli.engine.general.cogging import has_cogs
from hknob_cli.engine.general.controller import command, read_after
from hknob_cli.engine.general.flanks import play_chart
from hknob_cli.engine.general.interval import advance, advance_jittering, begin_clock, jitters, next_span
from hknob_cli.engine.general.slide_two import way
from hknob_cli.engine.general.slopes import cog_chart


class Rows(NamedTuple):
    """A motion sample by sample, lists or arrays; counts and sample periods.

    ``states`` takes the state at every sample, one after the other; ``torques``, counts per sample², what acts just
    after it.
    """

    states: Any
    torques: Any


def run(z, before, ring, head, body, wall, pad, rows):
    """Run as many intervals as ``rows`` has samples but one: ``(reading before, head)``."""
    states, torques = rows
    n, delay, samples = body.order, len(ring), len(torques) - 1
    for i in range(samples + 1):
        for j in range(n):
            states[i * n + j] = z[j]
        acting = command(read_after(z[0], before, wall), before, wall)
        if delay > 0:
            acting = ring[head] if wall.split > 0.0 else ring[(head + 1) % delay]
        torques[i] = z[n - 1] if body.lag > 0.0 else acting
        if i < samples:
            if jitters(wall.clock):
                before, head = advance_jittering(z, before, ring, head, body, wall, pad)
            else:
                before, head = advance(z, before, ring, head, body, wall, pad)
    return before, head


class Pieces(NamedTuple):
    """A motion piece by piece, lists or arrays: ``spans``, in samples, ``modes`` and ``commands``, a row each.

    ``states`` takes the state at the start of each piece and, after the last, at its end.
    """

    spans: Any
    modes: Any
    commands: Any
    states: Any


def chart(z, u, span, body, pad, rows, pieces):
    """Write down the pieces of one hold from row ``rows`` on, turning points included; the number of rows filled.

    Full rows end the chart.
    """
    if body.play > 0.0:
        return play_chart(z, u, span, body, pad, rows, pieces)
    if has_cogs(body.cogs):
        return cog_chart(body.cogs, z, u, span, body, pad, rows, pieces)
    n = body.order
    left = span
    mode = way(z[1], acceleration(z, u, body), body.friction)
    while left > 0.0 and rows < len(pieces.spans):
        for j in range(n):
            pieces.states[rows * n + j] = z[j]
        t, hit, _ = slide(z, u, mode, left, UNKNOWN, False, body, pad)
        left -= t
        if t > 0.0:
            pieces.spans[rows], pieces.modes[rows], pieces.commands[rows] = t, mode, u
            rows += 1
        if not hit:
            break
        mode = next_mode(mode, z, u, body)
    for j in range(n):
        pieces.states[rows * n + j] = z[j]
    return rows


def chart_period(z, before, ring, period, body, wall, pad, pieces):
    """Write down one period of an orbit, piece by piece; the number of pieces, or of all rows if there are more.

    Args:
        z: State at the start, left at the end.
        before: Reading one sample before.
        ring: Commands under way, oldest first.
        period: Samples.
        body: What moves.
        wall: What commands.
        pad: Work space, twice the order.
        pieces: `Pieces` to fill.
    """
    rows, head, delay = 0, 0, len(ring)
    begin_clock(wall.clock, -1.0)
    for _ in range(period):
        shown = read_after(z[0], before, wall)
        u = command(shown, before, wall)
        before, begun = shown, rows
        if delay > 0:
            older = ring[head]
            ring[head] = u
            head = (head + 1) % delay
            u = ring[head]
            if wall.split > 0.0:
                rows = chart(z, older, wall.split, body, pad, rows, pieces)
        span = next_span(wall.clock) if jitters(wall.clock) else 1.0 - wall.split
        rows = chart(z, u, span, body, pad, rows, pieces)
        if wall.hysteresis > 0.0:
            for row in range(begun, rows):
                before = read_after(pieces.states[row * body.order], before, wall)
    return rows
