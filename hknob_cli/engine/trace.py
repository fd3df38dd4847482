"""One period of an orbit, hold by hold: what the measures are taken from."""

from typing import Any, NamedTuple

from hknob_cli.engine.loop import copy_line, level_of, push


class Holds(NamedTuple):
    """The holds of one period of an orbit, lists or arrays; counts and sample periods.

    ``x``, counts, and ``v``, counts per sample: state at the start of each and, last, at the end; ``drive``, counts per
    sample²: what accelerates the knob in each beside spring and damping, one entry less.
    """

    x: Any
    v: Any
    drive: Any


def holds_per_sample(loop):
    """Holds in a sample interval: two where a delay splits it."""
    return 2 if loop.split > 0.0 else 1


def trace(x, v, ring, head, n, loop, holds):
    """Fill in the holds of ``n`` samples from ``(x, v)``: the state at the start of each, and the drive in it.

    ``holds`` takes n times `holds_per_sample` of them; the last state closes the period. Returns the sums of the
    positions at which holds start, and of the drives.
    """
    xs, vs, drive = holds
    delay = len(ring)
    line = copy_line(ring)
    at, hold = head, 0
    split = loop.split > 0.0
    places, drives = 0.0, 0.0
    for _ in range(n):
        older, newer = push(level_of(x, loop.sense), line, at, loop)
        if split:
            xs[hold], vs[hold], drive[hold] = x, v, older
            places, drives = places + x, drives + older
            hold += 1
            y = older - loop.beta * x
            x, v = x + (loop.s1 * v + loop.g1 * y), loop.f1 * v + loop.s1 * y
        xs[hold], vs[hold], drive[hold] = x, v, newer
        places, drives = places + x, drives + newer
        hold += 1
        y = newer - loop.beta * x
        x, v = x + (loop.s2 * v + loop.g2 * y), loop.f2 * v + loop.s2 * y
        if delay > 0:
            at = (at + 1) % delay
    xs[hold], vs[hold] = x, v
    return places, drives
