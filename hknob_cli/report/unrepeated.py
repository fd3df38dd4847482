"""Words on motion that never repeats: teeth that rattle, and a sample clock that jitters."""

from collections.abc import Sequence

from hknob_cli.report.table import short


def of_cells(some: int, count: int) -> str:
    """So many of the cells, in words."""
    if count == 1:
        return "this cell"
    how_many = "any of " if not some else "all " if some == count else f"{some:,} of "
    return f"{how_many}{count:,} cells"


def range_text(values: Sequence[float], unit: str) -> str:
    """The least and the largest, in words; one where both are written alike."""
    low, high = short(min(values)), short(max(values))
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"


def rattle_text(swings: Sequence[float], where: str = "") -> str:
    """A sentence, after a space, on teeth that part and meet again in no order; empty where none do."""
    if not swings:
        return ""
    swing = f"the knob swings by {range_text([1e3 * one for one in swings], 'mrad')} (one trial each, not proven)"
    return f" It moves on{where} and no trial repeats: {swing}."


def jitter_text(swings: Sequence[float], where: str = "", *, behind: bool = False) -> str:
    """A sentence, after a space, on trials that a jittering clock keeps from repeating; empty where there are none.

    ``behind``: whether the swings are those of a motor, with the knob behind a gear that yields.
    """
    if not swings:
        return ""
    what = "motor" if behind else "knob"
    swing = f"the {what} swings by {range_text([1e3 * one for one in swings], 'mrad')} on average"
    return (
        f" It buzzes{where} without repeating, because the sample clock jitters: {swing} (one trial each, not proven)."
    )


def every_clock_text(bounds: Sequence[float], cells: int = 1) -> str:
    """A sentence, after a space, on what is proven for every clock, in some of so many ``cells``."""
    swings = [1e3 * one for one in bounds if one > 0.0]
    said = []
    if rests := len(bounds) - len(swings):
        said.append(f"it comes to rest{f' in {of_cells(rests, cells)}' if cells > 1 else ''}")
    if swings:
        where = f" in {of_cells(len(swings), cells)}" if cells > 1 else ""
        said.append(f"in the end it swings by at most {range_text(swings, 'mrad')}{where}, largest less smallest angle")
    return f" Whatever the intervals are, {' and '.join(said)} (proven)." if said else ""
