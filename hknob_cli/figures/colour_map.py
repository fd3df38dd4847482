"""A map with colours on one scale, and the colour in which to write on each cell."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def colour_map(axes: "Axes", values: Any, label: str, *, limits: tuple[float, float] | None = None) -> list[list[str]]:
    """Draw one map; the colour in which to write on each of its cells.

    Colours are on a log scale of the values above 0, or with ``limits`` on an even one between these.
    """
    import numpy as np
    from matplotlib.colors import LogNorm, Normalize

    shown = values if limits else np.where(values > 0, values, np.nan)
    found = shown[np.isfinite(shown)]
    low, high = (float(found.min()), float(found.max())) if found.size else (1.0, 1.0)
    norm = Normalize(*limits) if limits else LogNorm(low, high if high > low else low * 1.01)
    axes.set_facecolor("0.85")
    image = axes.imshow(shown, origin="lower", aspect="auto", cmap="cividis", norm=norm)
    axes.set_title(label, fontsize=10)
    axes.tick_params(length=0)
    # Relative luminance (ITU-R BT.709) decides; cells without a value are light grey.
    light = image.to_rgba(shown)[..., :3] @ np.array([0.2126, 0.7152, 0.0722])
    return [
        ["white" if dark and some else "black" for dark, some in zip(*row, strict=True)]
        for row in zip(light < 0.5, np.isfinite(shown), strict=True)
    ]
