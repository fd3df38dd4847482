"""People who hold the knob, drawn from the means and the spread of Tables 1-5.

A subject has one factor each for inertia and stiffness, the same at every grip and in every experiment: who is stiff is
stiff throughout. The factors are lognormal, so that nothing is negative, and scaled to each row's coefficient of
variation. Blocks and trials have factors of their own, around 1.

Damping goes with stiffness as far as each row's spread of the damping ratio says. With ζ = B / (2 sqrt(J K)), lognormal
J, B and K, and J independent of both,

    var ln ζ = var ln B + (var ln J + var ln K) / 4 - r sqrt(var ln B var ln K),    var ln = ln(1 + cv²),

so the four printed coefficients of variation give r, the correlation of ln B with ln K, of each row; they are printed
to 0.1 %, which leaves r open by 0.03 at most. 25 rows have 0.15 to 1.00; two of key pinches -0.10 and -0.05; the three
lightest of Table 4 -1.2 to -2.7, which no correlation can be: -1 there, and ζ spreads less than printed (43 for 60 % at
0.71 N; with J at its worst, too, it would be 48 %). The printed means of ζ play no part in it. What of a subject's B
does not go with K is one factor, too.
"""

from functools import cache
from math import exp, log1p, sqrt
from typing import NamedTuple

import numpy as np

from hknob_cli.apparatus.hand import SecondOrder
from hknob_cli.errors import UsageError
from hknob_cli.printed import table
from hknob_cli.recordings.trial import Purpose, stream

_COLUMNS = (
    ("inertia_kg_m2", "inertia_cv_percent"),
    ("damping_nm_s_per_rad", "damping_cv_percent"),
    ("stiffness_nm_per_rad", "stiffness_cv_percent"),
)


class Experiment(NamedTuple):
    """One of the five: its number, which is its table's, grasp, diameter of the knob (mm), number of subjects."""

    number: int
    grasp: str
    knob_mm: float
    subjects: int


EXPERIMENTS = {
    1: Experiment(1, "simple pinch", 17.8, 9),
    2: Experiment(2, "key pinch", 17.8, 5),
    3: Experiment(3, "simple pinch", 29.9, 5),
    4: Experiment(4, "key pinch", 29.9, 5),
    5: Experiment(5, "three-finger", 29.9, 5),
}


class Variation(NamedTuple):
    """How people differ: ``subjects`` scales the printed spread; coefficients of variation of (J, B, K) by the others.

    The spread between blocks and between trials is not printed; these are assumptions, a few percent. They come on
    top of the printed spread between subjects: over three blocks of three trials by 1, 3 and 4 %.
    """

    subjects: float = 1.0
    blocks: tuple[float, float, float] = (0.02, 0.04, 0.06)
    trials: tuple[float, float, float] = (0.01, 0.03, 0.05)

    @classmethod
    def none(cls) -> "Variation":
        """Every hand is the mean one."""
        return cls(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


class Place(NamedTuple):
    """Where in the experiments: experiment, subject, target of the grip force (N), block and trial; numbers from 1."""

    experiment: int
    subject: int
    grip_n: float
    block: int = 1
    trial: int = 1


def grips(experiment: int) -> tuple[float, ...]:
    """Grip forces (N) of an experiment, the lightest first. Raises `UsageError` if there is no such experiment."""
    return tuple(_rows(experiment))


def mean_hand(experiment: int, grip_n: float) -> SecondOrder:
    """The tabled mean over subjects, the apparatus' inertia included. Raises `UsageError` if it is not in the table."""
    return SecondOrder(*_row(experiment, grip_n).means)


def spread(experiment: int, grip_n: float) -> tuple[float, float, float]:
    """The tabled coefficients of variation between subjects, of J, B and K. Raises `UsageError`."""
    return _row(experiment, grip_n).cvs


def subject_hand(place: Place, *, seed: int = 0, variation: Variation | None = None) -> SecondOrder:
    """The hand of a subject, on average over all blocks and trials. Raises `UsageError` if it is not in the table."""
    mean, cvs, rho = _row(place.experiment, place.grip_n)
    share = (variation or Variation()).subjects
    inertia, own, stiffness = stream(seed, Purpose.SUBJECT, place.subject).standard_normal(3)
    damping = rho * stiffness + sqrt(1.0 - rho * rho) * own
    scaled = (share * cvs[0], share * cvs[1], share * cvs[2])
    return scaled_hand(SecondOrder(*mean), scaled, np.array([inertia, damping, stiffness]))


def trial_hand(place: Place, *, seed: int = 0, variation: Variation | None = None) -> SecondOrder:
    """The hand of a subject in one trial of one block. Raises `UsageError` if it is not in the table."""
    variation = variation or Variation()
    hand = subject_hand(place, seed=seed, variation=variation)
    at = numbers(place)
    hand = scaled_hand(hand, variation.blocks, stream(seed, Purpose.BLOCK, *at[:-1]).standard_normal(3))
    return scaled_hand(hand, variation.trials, stream(seed, Purpose.TRIAL, *at).standard_normal(3))


def numbers(place: Place) -> tuple[int, ...]:
    """A place as whole numbers, for its random stream: the grip by its row. Raises `UsageError`."""
    _row(place.experiment, place.grip_n)
    row = grips(place.experiment).index(place.grip_n)
    return place.experiment, place.subject, row, place.block, place.trial


def scaled_hand(hand: SecondOrder, cvs: tuple[float, float, float], normal: np.ndarray) -> SecondOrder:
    """A hand times lognormal factors of mean 1 and these coefficients of variation."""
    values = []
    for value, cv, z in zip(hand, cvs, normal, strict=True):
        variance = log1p(cv * cv)
        values.append(value * exp(sqrt(variance) * float(z) - 0.5 * variance))
    return SecondOrder(*values)


class Row(NamedTuple):
    """A row of a table: means and coefficients of variation of J, B and K, and the correlation of ln B with ln K."""

    means: tuple[float, float, float]
    cvs: tuple[float, float, float]
    correlation: float


def _row(experiment: int, grip_n: float) -> Row:
    rows = _rows(experiment)
    if grip_n not in rows:
        raise UsageError(f"experiment {experiment} has no grip of {grip_n:g} N; it has: {', '.join(map(str, rows))}")
    return rows[grip_n]


@cache
def _rows(experiment: int) -> dict[float, Row]:
    """Rows by grip force."""
    if experiment not in EXPERIMENTS:
        raise UsageError(f"no experiment {experiment}; there are: {', '.join(map(str, EXPERIMENTS))}")
    found = {}
    for row in table(experiment):
        numbers = {name: value for name, value in row.items() if isinstance(value, float)}
        j, b, k = (numbers[mean] for mean, _ in _COLUMNS)
        cvs = [numbers[cv] / 100.0 for _, cv in _COLUMNS]
        ratio = numbers["damping_ratio_cv_percent"] / 100.0
        found[numbers["grip_n"]] = Row((j, b, k), (cvs[0], cvs[1], cvs[2]), _correlation(cvs, ratio))
    return found


def _correlation(cvs: list[float], ratio_cv: float) -> float:
    """Correlation of ln B with ln K that gives ζ this coefficient of variation, or the next that there can be."""
    inertia, damping, stiffness, ratio = (log1p(cv * cv) for cv in (*cvs, ratio_cv))
    implied = (damping + 0.25 * (inertia + stiffness) - ratio) / sqrt(damping * stiffness)
    return min(max(implied, -1.0), 1.0)
