"""One sample interval under a law: sense, decide, and move from change of torque to change of torque; many of them."""

from hknob_cli.engine.general.advance import advance_hold, advance_span, rub_many
from hknob_cli.engine.general.cogging import has_cogs
from hknob_cli.engine.general.controller import read, read_after, send
from hknob_cli.engine.general.hysteresis import turn_and_count
from hknob_cli.engine.general.interval import begin_clock, meant_pace, next_span
from hknob_cli.engine.general.laws.law import LOOK, MATRIX, PIECE, SPAN, TORQUE, F, G, S
from hknob_cli.engine.general.slide_two import step_with_friction
from hknob_cli.engine.general.torque_curve import curve_torque, has_curve
from hknob_cli.engine.general.torque_table import command_at, is_there
from hknob_cli.engine.general.trace import chart

FREE = 1e300  # of a guard


def depth_of(count, offset):
    """How deep in the wall a count says the knob is: the plain wall's torque in its own steps."""
    return -(count + offset) if count < 0.0 else 0.0


def driven_slope(u, slope, wall):
    """Slope of a torque by the speed, after the D/A converter and the amplifier, and the speed's way until it changes.

    ``u``: torque, and ``slope``: its slope, both before them, as accelerations.
    """
    if slope == 0.0:
        return 0.0, FREE
    room = FREE
    if wall.band > 0.0:
        room = abs(abs(u) - wall.band) / abs(slope)
        if abs(u) < wall.band:
            return 0.0, room
    if wall.step > 0.0:
        part = (u / wall.step + 0.5) % 1.0
        return 0.0, min(room, min(part, 1.0 - part) * wall.step / abs(slope))
    room = min(room, abs(abs(u) - wall.limit) / abs(slope))
    return (slope if abs(u) < wall.limit else 0.0), room


def decide(shown, speed, past, wall, law):
    """Let the law act on a reading: memory, torques and last reading are renewed in ``past``; the least guard.

    The wall's virtual damping acts beside the law, inside the wall, and so does a torque over the angle, unless the law
    commands nothing at all. The D/A converter and the amplifier come last. Of a law that senses the speed, ``law.out``
    is left with the slopes of what is driven.
    """
    guard = law.act(shown, speed, past, law.fixed, law.out)
    silent = law.cuts and guard < 0.0
    if silent:
        guard = -guard
    newest = law.line + (law.ages - 1) * law.parts
    for j in range(law.line, newest):
        past[j] = past[j + law.parts]
    brake = wall.damping * (shown - past[law.rows]) if shown < 0.0 else 0.0
    for i in range(law.parts):
        u = law.unit * law.out[i] - brake
        if is_there(wall.table) and not silent:
            u += command_at(shown, wall.table)
        if has_curve(wall.curve) and not silent:
            u += curve_torque(shown, wall.curve)
        if law.senses:
            slope, room = driven_slope(u, law.unit * law.out[law.parts + i], wall)
            law.out[law.parts + i] = slope
            guard = min(guard, room)
        if law.weight > 0.0:
            if wall.band > 0.0:
                guard = min(guard, abs(abs(u) - wall.band) / law.weight)
            if wall.step > 0.0:
                part = ((u if abs(u) >= wall.band else 0.0) / wall.step + 0.5) % 1.0
                guard = min(guard, min(part, 1.0 - part) * wall.step / law.weight)
        past[newest + i] = send(u, wall)
    past[law.rows] = shown
    return guard


def move_piece(z, past, piece, body, law, pad):
    """Move ``z``, beside cogging or of more than angle and speed, over one piece of an interval."""
    at = piece * PIECE
    u = past[int(law.sched[at + TORQUE])]
    if body.friction > 0.0 or body.play > 0.0 or has_cogs(body.cogs):
        rub_many(z, u, law.sched[at + SPAN], body, pad)
    else:
        advance_hold(z, u, int(law.sched[at + MATRIX]), body, pad)


def sense(x, speed, past, wall, law):
    """Read the encoder at ``x`` and let the law act on it; the least guard.

    With hysteresis ``past[law.line - 1]`` is the count at the last turning point, and then at the sample.
    """
    shown = read_after(x, past[law.line - 1], wall)
    guard = decide(shown, meant_pace(speed, wall.clock), past, wall, law)
    if wall.hysteresis > 0.0:
        past[law.line - 1] = shown
    return guard


def count_piece(z, past, piece, body, wall, law, pad):
    """Move ``z`` over one piece of an interval, and the count with it; how far its turning points may move."""
    at = piece * PIECE
    u = past[int(law.sched[at + TORQUE])]
    last = law.line - 1
    past[last], margin = turn_and_count(z, u, law.sched[at + SPAN], past[last], body, wall, pad)
    return margin


def advance_two(z, past, body, wall, law):
    """Move ``z`` of angle and speed over all pieces of an interval, and look.

    Between the pieces neither waits in memory, where each look would be in its way.
    """
    x, v = z[0], z[1]
    for piece in range(law.pieces):
        at = piece * PIECE
        u, s, g, f = past[int(law.sched[at + TORQUE])], law.sched[at + S], law.sched[at + G], law.sched[at + F]
        if body.friction > 0.0:
            x, v = step_with_friction(x, v, u, law.sched[at + SPAN], s, g, f, body)
        else:
            y = u + body.drive - body.beta * x
            x, v = x + (s * v + g * y), f * v + s * y
        look = int(law.sched[at + LOOK])
        if look >= 0:
            past[look] = read(x, wall)
    z[0], z[1] = x, v


def advance_with_law(z, past, body, wall, law, pad):
    """One interval from a sample to the next; the least guard."""
    guard = sense(z[0], z[1], past, wall, law)
    if body.order == 2 and wall.hysteresis == 0.0 and not has_cogs(body.cogs):
        advance_two(z, past, body, wall, law)
        return guard
    for piece in range(law.pieces):
        if wall.hysteresis > 0.0:
            count_piece(z, past, piece, body, wall, law, pad)
        else:
            move_piece(z, past, piece, body, law, pad)
        look = int(law.sched[piece * PIECE + LOOK])
        if look >= 0:
            past[look] = read_after(z[0], past[law.line - 1], wall)
    return guard


def advance_jittering_with_law(z, past, body, wall, law, pad):
    """As `advance_with_law`, over an interval of random length, whose looks and parts are longer or shorter with it."""
    guard = sense(z[0], z[1], past, wall, law)
    length, last = next_span(wall.clock), law.line - 1
    for piece in range(law.pieces):
        at = piece * PIECE
        u, span = past[int(law.sched[at + TORQUE])], length * law.sched[at + SPAN]
        if wall.hysteresis > 0.0:
            past[last], _ = turn_and_count(z, u, span, past[last], body, wall, pad)
        else:
            advance_span(z, u, span, body, pad)
        look = int(law.sched[at + LOOK])
        if look >= 0:
            past[look] = read_after(z[0], past[last], wall)
    return guard


def begin_past(past, shown, law):
    """What is remembered before the first sample, at which the encoder shows ``shown``: no torque is under way."""
    for j in range(len(past)):
        past[j] = 0.0
    for j in range(law.rows):
        past[j] = law.first[j]
    for j in range(law.places):
        past[j] = shown + law.fixed[0]
    for j in range(law.rows, law.line):
        past[j] = shown


def chart_with_law(z, past, period, body, wall, law, pad, pieces):
    """Write down one period of an orbit, as `general.trace.chart_period`."""
    rows = 0
    begin_clock(wall.clock, -1.0)
    for _ in range(period):
        sense(z[0], z[1], past, wall, law)
        length = next_span(wall.clock)
        for piece in range(law.pieces):
            at, begun = piece * PIECE, rows
            u = past[int(law.sched[at + TORQUE])]
            rows = chart(z, u, length * law.sched[at + SPAN], body, pad, rows, pieces)
            if wall.hysteresis > 0.0:
                for row in range(begun, rows):
                    past[law.line - 1] = read_after(pieces.states[row * body.order], past[law.line - 1], wall)
            look = int(law.sched[at + LOOK])
            if look >= 0:
                past[look] = read_after(z[0], past[law.line - 1], wall)
    return rows
