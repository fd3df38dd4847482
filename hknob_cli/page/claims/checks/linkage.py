"""How far a linkage's Jacobian changes while its tip moves for one interval (Hasser, Section 11.4)."""

from math import pi

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import check
from hknob_cli.results.result_set import ResultSet

_CONFIGURATIONS, _DIRECTIONS = 91, 72


@check
def jacobian_change(
    _: ResultSet,
    *,
    links_m: list[float],
    speed_m_s: float,
    interval_s: float,
    elbow_deg: list[float],
    inverse: bool = True,
) -> float:
    """Most (%) by which the Jacobian of a planar arm of two links changes while its tip moves at a speed for a time.

    The tip moves in every direction, from every angle of the elbow in a range (degrees, 0: straight) that leaves out
    the singular ones. The change is the largest singular value of the difference over that of the Jacobian before, or,
    with ``inverse``, of the inverses. Raises `UsageError` for a range with a singular elbow.
    """
    first, second = links_m
    low, high = (pi * value / 180.0 for value in elbow_deg)
    if not 0.0 < low <= high < pi:
        raise UsageError("elbow_deg: must lie between 0 and 180, where the arm is straight or folded")
    most = 0.0
    for elbow in np.linspace(low, high, _CONFIGURATIONS):
        here = _jacobian(first, second, 0.0, elbow)
        for angle in np.linspace(0.0, 2.0 * pi, _DIRECTIONS, endpoint=False):
            shoulder, bent = np.linalg.solve(here, speed_m_s * interval_s * np.array([np.cos(angle), np.sin(angle)]))
            there = _jacobian(first, second, shoulder, elbow + bent)
            old, new = (np.linalg.inv(here), np.linalg.inv(there)) if inverse else (here, there)
            most = max(most, float(np.linalg.norm(new - old, 2) / np.linalg.norm(old, 2)))
    return 100.0 * most


def _jacobian(first: float, second: float, shoulder: float, elbow: float) -> np.ndarray:
    """Velocity of the tip by the two joint speeds, m/rad; the shoulder's and the elbow's angle in rad."""
    near = first * np.array([-np.sin(shoulder), np.cos(shoulder)])
    far = second * np.array([-np.sin(shoulder + elbow), np.cos(shoulder + elbow)])
    return np.stack([near + far, far], axis=1)
