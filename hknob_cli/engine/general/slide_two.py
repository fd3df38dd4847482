"""Sliding of a second-order body: the zeros of its velocity have a closed form."""

from math import expm1, floor, log

from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero

SERIES = 6  # where the series begin in `Body.vectors`
MANY_TURNS = 8.0  # half cycles of ringing left in a hold beyond which they are taken in one


def coefficients(t, body):
    """(S, G, F) over a time ``t``, as `propagator.hold_coefficients`: up to a sample period by a series."""
    n = body.terms
    if n == 0 or t > 1.0:
        return hold_coefficients(body.alpha, body.beta, t)
    s, g = 0.0, 0.0
    for k in range(n - 1, -1, -1):
        s = s * t + body.vectors[SERIES + k]
        g = g * t + body.vectors[SERIES + n + k]
    s, g = s * t, g * t * t
    return s, g, 1.0 - body.beta * g - body.alpha * s


def skip_turns(x, drive, left, body):
    """Take a whole number of half cycles from a standstill at once, all but the last few: ``(x, time)``.

    At its turning points a ringing knob is A from where it would rest without friction, and A falls to r A - (1 + r) q
    per half cycle, q = friction / stiffness, r = exp(-alpha/2 spacing).
    """
    rest = drive / body.beta
    q = body.friction / body.beta
    away = abs(x - rest)
    k = 0.5 * body.alpha * body.spacing
    if k > 0.0:
        fall = -expm1(-k)
        bound = (2.0 - fall) * q / fall
        last = log((away + bound) / (q + bound)) / k
    else:
        last = (away - q) / (2.0 * q)
    turns = floor(min(last, left / body.spacing)) - 2.0
    if turns < 1.0:
        return x, 0.0
    if k > 0.0:
        decay = expm1(-k * turns)
        away = (decay + 1.0) * away - q * (2.0 + expm1(-k)) * decay / expm1(-k)
    else:
        away -= 2.0 * q * turns
    side = 1.0 if x > rest else -1.0
    if turns % 2.0 != 0.0:
        side = -side
    return rest + side * away, turns * body.spacing


def way(v, pull, friction):
    """Mode of the motion that begins at speed ``v`` under ``pull``: +1 or -1 sliding, 0 held."""
    if v > 0.0:
        return 1
    if v < 0.0:
        return -1
    if abs(pull) <= friction:
        return 0
    return 1 if pull > 0.0 else -1


def until_zero(x, v, drive, mode, left, sgf, known, body):
    """Coefficients (s, g, f) and length of the slide from (x, v) until the velocity vanishes or ``left`` is over.

    ``drive`` holds all constant torques, friction included. ``sgf``: the coefficients over ``left`` if ``known``.
    Returns ``(sgf, time, whether it vanished)``.
    """
    s, _, f = sgf
    y = drive - body.beta * x
    if known and body.spacing >= left and (f * v + s * y) * mode >= 0.0:
        return sgf, left, False
    t = first_zero(v, y, body.alpha, body.beta)
    if t >= left:
        if not known:
            sgf = coefficients(left, body)
        return sgf, left, False
    return coefficients(t, body), t, True


def step_with_friction(x, v, u, span, s, g, f, body):
    """Second order, with friction: the state after a hold of length ``span``, whose coefficients are (s, g, f)."""
    beta, friction = body.beta, body.friction
    free = u + body.drive
    mode = way(v, free - beta * x, friction)
    if mode == 0:
        return x, 0.0
    drive = free - mode * friction
    y = drive - beta * x
    slow = f * v + s * y
    if body.spacing >= span and slow * mode > 0.0:
        return x + (s * v + g * y), slow
    left = span
    known = True
    while left > 0.0 and mode != 0:
        if v == 0.0 and left > MANY_TURNS * body.spacing:
            x, t = skip_turns(x, free, left, body)
            if t > 0.0:
                left -= t
                known = False
                mode = way(v, free - beta * x, friction)
                continue
        drive = free - mode * friction
        y = drive - beta * x
        (s, g, f), t, ended = until_zero(x, v, drive, mode, left, (s, g, f), known, body)
        x, v = x + (s * v + g * y), f * v + s * y
        if ended or v * mode < 0.0:
            v = 0.0
        if not ended:
            break
        left -= t
        known = False
        mode = way(v, free - beta * x, friction)
    return x, v
