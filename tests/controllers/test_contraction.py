"""The forms that a proof rests on, on maps whose behaviour is known."""

import numpy as np
import pytest

from hknob_cli.controllers.contraction import contraction_form, fixed_point_step, frozen_rows, inverse_root, without


def rotation(factor: float) -> np.ndarray:
    return factor * np.array([[[np.cos(0.7), 30.0 * np.sin(0.7)], [-np.sin(0.7) / 30.0, np.cos(0.7)]]])


def test_distance_falls_by_exactly_the_square_of_the_difference() -> None:
    slopes = rotation(0.95)
    form, alive = contraction_form(slopes, np.array([1e-12]))
    assert alive.all()
    rng = np.random.default_rng(1)
    for d in rng.normal(size=(50, 2)):
        after = slopes[0] @ d
        before = d @ form[0] @ d
        assert after @ form[0] @ after == pytest.approx(before - d @ d, rel=1e-12)


@pytest.mark.parametrize("factor", [1.0, 1.0 - 1e-10, 1.0 + 1e-10, 1.3])
def test_no_contraction_within_the_noise(factor: float) -> None:
    """An undamped map is not told from one that contracts by less than its slopes are known to."""
    form, alive = contraction_form(rotation(factor), np.array([1e-9]))
    assert not alive.any()
    np.testing.assert_array_equal(form[0], np.eye(2))


def test_every_map_within_the_noise_contracts_in_the_form() -> None:
    slopes, noise = rotation(0.9), 1e-6
    form, alive = contraction_form(slopes, np.array([noise]))
    assert alive.all()
    rng = np.random.default_rng(2)
    root = np.linalg.cholesky(form[0])
    for _ in range(200):
        error = rng.normal(size=(2, 2))
        near = slopes[0] + noise * error / np.linalg.norm(error, 2)
        # in the coordinates of the form the map's largest singular value is below 1
        assert np.linalg.norm(root.T @ near @ np.linalg.inv(root.T), 2) < 1.0


def test_a_form_that_is_not_finite_is_none() -> None:
    slopes = np.array([[[np.nan, 0.0], [0.0, 0.1]], [[np.inf, 0.0], [0.0, 0.1]], [[0.5, 0.0], [0.0, 0.1]]])
    _, alive = contraction_form(slopes, np.zeros(3))
    assert alive.tolist() == [False, False, True]
    assert np.isfinite(fixed_point_step(slopes, np.ones((2, 3)))).all()


def test_root_bounds_a_functional_and_is_attained() -> None:
    form, _ = contraction_form(rotation(0.9), np.zeros(1))
    root = inverse_root(form)[0]
    r = np.array([3.0, -70.0])
    best = np.linalg.solve(form[0], r)
    bound = np.linalg.norm(root @ r) * np.sqrt(best @ form[0] @ best)
    assert r @ best == pytest.approx(bound, rel=1e-12)


def test_fixed_point() -> None:
    slopes = rotation(0.9)
    goal = np.array([2.0, -5.0])
    start = np.array([7.0, 1.0])
    missed = (slopes[0] @ (start - goal) + goal) - start
    np.testing.assert_allclose(start + fixed_point_step(slopes, missed[:, None])[:, 0], goal, rtol=1e-12)


def test_what_is_counted_is_frozen_and_what_decays_is_not() -> None:
    slopes = np.zeros((1, 6, 6))
    slopes[0, :2, :2] = rotation(0.9)[0]
    slopes[0, 2, 2] = 1.0  # kept as it was
    slopes[0, 3, 2] = 0.3  # of what is kept alone
    slopes[0, 4, 4] = 0.5  # a running mean of what was counted
    slopes[0, 5, 0] = 1e-12  # of the position, however little
    assert frozen_rows(slopes)[0].tolist() == [False, False, True, True, False, False]
    left = without(slopes, frozen_rows(slopes))[0]
    assert left[3, 2] == 0.0
    assert left[4, 4] == 0.5
