"""The picture of a calibration: readings as points, and the line through each set (Figs 77, 78 and 81)."""

from pathlib import Path
from typing import Any

from hknob_cli.figures.sheet import save
from hknob_cli.report.matrix import short

Row = dict[str, Any]
# What is on the axes, by unit: name, and scale to the unit that is shown.
_AXES = {
    "A": ("current", 1e3, "mA"),
    "N": ("force", 1.0, "N"),
    "N*m": ("torque", 1e3, "mN·m"),
    "V": ("voltage", 1.0, "V"),
}
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")  # Okabe & Ito's
_MARKERS = "o^sDvP"


def draw_calibration(quantities: list[Row], points: list[Row], *, title: str, path: Path) -> bool:
    """Draw into ``path`` (PNG): a panel for each range of the motor, one for all positions of the grip cell.

    False, drawing nothing, without points. Raises `ComputationError` if the file cannot be written.
    """
    if not points:
        return False
    from matplotlib.figure import Figure

    by_range = points[0]["x_unit"] == "A"
    names = list(dict.fromkeys(row["condition"] for row in points)) if by_range else ["readings"]
    figure = Figure(figsize=(1.0 + 6.2 * len(names), 5.0), layout="constrained")
    for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
        here = [row for row in points if not by_range or row["condition"] == name]
        sets = list(dict.fromkeys((row["quantity"], row["condition"]) for row in here))
        for i, (quantity, condition) in enumerate(sets):
            mine = sorted(
                (row for row in here if (row["quantity"], row["condition"]) == (quantity, condition)),
                key=lambda row: float(row["x"]),
            )
            (_, x_scale, _), (_, y_scale, _) = _AXES[mine[0]["x_unit"]], _AXES[mine[0]["y_unit"]]
            colour, marker = _COLOURS[i % len(_COLOURS)], _MARKERS[i % len(_MARKERS)]
            found = next(row for row in quantities if (row["quantity"], row["condition"]) == (quantity, condition))
            what = quantity if by_range else condition
            value = f"{what}: {short(found['value'], 3)} {found['unit'].replace('*', '·')}"
            xs = [x_scale * row["x"] for row in mine]
            axes.plot(xs, [y_scale * row["y"] for row in mine], marker, color=colour, label=value, markersize=6)
            axes.plot(xs, [y_scale * row["fitted"] for row in mine], "-", color=colour, linewidth=1.2)
        for put, unit in ((axes.set_xlabel, here[0]["x_unit"]), (axes.set_ylabel, here[0]["y_unit"])):
            word, _, shown = _AXES[unit]
            put(f"{word}, {shown}")
        if by_range:
            axes.set_title(name)
        axes.legend()
        axes.grid(alpha=0.3)
    figure.suptitle(f"{title}: readings, and the line through them")
    save(figure, path, stage="sysid", name=title)
    return True
