"""Laws of a spring and a damper whose speed is estimated as firmware does it, a function each; as in `kinds`.

Their memory is in counts and samples, and begins with zeros: the knob has stood where it is.
Fixed numbers of all: offset, gain of the damper in steps of the wall per count a sample, outside the wall too, the
low-pass's part of the way or 0, the pace above which there is no torque, the spring at the filtered angle, where the
last reading is in ``past``, and from `OWN` on those of the estimate.
"""

from math import inf

from hknob_cli.engine.general.laws.kinds import depth_of

OFFSET, GAIN, EVERYWHERE, GOES, MOST, FILTERED, LAST, OWN, NEXT = range(9)


def spring_and_damper(shown, pace, behind, room, fixed, out):
    """Set the torque for a pace; ``behind``: filtered angle less the count's; ``room``: to the nearest guard so far."""
    deep, inside = depth_of(shown, fixed[OFFSET]), shown < 0.0
    if fixed[FILTERED] > 0.0:
        at = shown + fixed[OFFSET] + behind
        deep, inside = max(-at, 0.0), at < 0.0
        if fixed[GAIN] != 0.0 and fixed[EVERYWHERE] == 0.0:
            room = min(room, abs(at))
    if fixed[EVERYWHERE] > 0.0 or inside:
        deep = deep + fixed[GAIN] * pace
    out[0] = 0.0 if abs(pace) > fixed[MOST] else deep
    return room


def filter_and_act(shown, pace, moved, past, row, fixed, out):
    """Pass a pace, and the angle if the spring acts on it, through the low-pass, whose memory begins at ``row``."""
    if fixed[GOES] == 0.0:
        return spring_and_damper(shown, pace, 0.0, inf, fixed, out)
    pace = past[row] + fixed[GOES] * (pace - past[row])
    past[row] = pace
    behind = 0.0
    if fixed[FILTERED] > 0.0:
        behind = (1.0 - fixed[GOES]) * (past[row + 1] - moved)
        past[row + 1] = behind
    return spring_and_damper(shown, pace, behind, abs(fixed[MOST] - abs(pace)), fixed, out)


def differenced_velocity(shown, speed, past, fixed, out):
    """Counts moved over a window. Memory: counts moved in the last samples, the newest first; then the low-pass's.

    Own: samples of the window.
    """
    moved = shown - past[int(fixed[LAST])]
    window = int(fixed[OWN])
    total = moved
    for j in range(window - 2, -1, -1):
        total += past[j]
        past[j] = past[j - 1] if j > 0 else moved
    return filter_and_act(shown, total / window, moved, past, window - 1, fixed, out)


def timed_velocity(shown, speed, past, fixed, out):
    """Counts over the time between changes. Memory: time since the last change, pace; then the low-pass's.

    Own: encoder readings an interval, and the time after which nothing moves, in these.
    """
    last = int(fixed[LAST])
    ticks = int(fixed[OWN])
    before, time, changed = past[last], past[0], 0.0
    moved = shown - before
    for i in range(ticks):
        now = past[last + 1 + i] if i < ticks - 1 else shown
        time = min(time + 1.0, fixed[NEXT])
        if now != before:
            changed += time
            time = 0.0
        before = now
    if changed > 0.0:
        past[1] = moved * ticks / min(changed, fixed[NEXT])
    past[0] = time
    if time > 0.0:  # a count more would have been seen
        past[1] = min(max(past[1], -ticks / time), ticks / time)
    if time >= fixed[NEXT]:
        past[1] = 0.0
    return filter_and_act(shown, past[1], moved, past, 2, fixed, out)


def adaptive_velocity(shown, speed, past, fixed, out):
    """Slope of the longest line, to the newest reading, that is within a count of all readings that it passes.

    Memory: counts moved in the last samples, the newest first; then the low-pass's. Own: samples of the longest line.
    """
    moved = shown - past[int(fixed[LAST])]
    longest = int(fixed[OWN])
    total = pace = moved
    # Slopes that pass within a count of the readings so far: bounds as fractions of whole numbers, which are exact.
    low, low_over, high, high_over = -1.0, 0.0, 1.0, 0.0
    for n in range(2, longest + 1):
        if (total - 1.0) * low_over > low * (n - 1):
            low, low_over = total - 1.0, n - 1.0
        if (total + 1.0) * high_over < high * (n - 1):
            high, high_over = total + 1.0, n - 1.0
        total += past[n - 2]
        if total * low_over < low * n or total * high_over > high * n:
            break
        pace = total / n
    for j in range(longest - 2, -1, -1):
        past[j] = past[j - 1] if j > 0 else moved
    return filter_and_act(shown, pace, moved, past, longest - 1, fixed, out)


def tracked_velocity(shown, speed, past, fixed, out):
    """Pace of an angle that follows the count. Memory: that angle less the count, its pace. Own: gains on both."""
    ahead = past[0] + past[1] - (shown - past[int(fixed[LAST])])
    past[0] = (1.0 - fixed[OWN]) * ahead
    past[1] = past[1] - fixed[NEXT] * ahead
    return spring_and_damper(shown, past[1], past[0], abs(fixed[MOST] - abs(past[1])), fixed, out)
