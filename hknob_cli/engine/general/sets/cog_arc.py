"""An arc of clock phases moved over a hold from corner to corner of cogging.

Sizes are the root of the energy with the spring of a stable slope (`cogging.size_at`), which grows on an unstable slope
alone, at the rate of `corners.growth_rate`. Line and ball of an arc are columns (`friction_arc`), which go by the
derivative along the centre: through a corner as they are. While a corner lies between the centre and a state, the
slopes of their torques differ by twice that of cogging, and this goes on only as long as the centre is as near to the
corner as the state may be to it. So what that adds is of the square of the arc's size, where the centre passes the
corner at a speed, and is bounded by the time that it is near; it is put into the ball.

With friction, of a knob of angle and speed, all states do alike where they slide all along, faster than they may differ
in speed; where friction holds all of them; or where all stop once, on one slope, and go on alike (`cog_stop`).
Elsewhere all of the arc is in the ball then, of which friction takes energy only.
"""

from math import exp, sqrt

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.cogging import (
    FREE,
    SLOPE,
    TURNED,
    has_cogs,
    is_stable,
    room_on,
    size_at,
    slope_at,
    unit_reach,
)
from hknob_cli.engine.general.columns import Columns, turn_round
from hknob_cli.engine.general.corners import growth_rate
from hknob_cli.engine.general.sets.cog_stop import Spread, slides_on, stop_on_slope
from hknob_cli.engine.general.sets.friction_arc import (
    BALL,
    BESIDE,
    ERROR,
    HIGH,
    LOW,
    STANDS,
    STEPS,
    WIDE,
    apart_of,
    ball_of,
    begin_arc,
    begin_ball,
    beside_of,
    rub_arc,
)
from hknob_cli.engine.general.slope_columns import spread_cogs
from hknob_cli.engine.general.slopes import (
    cog_acceleration,
    cog_many,
    cog_rate,
    pass_on,
    roll,
    roll_in_steps,
    stays_over,
    stiff_of,
    way_from,
)

ROUNDED = 1.0 + 1e-12  # what computing a growth rounds


def time_beside(room, speed, passes, pace, far, span):
    """How long, at one end of a piece of ``span``, a state may be beyond a corner that the centre is not at.

    Counted by how far beyond it is, as a part of ``far``. In a piece the centre goes one way.

    Args:
        room: How far the centre is from the nearer corner at that end.
        speed: Its speed there.
        passes: Whether it passes that corner there.
        pace: Bound on its accelerations.
        far: How far places of states may be from its own.
        span: Length of the piece.
    """
    if room > far:
        return 0.0
    ways = 0.5 if passes else 2.0
    square = speed * speed - (2.0 if passes else 4.0) * pace * far
    if not square > 0.0:
        return span
    return min(span, ways * far / sqrt(square))


def time_of_piece(room, z, slope, mode, corners, spread, span, cogs):
    """As `time_beside`, of a piece of ``span`` from ``room.first`` to ``z``, in all; in a mode without turning points.

    ``corners``: whether one is passed where it begins, and where it ends.
    """
    passed, passes = corners
    if mode == FREE:
        return span
    if mode == 0:
        return 0.0
    near = time_beside(room_on(room.first[0], slope, cogs), room.first[1], passed, spread.fast, spread.far, span)
    return near + time_beside(room_on(z[0], slope, cogs), z[1], passes, spread.fast, spread.far, span)


def rubs_alike(room, z, u, slope, mode, span, spread, body):
    """Whether all states of an arc begin a hold in the mode of the centre, and where it begins at rest go on in it.

    If all come to stand in it, the arc notes that. Where nothing rubs they do.
    """
    if body.friction == 0.0:
        return True
    arc, apart, stiff = room.arc, spread.apart, stiff_of(body)
    stands, pull = arc[STANDS] > 0.0, abs(cog_acceleration(z, u, slope, body))
    arc[STANDS] = 0.0
    if mode == 0:
        copy_to(room.begun, z)
        need = stiff * apart + (0.0 if stands else apart / span)
        arc[STANDS] = 1.0 if stays_over(room.begun, u, slope, 0, span, need, body, room.pad) else 0.0
        return stands and arc[STANDS] > 0.0
    if z[1] == 0.0:
        return stands and pull - body.friction - stiff * apart > stiff * (spread.fast + room.fast[1] * apart) * span
    return True


def rounded_by(room, z, u, fast, wide, drift, body):
    """Bounds on what roundings add in a hold, for each step: to the centre, and to a column, ``(wrong, skewed)``.

    ``fast``: how far the rates carry the centre; ``wide``: size of the columns.
    """
    wrong, skewed = drift.once[0] + drift.once[1] * abs(u), 0.0
    for j in range(body.order):
        wrong += drift.once[2 + j] * (abs(z[j]) + room.spans[j] * fast)
        skewed += drift.once[2 + j] * room.spans[j] * wide
    return wrong, skewed


def spread_of(room, z, u, slope, mode, span, grown, body):
    """The `cog_stop.Spread` of an arc in a hold in which sizes grow at most by ``grown``."""
    apart = apart_of(room, body) * grown
    cog_rate(z, u, slope, mode, body, room.pad)
    fast = size_at(body.cogs, room.pad, 0, body) * grown  # they are less after a stop
    far = min(unit_reach(body) * apart, abs(room.columns[0]) + beside_of(room, body) + apart * span)
    return Spread(apart, far + 8.0 * EPSILON * abs(z[0]), fast)


def keep_ball(room, growth, more, body):
    """Let the ball of an arc, which has moved with its columns, grow by a factor, and by ``more`` beside them."""
    room.arc[BALL] *= growth
    room.arc[BESIDE] = room.arc[BESIDE] * growth + more
    radius = ball_of(room, body)
    if room.arc[BESIDE] > WIDE * radius:
        begin_ball(room, radius, body)


def pass_over(z, u, slope, mode, end, body):
    """As `slopes.pass_on`; what nothing rubs, and balances where it has turned round, has no turning points there."""
    slope, mode = pass_on(z, u, slope, mode, end, body)
    if mode == 0 and body.friction == 0.0:
        mode = FREE
    return slope, mode


def leave_line(room, radius, body):
    """Let all of an arc be in a ball."""
    begin_ball(room, radius, body)
    for j in range(body.order):
        room.columns[j] = 0.0


def roll_arc(room, z, u, span, drift, body):
    """Move the arc in ``room``, its centre in ``z``, over a hold under ``u``; whether its states do alike in it."""
    arc, pad, n, cogs, rubs = room.arc, room.pad, body.order, body.cogs, body.friction > 0.0
    count = len(room.columns) // (n + 1)
    columns = Columns(room.columns, count * n, count, n)
    slope, rate = slope_at(z[0], cogs), growth_rate(body)
    mode, grown = way_from(z, u, slope, body), exp(rate * span) * ROUNDED
    wide = size_at(cogs, room.columns, 0, body) + ball_of(room, body)
    spread = spread_of(room, z, u, slope, mode if rubs else FREE, span, grown, body)
    moved = (abs(z[1]) + 0.5 * spread.fast * span) * span  # by the centre, at most
    calm = room_on(z[0], slope, cogs) > spread.far + moved
    wrong, skewed = rounded_by(room, z, u, spread.fast * span, wide * grown, drift, body)
    if not rubs and (calm or moved <= spread.far or mode == 0):
        mode = FREE  # no corner is near; or it hardly moves, and turns round, if it does, by roundings
    moving = z[1] != 0.0  # of what is let go it is told that it slides on
    alike = rubs_alike(room, z, u, slope, mode, span, spread, body)
    left, loose, near, more, wait, steps, pieces = span, 0.0, 0.0, 0.0, 0.0, 0, 1
    passed, fresh = False, mode != 0 and z[1] == 0.0
    while left > 0.0:
        copy_to(room.first, z)
        t, end, taken = roll_in_steps(z, u, slope, mode, left, fresh, body, pad)
        spread_cogs(columns, t, slope, mode, body, pad)
        left -= t
        steps += taken
        if not is_stable(slope):
            loose += t
        passes, turns = end > TURNED, end == TURNED
        if not calm:
            near += time_of_piece(room, z, slope, mode, (passed, passes), spread, t, cogs)
        passed = passes
        if rubs and mode != 0:
            window, after = 0.0, mode
            if turns:
                same, window, after, jump, added = stop_on_slope(room, z, u, slope, mode, left, spread, body)
                alike = alike and same and wait == 0.0 and 2.0 * window < left
                more += added
                turn_round(columns, jump, body)
            if alike and moving:
                alike = slides_on(room, u, slope, mode, t, (wait, window), spread, body)
            wait = 2.0 * window
            if turns:
                moving, arc[STANDS] = True, 1.0 if after == 0 and alike else 0.0
        elif rubs and turns:
            alike, arc[STANDS] = False, 0.0  # it is let go, and others at other times
        if end == 0:
            break
        slope, mode = pass_over(z, u, slope, mode, end, body)
        fresh = True
        pieces += 1
    arc[ERROR] = (arc[ERROR] + wrong * (1.0 + steps)) * grown
    if alike:
        added = (2.0 * cogs[SLOPE] * spread.far * near + more) * grown + STEPS * pieces * skewed
        keep_ball(room, exp(rate * loose) * ROUNDED, added, body)
        return True
    leave_line(room, wide * grown, body)
    return False


def turns_between(start, low, high, room, body):
    """Whether friction stops a motion without a torque between two times, or lets it go."""
    z, slope = room.first, 0.0
    copy_to(z, start)
    cog_many(body.cogs, z, 0.0, low, body, room.pad)
    slope, left = slope_at(z[0], body.cogs), high - low
    mode = way_from(z, 0.0, slope, body)
    while left > 0.0:
        t, end = roll(z, 0.0, slope, mode, left, True, body, room.pad)
        if end == TURNED:
            return True
        if end == 0:
            return False
        left -= t
        slope, mode = pass_on(z, 0.0, slope, mode, end, body)
    return False


def begin_rolling(start, room, drift, body):
    """As `begin_arc`, from corner to corner; the rate of the state has a rate all along, by one slope or the other."""
    arc, z, pad, n, rubs = room.arc, room.z, room.pad, body.order, body.friction > 0.0
    half = 0.5 * (arc[HIGH] - arc[LOW])
    copy_to(z, start)
    for j in range(n):
        arc[ERROR] += 8.0 * EPSILON * drift.units[j] * abs(start[j])
    for j in range(len(room.columns)):
        room.columns[j] = 0.0
    slope = slope_at(z[0], body.cogs)
    cog_rate(z, 0.0, slope, way_from(z, 0.0, slope, body) if rubs else FREE, body, pad)
    fast = size_at(body.cogs, pad, 0, body) * exp(growth_rate(body)) * ROUNDED
    stops = rubs and turns_between(start, arc[LOW], arc[HIGH], room, body)
    roll_arc(room, z, 0.0, arc[LOW] + half, drift, body)
    arc[STANDS], radius = 0.0, ball_of(room, body)
    for j in range(n):
        room.columns[j] = 0.0
    if stops:
        radius += half * fast
    else:
        slope = slope_at(z[0], body.cogs)
        cog_rate(z, 0.0, slope, way_from(z, 0.0, slope, body) if rubs else FREE, body, pad)
        for j in range(n):
            room.columns[j] = half * pad[j]
        radius += half * max(room.fast[1], room.fast[2]) * (0.5 * half * fast + arc[ERROR])
    begin_ball(room, radius, body)


def move_arc(room, z, u, span, drift, body):
    """Move the arc in ``room``, its centre in ``z``, over a hold under ``u``; whether its states do alike in it."""
    if has_cogs(body.cogs):
        return roll_arc(room, z, u, span, drift, body)
    return rub_arc(room, z, u, span, drift, body)


def begin_phases(start, rate, room, drift, body):
    """Leave in ``room`` the states of its arc's phases at the first sample, as `begin_arc`."""
    if has_cogs(body.cogs):
        begin_rolling(start, room, drift, body)
        return
    begin_arc(start, rate, room, drift, body)
