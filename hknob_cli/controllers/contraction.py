"""Whether an affine map from period to period brings motions together, and how far apart they may be meanwhile."""

import numpy as np

from hknob_cli.controllers.plant_batch import Array

DOUBLINGS = 40


def frozen_rows(slopes: Array) -> np.ndarray:
    """Rows of memory that no nearby motion changes, (lanes, rows): they hold what was counted.

    ``slopes`` (lanes, rows, rows). After a period such a row is as it was, or depends on frozen rows alone; a row that
    depends on itself with a factor that is neither 0 nor 1 is none. Slopes must be exactly 0: copies of one motion that
    differ elsewhere have counted the same.
    """
    own = np.abs(np.diagonal(slopes, axis1=1, axis2=2))
    frozen = (own == 0.0) | (np.abs(own - 1.0) < 1e-6)
    frozen[:, :2] = False
    others = slopes != 0.0
    others[:, np.arange(slopes.shape[1]), np.arange(slopes.shape[1])] = False
    for _ in range(slopes.shape[1]):
        frozen &= ~(others & ~frozen[:, None, :]).any(axis=2)
    return np.asarray(frozen)


def without(slopes: Array, rows: np.ndarray) -> Array:
    """Slopes (lanes, rows, rows) of the other rows alone; those of ``rows`` (lanes, rows) are 0."""
    return np.where(rows[:, :, None] | rows[:, None, :], 0.0, slopes)


def contraction_form(slopes: Array, noise: Array) -> tuple[Array, np.ndarray]:
    """P = sum of (A^k)^T A^k of each lane, (lanes, rows, rows), and where it shows a contraction.

    d^T P d falls by d^T d from period to period. It still falls for every map within ``noise`` (lanes,) of ``slopes``
    (spectral norm) where 2 noise |A| |P| + noise^2 |P| < 1; elsewhere P is the identity. By doubling the sum.
    """
    power = slopes.copy()
    size = power.shape[1]
    form = np.broadcast_to(np.eye(size), power.shape).copy()
    alive = np.isfinite(power).all(axis=(1, 2))
    power[~alive] = 0.0
    for _ in range(DOUBLINGS):
        form = form + power.transpose(0, 2, 1) @ form @ power
        power = power @ power
        wild = ~(np.abs(power).max(axis=(1, 2)) < 1e30) | ~(np.abs(form).max(axis=(1, 2)) < 1e30)
        alive &= ~wild
        power[wild], form[wild] = 0.0, np.eye(size)
    alive &= np.abs(power).max(axis=(1, 2)) < 1e-6
    with np.errstate(all="ignore"):
        steep = np.sqrt((slopes * slopes).sum(axis=(1, 2)))
        weight = np.sqrt((form * form).sum(axis=(1, 2)))
        alive &= noise * weight * (2.0 * steep + noise) < 1.0
    form[~alive] = np.eye(size)
    return form, alive


def inverse_root(form: Array) -> Array:
    """R of each lane with |r . d| <= |R r| sqrt(d^T P d) for all r and d."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(form)))


def fixed_point_step(slopes: Array, residual: Array) -> Array:
    """(I - A)^-1 of what a period misses, (rows, lanes); by least squares where a direction is neutral."""
    left = np.eye(slopes.shape[1]) - slopes
    with np.errstate(all="ignore"):
        usable = np.isfinite(left).all(axis=(1, 2)) & np.isfinite(residual).all(axis=0)
        left[~usable] = np.eye(slopes.shape[1])
        inverse = np.linalg.pinv(left, rcond=1e-10)
        return np.asarray((inverse @ np.where(usable, residual, 0.0).T[..., None])[..., 0].T)
