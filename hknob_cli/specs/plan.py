"""What a valid spec says, as plain values: SI numbers in tuples, without the machinery that validated them.

This is what the rest of the program sees. Defaults and absences are resolved: a part that is not listed is None.
"""

from math import nan
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from hknob_cli.specs.campaign import HwRunPlan
from hknob_cli.specs.controller import Controller as Controller
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.identification import SysidPlan
from hknob_cli.specs.over_angle import DeadZone as DeadZone
from hknob_cli.specs.over_angle import Detents as Detents
from hknob_cli.specs.over_angle import EndStops as EndStops
from hknob_cli.specs.over_angle import Profile as Profile
from hknob_cli.specs.parts import Actuator as Actuator
from hknob_cli.specs.parts import Bias as Bias
from hknob_cli.specs.parts import Encoder as Encoder
from hknob_cli.specs.parts import Finger as Finger
from hknob_cli.specs.parts import Fingerpad as Fingerpad
from hknob_cli.specs.parts import Hand as Hand
from hknob_cli.specs.parts import Knob as Knob
from hknob_cli.specs.parts import Scene as Scene
from hknob_cli.specs.parts import Wall as Wall
from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.quantity import PositiveSeconds, SignedTorque, declared
from hknob_cli.specs.squeeze import squeezed
from hknob_cli.specs.stage_plans import DesignPlan, Preset, RemediesPlan, ReportPlan
from hknob_cli.specs.unit_points import Points

RATE, COUNTS = "sample_rate_hz", "counts_per_rev"
GRIP, PERSON = "hand.grip_n", "person"

Cell = dict[str, float | int]
Axes = dict[str, list[float | int]]


class Starts(NamedTuple):
    """Angle (rad) and velocity (rad/s) where trials begin, and their number.

    ``sampled``: whether the spec asks for so many trials; else every clock phase is meant, and the number is that of
    the trials where a scene's motions cannot be followed all at once. ``span``: every start between two angles and two
    velocities at a sample instant, of which ``angle`` and ``velocity`` are the middle; None for one start. ``random``:
    how many of them are drawn where they cannot be followed all at once. ``anywhere``: every state at a sample instant.
    """

    angle: float
    velocity: float
    phases: int
    sampled: bool = True
    span: tuple[float, float, float, float] | None = None
    random: int = 0
    anywhere: bool = False

    @property
    def many(self) -> bool:
        """Whether sets of starts are meant, at a sample instant, and not one start."""
        return self.anywhere or self.span is not None

    @property
    def kind(self) -> str:
        """Which of `capabilities.STARTS` is meant."""
        if self.anywhere:
            return "anywhere"
        return "ranges" if self.span else "phases" if self.sampled else "one"


BESIDE = Starts(angle=0.02, velocity=0.0, phases=16)  # the start that most specs have, shown beside ranges


@declared()
class Pulse(NamedTuple):
    """A torque pulse on the knob from the start of a recording, away from the wall (Hasser, sec. 4.2.2)."""

    torque: Annotated[SignedTorque, "height of the pulse"]
    duration: Annotated[PositiveSeconds, "length of the pulse"]


class Record(NamedTuple):
    """Trajectories to keep: their duration and the time between rows (s), trials, and a pulse at their start.

    ``angles``: where they start (rad); empty: where all trials do. ``since``: time (s) of the first row that is kept.
    """

    duration: float
    interval: float
    trials: int
    pulse: Pulse | None = None
    angles: tuple[float, ...] = ()
    since: float = 0.0


class DfaPlan(NamedTuple):
    """A describing-function analysis by ``methods``; ``against``: folder of the sweep it is compared with."""

    name: str
    scene: Scene
    axes: Axes
    units: dict[str, str]
    methods: tuple[str, ...]
    against: str | None
    values: dict[str, Any]
    points: Points | None = None
    preset: Preset | None = None


class PredictPlan(NamedTuple):
    """Predictions by ``laws``; ``constant``: C of the quantum-period law, 1/s, None: analytic.

    ``criteria``: further criteria of stability, by name.
    ``case_file``, ``case_sha256``: the file that the constant was taken from, if any, and its digest.
    """

    name: str
    scene: Scene
    axes: Axes
    units: dict[str, str]
    laws: tuple[str, ...]
    constant: float | None
    case_sha256: str | None
    against: str | None
    values: dict[str, Any]
    case_file: Path | None = None
    points: Points | None = None
    preset: Preset | None = None
    criteria: tuple[str, ...] = ()


class SweepPlan(NamedTuple):
    """A sweep. ``axes``: values by name, ``units``: their units; ``values``: the spec as written, overrides applied.

    ``points``: the design whose points are the cells, if any, of which ``axes`` has the bounds; else all combinations.
    ``growth_s``: time over which the energy of bounces is fitted, ``basins``: starts a side of the map of basins, where
    asked for. ``seconds_per_cell``: time that a cell may take, if it is limited. ``preset``: what the scene is from, if
    it is from one; the same in the other plans.
    """

    name: str
    scene: Scene
    axes: Axes
    units: dict[str, str]
    starts: Starts
    max_samples: int | None
    values: dict[str, Any]
    record: Record | None = None
    growth_s: float | None = None
    perceive: Perceive | None = None
    points: Points | None = None
    seconds_per_cell: float | None = None
    basins: int | None = None
    preset: Preset | None = None


class BenchScene(NamedTuple):
    """One trial of a benchmark: from ``angle`` (rad) and ``velocity`` (rad/s), over ``samples`` sample intervals.

    ``counts_per_rev`` None: a continuous sensor. ``reference``: what errors are against, exact or digits60.
    """

    name: str
    scene: Scene
    sample_rate_hz: float
    counts_per_rev: int | None
    angle: float
    velocity: float
    samples: int
    reference: str


class BenchPlan(NamedTuple):
    """A benchmark of ``methods``.

    ``smoothing``: speed over which smoothed friction turns, rad/s; ``seconds_per_run``: processor time allowed;
    ``accurate``, ``same_attractor``: thresholds of the verdicts, relative to peak to peak.
    """

    name: str
    scenes: tuple[BenchScene, ...]
    methods: tuple[str, ...]
    tolerances: tuple[float, ...]
    substeps: tuple[int, ...]
    smoothing: float
    seconds_per_run: float
    accurate: float
    same_attractor: float
    values: dict[str, Any]


Plan = SweepPlan | DfaPlan | PredictPlan | BenchPlan | ReportPlan | SysidPlan | RemediesPlan | DesignPlan | HwRunPlan


def scene_at(scene: Scene, cell: Cell) -> Scene:
    """The scene with a cell's values in place, with the hand of its squeeze and with what its motor comes to.

    See `specs.squeeze.squeezed` and `specs.drive.reduced`.
    """
    return reduced(squeezed(placed(scene, cell)))


def knob_counts(scene: Scene, cell: Cell) -> float:
    """Counts for a turn of the knob, where `scene_at` has reduced the gear; NaN without an encoder's counts."""
    return cell.get(COUNTS, nan) * scene.turns


YIELDS, JITTERS, PUSHES = ("gear.stiffness",), ("clock.jitter",), ("bias.torque", "bias.half_quantum")
RUBS = ("knob.coulomb_torque", "gear.motor_coulomb_torque")
ROAMS = ("gear.backlash", "cogging.torque")  # what may keep trials from ever repeating


def may_have(scene: Scene, axes: Axes, *paths: str) -> bool:
    """Whether a number at one of these dotted paths is there, and not 0, in some of the cells at least."""
    return any(value_at(scene, path) or any(axes.get(path, [])) for path in paths)


def is_unpushed(scene: Scene, axes: Axes) -> bool:
    """Whether there is a wall, in some of the cells at least, and in none what pushes the knob into it."""
    return may_have(scene, axes, "wall.stiffness") and not may_have(scene, axes, *PUSHES)


def value_at(scene: Scene, path: str) -> Any:
    """What a scene has at a dotted path; None if it has no such part."""
    found: Any = scene
    for step in path.split("."):
        found = getattr(found, step, None)
    return found


def placed(scene: Scene, cell: Cell) -> Scene:
    """The scene with a cell's values in place, its motor as it is written."""
    if GRIP in cell and scene.hand:
        scene = scene._replace(hand=gripped(scene.hand, cell[GRIP]))
    if PERSON in cell and scene.hand:
        scene = scene._replace(hand=scene.hand.by_person[int(cell[PERSON]) - 1])
    for name, value in cell.items():
        if name not in (RATE, COUNTS, GRIP, PERSON):
            scene = _replaced(scene, name.split("."), value)
    return scene


def gripped(hand: Hand, grip_n: float) -> Hand:
    """The hand of the same table or file at another of its grip forces, the one nearest to ``grip_n``."""
    return min(hand.by_grip, key=lambda one: abs(one[0] - grip_n))[1]._replace(by_grip=hand.by_grip, origin=hand.origin)


def _replaced(part: Any, path: list[str], value: float) -> Any:
    """A part of the scene with the value at ``path`` in it replaced."""
    first, *rest = path
    return part._replace(**{first: _replaced(getattr(part, first), rest, value) if rest else value})
