"""A sweep that another spec is made of: validated as if it stood in a file, its faults where its parts were written."""

from typing import Any

from hknob_cli.spec.plan import SweepPlan
from hknob_cli.spec.source import Path_, Source


def derived_sweep(source: Source, values: dict[str, Any], places: dict[Path_, Path_]) -> SweepPlan:
    """The plan of the sweep that has these ``values``.

    ``places``: from where parts of it stand in ``source`` to where they are in the sweep; the last that fits wins.
    Raises `SpecError`, its faults at those places.
    """
    from hknob_cli.spec.load import validate

    derived = Source(source.name)
    derived.value, derived.waiting = values, source.waiting
    for stem, target in places.items():
        for kind in ("keys", "values", "overridden"):
            found = getattr(derived, kind)
            for path, place in list(getattr(source, kind).items()):
                if path[: len(stem)] == stem:
                    found[(*target, *path[len(stem) :])] = place
    plan = validate(derived, kind="sweep")
    assert isinstance(plan, SweepPlan)
    return plan
