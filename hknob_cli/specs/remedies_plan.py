"""A trial of remedies as plain values."""

from typing import Any, NamedTuple

from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.preset_plan import Preset

KNOCKS = 4  # trials of a knock on the wall, their sample clocks spread over an interval


class Tuned(NamedTuple):
    """A remedy at one ``value`` (SI) of the number that it tunes; its sweeps as in `Remedy`."""

    value: float
    grid: Any
    cases: tuple[Any, ...]


class Remedy(NamedTuple):
    """A remedy: what it ``needs``, its sweep over the ``grid``, and over each of the ``cases``; persons are the hands.

    The sweeps are `SweepPlan`s, of the first value where it tunes. ``source``: where the remedy is from; ``tunes``:
    the number of the scene that it tunes, by its dotted path, and ``tuned`` its values; empty where it does not.
    """

    name: str
    needs: str
    source: str
    grid: Any
    cases: tuple[Any, ...]
    tunes: str = ""
    tuned: tuple[Tuned, ...] = ()


class RemediesPlan(NamedTuple):
    """A trial: names of ``hands``; ``cases`` with their sample rate (Hz) and counts; the ``reference``'s name.

    ``torques`` (N·m), ``speed`` (rad/s), ``duration`` (s): how the stiffness is felt out.
    """

    name: str
    hands: tuple[str, ...]
    cases: tuple[tuple[str, float, int], ...]
    remedies: tuple[Remedy, ...]
    reference: str
    torques: tuple[float, float]
    speed: float
    duration: float
    values: dict[str, Any]
    preset: Preset | None = None

    @property
    def further(self) -> dict[str, str]:
        """Axes of the grid beside sample rate, counts and hands, with their units."""
        from hknob_cli.specs.plan import COUNTS, PERSON, RATE

        grid = self.remedies[0].grid
        return {name: grid.units[name] for name in grid.axes if name not in (RATE, COUNTS, PERSON)}

    @property
    def varied(self) -> dict[str, str]:
        """Those of the `further` axes that have several values."""
        grid = self.remedies[0].grid
        return {name: unit for name, unit in self.further.items() if len(grid.axes[name]) > 1}

    @property
    def ranged(self) -> bool:
        """Whether every start in a range is meant."""
        return self.remedies[0].grid.starts.span is not None

    @property
    def perceive(self) -> Perceive | None:
        """How levels are judged, where they are asked for."""
        how: Perceive | None = self.remedies[0].grid.perceive
        return how
