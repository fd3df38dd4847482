"""What published thresholds say of touch and hearing over frequency, and levels of results beside one another."""

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import check, one_number, rows_of
from hknob_cli.results.result_set import ResultSet, Where
from hknob_cli.specs.plan import COUNTS, RATE

AUDIBLE_HZ = (20.0, 12500.0)  # where ISO 226 has values


@check
def touch_optimum(_evidence: ResultSet, thresholds: str) -> float:
    """Frequency, Hz, at which a published set of thresholds of touch is least; the middle where several are."""
    from hknob_cli.perception import touch

    points = touch.thresholds(thresholds).points
    least = points[points[:, 1] <= points[:, 1].min() * (1.0 + 1e-9), 0]
    return float(0.5 * (least.min() + least.max()))


@check
def sensed_trough(
    evidence: ResultSet, result: str, over: str | None = None, where: Where | None = None, statistic: str = "median"
) -> float | None:
    """Sample rate, Hz, of the least of max(touch_db, hearing_db); a statistic over resolutions.

    ``over``: over that of another result. Cells at rest are left out, as in the check `trough`.
    """
    found = _least_noticed(evidence, result, where, statistic)
    if over is None or found is None:
        return found
    other = _least_noticed(evidence, over, where, statistic)
    return None if other is None else found / other


def _least_noticed(evidence: ResultSet, result: str, where: Where | None, statistic: str) -> float | None:
    best: dict[float, tuple[float, float]] = {}
    for row in rows_of(evidence, result, "cells", where, needs=["touch_db", "hearing_db", RATE, COUNTS]):
        levels = [row[name] for name in ("touch_db", "hearing_db") if row[name] is not None]
        if levels:
            here = (max(levels), row[RATE])
            best[row[COUNTS]] = min(best.get(row[COUNTS], here), here)
    return one_number((rate for _, rate in best.values()), statistic)


@check
def touch_drop(_evidence: ResultSet, thresholds: str, from_hz: float, to_hz: float) -> float:
    """How far the threshold of touch falls from one frequency to another, dB of displacement."""
    from hknob_cli.perception import touch

    first, second = touch.detection_threshold([from_hz, to_hz], name=thresholds)
    return float(20.0 * np.log10(first / second))


@check
def hearing_optimum(_evidence: ResultSet, phon: float | None = None) -> float:
    """Frequency, Hz, at which the least sound pressure is heard, or is as loud as ``phon`` (ISO 226), to 0.2 %."""
    frequency = np.geomspace(*AUDIBLE_HZ, 4000)
    return float(frequency[np.nanargmin(_contour(frequency, phon))])


@check
def hearing_change(_evidence: ResultSet, from_hz: float, to_hz: list[float], phon: float | None = None) -> float:
    """Largest size of the change of ISO 226's threshold, or contour of ``phon``, from a frequency to others, dB."""
    levels = _contour(np.array([from_hz, *to_hz]), phon)
    return float(np.abs(levels[1:] - levels[0]).max())


@check
def hearing_range(_evidence: ResultSet, from_hz: float, to_hz: float, phon: float | None = None) -> float:
    """Largest less least level of ISO 226's threshold, or contour of ``phon``, between two frequencies, dB."""
    return float(np.ptp(_contour(np.geomspace(from_hz, to_hz, 400), phon)))


@check
def hearing_falloff(_evidence: ResultSet, below_hz: float, above_hz: float, phon: float | None = None) -> float:
    """Rise of ISO 226's threshold, or contour of ``phon``, over the octave below one frequency and above another, dB.

    The lesser of the two.
    """
    octaves = _contour(np.array([0.5 * below_hz, below_hz, above_hz, 2.0 * above_hz]), phon)
    return float(min(octaves[0] - octaves[1], octaves[3] - octaves[2]))


@check
def level_difference(
    evidence: ResultSet, column: str, result: str, to: str, where: Where | None = None, to_where: Where | None = None
) -> float | None:
    """A level (dB) in one cell less the same in another, of the same or another result; means where several fit."""
    first = one_number((row[column] for row in rows_of(evidence, result, "cells", where, needs=[column])), "mean")
    second = one_number((row[column] for row in rows_of(evidence, to, "cells", to_where, needs=[column])), "mean")
    return None if first is None or second is None else first - second


@check
def torque_step_level(
    _evidence: ResultSet, stiffness_nm_per_rad: float, counts_per_rev: int, threshold: str = "least"
) -> float:
    """Level, dB, of the torque step of a count (N·m/rad times its angle) over the least variation that was detected.

    ``threshold``: the least of the published averages, or the largest, over the spatial periods of the experiment. A
    count finer than these periods is compared all the same.
    """
    from hknob_cli.perception import touch
    from hknob_cli.perception.level import threshold_set

    found = threshold_set("torque", None)
    published = {"least": found["torque_nm"], "largest": found["largest_nm"]}
    if threshold not in published:
        raise UsageError(f"threshold: must be least or largest, got '{threshold}'")
    step = touch.torque_step(stiffness_nm_per_rad, counts_per_rev)
    return float(20.0 * np.log10(step / published[threshold]))


def _contour(frequency: np.ndarray, phon: float | None) -> np.ndarray:
    """Levels, dB re 20 µPa, of the threshold or of a loudness level."""
    from hknob_cli.perception import hearing

    if phon is None:
        return hearing.hearing_threshold(frequency)
    return hearing.sound_pressure_level(frequency, phon)
