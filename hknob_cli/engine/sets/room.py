"""Work space of the sets of one cell, and the slots of it."""

from typing import Any, NamedTuple

import numpy as np

CAPACITY = 1024  # distinct ends that a cell keeps
POINTS = 16_384  # samples of orbits at which balls are compared with them
PIECES = 4096  # arcs that wait to be followed


class Known(NamedTuple):
    """The ends of a cell that are known so far.

    ``table``: as `engine.ensemble` has it, ten numbers a row, the share in place of a number of trials; ``lines``: their
    delay lines; ``points``: row, x and v of samples of proven orbits where the wall steps deeper, ``point_lines`` their
    delay lines; ``counts``: rows, points.
    """

    table: Any
    lines: Any
    points: Any
    point_lines: Any
    counts: Any


class ArcRoom(NamedTuple):
    """Work space of `sets.arc`: ``stack``, ``rings`` of arcs that wait; ``ring``, ``spare`` of one; ``cuts`` its parts."""

    stack: Any
    rings: Any
    ring: Any
    spare: Any
    cuts: Any


def make_arc_room(delay: int) -> ArcRoom:
    """Room for the arcs of a cell with a delay line of ``delay`` commands."""
    return ArcRoom(
        stack=np.zeros(9 * PIECES),
        rings=np.zeros(max(1, PIECES * delay)),
        ring=np.zeros(delay),
        spare=np.zeros(delay),
        cuts=np.zeros(3 * 1024),
    )


def make_known(delay: int) -> Known:
    """Room for the ends of a cell with a delay line of ``delay`` commands."""
    return Known(
        table=np.zeros(10 * (CAPACITY + 1)),
        lines=np.zeros(max(1, (CAPACITY + 1) * delay)),
        points=np.zeros(3 * POINTS),
        point_lines=np.zeros(max(1, POINTS * delay)),
        counts=np.zeros(2),
    )


class PolygonRoom(NamedTuple):
    """Work space of `sets.polygon`."""

    stack: Any
    ring: Any
    spare: Any
    own: Any
    corners: Any
    parts: Any
    moved: Any
    used: Any
    keys: Any
    cells: Any
    singles: Any
    many: Any
    coarse: Any


def make_polygon_room(stack=300_000, cells=2**19) -> PolygonRoom:
    z = np.zeros
    return PolygonRoom(z(31*stack), z(0), z(0), z(31), z(64), z(96), z(64), z(cells, dtype=np.bool_), z(2*cells), z(5*cells), z(31*cells), z(1, dtype=np.int64), z(1)+0.1)
