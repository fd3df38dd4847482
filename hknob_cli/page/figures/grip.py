"""Grip forces of the hardware test, a cell each trial (Hasser, Fig. 53, Table 8)."""

from typing import TYPE_CHECKING, Any

from hknob_cli.page import ink
from hknob_cli.page.figures import drawing
from hknob_cli.results.evidence import Evidence

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOWEST, TARGET, HIGHEST = 0.60, 0.71, 0.82  # N; the target is in the middle of the colours (Hasser, sec. 8.2)


@drawing
def grip_forces(_evidence: Evidence, _of: Any = None) -> "Figure":
    """Mean grip force (N) of each of the 16 trials, over sample rate and encoder resolution, written in its cell."""
    from hknob_cli.printed.tables import table

    rows: list[dict[str, Any]] = [row for row in table(8) if isinstance(row["encoder_bits"], float)]
    columns = [name for name in rows[0] if name.startswith("grip_") and name.endswith("_hz_n")]
    forces = [[float(row[name] or 0.0) for name in columns] for row in rows]
    drawn = ink.figure(2.4, width=4.6)
    panel = drawn.subplots()
    panel.pcolormesh(forces, cmap=ink.MAP, vmin=LOWEST, vmax=HIGHEST, edgecolors="none")
    for i, line in enumerate(forces):
        for j, force in enumerate(line):
            colour = ink.ON_DARK if force < TARGET else ink.ON_LIGHT
            panel.text(j + 0.5, i + 0.5, f"{force:.2f}", ha="center", va="center", color=colour)
    panel.set_xticks([j + 0.5 for j in range(len(columns))], [name.split("_")[1] for name in columns])
    panel.set_yticks([i + 0.5 for i in range(len(rows))], [f"{2 ** int(row['encoder_bits'])}" for row in rows])
    panel.tick_params(length=0)
    panel.grid(visible=False)
    panel.set_xlabel("sample rate, Hz")
    panel.set_ylabel("counts per revolution")
    return drawn
