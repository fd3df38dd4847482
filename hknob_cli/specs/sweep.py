"""The sweep's spec: a scene, a grid, and where its trials start; and a sweep that another spec is made of.

Such a sweep is validated as if it stood in a file, its faults where its parts were written.
"""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from hknob_cli.errors import Fault
from hknob_cli.specs.cells import cells_over
from hknob_cli.specs.grid import MAX_CELLS, Grid
from hknob_cli.specs.hand import PopulationSpec
from hknob_cli.specs.part import Part, Place
from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.plan import RATE, Axes, Pulse, Record, Starts, SweepPlan
from hknob_cli.specs.quantity import Angle, MayBeFloat, PositiveSeconds, Velocity
from hknob_cli.specs.refusals import Faults, apart, refusals, start_refusals
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.specs.source import Path_, Source, dotted, paths_in
from hknob_cli.specs.unit_points import Points

RANDOM = 256  # drawn from ranges, where not all can be followed at once and the spec does not say how many
PHASES = 64  # of one start, sampled where the motions of a scene cannot be followed all at once


def _form(value: Any) -> str:
    return "two values" if isinstance(value, list | tuple) else "one value"


AngleOrRange = Annotated[
    Annotated[Angle, Tag("one value")] | Annotated[tuple[Angle, Angle], Tag("two values")], Discriminator(_form)
]
VelocityOrRange = Annotated[
    Annotated[Velocity, Tag("one value")] | Annotated[tuple[Velocity, Velocity], Tag("two values")],
    Discriminator(_form),
]


class StartsSpec(Part):
    """Where the trials of a cell begin.

    One start means every clock phase of it, or as many as ``phases`` says. Two values of angle and velocity each mean
    every start between them, at a sample instant.
    """

    angle: Annotated[
        AngleOrRange,
        Field(
            description="knob angle at the start, above the wall where positive; [least, largest]: every one between"
        ),
    ] = 0.02
    velocity: Annotated[
        VelocityOrRange,
        Field(description="knob speed at the start; [least, largest]: every one between"),
    ] = 0.0
    phases: Annotated[
        int | None,
        Field(
            strict=True,
            ge=1,
            le=10_000_000,
            description="trials, whose first samples spread over an interval; null: every clock phase, exactly",
        ),
    ] = None
    random: Annotated[
        int | None,
        Field(
            strict=True,
            ge=1,
            le=1_000_000,
            description="of ranges: starts drawn at random in a cell whose starts cannot be followed all at once; null:"
            f" {RANDOM}",
        ),
    ] = None

    @property
    def spans(self) -> bool:
        """Whether every start in a box is meant."""
        return isinstance(self.angle, tuple) or isinstance(self.velocity, tuple)

    def faults(self) -> list[tuple[Place, str]]:
        """What is wrong with a range: places in the spec, and why."""
        if not self.spans:
            why = "must be absent where angle and velocity are not ranges: there is nothing to draw from"
            return [(("starts", "random"), why)] if self.random is not None else []
        found: list[tuple[Place, str]] = []
        for name in ("angle", "velocity"):
            value = getattr(self, name)
            if not isinstance(value, tuple):
                found.append(
                    (("starts", name), f"must be a range, [least, largest], as the other one is, got {value:g}")
                )
            elif not value[0] < value[1]:
                found.append((("starts", name), f"must have its least value first, got [{value[0]:g}, {value[1]:g}]"))
        if self.phases is not None:
            why = "must be absent where angle and velocity are ranges: every start is at a sample instant"
            found.append((("starts", "phases"), why))
        return found

    def plain(self) -> Starts:
        """The starts as plain values."""
        if isinstance(self.angle, tuple) and isinstance(self.velocity, tuple):
            span = (*self.angle, *self.velocity)
            middle = 0.5 * (span[0] + span[1]), 0.5 * (span[2] + span[3])
            random = self.random or RANDOM
            return Starts(*middle, random, False, span, random)
        assert isinstance(self.angle, float)
        assert isinstance(self.velocity, float)
        return Starts(self.angle, self.velocity, self.phases or PHASES, self.phases is not None)


def _kind(value: Any) -> str:
    return "every start" if isinstance(value, str) else "some starts"


AnyStarts = Annotated[
    Annotated[StartsSpec, Tag("some starts")] | Annotated[Literal["anywhere"], Tag("every start")],
    Discriminator(_kind),
    Field(description="one start, ranges of angle and velocity, or anywhere: every state at a sample instant"),
]


def kind_of_starts(starts: StartsSpec | str) -> str:
    """Which of `capabilities.STARTS` is meant."""
    if isinstance(starts, str):
        return "anywhere"
    return "ranges" if starts.spans else "one" if starts.phases is None else "phases"


def plain_starts(starts: StartsSpec | str) -> Starts:
    """The starts as plain values."""
    return Starts(0.0, 0.0, PHASES, False, anywhere=True) if isinstance(starts, str) else starts.plain()


MOST_ROWS = 1_000_000  # of the recordings of a sweep
MOST_CELLS = 10**13  # that a sweep may be let span

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=80)]


class LimitsSpec(Part):
    """Bounds on the work."""

    max_cells: Annotated[
        int,
        Field(strict=True, ge=1, le=MOST_CELLS, description="cells of the grid, with the people of a population"),
        MayBeFloat,
    ] = MAX_CELLS
    max_samples: Annotated[
        int | None,
        Field(strict=True, ge=100, le=2**30, description="samples a trial may take; null: by the plant's slowest mode"),
    ] = None
    seconds_per_cell: Annotated[
        PositiveSeconds | None,
        Field(
            le=1e6, description="time a cell may take, on the clock; trials that are not done are undecided; null: any"
        ),
    ] = None


class RecordSpec(Part):
    """Trajectories to keep: the exact motion of the first trials of every cell."""

    duration: Annotated[PositiveSeconds, Field(ge=1e-9, description="time to record, from the start of a trial")]
    interval: Annotated[
        PositiveSeconds | None,
        Field(description="time between rows, beside those where the torque changes; null: a thousandth of duration"),
    ] = None
    trials: Annotated[int, Field(strict=True, ge=1, le=1000, description="trials to record, by phase")] = 1
    angles: Annotated[
        list[Angle] | None,
        Field(min_length=1, max_length=100, description="angles to start recordings at, each; null: that of starts"),
    ] = None
    pulse: Pulse | None = None

    def plain(self) -> Record:
        """The recording as plain values."""
        return Record(
            duration=self.duration,
            interval=self.interval or self.duration / 1000.0,
            trials=self.trials,
            pulse=self.pulse,
            angles=tuple(self.angles or ()),
        )


class GrowthSpec(Part):
    """Energy at the bounce peaks, fitted by a parabola over time (Hasser, sec. 6.4.1)."""

    duration: Annotated[PositiveSeconds, Field(description="time over which bounces are collected")] = 1.0


class BasinsSpec(Part):
    """A map of every cell: which attractor the starts on a grid over the box of ``starts`` end in."""

    points: Annotated[int, Field(strict=True, ge=2, le=2000, description="starts a side of the map")] = 200


class SweepSpec(Part):
    """Simulate every cell of a grid to its proven limit cycles."""

    kind: Literal["sweep"]
    name: Annotated[Name, Field(description="names the results folder; letters, digits, '.', '_', '-'")]
    scene: SceneSpec
    grid: Grid
    starts: Annotated[AnyStarts, Field(default_factory=StartsSpec)]
    limits: Annotated[LimitsSpec, Field(default_factory=LimitsSpec)]
    record: RecordSpec | None = None
    growth: GrowthSpec | None = None
    basins: BasinsSpec | None = None
    population: PopulationSpec | None = None
    perceive: Perceive | None = None

    def contradictions(self, axes: Axes, points: Points | None) -> Faults:
        """What excludes something else: places in the spec, and what is wrong there."""
        starts, people = kind_of_starts(self.starts), self.population is not None
        found = [] if isinstance(self.starts, str) else self.starts.faults()
        if starts in ("ranges", "anywhere"):
            found += start_refusals(self.scene, axes, starts, people=people)
        asked = [one for one in ("record", "growth", "basins", "population", "perceive") if getattr(self, one)]
        found += apart(asked, starts)
        columns = {"growth": "bounces", "basins": "basins", "perceive": "perceive"}
        for one in asked:
            if one in columns and (one != "basins" or starts == "ranges"):
                found += refusals(self.scene, axes, [columns[one]])
        if self.record and self.record.pulse:
            found += refusals(self.scene, axes, ["pulse"])
        if self.basins and (mapped := self.basins.points**2 * len(cells_over(axes, points))) > MOST_ROWS:
            text = f"must be less, or the cells fewer: {mapped:.2g} starts would be mapped, at most {MOST_ROWS}"
            found.append((("basins", "points"), text))
        if self.population and self.scene.hand:
            found.append((("scene", "hand"), "must be absent where a population is given, which has the hands"))
        if self.record and starts in ("one", "phases"):  # of others it is a fault
            rows = self._recorded_rows(axes, points)
            if rows > MOST_ROWS:
                text = f"must be shorter, or interval longer: {rows:.2g} rows would be recorded, at most {MOST_ROWS}"
                found.append((("record", "duration"), text))
        return found

    def _recorded_rows(self, axes: Axes, points: Points | None) -> float:
        """Rows of all recordings, roughly; of a design as many as at the highest sample rate."""
        assert self.record
        record = self.record.plain()
        rates = axes.get(RATE, [0.0]) if self.scene.sampling != "continuous" else [0.0]
        trials = min(record.trials, plain_starts(self.starts).phases) if self.scene.sampling != "continuous" else 1
        each = [trials * record.duration * (2.0 * rate + 1.0 / record.interval) for rate in rates]
        each_cell = max(each) if points else sum(each) / len(each)
        return len(cells_over(axes, points)) * max(1, len(record.angles)) * each_cell

    def plan(self, axes: Axes, units: dict[str, str], values: dict[str, Any]) -> SweepPlan:
        """The spec as plain values, its axes resolved."""
        return SweepPlan(
            name=self.name,
            scene=self.scene.plain(),
            axes=axes,
            units=units,
            starts=plain_starts(self.starts),
            max_samples=self.limits.max_samples,
            seconds_per_cell=self.limits.seconds_per_cell,
            record=self.record.plain() if self.record else None,
            growth_s=self.growth.duration if self.growth else None,
            perceive=self.perceive,
            basins=self.basins.points if self.basins else None,
            values=values,
        )


class _Derived(Source):
    """What a spec is merged to; ``written``: by path in it, the path in the file."""

    written: dict[Path_, Path_]

    def fault(self, path: Path_, message: str, *, at_key: bool = False) -> Fault:
        """As `Source.fault`, with the key as it stands in the file."""
        for end in range(len(path), 0, -1):
            if path[:end] in self.written:
                key = (*self.written[path[:end]], *path[end:])
                break
        else:
            key = ("base", *path)
        return super().fault(path, message, at_key=at_key)._replace(key=dotted(key))


def derived_sweep(source: Source, values: dict[str, Any], places: dict[Path_, Path_]) -> SweepPlan:
    """The plan of the sweep that has these ``values``.

    ``places``: from where parts of it stand in ``source`` to where they are in the sweep; the last that fits wins.
    Raises `SpecError`, its faults at those places.
    """
    from hknob_cli.specs.load import validate

    derived = _Derived(source.name)
    derived.value, derived.waiting, derived.written = values, source.waiting, {}
    for stem, target in places.items():
        for kind in ("keys", "values", "overridden", "inherited"):
            found = getattr(derived, kind)
            for path, place in list(getattr(source, kind).items()):
                if path[: len(stem)] == stem:
                    there = (*target, *path[len(stem) :])
                    found[there] = place
                    if there:
                        derived.written[there] = path
        _open_overrides(source, derived, stem, target)
    plan = validate(derived, kind="sweep", presets=False)
    assert isinstance(plan, SweepPlan)
    return plan


def _open_overrides(source: Source, derived: _Derived, stem: Path_, target: Path_) -> None:
    """Note every key inside what was set as a whole: else its faults stand where the base has that key."""
    for end in range(1, len(stem) + 1):
        option = source.overridden.get(stem[:end])
        if option is None:
            continue
        value = source.value
        for step in stem:
            value = value.get(step) if isinstance(value, dict) else None
        for inner in paths_in(value):
            derived.overridden[(*target, *inner)] = option
            derived.written[(*target, *inner)] = (*stem, *inner)
