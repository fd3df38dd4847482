"""One period of an orbit, hold by hold: what the measures are taken from."""

from hknob_cli.engine.loop import interval, level_of, push


def trace(x, v, ring, head, n, loop, xs, vs, older, newer):
    """Fill in, for ``n`` samples from ``(x, v)``, the state at each sample and the drives of its interval.

    ``xs`` and ``vs`` take n + 1 entries (the last closes the period), ``older`` and ``newer`` take n.
    """
    delay = len(ring)
    line = ring.copy()
    at = head
    for i in range(n):
        xs[i], vs[i] = x, v
        older[i], newer[i] = push(level_of(x, loop.sense), line, at, loop)
        x, v = interval(x, v, older[i], newer[i], loop)
        if delay > 0:
            at = (at + 1) % delay
    xs[n], vs[n] = x, v
