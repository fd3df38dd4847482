"""Torque over the angle of a continuous sensor, which has no counts: a function of the angle itself, part by part.

A curve is a flat array: `HEAD` numbers of the profile, the detents, the end stops and the dead zone, then the angles of
the profile's points, and then its torques. Each part is linear between knees, where its slope changes, and steps, where
it jumps; but detents of shape sine bend. A part gives its torque, its slope, how far the angle may move until it passes
a knee or a step, the largest slope that it has up to there, and the size of what its torque is made of. Units are those
of `engine.loop`; the wall is not in it.

The compiler makes code of its own for scenes without any part of this kind, in which nothing of this is left: a curve
that is None is known by its type. Beside other such parts it is empty (`search.as_compiled`).
"""

from math import cos, pi, sin

from hknob_cli.engine.loop import floor

POINTS, SPAN, STEPPED = 0, 1, 2  # of the profile: points; angle after which it repeats, 0: never; 1: a step each
DETENT, SPACING, CENTRE, SHAPE, ZONE, LOW, HIGH = 3, 4, 5, 6, 7, 8, 9  # of detents; where they begin and end
STOP, LOWEST, HIGHEST = 10, 11, 12  # stiffness of end stops, 0 without them; where they begin, infinite without one
SPRING, HALF, MIDDLE, MOST = 13, 14, 15, 16  # of a dead zone: stiffness, 0 without one; half its width; largest torque
FAR = 17  # largest angle by which a place in the curve is computed
HEAD = 18
SINE, TRIANGLE, SPRUNG = 1.0, 2.0, 3.0  # shapes of detents
NEVER = float("inf")


def has_curve(curve):
    """Whether there is a curve."""
    if curve is None:
        return False
    return bool(len(curve))


def point_below(at, curve):
    """Last point of the profile that is not above an angle; -1 below the first."""
    low, high = -1, int(curve[POINTS])
    while high - low > 1:
        middle = (low + high) // 2
        if curve[HEAD + middle] <= at:
            low = middle
        else:
            high = middle
    return low


def profile_at(x, curve):
    """The profile at an angle: torque, slope, room, steepest slope, size."""
    count = int(curve[POINTS])
    if count == 0:
        return 0.0, 0.0, NEVER, 0.0, 0.0
    first, span = curve[HEAD], curve[SPAN]
    at = x - span * floor((x - first) / span) if span > 0.0 else x
    k = point_below(at, curve)
    torques = HEAD + count
    if k < 0:
        return curve[torques], 0.0, first - at, 0.0, abs(curve[torques])
    u = curve[torques + k]
    if k == count - 1:
        return u, 0.0, at - curve[HEAD + k], 0.0, abs(u)
    room = min(at - curve[HEAD + k], curve[HEAD + k + 1] - at)
    if curve[STEPPED] > 0.0:
        return u, 0.0, room, 0.0, abs(u)
    slope = (curve[torques + k + 1] - u) / (curve[HEAD + k + 1] - curve[HEAD + k])
    size = abs(u) + abs(curve[torques + k + 1])
    return u + slope * (at - curve[HEAD + k]), slope, room, abs(slope), size


def detents_at(x, curve):
    """The detents at an angle, as `profile_at`."""
    most = curve[DETENT]
    if most == 0.0:
        return 0.0, 0.0, NEVER, 0.0, 0.0
    if x < curve[LOW]:
        return 0.0, 0.0, curve[LOW] - x, 0.0, 0.0
    if x > curve[HIGH]:
        return 0.0, 0.0, x - curve[HIGH], 0.0, 0.0
    room, spacing = min(x - curve[LOW], curve[HIGH] - x), curve[SPACING]
    phase = (x - curve[CENTRE]) / spacing
    away = phase - floor(phase + 0.5)
    side = 1.0 if away > 0.0 else -1.0
    size = abs(away)
    if curve[SHAPE] == SINE:
        steepest = 2.0 * pi * most / spacing
        angle = 2.0 * pi * away
        return -most * sin(angle), -steepest * cos(angle), room, steepest, most
    if curve[SHAPE] == TRIANGLE:
        steepest, room = 4.0 * most / spacing, min(room, abs(0.25 - size) * spacing)
        if size <= 0.25:
            return -most * (4.0 * away), -steepest, room, steepest, most
        return -most * (side * (2.0 - 4.0 * size)), steepest, room, steepest, most
    zone = 0.5 * curve[ZONE] / spacing
    steepest, room = most / ((0.5 - zone) * spacing), min(room, (0.5 - size) * spacing)
    if size < zone:
        return 0.0, 0.0, min(room, (zone - size) * spacing), 0.0, 0.0
    if zone > 0.0:
        room = min(room, (size - zone) * spacing)
    return -most * (side * (size - zone) / (0.5 - zone)), -steepest, room, steepest, most


def stops_at(x, curve):
    """The end stops at an angle, as `profile_at`."""
    stiffness, low, high = curve[STOP], curve[LOWEST], curve[HIGHEST]
    if x < low:
        return stiffness * (low - x), -stiffness, low - x, stiffness, stiffness * (abs(low) + abs(x))
    if x > high:
        return stiffness * (high - x), -stiffness, x - high, stiffness, stiffness * (abs(high) + abs(x))
    return 0.0, 0.0, min(x - low, high - x), 0.0, 0.0


def zone_at(x, curve):
    """The dead zone at an angle, as `profile_at`."""
    stiffness, half, most = curve[SPRING], curve[HALF], curve[MOST]
    if stiffness == 0.0:
        return 0.0, 0.0, NEVER, 0.0, 0.0
    away = x - curve[MIDDLE]
    over = abs(away) - half
    if over < 0.0:
        return 0.0, 0.0, -over, 0.0, 0.0
    side = 1.0 if away > 0.0 else -1.0
    if stiffness * over >= most:
        return -side * most, 0.0, over - most / stiffness, 0.0, most
    room = most / stiffness - over
    if half > 0.0:
        room = min(room, over)
    return -side * (stiffness * over), -stiffness, room, stiffness, stiffness * (abs(away) + half)


def curve_at(x, curve):
    """All parts at an angle: torque, slope, room, steepest slope, size; nothing, and room without end, without any.

    Within the room the slope stays as it is, unless detents of shape sine bend it (`bend_of`), and is never larger than
    the steepest.
    """
    if curve is None or not len(curve):
        return 0.0, 0.0, NEVER, 0.0, 0.0
    u, slope, room, steepest, size = profile_at(x, curve)
    for part in (detents_at(x, curve), stops_at(x, curve), zone_at(x, curve)):
        u += part[0]
        slope += part[1]
        room = min(room, part[2])
        steepest += part[3]
        size += part[4]
    return u, slope, room, steepest, size


def curve_torque(x, curve):
    """Torque at an angle; 0 without a curve."""
    return curve_at(x, curve)[0]


def bend_of(curve):
    """The most by which a slope changes along an angle, within its room: of detents of shape sine; else 0."""
    if curve is None or not len(curve):
        return 0.0
    if curve[SHAPE] != SINE:
        return 0.0
    wave = 2.0 * pi / curve[SPACING]
    return curve[DETENT] * wave * wave


def rounded_size(x, curve):
    """Size of what a torque is computed from: of its parts, and of the angle, as torque on the steepest slope."""
    if curve is None or not len(curve):
        return 0.0
    _, _, _, steepest, size = curve_at(x, curve)
    return size + steepest * (abs(x) + curve[FAR])


def place_at(x, curve):
    """Number of the place that an angle is in, for motions that come to rest in one: higher the further up.

    Detents have one each; else knees and steps divide places.
    """
    if curve is None or not len(curve):
        return 0.0
    place = 0.0
    count = int(curve[POINTS])
    if count > 0:
        span = curve[SPAN]
        turns = floor((x - curve[HEAD]) / span) if span > 0.0 else 0.0
        place += turns * (count - 1.0) + point_below(x - span * turns, curve)
    if curve[DETENT] > 0.0:
        at = min(max(x, curve[LOW]), curve[HIGH])
        place += floor((at - curve[CENTRE]) / curve[SPACING] + 0.5)
        place += (1.0 if x > curve[LOW] else 0.0) + (1.0 if x > curve[HIGH] else 0.0)
    if curve[STOP] > 0.0:
        place += (1.0 if x > curve[LOWEST] else 0.0) + (1.0 if x > curve[HIGHEST] else 0.0)
    if curve[SPRING] > 0.0:
        away = x - curve[MIDDLE]
        place += (1.0 if away > -curve[HALF] else 0.0) + (1.0 if away > curve[HALF] else 0.0)
    return place
