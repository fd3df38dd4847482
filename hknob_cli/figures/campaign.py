"""The trials of a campaign as thumbnails, and one of them in full (Hasser, Fig. 54, App. D).

Samples of a campaign's trials, and their steady parts: what the drawings of them start from.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pyarrow as pa

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.panel import edges_between, scale_of
from hknob_cli.report.table import short
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.specs.plan import COUNTS, RATE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

Row = dict[str, Any]
MOST = 6  # rows, and columns, of thumbnails

LEAST_COUNTS = 3  # of the device's own encoder: less is not drawn larger, to either side
_STILL_S = 0.1  # of a trial at rest
_MARKED = 250  # samples up to which each has its dot


@dataclass(frozen=True)
class Held:
    """One trial: its row, and arrays (n,) over the samples with the wall on; SI units, time from when it came on.

    ``angle`` by the device's own encoder, ``torque`` commanded; ``steady`` where the buzz was steady;
    ``wall_stiffness`` in N·m/rad.
    """

    row: Row
    time: np.ndarray
    angle: np.ndarray
    torque: np.ndarray
    grip: np.ndarray
    steady: np.ndarray
    wall_stiffness: float

    @property
    def place(self) -> str:
        """Rate and resolution in words."""
        return f"{short(self.row[RATE], 6)} Hz, {self.row[COUNTS]} counts"

    @property
    def quantum(self) -> float:
        """One count of the wall's encoder, rad."""
        return 2.0 * pi / float(self.row[COUNTS])

    def last(self, span_s: float) -> np.ndarray:
        """Which samples are the last ``span_s`` of the steady part; of a trial without one, of all."""
        if not self.time.size:  # the wall was never on
            return self.steady
        end = float(self.time[self.steady][-1]) if self.steady.any() else float(self.time[-1])
        kept: np.ndarray = (self.time >= end - span_s) & (self.time <= end)
        return kept


def _tried(evidence: ResultSet, of: str, remedy: str) -> list[Row]:
    """Trials of a campaign, or those of a remedy that it tried. Raises `MissingError` where there is no such remedy."""
    rows = evidence[of].rows("trials")
    there = list(dict.fromkeys(row["remedy"] for row in rows if "remedy" in row))
    if there and not remedy:
        raise MissingError(f"'{of}' tried several remedies; give one of them as 'remedy': {', '.join(there)}")
    if remedy and remedy not in there:
        raise MissingError(f"'{of}' tried no remedy '{remedy}'; it has {', '.join(there) or 'none'}")
    return [row for row in rows if not remedy or row["remedy"] == remedy]


def held_trials(evidence: ResultSet, of: str, remedy: str = "") -> list[Held]:
    """The first trial of every cell, by resolution and rate; ``remedy``: under which, where a campaign tried several.

    Raises `MissingError` where no samples were kept, or there is no such remedy.
    """
    from pydantic import TypeAdapter

    from hknob_cli.specs.campaign import Wall

    stiffness = TypeAdapter(Wall).validate_python(evidence[of].provenance["spec"].get("wall") or {}).stiffness
    try:
        return held_of(_tried(evidence, of, remedy), evidence[of].table("samples"), stiffness)
    except MissingError as error:
        raise MissingError(f"{error} in '{of}'") from None


def held_of(trials: Sequence[Row], table: pa.Table, stiffness: float) -> list[Held]:
    """The first of ``trials`` of every cell, with its samples; ``stiffness``: of walls whose rows lack it, N·m/rad.

    Raises `MissingError` where there are none of them.
    """
    first: dict[tuple[int, float], Row] = {}
    for row in trials:
        key = (row[COUNTS], row[RATE])
        if key not in first or row["block"] < first[key]["block"]:
            first[key] = row
    number = table["trial"].to_numpy()
    found = []
    for _, row in sorted(first.items()):
        rows = np.flatnonzero(number == row["order"])
        if not rows.size:
            raise MissingError(f"no samples of trial {row['order']}")
        part = table.slice(int(rows[0]), int(rows[-1] - rows[0] + 1))
        running = part["running"].to_numpy(zero_copy_only=False)
        place = np.arange(running.size)
        steady = (place >= row["steady_first"]) & (place <= row["steady_last"]) & bool(row["sustained"])
        time, angle, torque, grip = (
            part[name].to_numpy()[running] for name in ("time_s", "angle_rad", "torque_nm", "grip_n")
        )
        begin = time[0] if time.size else 0.0
        spring = row.get("wall_stiffness", stiffness)
        found.append(Held(row, time - begin, angle, torque, grip, steady[running], spring))
    return found


def one_trial(evidence: ResultSet, of: str, *, sample_rate_hz: float, counts_per_rev: int, remedy: str = "") -> Held:
    """The first trial of a cell, under a remedy if one is named. Raises `MissingError` if there is none."""
    for trial in held_trials(evidence, of, remedy):
        if abs(trial.row[RATE] - sample_rate_hz) < 1e-6 and trial.row[COUNTS] == counts_per_rev:
            return trial
    raise MissingError(f"'{of}' has no trial at {sample_rate_hz:g} Hz and {counts_per_rev} counts")


@drawing
def campaign_thumbnails(evidence: ResultSet, of: str, *, cycles: float = 8.0, remedy: str = "") -> "Figure":
    """The end of the steady part of each cell's first trial: ``cycles`` of them, angle (mrad) about its mean.

    Rates rise to the right, resolutions downward, as in the print; a row has one scale. Trials without a sustained buzz
    are grey, their last 0.1 s. ``remedy``: under which, of a campaign that tried several. Raises `MissingError` where
    no samples were kept, for another remedy, or for more than 6 rates or resolutions.
    """
    trials = held_trials(evidence, of, remedy)
    rates, counts = sorted({one.row[RATE] for one in trials}), sorted({one.row[COUNTS] for one in trials})
    if max(len(rates), len(counts)) > MOST:
        raise MissingError(f"'{of}' has {len(counts)} resolutions at {len(rates)} rates, too many for thumbnails")
    drawn = theme.figure(0.85 * len(counts) + 0.9)
    draw_thumbnails(drawn, trials, cycles=cycles)
    return drawn


def draw_thumbnails(drawn: "FigureBase", trials: list[Held], *, cycles: float) -> None:
    """Draw them into a figure, or a part of one, as `campaign_thumbnails` says."""
    rates, counts = sorted({one.row[RATE] for one in trials}), sorted({one.row[COUNTS] for one in trials})
    panels = drawn.subplots(len(counts), len(rates), sharey="row", squeeze=False)
    reach = dict.fromkeys(counts, 0.0)
    for trial in trials:
        count = trial.row[COUNTS]
        panel = panels[counts.index(count)][rates.index(trial.row[RATE])]
        reach[count] = max(reach[count], _thumbnail(panel, trial, cycles))
    for j, rate in enumerate(rates):
        panels[0][j].set_title(f"{short(rate, 6)} Hz", fontsize=9)
    for i, count in enumerate(counts):
        panels[i][0].set_ylabel(f"{count}\nmrad", fontsize=8)
        panels[i][0].set_ylim(-1.1 * reach[count], 1.1 * reach[count])
    text = f"time, ms: the last {cycles:g} cycles of the buzz;  grey: at rest, 0.1 s;  angle about its mean"
    drawn.supxlabel(text, fontsize=8)


def _thumbnail(panel: "Axes", trial: Held, cycles: float) -> float:
    """Draw one; how far its scale must reach, mrad."""
    buzzes = bool(trial.row["sustained"] and trial.row["cycle_hz"])
    shown = trial.last(cycles / trial.row["cycle_hz"] if buzzes else _STILL_S)
    panel.tick_params(labelsize=7)
    panel.locator_params(axis="both", nbins=4)
    panel.grid(alpha=0.25)
    least = 1e3 * LEAST_COUNTS * 2.0 * pi / float(trial.row["native_counts"])
    if not shown.any():
        return least
    time, angle = 1e3 * trial.time[shown], 1e3 * trial.angle[shown]
    angle -= angle.mean()
    panel.plot(time - time[0], angle, linewidth=0.9, color=theme.COLOURS[0] if buzzes else theme.COLOURS[6])
    panel.margins(x=0.0)
    return max(least, float(np.abs(angle).max()))


class Part(NamedTuple):
    """The part of a trial that is drawn: the last ``cycles`` of the steady part, or from ``from_s`` to ``to_s``.

    These are s from when the wall came on. A trial without a sustained buzz has its last 0.1 s drawn.
    """

    cycles: float = 8.0
    from_s: float | None = None
    to_s: float | None = None

    def of(self, trial: Held) -> np.ndarray:
        """Which samples of a trial it has, (n,)."""
        if self.from_s is not None or self.to_s is not None:
            end = float(trial.time[-1]) if self.to_s is None else self.to_s
            return np.asarray((trial.time >= (self.from_s or 0.0)) & (trial.time <= end))
        buzzes = bool(trial.row["sustained"] and trial.row["cycle_hz"])
        return trial.last(self.cycles / trial.row["cycle_hz"] if buzzes else _STILL_S)


@drawing
def campaign_trial(
    evidence: ResultSet,
    of: str,
    *,
    sample_rate_hz: float,
    counts_per_rev: int,
    part: Part,
    grip: bool = True,
    remedy: str = "",
) -> "Figure":
    """One trial: angle by the device's own encoder, below it the torque, with the angle that the wall sees, and grip.

    Angles in mrad, or µrad if small, torque in mN·m, grip in N. ``remedy``: under which, of a campaign that tried
    several. Raises `MissingError` where there is no such trial, or nothing in that part.
    """
    trial = one_trial(evidence, of, sample_rate_hz=sample_rate_hz, counts_per_rev=counts_per_rev, remedy=remedy)
    shown = part.of(trial)
    if shown.sum() < 2:
        raise MissingError(f"'{of}' has no samples there, at {trial.place}")
    heights = [2.2, 1.1, *([0.9] if grip else [])]
    drawn = theme.figure(0.9 + sum(heights))
    panels = drawn.subplots(len(heights), 1, height_ratios=heights)
    begin = float(trial.time[shown][0])
    unit = scale_of(trial.angle[shown])
    time, angle = 1e3 * (trial.time[shown] - begin), unit.factor * trial.angle[shown]
    marks = {"marker": "o", "markersize": 2.6} if shown.sum() <= _MARKED else {}
    panels[0].plot(time, angle, color=theme.COLOURS[0], **marks)
    low, high = panels[0].get_ylim()
    panels[0].axhspan(min(low, 0.0), 0.0, color="black", alpha=0.06, linewidth=0)
    panels[0].axhline(0.0, color="black", linewidth=0.8, linestyle=(0, (4, 2)))
    for edge in edges_between(low, high, unit.factor * trial.quantum):
        panels[0].axhline(edge, color="black", linewidth=0.5, alpha=0.35, linestyle=(0, (1, 2)))
    panels[0].set_ylim(low, high)
    panels[0].set_ylabel(f"angle, {unit.prefix}rad")
    panels[1].plot(time, 1e3 * trial.torque[shown], drawstyle="steps-post", color=theme.COLOURS[1])
    panels[1].set_ylabel("torque, mN\u00b7m")
    if trial.wall_stiffness > 0.0:
        per = -1.0 / trial.wall_stiffness
        own = panels[1].secondary_yaxis("right", functions=(lambda torque: per * torque, lambda angle: angle / per))
        own.set_ylabel("angle seen, mrad")
        own.spines["right"].set_visible(True)
    for panel in panels[:2]:
        panel.set_xlim(time[0], time[-1])
    panels[0].tick_params(labelbottom=False)
    panels[1].set_xlabel(f"time, ms, from {begin:.3g} s after the wall came on" if begin else "time, ms")
    if grip:
        _draw_grip(panels[2], trial, shown)
    drawn.align_ylabels(list(panels))
    return drawn


def _draw_grip(panel: "Axes", trial: Held, shown: np.ndarray) -> None:
    """Grip force of the whole trial; the part that is shown above is shaded."""
    step = max(1, trial.time.size // 400)
    panel.plot(trial.time[::step], trial.grip[::step], color=theme.COLOURS[2])
    panel.axvspan(*trial.time[shown][[0, -1]], color="black", alpha=0.12, linewidth=0)
    panel.set_ylim(0.0, 1.2 * float(trial.grip.max()))
    panel.set_xlim(0.0, float(trial.time[-1]))
    panel.set_ylabel("grip, N")
    panel.set_xlabel("time with the wall on, s; shaded: shown above")
