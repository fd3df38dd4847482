"""What ear and hand are sensitive to over frequency: equal-loudness contours, and thresholds of vibration."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.figures import drawing, theme
from hknob_cli.results.result_set import ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TICKS_HZ = (20, 50, 100, 250, 600, 1000, 3000, 10000)


@drawing
def equal_loudness(
    _evidence: ResultSet, _of: Any = None, *, phon: Sequence[float] = (20, 40, 60, 80), edition: int | None = None
) -> "Figure":
    """Sound pressure level (dB) of pure tones that are as loud as one at 1 kHz, and the threshold (ISO 226).

    ``phon``: loudness levels, 20 to 90. Needs no result. Raises `UsageError` for another level or edition.
    """
    from hknob_cli.perception import hearing

    drawn = theme.figure(3.4)
    panel = drawn.subplots()
    frequency = np.geomspace(20.0, 12500.0, 400)
    threshold = hearing.hearing_threshold(frequency, edition=edition)
    panel.plot(frequency, threshold, color="black", linestyle="--")
    _name(panel, frequency, threshold, "threshold")
    for level in sorted(phon):
        there = hearing.is_specified(frequency, level)
        if not there.any():
            raise UsageError(f"phon: ISO 226 is for 20 to 90 phon, not {level:g}")
        heard = hearing.sound_pressure_level(frequency[there], level, edition=edition)
        panel.plot(frequency[there], heard, color=theme.COLOURS[0])
        _name(panel, frequency[there], heard, f"{level:g} phon")
    panel.set_ylabel("sound pressure level, dB re 20 µPa")
    panel.set_ylim(-12.0, 125.0)
    _frequencies(panel, TICKS_HZ, 20.0, 12500.0)
    return drawn


@drawing
def touch_thresholds(
    _evidence: ResultSet,
    _of: Any = None,
    *,
    sets: Sequence[str] = ("pen_hold", "cylinder", "thenar", "thenar_1988"),
    names: Sequence[str] | None = None,
) -> "Figure":
    """Least displacement of the skin (µm, peak) that is felt over frequency, by published sets of thresholds.

    Each line ends where its source does. Needs no result. Raises `UsageError` for an unknown set.
    """
    from hknob_cli.perception import touch

    drawn = theme.figure(3.2)
    panel = drawn.subplots()
    for i, (name, label) in enumerate(zip(sets, names or sets, strict=True)):
        found = touch.thresholds(name)
        frequency = np.geomspace(found.low_hz, found.high_hz, 200)
        style = theme.series(i) | {"linewidth": 1.6}
        panel.plot(frequency, 1e6 * touch.detection_threshold(frequency, name=name), label=label, **style)
        panel.plot(found.points[:, 0], 1e6 * found.points[:, 1], markersize=4.0, **theme.points(i))
    panel.set_yscale("log")
    panel.set_ylabel("threshold, µm peak")
    _frequencies(panel, (10, 20, 40, 100, 150, 250, 400), 9.0, 400.0)
    panel.legend(loc="lower left")
    return drawn


def _frequencies(panel: "Axes", ticks: Sequence[float], low: float, high: float) -> None:
    from matplotlib.ticker import NullFormatter, NullLocator

    panel.set_xscale("log")
    panel.set_xlim(low, high)
    panel.set_xticks(list(ticks), [f"{tick:g}" for tick in ticks])
    panel.xaxis.set_minor_locator(NullLocator())
    panel.xaxis.set_minor_formatter(NullFormatter())
    panel.set_xlabel("frequency, Hz")


def _name(panel: "Axes", frequency: np.ndarray, level: np.ndarray, text: str) -> None:
    """The contour's name on it, up to 1 kHz, where phon and decibels are the same."""
    at = int(np.abs(np.log(frequency / 1000.0)).argmin())
    panel.annotate(text, (frequency[at], level[at]), xytext=(-2, 3), textcoords="offset points", ha="right", fontsize=8)
