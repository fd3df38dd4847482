"""A motion under a law written down: piece by piece between events, or at samples."""

from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.laws.law import LOOK, PIECE, SPAN, TORQUE
from hknob_cli.engine.general.laws.step import advance_with_law, decide
from hknob_cli.engine.general.trace import chart


def run_with_law(z, past, samples, body, wall, law, pad, states):
    """Run ``samples`` intervals; ``states`` takes the state at every sample, (samples + 1) times the order."""
    n = body.order
    for i in range(samples + 1):
        for j in range(n):
            states[i * n + j] = z[j]
        if i < samples:
            advance_with_law(z, past, body, wall, law, pad)


def chart_with_law(z, past, period, body, wall, law, pad, capacity, spans, modes, commands, states):
    """Write down one period of an orbit, as `general.trace.chart_period`."""
    rows = 0
    for _ in range(period):
        decide(read(z[0], wall), z[1], past, wall, law)
        for piece in range(law.pieces):
            at = piece * PIECE
            u = past[int(law.sched[at + TORQUE])]
            rows = chart(z, u, law.sched[at + SPAN], body, pad, capacity, rows, spans, modes, commands, states)
            look = int(law.sched[at + LOOK])
            if look >= 0:
                past[look] = read(z[0], wall)
    return rows
