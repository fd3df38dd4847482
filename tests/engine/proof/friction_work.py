"""Little work space for tests of sets with friction, and a motion over a part of an interval that is told."""

from collections.abc import Callable
from math import inf
from types import SimpleNamespace
from typing import Any

from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.sets.cell import Cell, Centre
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.friction_set import ACTS, MOST, SET
from hknob_cli.engine.general.sets.friction_step import SLID, Hold, Room, Shape
from hknob_cli.engine.general.sets.piece import piece_size
from hknob_cli.engine.general.sets.room import make_piece_room

SQUARE = [-1.0, -0.5, 1.0, -0.5, 1.0, 0.5, -1.0, 0.5]


def zeros(count: int) -> list[float]:
    return [0.0] * count


def body_of(friction: float = 0.0, reach: float = 2.0) -> Any:
    """What is asked of a body of second order where another moves it."""
    return SimpleNamespace(
        order=2, friction=friction, reach=reach, beta=0.25, ratio=0.0, coil=0.0, lag=0.0, drive=0.0, halt=[0.0]
    )


def wall_of(**numbers: float) -> Controller:
    none = {"damping": 0.0, "truncate": 0.0, "analog": 0.0, "step": 0.0, "limit": inf, "split": 0.0}
    return Controller(**{**none, "kappa": 1.0, "sense": 1.0, "offset": 0.0, **numbers})


def drift_of(once: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0), blur: float = 0.0, bottom: float = -inf) -> Drift:
    """Nothing is rounded but what is stated."""
    return Drift(powers=[0.0], once=list(once), units=[0.0, 0.0], blur=blur, coast=0.0, bottom=bottom)


def law_of(looks: int, watch: Controller | None = None) -> Any:
    """A law that looks so often into an interval; two numbers that it remembers, then its looks."""
    return SimpleNamespace(looks=looks, rows=1, watch=watch or wall_of())


def work_of(sets: int = 32, delay: int = 0, looks: int = 0, course: list[float] | None = None, **more: Any) -> Any:
    """Room for so many sets within an interval."""
    work = SimpleNamespace(
        course=course or [], least=[0.0], sets=zeros((SET + looks) * sets), seen=zeros(looks),
        corners=zeros(8 * MOST + 4), one=zeros(2 * MOST), other=zeros(2 * MOST), space=zeros(8 * MOST + 12),
        line=zeros(3), acts=zeros(ACTS), lags=None, z=zeros(2), ring=zeros(delay), torques=zeros(max(2, delay)),
        moved=zeros(2), pad=zeros(4),
    )  # fmt: skip
    work.__dict__.update(more)
    return work


def cell_of(body: Any, drift: Drift, wall: Any, law: Any = None, **known: Any) -> Cell:
    """A cell of these, of whose ends nothing is told but what is ``known``."""
    return Cell(drift, SimpleNamespace(law=law, turns=None, **known), body, wall)


def centre_of(z: Any, ring: Any = (), before: float = 0.0, **more: Any) -> Centre:
    """A state that a set is told from."""
    given = {"head": 0, "error": 0.0, "level": 0.0, "sample": 0.0, "weight": 1.0, **more}
    return Centre(z=z, before=before, ring=ring, **given)


def room_of(pieces: int = 32, delay: int = 0) -> Any:
    room = make_piece_room(zeros, 2, delay, lattice=8, deep=8)
    return room._replace(stack=zeros(piece_size(2, delay) * pieces))


class Motion:
    """Moves a set over a part of an interval as told: ``(fate, corners)`` of each, then all slide and stay as they are.

    A part moves the centre by 1 in x and by 16 in v. ``told``: what each was asked.
    """

    def __init__(self, *script: tuple[int, list[float] | None], line: tuple[float, ...] = (1.0, 0.0, 0.0)) -> None:
        self.script, self.line = list(script), line
        self.told: list[tuple[Any, ...]] = []
        self.step = (1.0, 16.0)
        self.asked: Callable[[Any], tuple[int, list[float] | None]] | None = None

    def __call__(
        self, shape: Shape, u: float, hold: Hold, least: float, body: Any, room: Room
    ) -> tuple[int, float, float, int]:
        x, v, corners, count = shape
        self.told.append((x, v, u, *hold, list(corners[: 2 * count]), least))
        fate, after = self.script.pop(0) if self.script else (SLID, None)
        if self.asked is not None:
            fate, after = self.asked(least)
        room.line[:] = self.line
        if after is not None:
            corners[: len(after)] = after
            count = len(after) // 2
        return fate, x + self.step[0], v + self.step[1], count
