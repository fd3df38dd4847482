"""What a remedy costs who builds the knob: firmware alone, stiffness, a faster loop, or a new part; the quietest ones.

A remedy is a change of a scene and its grid. What it touches tells what it takes: a controller is firmware, and so is
the wall, but a softer one is felt; a sample rate is a faster loop; all else, and a velocity sensor, is a part.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from hknob_cli.specs.plan import RATE

Row = Mapping[str, Any]
NOTHING, FIRMWARE, SOFTER, LOOP, PART = "nothing", "firmware only", "stiffness", "a faster loop", "a new part"
_ORDER = (NOTHING, FIRMWARE, SOFTER, LOOP, PART)
_MOST_NAMED = 3  # remedies that bring the knob to rest
_FELT = 0.9  # of the stiffness: where less is left, it is said


def effort_of(remedy: Mapping[str, Any]) -> str:
    """The most that a remedy asks for, as a spec has it: by its change, and the number that it tunes."""
    change = remedy.get("change") or {}
    asked = {_of_part(part, value) for part, value in (change.get("scene") or {}).items()}
    asked |= {LOOP if axis == RATE else _of_path(axis) for axis in change.get("grid") or {}}
    asked |= {_of_path(path) for path in remedy.get("tune") or {}}
    return max(asked, key=_ORDER.index, default=NOTHING)


def _of_path(path: str) -> str:
    part, _, key = path.partition(".")
    return _of_part(part, {key: None})


def _of_part(part: str, value: Any) -> str:
    keys = value if isinstance(value, Mapping) else {}
    if part == "wall":
        return SOFTER if "stiffness" in keys else FIRMWARE
    return FIRMWARE if part == "controller" and keys.get("velocity") != "sensor" else PART


def most_of(grid: Mapping[str, Row], costs: Mapping[str, str]) -> str:
    """The remedy that does most without stiffness, and of several at rest the cheapest; empty if none helps."""
    some = [name for name in grid if costs[name] not in (NOTHING, SOFTER)]
    return quietest_of(sorted(some, key=lambda name: _ORDER.index(costs[name])), grid)


def cost_lines(
    grid: Mapping[str, Row],
    quietest: str,
    *,
    needs: Mapping[str, str],
    costs: Mapping[str, str],
    kept: Mapping[str, float | None],
) -> list[str]:
    """What the remedies that do most cost, and the quietest in firmware alone where they are none.

    ``grid``: what each remedy does over the grid; ``quietest``: the one with the smallest buzz, empty if none helps;
    ``needs``: in words of the spec; ``costs``: of `effort_of`; ``kept``: shares of the stiffness, where they are known.
    """

    def cost(name: str) -> str:
        share = kept[name]
        left = f" It keeps {share:.2g} of the stiffness." if share is not None and share < _FELT else ""
        return f"{name} costs {costs[name]}{f': {needs[name]}' if needs[name] else ''}.{left}"

    still = [name for name, row in grid.items() if rests(row) and costs[name] != NOTHING]
    named = [*still[:_MOST_NAMED], *([quietest] if quietest else [])]
    lines = [cost(name) for name in named]
    if not named or any(costs[name] == FIRMWARE for name in named):
        return lines
    cheap = quietest_of([name for name in grid if costs[name] == FIRMWARE], grid)
    if not cheap:
        return [*lines, "None in firmware alone makes the buzz smaller."]
    does = "comes to rest everywhere" if rests(grid[cheap]) else f"{grid[cheap]['ratio_median']:.3g} times smaller"
    return [*lines, f"In firmware alone: {cheap}, {does}.", cost(cheap)]


def rests(row: Row) -> bool:
    """Whether a remedy brings the knob to rest everywhere."""
    return bool(row["at_rest_fraction"] > 1.0 - 1e-9)


def quietest_of(names: Sequence[str], grid: Mapping[str, Row]) -> str:
    """Of some remedies one that rests everywhere, else that which makes the largest cycles smallest; empty if none."""
    some = [name for name in names if rests(grid[name]) or (grid[name]["ratio_median"] or 0.0) > 1.0]
    return max(some, key=lambda name: (rests(grid[name]), grid[name]["ratio_median"] or 0.0), default="")
