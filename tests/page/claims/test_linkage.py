"""The change of a linkage's Jacobian, against what its geometry says."""

from math import sin

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import compute
from hknob_cli.results.result_set import ResultSet

NOTHING = ResultSet({})
ARM = {"links_m": [0.1, 0.1], "speed_m_s": 1.0, "interval_s": 1e-4, "elbow_deg": [60.0, 120.0]}


@pytest.mark.parametrize("inverse", [True, False])
def test_a_short_way_changes_it_in_proportion(inverse: bool) -> None:
    """Of 1e-3 and 1e-4 of a link the change is as 10 to 1, but for a share of the second order, some 1e-2."""
    far, near = (
        compute("jacobian_change", NOTHING, {**ARM, "interval_s": s, "inverse": inverse}) for s in (1e-4, 1e-5)
    )
    assert far is not None
    assert near is not None
    assert far / near == pytest.approx(10.0, rel=0.02)


def test_only_the_share_of_the_links_counts() -> None:
    larger = compute("jacobian_change", NOTHING, {**ARM, "links_m": [0.2, 0.2], "interval_s": 2e-4})
    assert larger == pytest.approx(compute("jacobian_change", NOTHING, ARM), rel=1e-9)


def test_a_second_link_that_only_turns_turns_the_jacobian() -> None:
    """Elbow at 90 degrees, tip moved along the first link's circle about the shoulder: both columns turn by d / reach.

    The largest singular value of J turned by a, less J, is 2 sin(a / 2) that of J; other directions change it more.
    """
    reach = 0.1 * 2.0**0.5
    most = compute("jacobian_change", NOTHING, {**ARM, "elbow_deg": [90.0, 90.0], "inverse": False})
    assert most is not None
    assert most >= 100.0 * 2.0 * sin(0.5 * 1e-4 / reach) * (1.0 - 1e-3)
    # Both joint speeds are at most the speed over the least singular value, 0.062 m, and turn a column by 1 each.
    assert most <= 100.0 * 2.0 * 1e-4 / 0.0618


def test_a_singular_elbow_is_refused() -> None:
    with pytest.raises(UsageError, match="elbow_deg: must lie between 0 and 180"):
        compute("jacobian_change", NOTHING, {**ARM, "elbow_deg": [0.0, 90.0]})
