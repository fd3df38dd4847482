"""What sets of states are to what follows them: told from a centre, moved by the free plant alone, cut by positions."""

from typing import Protocol, Self

import numpy as np

from hknob_cli.controllers.plant_batch import Array


class Shape(Protocol):
    """Sets of states side by side, each told from a centre that is followed elsewhere.

    All states of a set had the same counts so far, and so the same torques and memory: their differences move as
    motions of the free plant do. ``after``: a part of a sample interval, from the last sample on.
    """

    def take(self, sets: np.ndarray) -> Self:
        """Some of them, by index."""

    def join(self, other: Self) -> Self:
        """These, then others."""

    def share(self) -> Array:
        """Of each, the measure of the starts that are in it, as a part of all."""

    def radius(self, sets: np.ndarray) -> Array:
        """Bound on the distance of states from the centre at this sample: |d|^2 = x^2 + v^2 / beta, counts."""

    def blur(self, sets: np.ndarray) -> Array:
        """Bound on the rounding of what is told of a set, in the same norm."""

    def extent(self, sets: np.ndarray, after: float) -> tuple[Array, Array]:
        """Least and largest position less the centre's."""

    def cut(self, sets: np.ndarray, after: float, low: Array, high: Array) -> tuple[np.ndarray, Self]:
        """Parts of ``sets`` with positions, less the centre's, from ``low`` to ``high``: of which each is, and they.

        A set may be named more than once, and has no part, one or several. Parts are told from the same centres.
        """

    def recentre(self, sets: np.ndarray) -> tuple[Array, Array]:
        """Tell some from a centre in their middle; by how far the centres are moved, counts and counts a sample."""

    def advance(self) -> None:
        """Go on by one sample."""
