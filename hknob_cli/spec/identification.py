"""What a valid identification spec says, as plain values."""

from pathlib import Path
from typing import Any, NamedTuple


class PreparePlan(NamedTuple):
    """How trials become motions; ``window_s`` before and after the onset."""

    average: bool
    decimate: int | None
    interpolate: bool
    window_s: tuple[float, float]


class VirtualPlan(NamedTuple):
    """Recordings to make on the virtual apparatus; ``rig``: what is given of it, by the names of `Rig`."""

    experiments: tuple[int, ...]
    subjects: int | None
    blocks: int
    trials: int
    seed: int
    grips: tuple[float, ...] | None
    model: str
    ideal: bool
    rig: dict[str, float]


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

    The experiment "" stands for all that are not named. With a ``study`` there are no recordings.
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
