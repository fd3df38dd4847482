"""Where all states of an arc slide, or stop or turn round once and go on alike, on slopes of cogging.

As in `friction_arc`: the speeds of two states differ by no more than the arc is large, friction or not, and an unstable
slope lets that grow at a known rate. So all slide as long as the centre is faster than that. All stop within a window
of the centre's stop in which none can go on. What derivatives at a stop leave out is bounded there, as long as no
corner is near: of angle and speed alone. Without friction a stop is a turning point, of any number of states.
"""

from typing import NamedTuple

from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.cogging import room_on
from hknob_cli.engine.general.sets.friction_arc import stop_bound
from hknob_cli.engine.general.slide_many import held_bound, held_slope
from hknob_cli.engine.general.slide_two import way
from hknob_cli.engine.general.slopes import cog_acceleration, cog_rate, roll, stays_over, stiff_of


class Spread(NamedTuple):
    """How far an arc's states may be from its centre all along a hold, and how fast that may change.

    ``apart``: by `cogging.size_at`; ``far``: in place alone; ``fast``: size of the rates of the centre.
    """

    apart: float
    far: float
    fast: float


def stop_on_slope(room, z, u, slope, mode, left, spread, body):
    """What a stop of the centre ``z`` that slid in ``mode`` does to an arc: ``(alike, window, then, jump, more)``.

    Args:
        room: `friction_arc_search.RubRoom`.
        z: The centre at its stop.
        u: Torque.
        slope: Of cogging, its number.
        mode: +1 or -1.
        left: Of the hold.
        spread: Of the arc.
        body: What moves.

    ``alike``: whether all stop within ``window`` of it, as far as the hold goes, and go on in the mode ``then``;
    ``jump``: relative change of the speeds' rate; ``more``: what derivatives leave out, by `cogging.size_at`.
    """
    apart, far, size = spread
    stiff, fast, pull = stiff_of(body), room.fast[1], cog_acceleration(z, u, slope, body)
    rate, then = pull - mode * body.friction, way(0.0, pull, body.friction)
    if rate == 0.0:
        return False, 0.0, then, 0.0, 0.0
    slowed, after = abs(rate), 0.0 if then == 0 else pull - then * body.friction
    window, own = 2.0 * apart / slowed, stiff * apart
    before, later = 2.0 * size, size  # of the rates; twice as much for a window before
    if body.order == 2:
        before, later = 2.0 * slowed, abs(after)
    bend, changes = stiff * (before + fast * apart), -1.0
    alike = 2.0 * fast * window <= 0.5 and 2.0 * (own + 2.0 * bend * window) <= slowed
    alike = alike and room_on(z[0], slope, body.cogs) > far + 8.0 * slowed * window * window
    if then == 0:
        copy_to(room.begun, z)
        cog_rate(z, u, slope, 0, body, room.pad)
        changes = abs(held_slope(room.pad, body)) + held_bound(room.pad, body) * window
        alike = alike and stays_over(room.begun, u, slope, 0, left, own + (bend + changes) * window, body, room.pad)
    else:
        later = stiff * (later + fast * apart)
        bend = max(bend, later)
        alike = alike and 2.0 * (own + 2.0 * later * window) <= abs(after)
    more = stop_bound(slowed, abs(after - rate), bend, changes, apart, window, room, body)
    return alike, window, then, (after - rate) / rate, more


def slides_on(room, u, slope, mode, span, times, spread, body):
    """Whether all states slide in ``mode`` on a slope, over a piece of ``span`` in which the centre does.

    The piece begins at ``room.first``. ``times``: ``(wait, window)``, so long after it begins, and twice so long
    before it ends, a state may do otherwise.
    """
    wait, window = times
    left = span - wait - 2.0 * window
    if not left > 0.0:
        return False
    copy_to(room.begun, room.first)
    if wait > 0.0:
        roll(room.begun, u, slope, mode, wait, True, body, room.pad)
    return stays_over(room.begun, u, slope, mode, left, spread.apart, body, room.pad)
