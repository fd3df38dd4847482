"""Motion from slope to slope of cogging: mode after mode, and written down.

As in `slide_many` a step is halved until it can be shown what becomes of the mode in it.
"""

from hknob_cli.engine.general.body import (
    CONSTANT,
    ENTRY,
    HALVES,
    HALVES_HELD,
    HALVINGS,
    RATES,
    acceleration,
    norm_at,
    rate_of,
    stiffness,
)
from hknob_cli.engine.general.cogging import (
    COGGED_HALVES,
    FALLEN,
    FREE,
    RISEN,
    ROOT,
    STABLE,
    TURNED,
    UNSTABLE,
    cog_number,
    corner_passed,
    corner_told,
    far_apart,
    is_stable,
    least_share,
    pull_on,
    room_on,
    slope_at,
)
from hknob_cli.engine.general.flanks import STILL
from hknob_cli.engine.general.slide_many import (
    FINEST,
    SHORTEST,
    accept,
    held_bound,
    held_slope,
    keeps_sign,
    outlook,
    stretch,
)
from hknob_cli.engine.loop import floor

NARROWEST = 16  # halvings of a sample period to which it is looked whether a motion stays over a bound


def stiff_of(body):
    """Bound on the acceleration of the knob by springs, dampers and a torque that lags, by `cogging.size_at`."""
    return stiffness(body) + cog_number(body.cogs, ROOT) + body.lag


def cog_acceleration(z, u, slope, body):
    """Acceleration of the knob without friction."""
    return acceleration(z, u, body) + pull_on(z[0], slope, body.cogs)


def cog_rate(z, u, slope, mode, body, out):
    """As `body.rate_of`, on a slope."""
    rate_of(z, u, mode, body, out)
    if mode != 0:
        pull = pull_on(z[0], slope, body.cogs)
        for i in range(body.order):
            out[i] += body.vectors[ENTRY * body.order + i] * pull


def speed_rate(z, at, u, slope, mode, body):
    """Rate of the speed of the state that begins at ``z[at]``, sliding: as `cog_rate` computes it, to the last bit."""
    n = body.order
    extra = -mode * body.friction
    if body.lag == 0.0:
        extra += u
    total = body.vectors[CONSTANT * n + 1] + body.vectors[ENTRY * n + 1] * extra
    for j in range(n):
        total += body.matrices[RATES * n * n + n + j] * z[at + j]
    return total + body.vectors[ENTRY * n + 1] * pull_on(z[at], slope, body.cogs)


def way_from_rest(z, at, u, slope, body):
    """Mode of a knob at rest in the state that begins at ``z[at]``: +1 or -1 if it then slides on, 0 if friction holds.

    The rate with which it would slide decides. Another sum of the same torques may round to the other side, and a knob
    that is held by one and let go by the other would hardly go on.
    """
    for mode in (1, -1):
        if speed_rate(z, at, u, slope, mode, body) * mode > 0.0:
            return mode
    return 0


def halves_on(slope, mode, body):
    """Where the matrices begin that move a state in a mode on a slope."""
    if mode == 0:
        return HALVES_HELD
    if body.cogs is None or not len(body.cogs):
        return HALVES
    return COGGED_HALVES if is_stable(slope) else COGGED_HALVES + HALVINGS


def outlook_on(cogs, z, u, slope, mode, body, pad):
    """As `slide_many.outlook`, on a slope: ``(value, fall, bound)``; `least_share` tells how the bound grows there."""
    if cogs is None or not len(cogs):
        value, _, fall, bound = outlook(z, u, mode, body, pad)
        return value, fall, bound
    cog_rate(z, u, slope, mode, body, pad)
    if mode == 0:
        value = body.friction - abs(cog_acceleration(z, u, slope, body))
        return value, -abs(held_slope(pad, body)), held_bound(pad, body)
    size = norm_at(pad, 0, body) + cogs[ROOT] * abs(pad[0])
    return z[1] * mode, min(pad[1] * mode, 0.0), size * stiff_of(body)


def stays_over(z, u, slope, mode, span, need, body, pad):
    """Whether a speed, sliding from ``z`` on, stays over ``need``; held, what friction can hold beside the torque.

    By halving, as `slide_many`; ``z`` is moved along. Without cogging any slope will do.
    """
    half, left = 0, floor(span * FINEST) / FINEST
    table = halves_on(slope, mode, body)
    while left > 0.0:
        h = 0.5**half
        while h > left:
            half += 1
            h *= 0.5
        value, fall, bound = outlook_on(body.cogs, z, u, slope, mode, body, pad)
        value -= need
        deepest, told = max(half, NARROWEST), False
        while not told:
            share = least_share(body.cogs, slope, h) if mode != 0 else 1.0
            told = share > 0.0 and keeps_sign(value, fall, bound / share, h)
            if not told:
                half += 1
                h *= 0.5
                if not value > 0.0 or half > deepest:
                    return False
        stretch(z, pad, table + half, body)
        accept(z, pad, body.order)
        left -= h
        if half > 0:
            half -= 1
    return True


def held_told(z, u, pad, slope, h, body):
    """Whether it can be told what becomes of a knob that friction holds within ``h``: nothing, or a release, once."""
    rate = held_slope(pad, body)
    bound = held_bound(pad, body)
    value = body.friction - abs(cog_acceleration(z, u, slope, body))
    return bound == 0.0 or keeps_sign(value, -abs(rate), bound, h) or abs(rate) > bound * h


def told(z, u, pad, slope, mode, h, size, body):
    """Whether at most one thing happens within ``h``, and once: a corner is passed, or the mode ends.

    ``pad`` has the rates in its first half; ``size`` bounds the root of their energy now.
    """
    if mode == 0:
        return held_told(z, u, pad, slope, h, body)
    if size == 0.0:
        return True  # nothing moves
    share = least_share(body.cogs, slope, h)
    if share == 0.0:
        return False
    pace = size / share
    if not corner_told(body.cogs, z[0], pad[0], pace, slope, mode, h):
        return False
    if mode == FREE:
        return True
    bend = pace * (stiffness(body) + body.cogs[ROOT])
    if body.lag > 0.0:
        bend += abs(pad[body.order - 1])
    rate = pad[1] * mode
    return keeps_sign(z[1] * mode, rate, bend, h) or abs(rate) > bend * h


def over(pad, u, slope, mode, body):
    """Which end the state in the second half of ``pad`` is past; 0 of none."""
    n = body.order
    x, v = pad[n], pad[n + 1]
    if mode == 0:
        return TURNED if way_from_rest(pad, n, u, slope, body) != 0 else 0
    if mode != FREE and v * mode < 0.0:
        return TURNED
    return corner_passed(body.cogs, x, v, slope)


def roll_in_steps(z, u, slope, mode, left, fresh, body, pad):
    """Move ``z`` on one slope in one ``mode`` until either ends or ``left`` is over: ``(time, end, steps)``.

    ``fresh``: whether it begins where another has ended: what is then too near to be told is taken after 2^-20 of a
    sample. An end is left past it, by the last bit of a sample period.
    """
    n = body.order
    total, half, steps = 0.0, 0, 0
    left = floor(left * FINEST) / FINEST
    table = HALVES_HELD
    if mode != 0:
        table = COGGED_HALVES if is_stable(slope) else COGGED_HALVES + HALVINGS
    root = body.cogs[ROOT]
    while left > 0.0 and not body.halt[0] > 0.0:
        steps += 1
        h = 0.5**half
        while h > left:
            half += 1
            h *= 0.5
        cog_rate(z, u, slope, mode, body, pad)
        size = norm_at(pad, 0, body) + root * abs(pad[0])
        deepest = SHORTEST if fresh else HALVINGS - 1
        clear = told(z, u, pad, slope, mode, h, size, body)
        while not clear and half < deepest:
            half += 1
            h *= 0.5
            clear = told(z, u, pad, slope, mode, h, size, body)
        stretch(z, pad, table + half, body)
        ended = over(pad, u, slope, mode, body)
        if ended > 0 and (clear or not fresh):
            for deeper in range(half + 1, HALVINGS):
                cog_rate(z, u, slope, mode, body, pad)
                stretch(z, pad, table + deeper, body)
                sooner = over(pad, u, slope, mode, body)
                if sooner > 0:
                    ended = sooner
                else:
                    accept(z, pad, n)
                    total += 0.5**deeper
            cog_rate(z, u, slope, mode, body, pad)
            stretch(z, pad, table + HALVINGS - 1, body)
            accept(z, pad, n)
            return total + 0.5 ** (HALVINGS - 1), ended, steps + HALVINGS
        accept(z, pad, n)
        total += h
        left -= h
        fresh = False
        if ended > 0:
            return total, ended, steps
        if half > 0:
            half -= 1
    return total, 0, steps


def roll(z, u, slope, mode, left, fresh, body, pad):
    """As `roll_in_steps`: ``(time, end)``."""
    t, end, _ = roll_in_steps(z, u, slope, mode, left, fresh, body, pad)
    return t, end


def way_from(z, u, slope, body):
    """Mode of the motion that begins at ``z`` where its turning points matter: +1 or -1 sliding, 0 held."""
    if z[1] == 0.0:
        return way_from_rest(z, 0, u, slope, body)
    return 1 if z[1] > 0.0 else -1


def settled(cogs, z, u, slope, span, body, pad):
    """Whether a knob that nothing rubs has settled on its slope, and how far it moves at most: ``(whether, way)``.

    Its turning points are roundings then. Its rates are a motion without a torque, whose energy bounds the way.
    """
    if body.friction > 0.0:
        return False, 0.0
    cog_rate(z, u, slope, FREE, body, pad)
    moved = far_apart(cogs, pad, z[0], body) * span
    return moved <= STILL * (1.0 + abs(z[0])) and moved < room_on(z[0], slope, cogs), moved


def pass_on(z, u, slope, mode, end, body):
    """Slope and mode after ``end``."""
    if end == RISEN:
        return slope + 1.0, mode
    if end == FALLEN:
        return slope - 1.0, mode
    if mode == 0:
        return slope, 1 if cog_acceleration(z, u, slope, body) > 0.0 else -1
    z[1] = 0.0
    return slope, way_from_rest(z, 0, u, slope, body)


def cog_many(cogs, z, u, span, body, pad):
    """Move ``z`` over any time up to a sample period from corner to corner; with friction from event to event."""
    if cogs is None or not len(cogs):
        return
    left = span
    slope = slope_at(z[0], cogs)
    mode = way_from(z, u, slope, body) if body.friction > 0.0 else FREE
    fresh = mode != 0 and z[1] == 0.0
    while left > 0.0:
        t, end = roll(z, u, slope, mode, left, fresh, body, pad)
        left -= t
        if end == 0:
            break
        slope, mode = pass_on(z, u, slope, mode, end, body)
        fresh = True


def cog_chart(cogs, z, u, span, body, pad, rows, pieces):
    """As `trace.chart`, from corner to corner; modes are by the sign of the speed `STABLE` or `UNSTABLE`, 0 held."""
    if cogs is None or not len(cogs):
        return rows
    n = body.order
    left = span
    slope = slope_at(z[0], cogs)
    mode = way_from(z, u, slope, body)
    fresh = mode != 0 and z[1] == 0.0
    while left > 0.0 and rows < len(pieces.spans):
        for j in range(n):
            pieces.states[rows * n + j] = z[j]
        t, end = roll(z, u, slope, mode, left, fresh, body, pad)
        left -= t
        if t > 0.0:
            pieces.spans[rows], pieces.commands[rows] = t, u
            pieces.modes[rows] = mode * (STABLE if is_stable(slope) else UNSTABLE)
            rows += 1
        if end == 0:
            break
        slope, mode = pass_on(z, u, slope, mode, end, body)
        fresh = True
    for j in range(n):
        pieces.states[rows * n + j] = z[j]
    return rows
