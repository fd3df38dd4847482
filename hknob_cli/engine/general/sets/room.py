"""Work space of the sets of one cell of the general loop: arrays for compiled code, lists for the interpreter."""

from collections.abc import Callable
from typing import Any, NamedTuple

from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.laws.law import Law
from hknob_cli.engine.general.sets.arc_parts import arc_size
from hknob_cli.engine.general.sets.lattice import CELL, KEY
from hknob_cli.engine.general.sets.piece import CORNERS, piece_size
from hknob_cli.engine.general.torque_table import HEAD

ARCS = 4096  # that wait to be followed
CELLS = 2**17  # of a lattice
DEEP = 2**14  # pieces that wait beside those of a lattice

Zeros = Callable[[int], Any]


class TurnRoom(NamedTuple):
    """Work space of `turns` and `parts`, where an encoder has hysteresis.

    ``course``: lengths and torques of the holds of an interval; ``swing``: how far one motion goes; ``places``, five a
    corner, and ``bounds``: how far those of a piece do; the next four: corners of it, and of its parts.
    """

    course: Any
    swing: Any
    places: Any
    bounds: Any
    kept: Any
    packed: Any
    whole: Any
    strip: Any
    z: Any
    other: Any
    ring: Any
    pad: Any


class PieceRoom(NamedTuple):
    """Work space of `piece`, `box` and `lattice`.

    ``stack``: pieces that wait; ``own``, ``own_z``, ``own_ring``, ``corners``: of the one that is followed; ``parts``
    to ``pad``: of one that is moved; ``used``, ``keys``, ``cells``, ``singles``: the lattice; ``taken``: its slots in
    use, ``counts[0]`` many; ``scale[0]``: of commands, where they are told apart.
    """

    stack: Any
    own: Any
    own_z: Any
    own_ring: Any
    corners: Any
    parts: Any
    halves: Any
    moved: Any
    middle: Any
    z: Any
    ring: Any
    matrix: Any
    spare: Any
    pad: Any
    used: Any
    keys: Any
    cells: Any
    singles: Any
    taken: Any
    counts: Any
    scale: Any


class ArcRoom(NamedTuple):
    """Work space of `arc`.

    ``stack``: arcs that wait; ``own_z``, ``own_ring``: centre of the one that is followed; ``rate``: of the curve of
    first states, at phase 0; ``below``, ``above``: ends of the arc; ``ended``: low and high phase, and row of the end,
    -1 without one, of the first arcs that ended. The others are work space.
    """

    stack: Any
    own_z: Any
    own_ring: Any
    rate: Any
    speed: Any
    turn: Any
    below: Any
    above: Any
    z: Any
    ring: Any
    matrix: Any
    power: Any
    spare: Any
    pad: Any
    ended: Any


def make_turn_room(zeros: Zeros, order: int, delay: int, wall: Controller, law: Law | None) -> TurnRoom | None:
    """Room for turning points where the encoder has hysteresis; None without."""
    if wall.hysteresis == 0.0:
        return None
    return TurnRoom(
        course=zeros(2 * max(2, 0 if law is None else law.pieces)),
        swing=zeros(8),
        places=zeros(5 * 4 * CORNERS),
        bounds=zeros(11),
        kept=zeros(4 * CORNERS * (order + 2)),
        packed=zeros(4 * CORNERS * (order + 2)),
        whole=zeros(2 * CORNERS * (order + 2)),
        strip=zeros(4 * CORNERS * (order + 2)),
        z=zeros(order),
        other=zeros(order),
        ring=zeros(delay),
        pad=zeros(2 * order),
    )


def make_piece_room(zeros: Zeros, order: int, delay: int, *, lattice: int = CELLS, deep: int = DEEP) -> PieceRoom:
    """Room for the pieces of a cell; those whose states differ in more than two numbers are not merged.

    ``lattice``: cells of the lattice, twice as many as it may hold; ``deep``: pieces that may wait beside them.
    """
    size, cells = piece_size(order, delay), lattice
    return PieceRoom(
        stack=zeros(size * (deep + cells)),
        own=zeros(size),
        own_z=zeros(order),
        own_ring=zeros(delay),
        corners=zeros(2 * CORNERS * order),
        parts=zeros(8 * CORNERS * order),
        halves=zeros(4 * CORNERS * order),
        moved=zeros(4 * CORNERS * order),
        middle=zeros(order),
        z=zeros(order),
        ring=zeros(delay),
        matrix=zeros(order * order),
        spare=zeros(order * order),
        pad=zeros(2 * order),
        used=zeros(cells),
        keys=zeros((KEY + delay) * cells),
        cells=zeros(CELL * cells),
        singles=zeros(size * cells),
        taken=zeros(cells),
        counts=zeros(1),
        scale=zeros(1),
    )


def make_arc_room(zeros: Zeros, order: int, delay: int) -> ArcRoom:
    """Room for the arcs of a cell."""
    return ArcRoom(
        stack=zeros(arc_size(order, delay) * ARCS),
        own_z=zeros(order),
        own_ring=zeros(delay),
        rate=zeros(order),
        speed=zeros(order),
        turn=zeros(order),
        below=zeros(order),
        above=zeros(order),
        z=zeros(order),
        ring=zeros(delay),
        matrix=zeros(order * order),
        power=zeros(order * order),
        spare=zeros(order),
        pad=zeros(2 * order),
        ended=zeros(3 * ARCS),
    )


def hash_scale(wall: Controller) -> float:
    """By which commands are multiplied where they are told apart by whole numbers, roughly."""
    if wall.table is not None:
        most = max(abs(float(value)) for value in wall.table[HEAD : HEAD + (len(wall.table) - HEAD) // 3])
        return 2.0**15 / most if most > 0.0 else 1.0
    return 8.0 / wall.kappa if wall.kappa > 0.0 else 1.0
