"""The kinds of holds of a period, and the numbers of each: one kind a sample, or two where a delay splits it.

The numbers lie flat, `PART` a kind, in the order in which the kinds follow one another in a sample interval.
"""

from hknob_cli.engine.orbit.forms import hold_forms
from hknob_cli.engine.propagator import hold_coefficients

LENGTH, S, G = 0, 1, 2  # of the hold, and its coefficients
MEAN, SQUARE, SPEED = 3, 6, 12  # forms of `orbit.forms`
PART = 18


def fill_part(parts, kind, alpha, beta, length):
    """Fill in the numbers of one ``kind`` of hold."""
    base = kind * PART
    parts[base + LENGTH] = length
    parts[base + S], parts[base + G], _ = hold_coefficients(alpha, beta, length)
    forms = hold_forms(alpha, beta, length)
    for i in range(len(forms)):
        parts[base + MEAN + i] = forms[i]


def fill_parts(parts, loop):
    """Fill in the numbers of the holds of a loop."""
    if loop.split > 0.0:
        fill_part(parts, 0, loop.alpha, loop.beta, loop.split)
        fill_part(parts, 1, loop.alpha, loop.beta, 1.0 - loop.split)
    else:
        fill_part(parts, 0, loop.alpha, loop.beta, 1.0)
