"""Motion from flank to flank: mode after mode of teeth with play, with its derivative, and written down.

A difference of two motions keeps its direction where teeth part; where they meet, the rates jump by -c o' in the mesh,
and the difference by -c times its own part in d, however fast they meet (Leine & Nijmeijer 2004, sec. 7). It goes
through a corner of cogging as it is, because the torque has no jump there.
"""

from hknob_cli.engine.general.body import STUCK
from hknob_cli.engine.general.cogging import (
    FALLEN,
    RISEN,
    TOOTHED,
    TURNED,
    cog_room,
    far_apart,
    has_cogs,
    is_stable,
    slope_of,
)
from hknob_cli.engine.general.columns import CORNER_ROOM, LEVEL, PRESSED, SPEED, spread_by, spread_many, turn_round
from hknob_cli.engine.general.flank_rest import flank_room_on
from hknob_cli.engine.general.teeth import (
    APART,
    BACK,
    ON_STABLE,
    ON_UNSTABLE,
    SPRUNG,
    STUCK_APART,
    STUCK_BACK,
    direction,
    flank,
    halves_of,
    pressing,
    teeth_pull,
    teeth_rate,
)
from hknob_cli.engine.general.teeth_ends import Mode, press

STILL = 1e-11  # counts, relative: what moves by less has settled, and meets a velocity of 0 at every rounding


def next_flank(z, side, body):
    """Flank after a mode has ended at ``z``: none after one, else the nearer."""
    if side != 0:
        return 0
    return 1 if z[2] > -0.5 * body.play else -1


def pass_end(z, u, side, toward, end, body, slope=0.0):
    """Flank, and direction, after a mode has ended at ``z``, whose speed is 0 where it has turned round.

    Not of an end at a corner of cogging: see `pass_any_end`.
    """
    if body.friction == 0.0:
        if toward != 0 and (end == TURNED or z[1] * toward < 0.0):
            z[1] = 0.0
        else:
            side = next_flank(z, side, body)
        return side, 0 if toward == 0 else direction(z, u, side, body, slope)
    if end == SPRUNG:
        side = next_flank(z, side, body)
    elif toward == 0:  # released, though rounding may say otherwise
        return side, 1 if teeth_pull(z, 0, u, side, body, slope) > 0.0 else -1
    else:
        z[1] = 0.0
    return side, direction(z, u, side, body, slope)


def pass_any_end(z, u, side, toward, slope, end, body):
    """As `pass_end`, of corners of cogging, too: flank, direction, and slope."""
    if has_cogs(body.cogs):
        if end == RISEN:
            return side, toward, slope + 1.0
        if end == FALLEN:
            return side, toward, slope - 1.0
    side, toward = pass_end(z, u, side, toward, end, body, slope)
    return side, toward, slope


def still_in_teeth(z, u, side, slope, span, body, pad):
    """How far a motion moves at most over ``span`` where no teeth part and no corner is passed; inf of another.

    Only without friction. Its rates are a motion without a torque, whose energy never grows.
    """
    if body.friction > 0.0 or side == 0:
        return float("inf")
    teeth_rate(z, u, side, 0, body, pad, slope)
    moved = far_apart(body.cogs, pad, z[0], body) * span
    stays = moved < flank_room_on(body.cogs, pressing(z, 0, side, body), z[0], body)
    return moved if stays and moved < cog_room(body.cogs, z[0], slope) else float("inf")


def play_many(z, u, span, body, pad):
    """Move ``z`` over any time up to a sample period from flank to flank."""
    left = span
    side, slope = flank(z, body), slope_of(body.cogs, z[0])
    toward = direction(z, u, side, body, slope) if body.friction > 0.0 else 0
    fresh = toward != 0 and z[1] == 0.0
    while left > 0.0:
        t, ended, _ = press(z, u, Mode(side, toward, slope), left, fresh, body, pad)
        left -= t
        if ended == 0:
            break
        side, toward, slope = pass_any_end(z, u, side, toward, slope, ended, body)
        fresh = True


def meet(z, side, columns, body):
    """The columns where teeth meet: the rates of both bodies jump by the damper's torque (saltation matrix)."""
    if not side * z[3] > 0.0:
        return
    cols, width = columns.values, columns.width
    for c in range(columns.number):
        jump = body.pad_damping * cols[c * width + 2]
        cols[c * width + 1] -= jump
        cols[c * width + 3] -= (1.0 + body.ratio) * jump


def meet_with_friction(z, u, side, before, toward, columns, body, slope=0.0):
    """As `meet`, of a motor that friction holds before or after; ``before``, ``toward``: its direction."""
    if not side * z[3] > 0.0:
        return
    pull = 0.0 if toward == 0 else (teeth_pull(z, 0, u, side, body, slope) - toward * body.friction) / z[3]
    cols, width = columns.values, columns.width
    for c in range(columns.number):
        jump = body.pad_damping * cols[c * width + 2]
        own = -jump if before != 0 else pull * cols[c * width + 2]
        cols[c * width + 1] += own
        cols[c * width + 3] += own - body.ratio * jump


def spread_teeth(columns, span, side, toward, body, pad, slope=0.0):
    """Move the columns over ``span`` in one mode."""
    halves, apart = halves_of(side, toward, slope, body), 1 if side == 0 else 0
    if toward == 0 and body.friction > 0.0:
        spread_by(columns, span, STUCK + apart, halves, False, body, pad)
    elif has_cogs(body.cogs):
        matrix = TOOTHED + 2 * apart + (0 if is_stable(slope) else 1)
        spread_by(columns, span, matrix, halves, True, body, pad)
    else:
        spread_many(columns, span, side, body, pad)


def play_columns(z, u, span, body, pad, columns, marks):
    """As `advance.rub_columns`, from flank to flank, with its ``marks``.

    The least torque of the mesh is below 0 where teeth have parted.
    """
    left = span
    side, slope = flank(z, body), slope_of(body.cogs, z[0])
    rubs = body.friction > 0.0
    toward = direction(z, u, side, body, slope) if rubs else 0
    if has_cogs(body.cogs):
        moved = still_in_teeth(z, u, side, slope, span, body, pad)
        still = moved <= STILL * (1.0 + abs(z[0]))
        marks[CORNER_ROOM] = min(marks[CORNER_ROOM], cog_room(body.cogs, z[0], slope) - (moved if still else 0.0))
        if not rubs and not still:
            toward = direction(z, u, side, body, slope)
    fresh = toward != 0 and z[1] == 0.0
    if rubs and z[1] == 0.0:
        marks[LEVEL] = min(marks[LEVEL], abs(abs(teeth_pull(z, 0, u, side, body, slope)) - body.friction))
    while left > 0.0:
        t, ended, least = press(z, u, Mode(side, toward, slope), left, fresh, body, pad)
        spread_teeth(columns, t, side, toward, body, pad, slope)
        marks[PRESSED] = min(marks[PRESSED], least if side != 0 else -1.0)
        left -= t
        # On its way the motor is nearest to a corner where it turns round, or where the way ends.
        marks[CORNER_ROOM] = min(marks[CORNER_ROOM], cog_room(body.cogs, z[0], slope))
        if ended == 0:
            break
        before, ago = toward, side
        side, toward, slope = pass_any_end(z, u, side, toward, slope, ended, body)
        fresh = True
        if ended in (RISEN, FALLEN):
            marks[CORNER_ROOM] = -1.0
            continue
        if not rubs:
            if side not in (0, ago):
                meet(z, side, columns, body)
            continue
        pull = teeth_pull(z, 0, u, side, body, slope)
        if z[1] == 0.0 and (before != 0 or side != ago):
            marks[LEVEL] = min(marks[LEVEL], abs(abs(pull) - body.friction))
        if side != ago:
            if side != 0:
                meet_with_friction(z, u, side, before, toward, columns, body, slope)
        elif before != 0:
            rate = pull - before * body.friction
            after = 0.0 if toward == 0 else pull - toward * body.friction
            if rate != 0.0:
                turn_round(columns, (after - rate) / rate, body)
    if rubs and toward != 0:
        marks[SPEED] = min(marks[SPEED], abs(z[1]))


def kind_of(side, toward, body, slope=0.0):
    """Mode of a piece that is written down."""
    if toward == 0 and body.friction > 0.0:
        return 0 if side > 0 else (STUCK_APART if side == 0 else STUCK_BACK)
    kind = 1 if side > 0 else (APART if side == 0 else BACK)
    if has_cogs(body.cogs):
        kind += ON_STABLE if is_stable(slope) else ON_UNSTABLE
    return toward * kind


def play_chart(z, u, span, body, pad, rows, pieces):
    """As `trace.chart`, from flank to flank; modes are by the sign of the speed 1, `APART` or `BACK`.

    Those of a motor that is held are 0, `STUCK_APART` or `STUCK_BACK`.
    """
    n = body.order
    left = span
    side, slope = flank(z, body), slope_of(body.cogs, z[0])
    toward = direction(z, u, side, body, slope)
    fresh = body.friction > 0.0 and toward != 0 and z[1] == 0.0
    while left > 0.0 and rows < len(pieces.spans):
        for j in range(n):
            pieces.states[rows * n + j] = z[j]
        t, ended, _ = press(z, u, Mode(side, toward, slope), left, fresh, body, pad)
        left -= t
        if t > 0.0:
            pieces.spans[rows], pieces.commands[rows] = t, u
            pieces.modes[rows] = kind_of(side, toward, body, slope)
            rows += 1
        if ended == 0:
            break
        side, toward, slope = pass_any_end(z, u, side, toward, slope, ended, body)
        fresh = True
    for j in range(n):
        pieces.states[rows * n + j] = z[j]
    return rows
