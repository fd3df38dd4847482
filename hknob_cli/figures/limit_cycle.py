"""Settled cycles: in the phase plane, the way in faint and the limit cycle strong (Hasser, Fig. 72), and side by side.

Side by side they are drawn over time, with the harmonics of the speed, which is what a clip of it is.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.panel import edges_between, key, scale_of
from hknob_cli.figures.recording import At, Of, Recording, one_recording, settled_period
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ARROWS = 4  # along the cycle


@drawing
def phase_plane(
    evidence: ResultSet,
    of: Of,
    *,
    at: At | None = None,
    from_s: float | None = None,
    to_s: float | None = None,
    steady_s: float = 0.05,
    samples: bool = True,
    height: float = 4.0,
) -> "Figure":
    """Velocity (rad/s) over angle of one recording.

    The last ``steady_s`` (s) of the window are strong, what comes before faint; ``samples`` marks where the controller
    reads in the strong part. ``height`` in inches. Raises `MissingError`.
    """
    one = one_recording(evidence, of, at=at, from_s=from_s, to_s=to_s)
    begin = float(one.time[-1]) - steady_s
    steady = one.between(begin, None)
    if steady.time[0] == one.time[0]:
        raise MissingError(f"{steady_s:g} s of '{one.name}' are more than the window shown")
    unit = scale_of(one.angle)
    drawn = theme.figure(height, width=5.6)
    panel = drawn.subplots()
    before = one.time <= steady.time[0]
    panel.plot(
        unit.factor * one.angle[before], one.velocity[before], color="black", linewidth=0.8, alpha=0.45, label="way in"
    )
    panel.plot(unit.factor * steady.angle, steady.velocity, label="steady", **theme.series(0))
    if samples:
        dots: dict[str, Any] = {"color": theme.COLOURS[1], "marker": "o", "linestyle": "none", "markersize": 3.0}
        read = steady.samples
        panel.plot(unit.factor * steady.angle[read], steady.velocity[read], label="samples", **dots)
    _point(panel, steady, unit.factor)
    _rule(panel, one, unit.factor)
    panel.set_xlabel(f"angle, {unit.prefix}rad")
    panel.set_ylabel("velocity, rad/s")
    key(panel)
    return drawn


def _point(panel: "Axes", steady: Recording, factor: float) -> None:
    """Arrows in the direction of motion, at equal parts of one cycle."""
    peaks, _, up = steady.turns
    tops = peaks[up]
    if len(tops) < 2:
        return
    span = float(tops[1] - tops[0])
    for part in (np.arange(ARROWS) + 0.5) / ARROWS:
        times = tops[0] + span * (part + np.array([0.0, 0.02]))
        (x0, x1), (y0, y1) = (np.interp(times, steady.time, of) for of in (factor * steady.angle, steady.velocity))
        arrow: dict[str, Any] = {
            "arrowstyle": "-|>",
            "color": theme.COLOURS[0],
            "shrinkA": 0,
            "shrinkB": 0,
            "mutation_scale": 13,
        }
        panel.annotate("", (x1, y1), xytext=(x0, y0), arrowprops=arrow)


def _rule(panel: "Axes", one: Recording, factor: float) -> None:
    """The wall, shaded and with its edge dotted, and count edges; what is in view has a name in the key."""
    low, high = panel.get_xlim()
    if one.scene.wall.stiffness > 0.0:
        panel.axvspan(min(low, 0.0), 0.0, color="black", alpha=0.06, linewidth=0)
        name = "edge of the wall" if low < 0.0 < high else "_"
        panel.axvline(0.0, color="black", linewidth=1.1, linestyle=":", label=name)
    edges = edges_between(low, high, factor * one.quantum)
    for i, edge in enumerate(edges):
        name = "_" if i else "edge of a count"
        panel.axvline(edge, color="black", linewidth=0.8, alpha=0.6, linestyle=(0, (1, 2)), label=name)
    panel.set_xlim(low, high)


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
