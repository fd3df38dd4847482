"""The ends of a cell that its sets of states came to, and why some came to none that is proven."""

from collections.abc import Callable
from typing import Any, NamedTuple

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.period_map import Space
from hknob_cli.engine.general.search import GENERAL_FATES, attractor_of
from hknob_cli.engine.general.sets.known import NO_ROOM
from hknob_cli.engine.general.sets.piece import WEIGHT
from hknob_cli.engine.general.sets.room import PieceRoom, TurnRoom
from hknob_cli.engine.outcome import Reason

ENDS = 512  # distinct ends that a cell keeps
FATES = 16  # of ends
POINTS = 16_384  # samples of proven orbits at which sets are compared with them

Zeros = Callable[[int], Any]


class Known(NamedTuple):
    """The ends of a cell that are known so far.

    ``table``, ``states``, ``lines``: as in `general.ensemble.run_trials`, with the measure of the starts that reach a
    row, not the number of trials. ``points``: row, last reading, state, and commands under way of samples of proven
    orbits where the wall steps deeper. ``counts``: of rows and of points. ``why``: measure of the starts without
    a proven end, by the fate that is none. ``law``: of a controller, None without one; commands under way are all that
    it remembers, then. ``turns``: None without hysteresis of the encoder. The others are work space of a trial.
    """

    table: Any
    states: Any
    lines: Any
    points: Any
    counts: Any
    why: Any
    z: Any
    ring: Any
    check: Any
    check_ring: Any
    keep: Any
    keep_ring: Any
    space: Space
    law: Any = None
    turns: TurnRoom | None = None


def make_known(zeros: Zeros, order: int, delay: int, space: Space, law: Any = None) -> Known:
    """Room for the ends of a cell of this order and number of commands under way, or numbers that a law remembers."""
    return Known(
        table=zeros(FIELDS * ENDS),
        states=zeros(order * ENDS),
        lines=zeros(max(1, delay * ENDS)),
        points=zeros((order + delay + 2) * POINTS),
        counts=zeros(2),
        why=zeros(FATES),
        z=zeros(order),
        ring=zeros(delay),
        check=zeros(order),
        check_ring=zeros(delay),
        keep=zeros(order),
        keep_ring=zeros(delay),
        space=space,
        law=law,
    )


def why_not(known: Known) -> Reason:
    """Why most of the starts without a proven end have none; `Reason.NONE` where all have one."""
    measure, fate = max((float(weight), fate) for fate, weight in enumerate(known.why))
    if measure == 0.0:
        return Reason.NONE
    return Reason.TOO_MANY if fate == NO_ROOM else GENERAL_FATES[fate][1]


def ends_of(known: Known, order: int, delay_line: int) -> list[Attractor]:
    """The ends that are known, with their shares."""
    return [
        attractor_of(
            known.table[FIELDS * row : FIELDS * (row + 1)],
            [float(value) for value in known.states[row * order : (row + 1) * order]],
            [float(value) for value in known.lines[row * delay_line : (row + 1) * delay_line]],
            Reason.NO_REPEAT,
        )
        for row in range(int(known.counts[0]))
    ]


def measure_left(room: PieceRoom, waiting: int, size: int) -> float:
    """Measure of the starts that wait, in pieces of so many numbers or in the lattice: a bound on it."""
    left = sum(room.stack[k * size + WEIGHT] for k in range(int(waiting)))
    left += sum(room.singles[int(room.taken[k]) * size + WEIGHT] for k in range(int(room.counts[0])))
    return float(left)
