"""What an encoder leaves of a velocity that is differenced from its counts (Hasser, sec. 10.2, item 6)."""

from itertools import pairwise
from math import floor, pi, sqrt

from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.grid import exponent
from hknob_cli.page.claims.checks.motion import motion
from hknob_cli.results.result_set import MissingError, ResultSet, Where

SAMPLE = "sample"


@check
def velocity_error(evidence: ResultSet, result: str, counts_per_rev: int, where: Where | None = None) -> float | None:
    """Error (% of its rms) of the velocity of a recorded motion if its samples were read by an encoder of such counts.

    The error is the difference of two readings less that of the two angles, over the sample period; rms. The motion is
    that of the recording, whatever sensor it was under.
    """
    samples = [point for point in motion(evidence, result, where) if point.event == SAMPLE]
    if len(samples) < 3:
        raise MissingError(f"no samples are recorded in '{result}'")
    count = 2.0 * pi / counts_per_rev
    wrong, whole = 0.0, 0.0
    for before, now in pairwise(samples):
        true = now.angle - before.angle
        read = count * (floor(now.angle / count) - floor(before.angle / count))
        wrong, whole = wrong + (read - true) ** 2, whole + true**2
    return 100.0 * sqrt(wrong / whole) if whole else None


@check
def velocity_error_exponent(
    evidence: ResultSet, result: str, counts_per_rev: list[int], where: Where | None = None
) -> float | None:
    """Exponent of `velocity_error` as a power of the counts per revolution; -1: in proportion to the count."""
    line = [(float(counts), velocity_error(evidence, result, counts, where)) for counts in counts_per_rev]
    return exponent([(at, value) for at, value in line if value is not None])
