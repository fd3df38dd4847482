"""Errors of a differenced velocity, against readings written out by hand."""

from math import sqrt
from typing import Any

import pytest

from hknob_cli.page.claims.checks import compute
from hknob_cli.results.result_set import MissingError
from tests.page.claims.conftest import Made
from tests.page.claims.test_motion import row

COUNTS = 1000


def turned(made: Made, name: str, angles: list[float], *, event: str = "sample") -> Any:
    """A recording at whole milliseconds, angles in counts of 1000 a revolution, with a row between that is none."""
    rows = [row(0.001 * i, angle, event=event) for i, angle in enumerate(angles)]
    return made(name, {"trajectories": [*rows[:1], row(0.0005, 9.0), *rows[1:]]})


def test_the_error_is_that_of_the_readings(made: Made) -> None:
    """Angles 0.5, 1.2, 1.6 read as 0, 1, 1: moved by 0.7 and 0.4, read as 1 and 0."""
    evidence = turned(made, "a", [0.5, 1.2, 1.6])
    expected = 100.0 * sqrt((0.3**2 + 0.4**2) / (0.7**2 + 0.4**2))
    given = {"result": "a", "counts_per_rev": COUNTS}
    assert compute("velocity_error", evidence, given) == pytest.approx(expected, rel=1e-9)


def test_of_a_fast_motion_the_error_goes_with_the_count(made: Made) -> None:
    """Many counts a sample: each difference is off by a triangle of +-1 count, rms 1/sqrt(6), whatever the count."""
    golden = 0.5 * (sqrt(5.0) - 1.0)
    evidence = turned(made, "a", [7.0 * golden * i + 3.0 * golden * i * i for i in range(400)])
    given = {"result": "a", "counts_per_rev": [COUNTS, 2 * COUNTS, 4 * COUNTS]}
    assert compute("velocity_error_exponent", evidence, given) == pytest.approx(-1.0, abs=0.05)
    speeds = [7.0 * golden + 3.0 * golden * (2 * i + 1) for i in range(399)]
    rms = sqrt(sum(speed**2 for speed in speeds) / len(speeds))
    # 399 errors of a bounded law: four standard errors of their rms are below 10 %.
    found = compute("velocity_error", evidence, {"result": "a", "counts_per_rev": COUNTS})
    assert found == pytest.approx(100.0 / sqrt(6.0) / rms, rel=0.1)


def test_without_samples_there_is_no_velocity(made: Made) -> None:
    evidence = turned(made, "a", [0.5, 1.2, 1.6], event="")
    with pytest.raises(MissingError, match="no samples are recorded in 'a'"):
        compute("velocity_error", evidence, {"result": "a", "counts_per_rev": COUNTS})
