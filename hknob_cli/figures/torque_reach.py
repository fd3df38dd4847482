"""How far the torque of one count can move a knob at each pitch, and what is said and found of it (Hasser, Fig. 69)."""

from typing import TYPE_CHECKING

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import grid
from hknob_cli.figures.numbers import log_ticks
from hknob_cli.results.means import WORST
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MARGIN = 3.0  # factor of frequency that the line reaches beyond the points


@drawing
def torque_reach(
    evidence: ResultSet,
    of: list[str],
    *,
    names: list[str] | None = None,
    printed_hz: float | None = None,
    printed_rad: float | None = None,
) -> "Figure":
    """Peak to peak (mrad) over pitch (Hz): the most that +- half a count's torque gives the inertia, K q / (32 J f^2).

    The first ``of`` is a sweep of one cell, whose scene has the wall and the inertia; it and the others (sweeps and
    campaigns of one cell) are points, the largest cycle of each. ``printed_hz``, ``printed_rad``: what a text says.
    Raises `MissingError` where one is at rest.
    """
    from hknob_cli.specs.plan import scene_at
    from hknob_cli.theory.laws import working_edge

    points: list[tuple[str, float, float]] = []
    for name, said in zip(of, names or of, strict=True):
        cells = grid(evidence[name], columns=WORST).rows
        if len(cells) != 1 or not cells[0][WORST[0]]:
            raise MissingError(f"'{name}' is at rest, or of several cells")
        size, pitch = (float(cells[0][column]) for column in WORST)
        points.append((said, pitch, size))
    pitches = [pitch for _, pitch, _ in points] + ([printed_hz] if printed_hz else [])
    line = np.geomspace(min(pitches) / _MARGIN, max(pitches) * _MARGIN, 60)
    first = evidence[of[0]]
    cell = {axis: first.rows("cells")[0][axis] for axis in first.axes}
    edge = working_edge(scene_at(first.scene, cell), cell)
    at_one = edge.wall_stiffness * edge.quantum_rad / (32.0 * edge.inertia)  # a triangle of velocity, at 1 Hz
    drawn = theme.figure(3.3)
    panel = drawn.subplots()
    panel.plot(line, 1e3 * at_one / line**2, color="black", linewidth=1.2, label="half a count's torque, no losses")
    for i, (said, at_hz, p2p_rad) in enumerate(points):
        panel.plot([at_hz], [1e3 * p2p_rad], markersize=7, label=said, **theme.points(i))
    if printed_hz and printed_rad:
        reach = at_one / printed_hz**2
        panel.plot([printed_hz], [1e3 * printed_rad], markersize=13, marker="*", linestyle="none", color="black",
                   label="printed")  # fmt: skip
        panel.plot([printed_hz] * 2, [1e3 * reach, 1e3 * printed_rad], color="black", linestyle=":", linewidth=1.0)
        panel.text(1.05 * printed_hz, 1e3 * (reach * printed_rad) ** 0.5, f"{printed_rad / reach:.0f}-fold", fontsize=8)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xticks(*log_ticks(*panel.get_xlim()))
    panel.set_yticks(*log_ticks(*panel.get_ylim()))
    panel.set_xticks([], minor=True)
    panel.set_yticks([], minor=True)
    panel.set_xlabel("frequency, Hz")
    panel.set_ylabel("peak to peak, mrad")
    panel.legend(loc="lower left")
    return drawn
