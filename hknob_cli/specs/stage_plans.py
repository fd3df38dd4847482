"""Plans of the other kinds of specs as plain values: presets, remedies, designs, pages and pipelines."""

from math import prod
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.specs.perception import Perceive


class PresetValue(NamedTuple):
    """A value by its dotted path in scene or grid, as written; ``source``: where it is from; ``assumed``: why this one.

    One of the two texts is empty. Both are where the file says nothing about the value.
    """

    path: str
    value: Any
    source: str = ""
    assumed: str = ""

    @property
    def text(self) -> str:
        """The value, and what is said about it."""
        said = f"assumed: {self.assumed}" if self.assumed else self.source or "no source"
        return f"{self.path} = {self.value}: {said}"


class Preset(NamedTuple):
    """A preset in use: its name or path as a spec has it, what it is, its file and digest, and what it leaves out.

    ``about``: where to read more. ``values`` of a spec's own are not among these.
    """

    name: str
    title: str
    about: str
    file: Path
    sha256: str
    values: tuple[PresetValue, ...]
    left_out: tuple[str, ...]

    @property
    def lines(self) -> list[str]:
        """What a user is told of the preset, a line each."""
        return [
            f"preset {self.name}: {self.title}",
            *([f"  from: {self.about}"] if self.about else []),
            *(f"  {one.text}" for one in self.values),
            *(f"  left out: {one}" for one in self.left_out),
        ]


KNOCKS = 4  # trials of a knock on the wall, their sample clocks spread over an interval


class Tuned(NamedTuple):
    """A remedy at one ``value`` (SI) of the number that it tunes; its sweeps as in `Remedy`."""

    value: float
    grid: Any
    cases: tuple[Any, ...]


class Remedy(NamedTuple):
    """A remedy: what it ``needs``, its sweep over the ``grid``, and over each of the ``cases``; persons are the hands.

    The sweeps are `SweepPlan`s, of the first value where it tunes. ``source``: where the remedy is from; ``tunes``:
    the number of the scene that it tunes, by its dotted path, and ``tuned`` its values; empty where it does not.
    """

    name: str
    needs: str
    source: str
    grid: Any
    cases: tuple[Any, ...]
    tunes: str = ""
    tuned: tuple[Tuned, ...] = ()


class RemediesPlan(NamedTuple):
    """A trial: names of ``hands``; ``cases`` with their sample rate (Hz) and counts; the ``reference``'s name.

    ``torques`` (N·m), ``speed`` (rad/s), ``duration`` (s): how the stiffness is felt out.
    """

    name: str
    hands: tuple[str, ...]
    cases: tuple[tuple[str, float, int], ...]
    remedies: tuple[Remedy, ...]
    reference: str
    torques: tuple[float, float]
    speed: float
    duration: float
    values: dict[str, Any]
    preset: Preset | None = None

    @property
    def further(self) -> dict[str, str]:
        """Axes of the grid beside sample rate, counts and hands, with their units."""
        from hknob_cli.specs.plan import COUNTS, PERSON, RATE

        grid = self.remedies[0].grid
        return {name: grid.units[name] for name in grid.axes if name not in (RATE, COUNTS, PERSON)}

    @property
    def varied(self) -> dict[str, str]:
        """Those of the `further` axes that have several values."""
        grid = self.remedies[0].grid
        return {name: unit for name, unit in self.further.items() if len(grid.axes[name]) > 1}

    @property
    def ranged(self) -> bool:
        """Whether every start in a range is meant."""
        return self.remedies[0].grid.starts.span is not None

    @property
    def perceive(self) -> Perceive | None:
        """How levels are judged, where they are asked for."""
        how: Perceive | None = self.remedies[0].grid.perceive
        return how


Value = float | int


class Option(NamedTuple):
    """A value of a choice (SI), its cost, and what it is called."""

    value: Value
    cost: float
    label: str = ""


class Choice(NamedTuple):
    """What can be chosen: ``name`` is sample_rate_hz, counts_per_rev, or a dotted path in the scene; its unit."""

    name: str
    unit: str
    options: tuple[Option, ...]


class Candidate(NamedTuple):
    """A remedy to choose: its cost, its ``sweep`` (`SweepPlan`) over all people and whatever it leaves to choose.

    ``fixed``: choices that the remedy makes itself, whose cost is in its own.
    """

    name: str
    needs: str
    cost: float
    sweep: Any
    fixed: tuple[str, ...]


class Limit(NamedTuple):
    """At most a share of the people has a level above ``most_db``: above threshold, or above the present design."""

    most_db: float
    people: float
    above_present: bool


class DesignPlan(NamedTuple):
    """A search: ``choices``, ``candidates`` (the ``reference`` among them, by name), ``present`` design by choice.

    ``stiffness``: least that the wall renders (N·m/rad); ``torque_step_db``: most; None where there is no limit.
    ``torques``: two pushes (N·m) about which a controller's stiffness is felt out. ``uncertainty_db``: how well levels
    are known.
    """

    name: str
    people: int
    choices: tuple[Choice, ...]
    candidates: tuple[Candidate, ...]
    reference: str
    present: dict[str, Value]
    stiffness: float | None
    touch: Limit | None
    hearing: Limit | None
    torque_step_db: float | None
    torques: tuple[float, float]
    exhaustive: bool
    values: dict[str, Any]
    uncertainty_db: float = 2.0
    preset: Preset | None = None

    @property
    def size(self) -> int:
        """Number of designs."""
        return sum(
            prod(len(one.options) for one in self.choices if one.name not in candidate.fixed)
            for candidate in self.candidates
        )

    @property
    def drawn(self) -> bool:
        """Whether the people are drawn from a population, not listed."""
        return not isinstance(self.values["people"], list)

    @property
    def ranged(self) -> bool:
        """Whether every start in a range is meant."""
        return self.candidates[0].sweep.starts.span is not None

    @property
    def perceive(self) -> Perceive:
        """How levels are judged."""
        how: Perceive = self.candidates[0].sweep.perceive
        return how

    @property
    def scene(self) -> Any:
        """The reference's scene, whose hand says where the people are from."""
        return next(one.sweep.scene for one in self.candidates if one.name == self.reference)


class Sentence(NamedTuple):
    """Text, and for each ``{name}`` in it the check, its arguments, a factor and a format; without values as it is.

    ``where`` it is in its file.
    """

    text: str
    values: dict[str, tuple[str, dict[str, Any], float, str]] = {}  # noqa: RUF012 - never written to
    where: str = ""


class Listen(NamedTuple):
    """A clip to listen to: its name, the result ``of`` whose recording it is, and which recording, by columns."""

    name: str
    of: str
    at: tuple[tuple[str, float], ...] = ()


class FigurePlan(NamedTuple):
    """A figure of a page: which drawing, ``of`` which results, with which options."""

    id: str
    draw: str
    of: tuple[str, ...]
    options: dict[str, Any]
    title: str
    caption: Sentence
    alt: str
    where: str = ""
    listen: tuple[Listen, ...] = ()


class TablePlan(NamedTuple):
    """A table of a page: the rows of a ``file`` of a result.

    Of a long one those are shown where one of the columns ``first`` is true, which ``first_are`` says in words, or
    those with the largest ``key``. ``made``: what the rows are, where the result has no such file.
    """

    id: str
    of: str
    file: str
    title: str
    caption: str = ""
    key: str = ""
    first: tuple[str, ...] = ()
    first_are: str = ""
    made: str = ""


class ChapterPlan(NamedTuple):
    """A part of a page."""

    title: str
    text: str
    figures: tuple[FigurePlan, ...]
    tables: tuple[TablePlan, ...] = ()


class ReportPlan(NamedTuple):
    """A page.

    ``results``: folders by name; ``claims``: the ledger's file; ``contents``: that of its text's contents; ``lead``:
    figures of the summary; ``rerun``: command lines that make the page again.
    """

    name: str
    title: str
    results: dict[str, str]
    claims: str | None
    summary: tuple[Sentence, ...]
    lead: tuple[str, ...]
    chapters: tuple[ChapterPlan, ...]
    rerun: tuple[str, ...]
    values: dict[str, Any]
    contents: str | None = None


class StagePlan(NamedTuple):
    """A stage of a pipeline: its ``spec``, or the ``folder`` of results that are taken as they are.

    ``settings``: overrides of its spec; ``inputs``: by path in its spec, the stage or stages whose folders go there;
    ``where``: the place in the pipeline's file.
    """

    name: str
    spec: Path | None
    settings: tuple[str, ...]
    inputs: dict[str, tuple[str, ...] | str]
    where: str
    folder: Path | None = None

    @property
    def needs(self) -> tuple[str, ...]:
        """Stages that it waits for."""
        return tuple(
            dict.fromkeys(
                name for found in self.inputs.values() for name in ((found,) if isinstance(found, str) else found)
            )
        )


class PipelinePlan(NamedTuple):
    """A pipeline of stages by name."""

    name: str
    stages: dict[str, StagePlan]
    values: dict[str, Any]
