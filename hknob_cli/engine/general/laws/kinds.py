"""The laws: from what the sensor shows and what is remembered to the torques of an interval, a function each.

``shown``: the encoder's count; ``speed``: of a velocity sensor, counts a sample; ``past``: memory, which a law rewrites
in place, then the last reading and those at the looks into the last interval; ``fixed``: numbers of its own, first the
offset of the counts; ``out``: takes the torques of the parts of the interval, in steps of the wall, and of a law that
senses the speed, which has one part, the torque's slope by it. What is returned is how far the number that fades, the
sum that drifts, or the speed that is sensed may move before the law acts otherwise; inf where it may be anything.

The sources of the laws are given in `controllers`, which has them over arrays of trials.
"""

from math import cos, inf, pi

LONGEST = 4096.0  # samples of a cycle that phase damping times
MEAN_SAMPLES = 64.0  # of its running mean
UNSURE = 1.0 / 6.0
DRIFT = 0.05


def depth_of(count, offset):
    """How deep in the wall a count says the knob is: the plain wall's torque in its own steps."""
    return -(count + offset) if count < 0.0 else 0.0


def bounded_lag(shown, speed, past, fixed, out):
    """Memory: the wall's running mean. Fixed: offset, its part of the way, what of a step acts at once."""
    w = depth_of(shown, fixed[0])
    past[0] = past[0] + fixed[1] * (w - past[0])
    out[0] = w - (1.0 - fixed[2]) * min(max(w - past[0], -1.0), 1.0)
    return inf


def first_order_hold(shown, speed, past, fixed, out):
    """Memory: the wall's last torque, the last mean. Fixed: offset, whether to correct, looks, steps."""
    now, before = depth_of(shown, fixed[0]), past[0]
    mean, acted = 1.5 * now - 0.5 * before, 0.5 * (now + before)
    count, steps = int(fixed[2]) + 1, int(fixed[3])
    if count > 1:
        total, moment = 0.0, 0.0
        for k in range(count + 1):
            w = before if k == 0 else now if k == count else depth_of(past[2 + k], fixed[0])
            total = total + w
            moment = moment + (k - 0.5 * count) * w
        slope = moment * (12.0 / ((count + 1) * (count + 2)))
        mean = 0.5 * (now + (total / (count + 1) + 1.5 * slope))
        acted = (total - 0.5 * (before + now)) / count
    missed = acted - past[1] if fixed[1] > 0.0 else 0.0
    past[0], past[1] = now, mean
    out[0] = mean + missed
    if steps > 1:
        rise = 2.0 * (mean - now)
        for k in range(steps):
            out[k] = now + (k + 0.5) / steps * rise + missed
    return inf


def half_sample(shown, speed, past, fixed, out):
    """Memory: the place. Fixed: offset, S of half an interval, the part of a place left, the yielding, a sensor."""
    at = shown + fixed[0]
    pace = speed if fixed[4] > 0.0 else at - past[0]
    middle = (fixed[2] * at + fixed[1] * pace) * fixed[3]
    past[0] = at
    slope = fixed[1] * fixed[3]
    out[0] = max(-middle, 0.0)
    out[1] = -slope if middle < 0.0 else 0.0
    return abs(middle) / slope


def impulse_damping(shown, speed, past, fixed, out):
    """Memory: the wall's last torque. Fixed: offset, pulse, gain, looks."""
    now, before = depth_of(shown, fixed[0]), past[0]
    looks = int(fixed[3])
    if looks == 0:
        missed = 0.5 * (now - before)
    else:
        count = looks + 1
        between = 0.0
        for i in range(looks):
            between += depth_of(past[2 + i], fixed[0])
        missed = (0.5 * now - (count - 0.5) * before + between) / count
    past[0] = now
    out[0] = now + fixed[2] * missed / fixed[1]
    if fixed[1] < 1.0:
        out[1] = now
    return inf


def matched_wall(shown, speed, past, fixed, out):
    """Memory: the place. Fixed: offset, gains on place and pace, a sensor."""
    at = shown + fixed[0]
    pace = speed if fixed[3] > 0.0 else at - past[0]
    past[0] = at
    out[0] = -(fixed[1] * at + fixed[2] * pace) if shown < 0.0 else 0.0
    out[1] = -fixed[2] if shown < 0.0 else 0.0
    return inf


def passivity(shown, speed, past, fixed, out):
    """Memory: place, torque, energy, and 1 where the energy begins anew. Fixed: offset, most damping, reset."""
    now, at = depth_of(shown, fixed[0]), shown + fixed[0]
    travel = at - past[0]
    energy = owed = past[2] - past[1] * travel
    torque = now
    if energy < 0.0 and travel != 0.0:
        torque = now - min(-energy / (travel * travel), fixed[1]) * travel
    past[3] = 0.0
    if fixed[2] > 0.0 and now == 0.0 and travel == 0.0:
        energy = 0.0
        past[3] = 1.0
    past[0], past[1], past[2] = at, torque, energy
    out[0] = torque
    return -owed - fixed[1] * travel * travel if travel != 0.0 else inf


def take_time(past, row, variance, time, kalman):
    """Take a time between crossings into its estimate."""
    if not time < LONGEST:
        return
    if kalman == 0.0:
        past[row] = time
        return
    spread = past[variance] + DRIFT
    gain = spread / (spread + UNSURE)
    past[row] = past[row] + gain * (time - past[row])
    past[variance] = (1.0 - gain) * spread


def phase_damping(shown, speed, past, fixed, out):
    """Memory: torque, its mean, samples since a crossing, estimates inside and outside, their variances, the way.

    Fixed: offset, height, part of a turn, both crossings, Kalman filter.
    """
    now, before, last_mean = depth_of(shown, fixed[0]), past[0], past[1]
    mean = last_mean + (now - last_mean) / MEAN_SAMPLES
    since = min(past[2] + 1.0, LONGEST)
    entered = now > mean and before <= last_mean
    left = now <= mean and before > last_mean
    way = 1.0
    if fixed[3] > 0.0:
        if entered:
            take_time(past, 4, 6, since, fixed[4])
            past[7] = 1.0
        if left:
            take_time(past, 3, 5, since, fixed[4])
            past[7] = -1.0
        if entered or left:
            since = 0.0
        way = past[7]
        half = past[3] if way > 0.0 else past[4]
        known = half > 0.0 and way != 0.0
        turn = 0.5 * (since + 0.5) / half if known else 0.0
    else:
        if entered:
            take_time(past, 3, 5, since, fixed[4])
            past[7] = 1.0
            since = 0.0
        known = past[3] > 0.0 and past[7] != 0.0
        turn = (since + 0.5) / past[3] if known else 0.0
    torque = now
    if known and turn <= fixed[2]:
        torque = now + fixed[1] * way * cos(2.0 * pi * turn)
    past[0], past[1], past[2] = now, mean, since
    out[0] = torque
    return min(abs(now - mean), abs(before - last_mean))


def stiffening(shown, speed, past, fixed, out):
    """No memory. Fixed: offset, a count in parts of the depth, part of the stiffness at the surface."""
    now = depth_of(shown, fixed[0])
    out[0] = now * (fixed[2] + (1.0 - fixed[2]) * min(now * fixed[1], 1.0))
    return inf


def velocity_damping(shown, speed, past, fixed, out):
    """Memory: the last places, the newest first, and the filtered pace if there is a filter.

    Fixed: offset, steps of the wall per count a sample, a sensor, outside the wall too, samples of the window, the
    filter's part of the way or 0, the pace above which there is no torque.
    """
    at = shown + fixed[0]
    window = int(fixed[4])
    pace = speed if fixed[2] > 0.0 else (at - past[window - 1]) / window
    for j in range(window - 1, 0, -1):
        past[j] = past[j - 1]
    past[0] = at
    room = inf
    if fixed[5] > 0.0:
        pace = past[window] + fixed[5] * (pace - past[window])
        past[window] = pace
    if fixed[5] > 0.0 or fixed[2] > 0.0:
        room = abs(fixed[6] - abs(pace))
    out[0], out[1] = depth_of(shown, fixed[0]), 0.0
    if fixed[3] > 0.0 or shown < 0.0:
        out[0], out[1] = out[0] + fixed[1] * pace, fixed[1]
    if abs(pace) > fixed[6]:
        out[0], out[1] = 0.0, 0.0
    return room
