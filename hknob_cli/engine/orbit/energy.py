"""Energy over one period: what the virtual wall puts in.

On a limit cycle it is what the damping takes out (bias and hand stiffness return what they take), alpha times the
integral of v²; the two are computed independently, so that their difference checks the orbit and its integrals.
"""

from hknob_cli.engine.orbit.holds import PART, G, S


def wall_work(x, v, drive, count, parts, kinds, beta, mean):
    """Work of the wall torque over ``count`` holds, in units of J (counts per sample)²: sum of torque times distance.

    The ``mean`` drive does no work over a period; without it the sum keeps its digits however deep the knob is pushed.
    """
    work = 0.0
    base, other = 0, (kinds - 1) * PART
    for i in range(count):
        work += (drive[i] - mean) * (parts[base + S] * v[i] + parts[base + G] * (drive[i] - beta * x[i]))
        base = other - base
    return work
