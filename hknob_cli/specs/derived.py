"""A sweep that another spec is made of: validated as if it stood in a file, its faults where its parts were written."""

from typing import Any

from hknob_cli.errors import Fault
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.specs.source import Path_, Source, dotted, paths_in


class _Derived(Source):
    """What a spec is merged to; ``written``: by path in it, the path in the file."""

    written: dict[Path_, Path_]

    def fault(self, path: Path_, message: str, *, at_key: bool = False) -> Fault:
        """As `Source.fault`, with the key as it stands in the file."""
        for end in range(len(path), 0, -1):
            if path[:end] in self.written:
                key = (*self.written[path[:end]], *path[end:])
                break
        else:
            key = ("base", *path)
        return super().fault(path, message, at_key=at_key)._replace(key=dotted(key))


def derived_sweep(source: Source, values: dict[str, Any], places: dict[Path_, Path_]) -> SweepPlan:
    """The plan of the sweep that has these ``values``.

    ``places``: from where parts of it stand in ``source`` to where they are in the sweep; the last that fits wins.
    Raises `SpecError`, its faults at those places.
    """
    from hknob_cli.specs.load import validate

    derived = _Derived(source.name)
    derived.value, derived.waiting, derived.written = values, source.waiting, {}
    for stem, target in places.items():
        for kind in ("keys", "values", "overridden", "inherited"):
            found = getattr(derived, kind)
            for path, place in list(getattr(source, kind).items()):
                if path[: len(stem)] == stem:
                    there = (*target, *path[len(stem) :])
                    found[there] = place
                    if there:
                        derived.written[there] = path
        _open_overrides(source, derived, stem, target)
    plan = validate(derived, kind="sweep", presets=False)
    assert isinstance(plan, SweepPlan)
    return plan


def _open_overrides(source: Source, derived: _Derived, stem: Path_, target: Path_) -> None:
    """Note every key inside what was set as a whole: else its faults stand where the base has that key."""
    for end in range(1, len(stem) + 1):
        option = source.overridden.get(stem[:end])
        if option is None:
            continue
        value = source.value
        for step in stem:
            value = value.get(step) if isinstance(value, dict) else None
        for inner in paths_in(value):
            derived.overridden[(*target, *inner)] = option
            derived.written[(*target, *inner)] = (*stem, *inner)
