"""A figure that is drawn once when it is saved.

Matplotlib draws a figure with a layout twice: once with the pen up, so that its layout is made, and once for good. The
layout asks each artist for its size itself, and needs no such drawing. The bytes are the same, in two thirds of the
time. `theme` loads this where a figure is made.
"""

from typing import Any

from matplotlib.figure import Figure  # noqa: TID253
from matplotlib.layout_engine import ConstrainedLayoutEngine  # noqa: TID253


class LaidOut(Figure):
    """A figure with a constrained layout."""

    def draw(self, renderer: Any) -> None:
        """Draw it; where it is being saved and has no layout yet, make only that."""
        engine = self.get_layout_engine()
        if isinstance(engine, ConstrainedLayoutEngine) and self.canvas.is_saving():
            engine.execute(self)
            return
        super().draw(renderer)
