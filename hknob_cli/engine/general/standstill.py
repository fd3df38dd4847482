"""Rest in the general loop: held by friction, or settling inside one level under a command that no longer changes."""

from math import sqrt

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import acceleration, coil_at, distance
from hknob_cli.engine.general.cog_rest import LastTorque, keeps_to_slope, settles_free
from hknob_cli.engine.general.cogging import PEAK, cog_number, cog_pull, has_cogs
from hknob_cli.engine.general.controller import command, edge_gap, follows, goes_on
from hknob_cli.engine.general.flank_rest import flank_room, held_in_teeth
from hknob_cli.engine.general.inner_region import (
    ROUNDINGS,
    come_to_rest,
    gives_nothing,
    hold_zone,
    keeps_reading,
)
from hknob_cli.engine.general.interval import jitters
from hknob_cli.engine.general.torque_curve import has_curve
from hknob_cli.engine.general.torque_table import is_there
from hknob_cli.engine.rest import AT_REST, LEAVES, MOVING, REST_ON_EDGE, RINGS

SETTLING = 5  # beside the fates of `engine.rest`: one reading for ever, and friction brings the knob to rest


def steady(ring, u):
    """Whether every command under way is ``u``."""
    for j in range(len(ring)):
        if ring[j] != u:
            return False
    return True


def stays_held(z, u, body):
    """Whether friction holds the knob for ever, and the finger and the lag settle behind it."""
    if z[1] != 0.0:
        return False
    cogged = cog_pull(body.cogs, z[0])
    if body.play > 0.0:
        return held_in_teeth(z, u, body, cogged)
    if body.order == 2:
        return abs(acceleration(z, u, body) + cogged) <= body.friction
    late = abs(z[body.order - 1] - u) if body.lag > 0.0 else 0.0
    if body.coil > 0.0:
        late += body.coil * abs(z[coil_at(body)])
    if body.ratio == 0.0:
        now = body.drive + u - body.beta * z[0] + cogged
        return abs(now) + late <= body.friction
    if body.finger_damping + body.pad_damping == 0.0:
        return False
    stiff = body.ratio * body.pad_stiffness + body.finger_stiffness
    if stiff == 0.0:
        return False
    d = (body.finger_stiffness * z[0] + body.finger_stiffness * body.shift) / stiff
    energy = sqrt(z[3] * z[3] / body.ratio + stiff / body.ratio * (z[2] - d) * (z[2] - d))
    swing = (body.pad_damping * sqrt(body.ratio) + body.pad_stiffness * sqrt(body.ratio / stiff)) * energy
    return abs(u + cogged - body.push - body.pad_stiffness * d) + swing + late <= body.friction


def runs_off(z, u, shown, body, wall):
    """Whether a knob that nothing holds turns the way it is driven, and no change of command lies ahead."""
    if not is_there(wall.table) or body.order > 2 or body.beta > 0.0:
        return False
    pull = u - body.push
    return abs(pull) > body.friction + cog_number(body.cogs, PEAK) and pull * z[1] > 0.0 and goes_on(z[1], shown, wall)


def rest_rounding(z, rest, u, body):
    """Bound on what roundings move the place of a rest at ``rest`` without friction, and distances of ``z`` from it."""
    size = 0.0  # of the torques that balance, over the stiffness
    if body.ratio > 0.0:
        size = (abs(u) + body.push) * (1.0 / body.pad_stiffness + body.ratio / body.finger_stiffness) + abs(body.shift)
    elif body.beta > 0.0:
        size = (abs(u) + abs(body.drive)) / body.beta
    return ROUNDINGS * EPSILON * (1.0 + abs(rest) + abs(z[0]) + size)


def is_followed(shown, wall):
    """Whether a command follows the angle of a continuous sensor, so that it changes until the knob stands still."""
    if wall.analog == 0.0:
        return False
    return follows(shown, wall) if has_curve(wall.curve) else shown < 0.0


def comes_to_rest(z, shown, u, body, wall, delay, orbit):
    """Whether a command that follows the knob brings it to rest, whatever the intervals: ``(whether, gap)``.

    By energy, as `inner_region` has it, without friction: it falls as long as anything moves. The rest is left in
    ``orbit``; the gap is its distance to the nearest change of the command's slope.
    """
    if not follows(shown, wall) or not gives_nothing(shown, delay, body, wall) or not body.alpha > 0.0:
        return False, 0.0
    stiffness, low, high = hold_zone(u, shown, body, wall)
    if not stiffness > 0.0:
        return False, 0.0
    rest = 0.5 * (low + high)
    dx, dv = z[0] - rest, z[1]
    reach = sqrt(dx * dx + dv * dv / stiffness) + abs(low - high)
    orbit[0], orbit[1] = rest, 0.0
    gap = edge_gap(rest, rest, rest, wall)
    return reach + ROUNDINGS * EPSILON * (1.0 + abs(rest) + abs(z[0])) < gap, gap


def fate_of_held(z, shown, gap, wall):
    """Fate of a knob that friction holds, by the gap to the nearest change of reading."""
    if wall.analog > 0.0 and shown < 0.0 and not has_curve(wall.curve):
        return AT_REST
    return AT_REST if gap > ROUNDINGS * EPSILON * (1.0 + abs(z[0])) else REST_ON_EDGE


def find_balance(u, body, orbit):
    """Leave in ``orbit`` where a body without friction stands under the torque ``u``; whether it does."""
    n = body.order
    for i in range(n):
        orbit[i] = 0.0
    if body.ratio > 0.0:
        if body.pad_stiffness == 0.0 or body.finger_stiffness == 0.0:
            return False
        drive = u - body.push
        orbit[2] = drive / body.pad_stiffness
        orbit[0] = orbit[2] + body.ratio * drive / body.finger_stiffness - body.shift
    elif body.beta > 0.0:
        orbit[0] = (u + body.drive) / body.beta
    else:
        return False
    if body.lag > 0.0:
        orbit[n - 1] = u
    return True


def is_left_alone(z, u, body):
    """Whether nothing but damping ever acts on a knob that no spring holds."""
    if body.coil > 0.0:
        return False
    return u - body.push == 0.0 and not (body.lag > 0.0 and z[2] != u)


def fate_by_energy(z, shown, u, body, wall, orbit, away):
    """Fate of a trial without friction, by its distance from the rest in ``orbit``, which never grows."""
    for i in range(body.order):
        away[i] = z[i] - orbit[i]
    rest = orbit[0]
    seen = rest if has_curve(wall.curve) else shown
    gap = edge_gap(rest, seen, seen, wall)
    bound = rest_rounding(z, rest, u, body)
    reach = distance(away, body)
    if body.play > 0.0 and not reach + bound < flank_room(body.pad_stiffness * orbit[2], body):
        return MOVING, gap
    if reach + bound < gap:
        return (AT_REST if body.damped else RINGS), gap
    if abs(gap) <= bound and reach < 1e-6:
        return REST_ON_EDGE, 0.0
    return MOVING, gap


def settles_alone(z, shown, u, gap, body, wall, orbit, away):
    """Fate of a trial without friction under a torque that goes on, as `settles`; ``gap``: of where it is now."""
    if body.ratio > 0.0 or body.beta > 0.0:
        if not find_balance(u, body, orbit):
            return MOVING, gap
        return fate_by_energy(z, shown, u, body, wall, orbit, away)
    if not is_left_alone(z, u, body):
        return MOVING, gap
    if body.alpha == 0.0:
        if z[1] == 0.0:
            return AT_REST, gap
        return (LEAVES if goes_on(z[1], shown, wall) else MOVING), gap
    orbit[0] = z[0] + z[1] / body.alpha
    if body.lag > 0.0:
        orbit[body.order - 1] = u
    return fate_by_energy(z, shown, u, body, wall, orbit, away)


def settles(z, shown, before, ring, body, wall, orbit, away):
    """Fate of a trial whose reading goes on: ``(fate, margin)``; the rest point is left in ``orbit``.

    `SETTLING` is a rest that may never be reached.
    """
    u = command(shown, shown, wall)
    if not steady(ring, u) or (wall.damping > 0.0 and shown != before):
        return MOVING, 0.0
    for i in range(body.order):
        orbit[i] = 0.0
    orbit[0] = z[0]
    gap = edge_gap(z[0], shown, before, wall)
    if runs_off(z, u, shown, body, wall):
        return LEAVES, gap
    if body.friction > 0.0 and stays_held(z, u, body):
        return fate_of_held(z, shown, gap, wall), gap
    followed = is_followed(shown, wall)
    if has_cogs(body.cogs):
        if followed:
            return MOVING, gap
        if body.friction == 0.0:
            return settles_free(body.cogs, z, LastTorque(u, 0.0, 0.0), shown, body, wall, orbit, away)
        keeps, gap = keeps_to_slope(body.cogs, z, LastTorque(u, 0.0, 0.0), shown, body, wall, orbit, away)
        return (SETTLING if keeps else MOVING), gap
    if body.friction > 0.0:
        keeps, gap = keeps_reading(z, shown, u, body, wall, len(ring), orbit, away)
        if keeps:
            come_to_rest(z, shown, u, body, wall, orbit)
        return (SETTLING if keeps else MOVING), gap
    if followed:
        if jitters(wall.clock):
            rests, gap = comes_to_rest(z, shown, u, body, wall, len(ring), orbit)
            return (AT_REST if rests else MOVING), gap
        return MOVING, gap
    return settles_alone(z, shown, u, gap, body, wall, orbit, away)
