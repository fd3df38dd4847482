"""What a sweep says of touch and hearing: which levels it has, their names, and the finding in a sentence."""

from typing import Any, NamedTuple

from hknob_cli.perception.published import published


class Level(NamedTuple):
    """A column of levels in dB: title over a table or picture, head of a list."""

    column: str
    title: str
    head: str


_LEVELS = (
    Level("touch_db", "touch, dB above threshold (the harmonic of a cycle that is felt best)", "touch dB"),
    Level("hearing_db", "sound, dB above threshold (the most audible harmonic)", "sound dB"),
    Level("hearing_relative_db", "sound, relative dB (no sound gain given: only differences mean something)", "sound"),
)


def perceived_levels(rows: list[dict[str, Any]]) -> list[Level]:
    """Levels that cells have a value of, none where a sweep was not asked for them."""
    return [one for one in _LEVELS if any(row.get(one.column) is not None for row in rows)]


def level_limits(rows: list[dict[str, Any]], level: Level) -> tuple[float, float]:
    """Ends of a scale for a level: from threshold or below, but for a relative one, which has no threshold."""
    known = [row[level.column] for row in rows if row[level.column] is not None]
    low = min(known) if level.column == "hearing_relative_db" else min(0.0, *known)
    return low, max(low + 1.0, *known)


def perceived_text(rows: list[dict[str, Any]]) -> list[str]:
    """How many cells are felt and heard, and where nothing is published."""
    found = []
    for fraction, level, verb in (("felt_fraction", "touch_db", "felt"), ("heard_fraction", "hearing_db", "heard")):
        if level not in rows[0]:
            continue
        known = [row for row in rows if row[level] is not None]
        some = [row[level] for row in known if row[fraction] > 0.0]
        text = f"{verb} in {len(some)} of {len(known)} cells with a level"
        if some:
            text += f", by {_span(some)} dB above an average person's threshold"
        missing = sum(map(_cycles, rows)) - len(known)
        found.append(text + (f"; {missing} with cycles have none, outside what is published" if missing > 0 else ""))
        if level == "touch_db" and known:
            found.append(touch_uncertainty())
    steps = [row["torque_step_db"] for row in rows if row.get("torque_step_db") is not None]
    if steps:
        less = f" ({len(rows) - len(steps)} cells are outside what is published)" if len(steps) < len(rows) else ""
        found.append(f"torque step of a count: {_span(steps)} dB above the least variation detected{less}")
    return found


def _span(values: list[float]) -> str:
    low, high = f"{min(values):.3g}", f"{max(values):.3g}"
    return low if low == high else f"{low} to {high}"


def touch_uncertainty() -> str:
    """How well a level of touch is known: the reading of one set of thresholds, and the sets among each other."""
    data = published("touch")
    return (
        f"levels of touch are known to about {data['within_set_db']} dB within one set of thresholds, "
        f"to about {data['between_sets_db']} dB between sets"
    )


def _cycles(row: dict[str, Any]) -> bool:
    return bool(row["at_rest_fraction"] + row["diverged_fraction"] + row["undecided_fraction"] < 1.0)
