"""What a judgment by thresholds may be wrong by: levels that are higher or lower, and other published thresholds."""

from typing import NamedTuple

from hknob_cli.perception.published import published
from hknob_cli.specs.design_plan import DesignPlan

REDRAWS = 1000  # of the people, with replacement


class Doubt(NamedTuple):
    """One way in which levels may be others: ``shift_db`` higher, or by another set of ``thresholds`` of touch."""

    name: str
    shift_db: float = 0.0
    thresholds: str | None = None


def other_sets(plan: DesignPlan) -> tuple[str, ...]:
    """Published thresholds of touch beside those that the plan judges by."""
    return tuple(name for name in published("touch")["thresholds"] if name != plan.perceive.thresholds)


def doubts(plan: DesignPlan) -> tuple[Doubt, ...]:
    """All that could change the answer of a search; none where no level is limited."""
    found: list[Doubt] = []
    if (plan.touch or plan.hearing) and plan.uncertainty_db > 0.0:
        off = plan.uncertainty_db
        found += [Doubt(f"levels {off:g} dB lower", -off), Doubt(f"levels {off:g} dB higher", off)]
    if plan.touch:
        found += [Doubt(f"thresholds {name}", thresholds=name) for name in other_sets(plan)]
    return tuple(found)
