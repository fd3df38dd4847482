"""What ear and hand are sensitive to, and the optimisation by the senses (Hasser, sec. 10.7, Fig. 70)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Layout, grid, notes
from hknob_cli.figures.heat import norm_of
from hknob_cli.figures.maps import draw_surface, ending
from hknob_cli.results.result_set import MissingError, ResultSet

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


FELT, HEARD = SENSES = "touch_db", "hearing_db"


@drawing
def sensory_surface(
    evidence: ResultSet,
    of: str,
    *,
    layout: Layout,
    mesh: bool = False,
) -> "Figure":
    """The larger of the levels of touch and of sound above their thresholds, dB, over two axes; small is good.

    A letter says which of the two it is (t: touch, h: hearing); the best cell of each row has a frame. Each level is
    that of the cell's most noticeable cycle. Raises `MissingError`, also where sound has no gain.
    """
    if HEARD not in evidence[of].table("cells").column_names:
        raise MissingError(f"the sound of '{of}' has no level: its perceive has no sound_gain and no sound_response")
    cells = grid(evidence[of], layout, columns=SENSES)
    felt, heard = (cells.values(column) for column in SENSES)
    values = [[_larger(*both) for both in zip(*lines, strict=True)] for lines in zip(felt, heard, strict=True)]
    flat = [value for line in values for value in line]
    if not any(value == value for value in flat):
        raise MissingError(f"'{of}' has no limit cycle")
    texts = [
        [
            f"{value:.0f} {'t' if touch == value else 'h'}" if value == value else ending(cell)
            for value, touch, cell in zip(*lines, strict=True)
        ]
        for lines in zip(values, felt, cells.cells, strict=True)
    ]
    label = "more noticeable of the two, dB above threshold"
    figure = draw_surface(cells, values, texts, norm=norm_of(flat, log=False), label=label, mesh=mesh, least=2)
    said = "t: touch is the more noticeable;  h: hearing;  frame: best of its row"
    figure.supxlabel(";  ".join(filter(None, [said, notes([cells], FELT)])), fontsize=8)
    return figure


def _larger(one: float, other: float) -> float:
    """The larger of two levels; of one that is known and one that is not (NaN), the known."""
    return one if other != other or one >= other else other
