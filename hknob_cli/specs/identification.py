"""What a valid identification spec says, as plain values."""

from os.path import exists, isdir  # which raise no error, as those of pathlib do where a name is too long
from pathlib import Path
from typing import Any, NamedTuple

CAMPAIGN_SAMPLES = "samples.parquet"  # of a folder of hw-run that is named in place of a file


class ColumnPlan(NamedTuple):
    """A column of a recording: its ``source`` in the file, by which ``factor`` its numbers become SI.

    Or, with no source, the ``value`` of all rows.
    """

    source: str
    factor: float = 1.0
    value: str | float | None = None


class PreparePlan(NamedTuple):
    """How trials become motions; ``window_s`` before and after the onset; ``span_s``: what is kept of a record."""

    average: bool
    decimate: int | None
    interpolate: bool
    window_s: tuple[float, float]
    span_s: tuple[float, float] | None = None


class MotionPlan(NamedTuple):
    """What recorded motions are: ``continuous`` or a pulse each, from rest or a ``free_start``.

    ``torque``: commanded or measured, by default measured where it is there; ``ramps``: straight between samples.
    """

    continuous: bool = False
    free_start: bool = False
    torque: str | None = None
    ramps: bool = False


class InputPlan(NamedTuple):
    """A torque in place of the pulse (`apparatus.hand_recording`): frequencies of a sine (the first), chirp; chips."""

    kind: str
    duration_s: float
    from_hz: float
    to_hz: float
    chip_s: float


class VirtualPlan(NamedTuple):
    """Recordings to make on the virtual apparatus; ``rig``: what is given of it, by the names of `Rig`.

    ``input``: the torque, None for the pulse.
    """

    experiments: tuple[int, ...]
    subjects: int | None
    blocks: int
    trials: int
    seed: int
    grips: tuple[float, ...] | None
    model: str
    ideal: bool
    rig: dict[str, float]
    input: InputPlan | None = None


class BiasPlan(NamedTuple):
    """How far off the estimators are: printed hands, and levels of each nuisance by its name in `bias_study`."""

    table: int
    grips_n: tuple[float, ...]
    repeats: int
    seed: int
    nuisances: dict[str, tuple[float, ...]]


class HiddenPlan(NamedTuple):
    """What a second-order fit takes for the inertia of a hand with finger and fingerpad, over ratios K1/K2 = B1/B2."""

    table: int
    grip_n: float
    finger_inertia: float
    ratios: tuple[float, ...]


class StudyPlan(NamedTuple):
    """What is asked about the estimators themselves."""

    bias: BiasPlan | None
    hidden: HiddenPlan | None


class SysidPlan(NamedTuple):
    """An identification. ``apparatus``, ``radius``: inertia to subtract and radius of the knob by experiment.

    The experiment "" stands for all that are not named. With a ``study`` there are no recordings. ``columns`` of the
    files by their names here; ``limits`` by column, above which a number is a surprise; ``fixed`` parameters by name.
    ``against``: folder of a campaign of pulses on a virtual device, whose hands are known; empty for none.
    """

    name: str
    what: str
    recordings: tuple[Path, ...]
    virtual: VirtualPlan | None
    keep: bool
    counts_per_rev: int | None
    prepare: PreparePlan
    estimators: tuple[str, ...]
    coulomb_nm: float
    lag_s: float
    apparatus: dict[str, float]
    radius: dict[str, float]
    values: dict[str, Any]
    study: StudyPlan | None = None
    columns: dict[str, ColumnPlan] = {}  # noqa: RUF012  # never changed
    limits: dict[str, float] = {}  # noqa: RUF012
    against: str = ""
    motion: MotionPlan = MotionPlan()
    fixed: dict[str, float] = {}  # noqa: RUF012

    @property
    def files(self) -> tuple[Path, ...]:
        """The recordings, that of its samples in place of a folder of a campaign, which may not be there yet."""
        return tuple(
            one / CAMPAIGN_SAMPLES if isdir(one) or not (one.suffix or exists(one)) else one  # noqa: PTH110, PTH112
            for one in self.recordings
        )
