"""What people notice of a design, how designs are ranked, and how sure the answer of a search is.

How sure it is: what the answer would be with other levels, other thresholds, other people.
"""

from collections.abc import Callable, Mapping, Sequence
from math import inf, isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.perception.level import REDRAWS, Doubt
from hknob_cli.results.columns import together
from hknob_cli.specs.stage_plans import DesignPlan, Limit
from hknob_cli.stages.design.designs import Design

Rows = Sequence[dict[str, Any]]
ANY = Limit(most_db=0.0, people=0.0, above_present=False)  # where there is no limit
ROUNDING = 1e-9  # relative, of stiffness: a wall that renders exactly what is asked renders it

SENSES = ("touch", "hearing")


class Judged(NamedTuple):
    """A design's numbers, as columns say them, and its failures: limit to how far it is from being met, in words."""

    row: dict[str, Any]
    fails: dict[str, str]
    felt_db: float  # -inf at rest, inf where not known
    asked: dict[str, tuple[Limit, list[float]]]  # by sense that is limited, of each person what the limit is about, dB
    others: dict[str, list[float]]  # the same of touch, by other published thresholds


def judge(plan: DesignPlan, rows: Rows, present: Rows, stiffness: float) -> Judged:
    """A design by the ``rows`` of its people, those of the ``present`` design, and its stiffness (N·m/rad)."""
    heard = "hearing_db" if plan.perceive.gained else "hearing_relative_db"
    found: dict[str, float] = {}
    asked_of: dict[str, tuple[Limit, list[float]]] = {}
    for sense, column, limit in (("touch", "touch_db", plan.touch), ("hearing", heard, plan.hearing)):
        levels = [level(row, column) for row in rows]
        over = [above(mine, level(row, column)) for mine, row in zip(levels, present, strict=True)]
        found |= _noticed(sense, levels, over, limit)
        if limit:
            asked_of[sense] = limit, over if limit.above_present else levels
    step = rows[0]["torque_step_db"]
    fails = _failures(plan, stiffness, asked_of, step)
    margin = min((limit.most_db - exceeded_by(some, limit.people) for limit, some in asked_of.values()), default=inf)
    largest = max(rows, key=lambda one: -1.0 if one["p2p_max_rad"] is None else one["p2p_max_rad"])
    domain = [one["in_domain"] for one in rows if one.get("in_domain") is not None]
    row = {
        "p2p_max_rad": largest["p2p_max_rad"],
        "frequency_at_max_hz": largest["frequency_at_max_hz"],
        "p2p_rad": _mean(rows, "p2p_rad"),
        "frequency_hz": _mean(rows, "frequency_hz"),
        "in_domain": all(domain) if domain else None,
        "margin_db": margin if isfinite(margin) else None,
        "stiffness_nm_per_rad": stiffness,
        **{name: value if isfinite(value) else None for name, value in found.items()},
        "torque_step_db": step,
        "unknown": sum(level(one, "touch_db") == inf for one in rows) / len(rows),
        "at_rest_fraction": _mean(rows, "at_rest_fraction"),
        "certified_fraction": _mean(rows, "certified_fraction"),
        "certified": all(one["certified_fraction"] == 1.0 for one in rows),
        "feasible": not fails,
        "fails": ", ".join(f"{name} {text}" for name, text in fails.items()),
        **(together(list(rows)) if plan.ranged else {}),
    }
    return Judged(
        row=row, fails=fails, felt_db=found["touch_db"], asked=asked_of, others=_by_other_sets(plan, rows, present)
    )


def _failures(
    plan: DesignPlan, stiffness: float, asked: Mapping[str, tuple[Limit, list[float]]], step: float | None
) -> dict[str, str]:
    """Limits that are not met, and how far each is from being met; ``step`` is the torque step, dB."""
    fails: dict[str, str] = {}
    if plan.stiffness is not None and not stiffness >= plan.stiffness * (1.0 - ROUNDING):
        fails["stiffness"] = f"{stiffness:.3g} N*m/rad" if isfinite(stiffness) else "not known"
    for sense, (limit, levels) in asked.items():
        most = exceeded_by(levels, limit.people)
        if most > limit.most_db:
            fails[sense] = f"{most - limit.most_db:+.1f} dB" if isfinite(most) else "not known"
    if plan.torque_step_db is not None and (step is None or step > plan.torque_step_db):
        fails["torque step"] = f"{step - plan.torque_step_db:+.1f} dB" if step is not None else "not known"
    return fails


def _noticed(sense: str, levels: list[float], over: list[float], limit: Limit | None) -> dict[str, float]:
    """Columns of one sense: the people's ``levels``, dB, and how far those are ``over`` the present ones."""
    asked = limit or ANY
    judged = over if asked.above_present else levels
    share = sum(one > asked.most_db for one in judged) / len(judged)
    return {
        f"{sense}_db": exceeded_by(levels, asked.people),
        f"{sense}_above_present_db": exceeded_by(over, asked.people),
        f"{sense}_above": share if limit or sense == "touch" else nan,
    }


def _by_other_sets(plan: DesignPlan, rows: Rows, present: Rows) -> dict[str, list[float]]:
    """What a limit of touch is about, of each person, by thresholds that others have published."""
    names = rows[0].get("by_set", {}) if plan.touch else {}
    found: dict[str, list[float]] = {}
    for name in names:
        levels = [row["by_set"][name] for row in rows]
        there = [row["by_set"][name] for row in present]
        over = [above(mine, other) for mine, other in zip(levels, there, strict=True)]
        found[name] = over if plan.touch and plan.touch.above_present else levels
    return found


def level(row: dict[str, Any], column: str) -> float:
    """A person's level, dB: -inf at rest, inf where it is not known of every trial."""
    if row["undecided_fraction"] + row["diverged_fraction"] > 0.0:
        return inf
    if row[column] is not None:
        return float(row[column])
    return -inf if row["at_rest_fraction"] == 1.0 else inf


def above(level_db: float, present_db: float) -> float:
    """How far a level is above the present one, dB; anything is far above rest, and rest is above nothing."""
    if level_db == -inf or level_db == inf:
        return level_db
    return inf if present_db in (-inf, inf) else level_db - present_db


def exceeded_by(levels: Sequence[float], share: float) -> float:
    """The least level that at most a share of the people are above."""
    allowed = int(share * len(levels) + 1e-9)
    return sorted(levels, reverse=True)[allowed]


def _mean(rows: Rows, column: str) -> float:
    values = [row[column] for row in rows if row[column] is not None]
    return sum(values) / len(values) if values else nan


def meets(one: Judged, doubt: Doubt) -> bool:
    """Whether a design meets every limit if ``doubt`` is right."""
    if set(one.fails) - set(SENSES):
        return False
    for sense, (limit, levels) in one.asked.items():
        judged = one.others[doubt.thresholds] if sense == "touch" and doubt.thresholds else levels
        # A level that is exactly the present one's is of the same cycle, and differs from it by nothing.
        same = limit.above_present
        shifted = [level if same and level == 0.0 else level + doubt.shift_db for level in judged]
        if exceeded_by(shifted, limit.people) > limit.most_db:
            return False
    return True


def rank(done: Mapping[Design, Judged], order: Mapping[Design, int]) -> Callable[[Design], tuple[float, float, int]]:
    """What designs are ranked by: cost; of equal cost what is felt of them; then their ``order`` in the spec."""
    return lambda one: (one.cost, done[one].felt_db, order[one])


def answer_if(done: Mapping[Design, Judged], order: Mapping[Design, int], doubt: Doubt, most: float) -> Design | None:
    """The cheapest that is good if ``doubt`` is right; None where it costs more than ``most``, or there is none."""
    good = [design for design, one in done.items() if design.cost <= most and meets(one, doubt)]
    return min(good, key=rank(done, order), default=None)


def redrawn(
    done: Mapping[Design, Judged], order: Mapping[Design, int], most: float = inf, *, seed: int = 1
) -> dict[Design, float]:
    """Share of redraws of the people, with replacement, in which a design is the answer; the rest cost more.

    Only those that cost at most ``most`` are compared: all of them have been evaluated.
    """
    designs = sorted((one for one in done if one.cost <= most), key=rank(done, order))
    people = max((len(levels) for one in done.values() for _, levels in one.asked.values()), default=0)
    if not people:
        return {}
    drawn = np.random.default_rng(seed).multinomial(people, np.full(people, 1.0 / people), REDRAWS)
    left = np.ones(REDRAWS, dtype=bool)
    found: dict[Design, float] = {}
    for design in designs:
        one = done[design]
        if set(one.fails) - set(SENSES):
            continue
        good = left.copy()
        for limit, levels in one.asked.values():
            over = np.array(levels) > limit.most_db
            good &= drawn @ over <= int(limit.people * people + 1e-9)
        if good.any():
            found[design] = float(good.sum()) / REDRAWS
        left &= ~good
    return found
