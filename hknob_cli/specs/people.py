"""People drawn at random: hands whose inertia, damping and stiffness are lognormal over persons.

A lognormal is positive, and has any mean and standard deviation. Correlations are those of the numbers themselves, not
of their logarithms: E[xy] = E[x] E[y] exp(c), with c the covariance of the logarithms, so that for coefficients of
variation u and v and correlation r it is c = ln(1 + r u v).
"""

from typing import TYPE_CHECKING, Any, NamedTuple

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
