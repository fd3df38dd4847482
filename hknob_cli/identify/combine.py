"""From fits of blocks to a person's numbers, and from persons to a table: the spread between them is the error.

A fit's own standard error says how well one motion tells its model. The hand itself differs from trial to trial, which
no single fit can know; only repeated blocks show it.
"""

from collections.abc import Iterable
from math import hypot, isfinite, nan, sqrt
from statistics import fmean, stdev
from typing import NamedTuple

from hknob_cli.identify.fit import Estimate
from hknob_cli.identify.quality import judged


class Spread(NamedTuple):
    """Mean, standard deviation (n - 1; NaN of one), coefficient of variation std/mean, and how many."""

    mean: float
    std: float
    cv: float
    number: int


def over_blocks(estimates: Iterable[Estimate]) -> Estimate:
    """One person's value of one condition: the mean over blocks, its standard error from the spread between them.

    Blocks that are not finite are left out. Of a single block the fit's own standard error, which leaves out the hand's
    variation; of none, NaN. What a misfit of the model makes of the fits' errors is common to the blocks: its mean is
    added. An interval is the mean ± Student's t of (blocks - 1) degrees times this: 4.3 for three.
    """
    kept = [one for one in estimates if isfinite(one.value)]
    if not kept:
        return Estimate(nan, nan, False)
    if len(kept) == 1 or all(one.std == 0.0 for one in kept):  # a single one, or one that is known
        return kept[0]
    values = [one.value for one in kept]
    misfit = fmean(one.misfit for one in kept)
    return judged(fmean(values), hypot(stdev(values) / sqrt(len(values)), misfit), misfit)


def over_subjects(values: Iterable[float]) -> Spread:
    """Mean, standard deviation (n - 1) and coefficient of variation over persons, as Tables 1 to 5; of finite ones."""
    kept = [value for value in values if isfinite(value)]
    if not kept:
        return Spread(nan, nan, nan, 0)
    mean = fmean(kept)
    std = stdev(kept) if len(kept) > 1 else nan
    return Spread(mean, std, std / mean if mean else nan, len(kept))


def student(level: float, degrees: int) -> float:
    """Half width of a two-sided interval at ``level`` (0.95), in standard errors, with these degrees of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(degrees, 0.5 + 0.5 * level))
