"""A search for a design on the terminal: the answer, what binds it, what less would cost, and the front."""

import re
from typing import Any

import pyarrow as pa

from hknob_cli.perception.level import REDRAWS, doubts
from hknob_cli.report.table import matrix, short, table
from hknob_cli.results.columns import from_where
from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.specs.stage_plans import DesignPlan

Row = dict[str, Any]
MOST_FRONT = 20  # lines
SAID = (
    "Costs add. The share of people is of their hands (inertia, damping, stiffness); all have the same, average",
    "threshold, because no source gives the spread of thresholds between persons. All push as the base says.",
)


def describe_design(plan: DesignPlan, table: pa.Table) -> Row:
    """Summary as plain data: the answer, the present design, what binds, the next cheaper, the front, Fig. 70."""
    rows = table.to_pylist()
    chosen = flagged(rows, "chosen")
    cheaper = flagged(rows, "next_cheaper")
    steps = [
        {"choice": name, "from": chosen[name], "to": row[name], "saves": chosen["cost"] - row["cost"], **row}
        for row in rows
        for name in row["relaxes"].split(", ")
        if name and chosen
    ]
    plain = [row for row in rows if row["notional"] is not None]
    return {
        "people": plan.people,
        "designs": plan.size,
        "evaluated": len(rows),
        "exhaustive": len(rows) == plan.size,
        "feasible": sum(row["feasible"] for row in rows),
        "limits": limits(plan),
        "chosen": chosen,
        "present": flagged(rows, "present"),
        "binding": {step["choice"]: step["fails"] for step in steps},
        "relaxed": steps,
        "outside_domain": sum(row.get("in_domain") is False for row in rows),
        "uncertainty_db": plan.uncertainty_db,
        "answer_if": {one.name: _answer_if(rows, one.name) for one in doubts(plan)},
        "redrawn": _redrawn(rows),
        "next_cheaper": cheaper,
        "next_cheaper_touch_db": _more(cheaper, chosen, "touch_db"),
        "next_cheaper_hearing_db": _more(cheaper, chosen, "hearing_above_present_db"),
        "front": [row for row in rows if row["front"]],
        "notional": [{name: row[name] for name in (RATE, COUNTS, "notional", "touch_db")} for row in plain],
        "notional_best": min(plain, key=lambda row: row["notional"], default=None),
    }


def _answer_if(rows: list[Row], name: str) -> Row | None:
    """The design that would be the answer if levels or thresholds were others; None where that would cost more."""
    return next((row for row in rows if name in row["answer_if"].split("; ")), None)


def _redrawn(rows: list[Row]) -> list[Row]:
    """Answers of redraws of the people, the most frequent first; empty where people are listed."""
    found = [row for row in rows if row.get("redrawn")]
    return sorted(found, key=lambda row: -float(row["redrawn"]))


def flagged(rows: list[Row], flag: str) -> Row | None:
    """The first row that has a flag; None where none has."""
    return next((row for row in rows if row[flag]), None)


def _more(row: Row | None, than: Row | None, column: str) -> float | None:
    if row is None or than is None or row[column] is None or than[column] is None:
        return None
    return float(row[column] - than[column])


def limits(plan: DesignPlan) -> list[str]:
    """What is asked for, in words."""
    found = []
    if plan.stiffness is not None:
        found.append(f"stiffness at least {plan.stiffness:g} N*m/rad")
    for name, limit in (("touch", plan.touch), ("hearing", plan.hearing)):
        if limit:
            over = "the present design" if limit.above_present else "threshold"
            who = f"at most {100 * limit.people:g} % of people" if limit.people else "nobody"
            found.append(f"{name}: {who} more than {limit.most_db:g} dB above {over}")
    if plan.torque_step_db is not None:
        found.append(f"torque step at most {plan.torque_step_db:g} dB")
    return found


def design_text(plan: DesignPlan, summary: Row) -> str:
    """The answer as lines, and the front as a table."""
    stale = " (up to date)" if summary["status"] == "up to date" else ""
    lines = [
        f"{summary['name']}: {summary['evaluated']} of {summary['designs']} designs evaluated for"
        f" {summary['people']} people{stale}",
        *(f"  {one}" for one in summary["limits"]),
        "",
        *_answer(plan, summary),
        "",
        *_table(plan, summary),
    ]
    best, surface = summary["notional_best"], _surface(summary["notional"])
    if best and surface:
        lines += ["", *surface]
        lines.append(
            f"The notional surface of Hasser's Fig. 70 (above) is least at {best[RATE]:g} Hz and {best[COUNTS]} counts,"
            f" where the knob {_felt(best)}."
        )
    return "\n".join([*lines, "", " ".join(SAID)])


def _answer(plan: DesignPlan, summary: Row) -> list[str]:
    chosen, there = summary["chosen"], summary["present"]
    if chosen is None:
        lines = ["No design meets every limit; all were evaluated."]
    else:
        proof = "Every orbit of everyone is proven." if chosen["certified"] else _unproven(chosen)
        lines = [
            f"The cheapest design that meets every limit: {name_of(plan, chosen)}",
            f"  It costs {chosen['cost']:g} and {_felt(chosen)}. {proof}",
        ]
        lines += [f"  {_extent(chosen)}"] if plan.ranged else []
        if chosen.get("in_domain") is False:
            lines.append(
                "  WARNING: for some hands its bounded_lag is outside the domain that"
                " docs/reference/controllers.md states"
            )
        for step in summary["relaxed"]:
            what = f"{step['choice']} {_value(step['to'])} in place of {_value(step['from'])}"
            lines.append(f"  {what} would save {step['saves']:g}, but {misses(step['fails'])}")
        cheaper = summary["next_cheaper"]
        if cheaper:
            lines.append(f"The next cheaper design: {name_of(plan, cheaper)}")
            lines.append(f"  It costs {cheaper['cost']:g} and {_felt(cheaper)}.")
    lines.append(f"The present design: {name_of(plan, there)}")
    lines.append(f"  It costs {there['cost']:g} and {_felt(there)}.")
    lines += [f"  {_extent(there)}"] if plan.ranged else []
    return [*lines, *_how_sure(plan, summary)]


def misses(fails: str) -> str:
    """By how much a cheaper design misses which limits: of ``fails``, the text of its row."""
    parts = [
        one.replace(" +", " by ") if " +" in one else re.sub(r" (?=\d|not)(.*)", r" (\1)", one)
        for one in fails.split(", ")
    ]
    return f"misses the limit of {' and of '.join(parts)}" if fails else "meets every limit"


def _how_sure(plan: DesignPlan, summary: Row) -> list[str]:
    """What would change the answer: levels that are others, other thresholds, other people."""
    found, chosen = summary["answer_if"], summary["chosen"]
    if not found or chosen is None:
        return []
    off = summary["uncertainty_db"]
    same = [name for name, row in found.items() if row is chosen]
    lines = [""]
    if chosen["margin_db"] is None:
        lines.append("How sure: the tightest limit is met by rest, or its level is not known.")
    else:
        close = f", less than the {off:g} dB to which levels are known" if chosen["margin_db"] < off else ""
        lines.append(f"How sure: the tightest limit is met by {chosen['margin_db']:.1f} dB{close}.")
    if same:
        lines.append(f"  The answer stays the same with {', '.join(same)}.")
    for name, row in found.items():
        if row is None:
            lines.append(f"  With {name} the answer is a dearer design.")
        elif row is not chosen:
            lines.append(f"  With {name} it is {name_of(plan, row)}, at a cost of {row['cost']:g}.")
    return [*lines, *_others_drawn(plan, summary)]


def _others_drawn(plan: DesignPlan, summary: Row) -> list[str]:
    """How often other people of the same population would have given another answer."""
    if not plan.drawn:
        return []
    chosen, found = summary["chosen"], summary["redrawn"]
    lines = [
        f"  With {plan.people} other people, by {REDRAWS} redraws: the same answer in {100 * chosen['redrawn']:.0f} %,"
        f" a dearer one in {100 * (1.0 - sum(row['redrawn'] for row in found)):.0f} %."
    ]
    other = next((row for row in found if row is not chosen), None)
    if other:
        lines.append(
            f"  In {100 * other['redrawn']:.0f} % it is {name_of(plan, other)}, at a cost of {other['cost']:g}."
        )
    return lines


def _extent(row: Row) -> str:
    """How large its largest cycle is, of which starts that is, and what one start ends in."""
    from_ = from_where(row)
    whose = {
        "all": "of every start in the ranges, as is proven",
        "not all": "of the starts in the ranges whose end is proven",
    }.get(from_, f"of {from_} random starts in the ranges; others may end in larger ones")
    return (
        f"its largest cycle is {_size(row['p2p_max_rad'])}, {whose}; from one start {_size(row['p2p_one_start_rad'])}"
    )


def _size(value: float | None) -> str:
    return "unbounded" if value is None else "none (at rest)" if value == 0.0 else f"{1e3 * value:.3g} mrad"


def _unproven(row: Row) -> str:
    return (
        f"It is NOT PROVEN for all: {100 * (1.0 - row['certified_fraction']):.2g} % of the trials have no certificate."
    )


def name_of(plan: DesignPlan, row: Row) -> str:
    """A design in words: its remedy, and the values of its choices, by label where they have one."""
    parts = [row["remedy"]]
    for choice in plan.choices:
        label = next((one.label for one in choice.options if one.value == row[choice.name]), "")
        units = {RATE: "Hz", COUNTS: "counts"}.get(choice.name, f"{choice.unit} {choice.name}")
        parts.append(label or f"{row[choice.name]:g} {units}")
    return ", ".join(parts)


def _value(value: Any) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _felt(row: Row) -> str:
    """How much the most noticeable cycle is felt, above an average person's threshold."""
    if row["touch_db"] is not None:
        return f"is felt by {row['touch_db']:.1f} dB"
    return "has no known level of touch" if row.get("unknown") else "comes to rest"


def _table(plan: DesignPlan, summary: Row) -> list[str]:
    also = [row for row in (summary["chosen"], summary["present"]) if row and not row["front"]]
    rows = sorted([*summary["front"][-MOST_FRONT:], *also], key=lambda row: row["cost"])
    heads = ["cost", "touch dB", "ear dB", "step dB", "K", "proven %", "design"]
    lines = [
        "Cost against touch; ear: sound over the present design's. Nothing stiff enough and as cheap is felt less:"
    ]
    body = []
    for row in rows:
        cells = [
            f"{row['cost']:g}",
            short(row["touch_db"], 3) if row["touch_db"] is not None else ("?" if row["unknown"] else "rest"),
            short(row["hearing_above_present_db"], 3),
            short(row["torque_step_db"], 3),
            short(row["stiffness_nm_per_rad"], 3),
            f"{100 * row['certified_fraction']:.4g}",
        ]
        mark = " <- present" if row["present"] else ""
        mark += " <- chosen" if row["chosen"] else f" (fails {row['fails']})" if row["fails"] else ""
        body.append([*cells, f"{name_of(plan, row)}{mark}"])
    return [*lines, *table(heads, body, left={6}, flow=6)]


def _surface(rows: list[Row]) -> list[str]:
    axes = [RATE, COUNTS]
    if len({row[RATE] for row in rows}) < 2 or len({row[COUNTS] for row in rows}) < 2:
        return []
    return matrix(rows, axes, "notional", scale=1.0, title="notional, 0 to 1: larger of log peak to peak and frequency")
