"""Work space of the sets of one cell: the same for compiled code, in arrays, and for the interpreter, in lists."""

from collections.abc import Callable
from typing import Any, NamedTuple

from hknob_cli.engine.sets.arc import ARC, PROGRESS
from hknob_cli.engine.sets.polygon import CELL, CORNERS, POLYGON

ENDS = 1024  # distinct ends that a cell keeps
POINTS = 16_384  # samples of proven orbits at which sets are compared with them
ARCS = 4096  # that wait to be followed
PARTS = 1024  # of one arc
CELLS = 2**18  # of a lattice
REGION_CORNERS = 2048  # of a region that moves on, and of what it becomes in a sample
POLYGONS = CELLS + 2**14  # that wait to be followed

Zeros = Callable[[int], Any]


class Known(NamedTuple):
    """The ends of a cell that are known so far.

    ``table``: as `engine.ensemble` has it, ten numbers a row, of which the number of trials is the measure of the
    starts that reach it; ``lines``: their delay lines. ``points``: row, x and v of samples of proven orbits where
    the wall steps deeper, in the order of x; ``point_lines`` their delay lines; ``margins``: of their orbits, less the
    bound on rounding.
    ``counts``: of rows and of points, and the largest of the margins.
    """

    table: Any
    lines: Any
    points: Any
    point_lines: Any
    margins: Any
    counts: Any


class ArcRoom(NamedTuple):
    """Work space of `sets.arc`.

    ``stack`` and ``rings``: of arcs that wait; ``ring``, ``spare``: of one; ``cuts``: its parts; ``ended``: low
    and high phase, and row of the end, -1 without one, of the first arcs that ended; ``progress``: how far a cell is.
    """

    stack: Any
    rings: Any
    ring: Any
    spare: Any
    cuts: Any
    ended: Any
    progress: Any


class PolygonRoom(NamedTuple):
    """Work space of `sets.polygon`.

    ``stack``: polygons that wait; ``own``, ``corners``, ``parts``, ``halves``, ``moved``: of one; ``ring``:
    empty, as a box has no delay line; ``used``, ``keys``, ``cells``, ``singles``: the lattice; ``taken``: its slots in
    use, ``counts[0]`` many.
    """

    stack: Any
    own: Any
    corners: Any
    parts: Any
    halves: Any
    moved: Any
    ring: Any
    used: Any
    keys: Any
    cells: Any
    singles: Any
    taken: Any
    counts: Any


class RegionRoom(NamedTuple):
    """Work space of `sets.region`.

    ``region``: its corners; ``cloud``, ``spare``: what they become in a sample; ``chain``, ``rough``: of the hulls.
    """

    region: Any
    cloud: Any
    spare: Any
    chain: Any
    rough: Any


def make_known(zeros: Zeros, delay: int) -> Known:
    """Room for the ends of a cell with a delay line of ``delay`` commands."""
    return Known(
        table=zeros(10 * (ENDS + 1)),
        lines=zeros(max(1, (ENDS + 1) * delay)),
        points=zeros(3 * POINTS),
        point_lines=zeros(max(1, POINTS * delay)),
        margins=zeros(POINTS),
        counts=zeros(3),
    )


def make_arc_room(zeros: Zeros, delay: int) -> ArcRoom:
    """Room for the arcs of a cell with a delay line of ``delay`` commands."""
    return ArcRoom(
        stack=zeros(ARC * ARCS),
        rings=zeros(max(1, ARCS * delay)),
        ring=zeros(delay),
        spare=zeros(delay),
        cuts=zeros(3 * PARTS),
        ended=zeros(3 * ARCS),
        progress=zeros(PROGRESS),
    )


def make_polygon_room(zeros: Zeros) -> PolygonRoom:
    """Room for the polygons of a cell."""
    return PolygonRoom(
        stack=zeros(POLYGON * POLYGONS),
        own=zeros(POLYGON),
        corners=zeros(2 * CORNERS),
        parts=zeros(8 * CORNERS),
        halves=zeros(4 * CORNERS),
        moved=zeros(4 * CORNERS),
        ring=zeros(0),
        used=zeros(CELLS),
        keys=zeros(2 * CELLS),
        cells=zeros(CELL * CELLS),
        singles=zeros(POLYGON * CELLS),
        taken=zeros(CELLS),
        counts=zeros(1),
    )


def make_region_room(zeros: Zeros) -> RegionRoom:
    """Room for a convex region that moves on."""
    return RegionRoom(*(zeros(2 * REGION_CORNERS) for _ in range(5)))
