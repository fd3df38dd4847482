"""Settled cycles side by side: the angle over time, and the harmonics of the speed, which is what a clip of it is."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.recording import At, settled_period
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FLOOR_DB = 50.0  # below the strongest harmonic of all: fainter ones are not drawn


@drawing
def cycle_spectra(
    evidence: ResultSet,
    of: str | Sequence[str],
    *,
    names: Sequence[str] | None = None,
    at: At | None = None,
    shown_s: float = 0.05,
    highest_hz: float = 4000.0,
) -> "Figure":
    """Angle about its mean (mrad) over ``shown_s``, and the peak speed of each harmonic (mrad/s) up to ``highest_hz``.

    A row for each recording, which has settled to a proven cycle; all rows have the same scales. Harmonics fainter than
    the strongest of all by 50 dB are left out. Raises `MissingError`.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    from hknob_cli.recordings.spectrum import recorded_harmonics

    results = [of] if isinstance(of, str) else list(of)
    titles = list(names or results)
    if len(titles) != len(results):
        raise MissingError(f"{len(results)} recordings, but {len(titles)} names")
    periods = [settled_period(evidence, name, at=at) for name in results]
    motions = [recorded_harmonics(one.time, one.velocity, highest_hz=highest_hz) for one in periods]
    most = max(float(motion.speed_rad_s.max(initial=0.0)) for motion in motions)
    drawn = theme.figure(0.6 + 1.05 * len(results))
    panels = drawn.subplots(len(results), 2, squeeze=False, sharex="col", sharey="col", width_ratios=[1.25, 1.0])
    for i, ((left, right), title, one, motion) in enumerate(zip(panels, titles, periods, motions, strict=True)):
        length = one.time[-1] - one.time[0]
        repeats = int(np.ceil(shown_s / length)) + 1
        times = np.concatenate([one.time[:-1] - one.time[0] + k * length for k in range(repeats)])
        angles = np.tile(one.angle[:-1] - one.angle.mean(), repeats)
        left.plot(1e3 * times, 1e3 * angles, **{**theme.series(i), "linestyle": "-"})
        left.set_title(title, loc="left")
        kept = motion.speed_rad_s > most * 10.0 ** (-FLOOR_DB / 20.0)
        stems: dict[str, Any] = {"color": theme.COLOURS[i % len(theme.COLOURS)]}
        speed, floor = 1e3 * motion.speed_rad_s[kept], 1e3 * most * 10.0 ** (-FLOOR_DB / 20.0)
        right.vlines(motion.frequency_hz[kept], floor, speed, linewidth=0.9, **stems)
        right.plot(motion.frequency_hz[kept], speed, markersize=2.5, **{**theme.points(i), **stems})
    panels[0][0].set_xlim(0.0, 1e3 * shown_s)
    side = panels[0][1]
    side.set_xscale("log")
    side.set_yscale("log")
    side.set_xlim(10.0, highest_hz)
    side.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    side.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
    side.xaxis.set_minor_formatter(NullFormatter())
    panels[-1][0].set_xlabel("time, ms")
    panels[-1][1].set_xlabel("frequency of the harmonic, Hz")
    drawn.supylabel("left: angle about its mean, mrad;  right: peak speed, mrad/s", fontsize=8)
    return drawn
