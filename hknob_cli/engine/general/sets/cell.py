"""What the functions of sets have in common: the cell whose states are followed, and the state a set is told from."""

from typing import Any, NamedTuple


class Cell(NamedTuple):
    """A cell of the grid, as its sets of states are followed.

    ``drift``: bounds on roundings, `drift.Drift`; ``known``: the ends so far, `ends.Known`, with the law of a
    controller and the room for turning points; ``body``: what moves; ``wall``: what commands.
    """

    drift: Any
    known: Any
    body: Any
    wall: Any


class Centre(NamedTuple):
    """The state that a set is told from, which is that of a trial, and what all states of the set share.

    Attributes:
        z: State, (order); functions that move a set change it in place.
        before: What the controller remembers of the last reading, `readings.remembered`.
        ring: Commands under way, or what a law remembers; changed in place.
        head: Where the oldest of them is.
        error: Bound on the rounding error of the state, in `body.norm`.
        level: Reading as which all states of the set acted last, or as which they act now.
        sample: Samples taken so far; half a sample more says that ``level`` is settled for the next.
        weight: Measure of the starts that are in the set.
    """

    z: Any
    before: float
    ring: Any
    head: int
    error: float
    level: float
    sample: float
    weight: float


def acting_as(centre, level, before, error):
    """The same set, which acts as ``level``, after a reading ``before``, told to within ``error``."""
    return Centre(centre.z, before, centre.ring, centre.head, error, level, centre.sample, centre.weight)
