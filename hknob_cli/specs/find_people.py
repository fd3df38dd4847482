"""The people of a population: the subjects of a file, or drawn as those of a file or of a printed table spread.

People are drawn with hands whose numbers are lognormal. A lognormal is positive, and has any mean and standard
deviation. Correlations are those of the numbers themselves, not of their logarithms: E[xy] = E[x] E[y] exp(c), with c
the covariance of the logarithms, so that for coefficients of variation u and v and correlation r it is c = ln(1 + r u
v).
"""

from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.errors import UsageError
from hknob_cli.specs.hand import PopulationSpec, same_grip
from hknob_cli.specs.hand_from import (
    APPARATUS,
    STDS,
    ChoiceError,
    Row,
    flag_note,
    narrowed,
    numbers_of,
    place_of,
    read_conditions,
)
from hknob_cli.specs.part import Place
from hknob_cli.specs.parts import Origin
from hknob_cli.specs.plan import Hand
from hknob_cli.specs.source import Source

if TYPE_CHECKING:
    from numpy.typing import NDArray

Triple = tuple[float, float, float]


class Spread(NamedTuple):
    """Means and standard deviations of inertia (kg·m²), damping (N·m·s/rad) and stiffness (N·m/rad) over persons.

    ``correlations``: 3 x 3, in that order; None where the three are independent.
    """

    means: Triple
    stds: Triple
    correlations: tuple[Triple, ...] | None = None


def spread_of(hands: list[Triple]) -> Spread:
    """Spread of two hands or more: means, sample standard deviations, and correlations (0 with what is constant)."""
    import numpy as np

    columns = np.array(hands).T
    means, stds = columns.mean(axis=1), columns.std(axis=1, ddof=1)
    scaled = (columns - means[:, None]) / np.where(stds > 0.0, stds, 1.0)[:, None]
    correlations = scaled @ scaled.T / (len(hands) - 1)
    np.fill_diagonal(correlations, 1.0)
    return Spread(_triple(means), _triple(stds), tuple(_triple(row) for row in correlations))


def draw(spread: Spread, *, people: int, seed: int) -> list[Triple]:
    """Draw hands; of more people, the first are the same. Means must be above 0.

    Correlations that no three lognormals can have together are drawn as near to them as can be.
    """
    import numpy as np

    means, variation = np.array(spread.means), np.array(spread.stds) / np.array(spread.means)
    correlations = np.eye(3) if spread.correlations is None else np.array(spread.correlations)
    # A correlation so negative that 1 + r u v would not be above 0 is one that two lognormals cannot have.
    covariance = np.log1p(np.maximum(correlations * np.outer(variation, variation), -0.999))
    normal = np.random.default_rng(seed).standard_normal((people, 3))
    root = _root(covariance)
    # Sums written out: those of a linear algebra library may differ with the number of rows.
    exponents = normal[:, :1] * root[0] + normal[:, 1:2] * root[1] + normal[:, 2:] * root[2]
    numbers = means * np.exp(exponents - 0.5 * np.diag(covariance))
    return [_triple(row) for row in numbers]


def _root(covariance: "NDArray[Any]") -> "NDArray[Any]":
    """Symmetric square root of a covariance, negative eigenvalues taken for 0 and the variances kept."""
    import numpy as np

    values, vectors = np.linalg.eigh(covariance)
    nearest = vectors * np.maximum(values, 0.0) @ vectors.T
    wanted, found = np.diag(covariance), np.diag(nearest)
    kept = np.sqrt(wanted / np.where(found > 0.0, found, 1.0))
    values, vectors = np.linalg.eigh(nearest * np.outer(kept, kept))
    root: NDArray[Any] = vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
    return root


def _triple(row: Any) -> Triple:
    inertia, damping, stiffness = (float(value) for value in row)
    return inertia, damping, stiffness


Notes = tuple[str, ...]


class Population(NamedTuple):
    """Hands of the people, where they are from, and faults: places in the spec, and what is wrong there."""

    hands: tuple[Hand, ...]
    origin: Origin
    faults: list[tuple[Place, str]]


def find_people(source: Source, spec: PopulationSpec, knob_inertia: float) -> Population:
    """The people; with each the knob, of at least ``knob_inertia`` (kg·m²), must have an inertia above 0.

    Their hands are without numbers as long as another stage is yet to find them.
    """
    faults: list[tuple[Place, str]] = [(("population", key), text) for key, text in spec.contradictions()]
    nobody = Population((Hand(),) * (spec.people if spec.spread == "lognormal" else 1), Origin(), faults)
    if faults or spec.from_ in source.waiting:
        return nobody
    try:
        hands, origin = _printed(spec) if spec.table else _identified(source, spec)
    except UsageError as error:
        return nobody._replace(faults=[(("population", "from"), str(error))])
    except ChoiceError as error:
        return nobody._replace(faults=[(("population", error.key), str(error))])
    light = sum(knob_inertia + hand[0] <= 0.0 for hand in hands)
    if light:
        text = f"must leave an inertia above 0: {light} of {len(hands)} people take away more than the knob has"
        faults.append((("population",), f"{text}, {knob_inertia:g} kg*m^2"))
    return Population(tuple(Hand(*hand) for hand in hands), origin, faults)


def _printed(spec: PopulationSpec) -> tuple[list[Triple], Origin]:
    """People of a printed table: of each number the mean and standard deviation are known, nothing else."""
    from hknob_cli.printed import apparatus_inertia, grasps, printed

    assert spec.table
    rows = zip(grasps(spec.table), printed(spec.table), strict=True)
    grasp, row = next((grasp, row) for grasp, row in rows if same_grip(grasp.grip_n, spec.grip_n or 0.0))
    names = ("inertia_std_kg_m2", "damping_std_nm_s_per_rad", "stiffness_std_nm_per_rad")
    inertia, damping, stiffness = (float(row[name]) for name in names)
    hands, notes = _drawn(Spread(grasp[1:], (inertia, damping, stiffness)), spec, apparatus_inertia(spec.table))
    alone = f"population: table {spec.table} has no correlations; inertia, damping, stiffness are drawn independently"
    return hands, Origin(notes=(alone, *notes))


def _identified(source: Source, spec: PopulationSpec) -> tuple[list[Triple], Origin]:
    """People as identified, or drawn as they spread. Raises `UsageError` and `ChoiceError`."""
    found = read_conditions(place_of(source, spec.from_ or ""))
    wanted: Row = {key: getattr(spec, key) for key in ("experiment", "grip_n", "estimator")}
    subjects = [row for row in found.rows if row["level"] == "subject"]
    means = [row for row in found.rows if row["level"] == "all"]
    rows = narrowed(subjects or means, wanted, wanted)
    rows.sort(key=lambda row: str(row["subject"]))
    if not rows or (spec.spread == "subjects" and not subjects):
        raise ChoiceError("from", "has no subjects")
    if len({row["subject"] for row in rows}) < len(rows):
        raise ChoiceError("from", "has several rows for a subject")
    hands = [numbers_of(row, spec.subtract_apparatus) for row in rows]
    notes = flag_note(rows)
    if spec.spread == "lognormal":
        spread, alone = _spread(rows, hands)
        apparatus = max(row[APPARATUS] or spec.subtract_apparatus or 0.0 for row in rows)
        hands, more = _drawn(spread, spec, apparatus)
        notes += (*alone, *more)
    return hands, Origin(found.file, found.sha256, notes)


def _spread(rows: list[Row], hands: list[Triple]) -> tuple[Spread, Notes]:
    """Spread over subjects; of a mean over persons, its standard deviations. Raises `ChoiceError`."""
    if len(rows) > 1:
        return spread_of(hands), ()
    if rows[0]["level"] == "subject":
        raise ChoiceError("from", "has one subject, whose spread is unknown; spread: subjects takes that one")
    values = [rows[0][name] for name in STDS]
    if any(value is None or not 0.0 <= value < inf for value in values):
        raise ChoiceError("from", "has no subjects, and no standard deviations over persons")
    inertia, damping, stiffness = map(float, values)
    alone = "population: the file has no subjects; inertia, damping, stiffness are drawn independently"
    return Spread(hands[0], (inertia, damping, stiffness)), (alone,)


def _drawn(spread: Spread, spec: PopulationSpec, apparatus: float) -> tuple[list[Triple], Notes]:
    """People drawn, and what to say of them. Raises `ChoiceError` where a mean has no lognormal.

    A mean inertia that is not above 0 is drawn with that of the apparatus (kg·m²) it was measured with.
    """
    inertia, damping, stiffness = spread.means
    if min(damping, stiffness) <= 0.0:
        raise ChoiceError("from", f"has a mean damping of {damping:g} and stiffness of {stiffness:g}; must be > 0")
    beside = apparatus if inertia <= 0.0 else 0.0
    if inertia + beside <= 0.0:
        raise ChoiceError("from", f"has a mean inertia of {inertia:g} kg*m^2, which must be > 0")
    spread = spread._replace(means=(inertia + beside, damping, stiffness))
    hands = [(j - beside, b, k) for j, b, k in draw(spread, people=spec.people, seed=spec.seed)]
    text = f"population: the hand's mean inertia is {inertia:g} kg*m^2; it is drawn with the apparatus' {apparatus:g}"
    return hands, (text,) if beside else ()
