"""The plant over one hold: its exact response to a constant torque, in closed form.

Everything in the engine is dimensionless: angle in encoder counts, time in sample periods. The plant is then

    x'' + alpha x' + beta x = drive,   alpha = b T / J,   beta = k T^2 / J,

and over a time ``t`` under a constant drive it goes, exactly, to

    y  = drive - beta x
    x+ = x + S v + G y
    v+ = F v + S y

The increment form keeps full accuracy when a hold is a millionth of a time constant, where a transition matrix
would be the identity plus rounding.
"""

from math import cos, exp, expm1, sin, sqrt


def hold_coefficients(alpha, beta, t):
    """Coefficients ``(S, G, F)`` of the plant's exact response over a time ``t``.

    ``alpha >= 0`` and ``beta >= 0`` are per sample period, ``t >= 0`` counts sample periods. ``S`` is the response
    of the position to a unit velocity, ``G`` to a unit constant acceleration, ``F`` of the velocity to a unit
    velocity. Relative accuracy is a few units in the last place, from the undamped to the overdamped plant: near the
    origin by Taylor series, elsewhere by forms whose terms do not cancel.

    Source: Phi and Gamma of Franklin, Powell & Workman, *Digital Control of Dynamic Systems*, sec. 4.3, for a
    second-order plant.
    """
    a = 0.5 * alpha * t
    c = beta * t * t
    if a <= 0.5 and c <= 1.0:
        # g'' + 2a g' + c g = 1 from rest, as a power series summed at 1: G is the value, S the slope.
        before, term = 0.0, 0.5
        g, s = term, 1.0
        n = 2
        while abs(term) + abs(before) > 1e-20:
            # Times the reciprocal: that does not wait for the term, as a division of it would.
            before, term = term, -(2.0 * a * n * term + c * before) * (1.0 / ((n + 1) * n))
            n += 1
            g += term
            s += n * term
        f = 1.0 - c * g - 2.0 * a * s
    elif a * a > c:
        r = sqrt(a * a - c)
        slow, fast = c / (a + r), a + r
        s = exp(-slow) * -expm1(-2.0 * r) / (2.0 * r)
        risen = -expm1(-slow) / slow if slow > 0.0 else 1.0
        g = (risen - s) / fast
        f = exp(-fast) - slow * s
    else:
        w = sqrt(c - a * a)
        decay = exp(-a)
        sinc = sin(w) / w if w > 0.0 else 1.0
        s = decay * sinc
        g = (1.0 - decay * (cos(w) + a * sinc)) / c
        f = decay * (cos(w) - a * sinc)
    return s * t, g * t * t, f


def slowest_rate(alpha, beta):
    """Decay rate of the slowest mode that decays at all, per sample period; 0 without damping.

    Without hand stiffness the position does not decay; the rate is then that of the velocity.
    """
    a = 0.5 * alpha
    if beta == 0.0:
        return alpha
    if a * a > beta:
        return beta / (a + sqrt(a * a - beta))
    return a
