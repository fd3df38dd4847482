"""One claim for the terminal: its verdict first, then what the text says, by which rule, and every reading."""

from typing import Any

from hknob_cli.page.claims.verdict import NOT_TESTABLE, reading_text
from hknob_cli.report.table import folded


def claim_text(row: dict[str, Any]) -> str:
    """Lines as wide as the terminal; ``row``: that of ``claims.parquet``."""
    lines = [_answer(row), "", f"{row['claim']} ({row['place']})", f"The text says: {' '.join(row['says'].split())}"]
    if row["verdict"] != NOT_TESTABLE:
        lines.append(
            f"The rule: {row['tolerance'].replace('holds:', 'reproduced:')} ({' '.join(row['because'].split())})"
        )
    if row["readings"]:
        lines += ["Readings:", *(f"  {reading_text(reading, row['unit'])}" for reading in row["readings"])]
    if row["finding"]:
        lines.append(f"Finding: {' '.join(row['finding'].split())}")
    return folded("\n".join(lines))


def _answer(row: dict[str, Any]) -> str:
    """The verdict, and the number that it rests on."""
    verdict = row["verdict"].capitalize()
    if row["computed"] is None:
        return f"{verdict}: {' '.join(row['because'].split())}."
    unit = f" {row['unit']}" if row["unit"] else ""
    printed = "" if row["printed"] is None else f", printed {row['printed']:.4g}{unit}"
    of = f" ({row['reading']})" if row["agreeing"] < row["allowed"] or row["allowed"] > 1 else ""
    return f"{verdict}: computed {row['computed']:.4g}{unit}{printed}{of}."
