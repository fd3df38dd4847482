"""A second-order knob's response to a recorded torque with Coulomb friction, exact from turn to turn.

Numbers as in `pulse`. Within a hold the torque is constant, or falls exponentially to a constant (a motor with a lag).
"""

from math import exp, log1p

from hknob_cli.engine.pulse import hold_derivatives

EVENTS = 32  # turns, stops and releases within one hold of the torque, at most


def pull_at(v, d, w, alpha, beta, decay, t):
    """Velocity and acceleration at a time ``t`` after velocity ``v``, net drive ``d``, and ``w`` exp(-decay t)."""
    s, g, f, q, r, _sa, _ga, _fa, _qa, _ra, _sb, _gb, _fb, _qb, _rb = hold_derivatives(alpha, beta, decay, t)
    speed = f * v + s * d + r * w
    fallen = w * exp(-decay * t) if w != 0.0 else 0.0
    return speed, d + fallen - beta * (s * v + g * d + q * w) - alpha * speed


def turning_time(v, d, w, way, alpha, beta, decay, t):
    """When the velocity, along ``way`` before, comes to zero in (0, t] under ``d + w exp(-decay t)``; it does before t.

    Newton's method within a bracket that shrinks.
    """
    low, high, time = 0.0, t, t * 0.5
    for _ in range(60):
        speed, pull = pull_at(v, d, w, alpha, beta, decay, time)
        if speed == 0.0:
            break
        if speed * way > 0.0:
            low = time
        else:
            high = time
        step = time - speed / pull if pull != 0.0 else 0.5 * (low + high)
        if not low < step < high:
            step = 0.5 * (low + high)
        if abs(step - time) <= 1e-16:
            break
        time = step
    return time


def slowest_time(v, d, w, way, alpha, beta, decay, t):
    """When a knob that first slows and then gains speed within ``t`` is slowest: bisection of its acceleration."""
    low, high = 0.0, t
    for _ in range(60):
        time = 0.5 * (low + high)
        _speed, pull = pull_at(v, d, w, alpha, beta, decay, time)
        if pull * way < 0.0:
            low = time
        else:
            high = time
    return 0.5 * (low + high)


def release_time(free, w, phi, decay):
    """When a knob that sticks under ``free``, of which ``w`` decays, comes loose; -1 if it never does."""
    rest = free - w
    if w == 0.0 or abs(rest) <= phi:
        return -1.0
    share = ((phi if rest > 0.0 else -phi) - free) / w
    return -log1p(share) / decay if share < 0.0 else 0.0


def way_under(free, phi):
    """Which way a knob at rest moves under a drive; 0 where friction holds it."""
    if abs(free) <= phi:
        return 0.0
    return 1.0 if free > 0.0 else -1.0


def set_off(free, w, phi, decay, left):
    """Which way a knob that sticks comes loose within ``left``, and when: ``(way, time)``, way 0 if it does not.

    It sticks, or not, under ``free``, and under ``w`` beside that, which decays.
    """
    way = way_under(free + w, phi)
    if way != 0.0:
        return way, 0.0
    time = release_time(free + w, w, phi, decay)
    if time < 0.0 or time >= left:
        return 0.0, left
    return (1.0 if free > 0.0 else -1.0), time


def follow_with_friction(pull, plant, first, speed, angle, slopes):
    """Angle at every sample, and its derivatives by alpha, beta and phi at a fixed gain, with Coulomb friction.

    All is given as to `follow_torque`. The knob sticks where the velocity is zero and the net drive at most ``phi``;
    what fades within a hold can let it go there. Where it turns, the derivatives jump as the acceleration does (the
    instant of turning moves); where it comes loose, nothing jumps. A fading torque can turn it for a part of a hold:
    one such dip is looked for, where the acceleration's sign tells of it. Fills ``angle`` (n,) rad and ``slopes``
    (n, 3), or (n, 5): by first angle and speed, too.
    """
    torque, fading, decay = pull
    gain, alpha, beta, phi = plant
    whole = hold_derivatives(alpha, beta, decay, 1.0)
    x, v, xa, va, xb, vb, xf, vf = first, speed, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    xx, vx, xv, vv = 1.0, 0.0, 0.0, 1.0
    free_start, lagging = slopes.shape[1] > 3, len(fading) > 0
    way = 0.0  # direction of slip, 0 where it sticks
    if v != 0.0:
        way = 1.0 if v > 0.0 else -1.0
    for i in range(len(torque)):
        angle[i], slopes[i, 0], slopes[i, 1], slopes[i, 2] = x, xa, xb, xf
        if free_start:
            slopes[i, 3], slopes[i, 4] = xx, xv
        left, w = 1.0, gain * fading[i] if lagging else 0.0
        for _ in range(EVENTS):
            if not left > 0.0:
                break
            free = gain * torque[i] - beta * x
            if way == 0.0:
                way, time = set_off(free, w, phi, decay, left)
                if way == 0.0:
                    break
                left -= time
                w *= exp(-decay * time)
            d = free - phi * way
            time, turns = left, False
            part = whole if left == 1.0 else hold_derivatives(alpha, beta, decay, left)
            if (part[2] * v + part[0] * d + part[4] * w) * way < 0.0:
                turns = True
                time = turning_time(v, d, w, way, alpha, beta, decay, left)
            elif w != 0.0 and v != 0.0 and (d + w - alpha * v) * way < 0.0:
                _speed, pull = pull_at(v, d, w, alpha, beta, decay, left)
                if pull * way > 0.0:
                    slowest = slowest_time(v, d, w, way, alpha, beta, decay, left)
                    least, _pull = pull_at(v, d, w, alpha, beta, decay, slowest)
                    if least * way < 0.0:
                        turns = True
                        time = turning_time(v, d, w, way, alpha, beta, decay, slowest)
            if turns:
                part = hold_derivatives(alpha, beta, decay, time)
            s, g, f, q, r, sa, ga, fa, qa, ra, sb, gb, fb, qb, rb = part
            da, db, df = -beta * xa, -x - beta * xb, -way - beta * xf
            xa += sa * v + s * va + ga * d + g * da + qa * w
            va = fa * v + f * va + sa * d + s * da + ra * w
            xb += sb * v + s * vb + gb * d + g * db + qb * w
            vb = fb * v + f * vb + sb * d + s * db + rb * w
            xf += s * vf + g * df
            vf = f * vf + s * df
            if free_start:
                dx, dv = -beta * xx, -beta * xv
                xx += s * vx + g * dx
                vx = f * vx + s * dx
                xv += s * vv + g * dv
                vv = f * vv + s * dv
            x += s * v + g * d + q * w
            v = f * v + s * d + r * w
            left -= time
            if w != 0.0:
                w *= exp(-decay * time)
            if turns:
                free = gain * torque[i] - beta * x + w
                before = free - phi * way
                way = way_under(free, phi)
                after = free - phi * way if way != 0.0 else 0.0
                jump = after / before if before != 0.0 else 0.0
                v, va, vb, vf = 0.0, va * jump, vb * jump, vf * jump
                vx, vv = vx * jump, vv * jump
