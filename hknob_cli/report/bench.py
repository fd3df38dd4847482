"""A benchmark in words and numbers: who is accurate where, and at what cost."""

from typing import Any

from hknob_cli.report.table import table
from hknob_cli.report.verdicts import compared

VERDICTS = {
    "accurate": "A",
    "inaccurate": "i",
    "wrong attractor": "W",
    "failed": "F",
    "too slow": "S",
    "no reference": "N",
}

Rows = list[dict[str, Any]]


def describe_bench(rows: Rows) -> dict[str, Any]:
    """Summary as plain data: runs, counts of verdicts by method, and times at equal error by scene."""
    methods = list(dict.fromkeys(row["method"] for row in rows))
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    return {
        "scenes": scenes,
        "methods": methods,
        "verdicts": {
            method: {
                verdict: sum(row["verdict"] == verdict for row in rows if row["method"] == method)
                for verdict in VERDICTS
            }
            for method in methods
        },
        "equal_error": [equal_error([row for row in rows if row["scene"] == scene]) for scene in scenes],
        "runs": rows,
    }


def equal_error(rows: Rows) -> dict[str, Any]:
    """In one scene: the fastest accurate run of the exact engine and of a rival, None if there is none; the ratio.

    ``ratio``: how many times longer the rival takes.
    """
    good = [row for row in rows if row["verdict"] == "accurate"]
    exact = min((row for row in good if row["method"] == "exact"), key=lambda row: row["seconds"], default=None)
    rival = min((row for row in good if row["method"] != "exact"), key=lambda row: row["seconds"], default=None)
    return {
        "scene": rows[0]["scene"],
        "reference": rows[0]["reference"],
        "no_reference": rows[0].get("no_reference", ""),
        "exact_relative_error": exact["relative_error"] if exact else None,
        "exact_seconds": exact["seconds"] if exact else None,
        "rival": f"{rival['method']}, {rival['setting']}" if rival else None,
        "rival_seconds": rival["seconds"] if rival else None,
        "ratio": rival["seconds"] / exact["seconds"] if rival and exact and exact["seconds"] > 0.0 else None,
    }


def bench_text(summary: dict[str, Any]) -> str:
    """The two tables on the terminal."""
    rows = summary["runs"]
    stale = " (up to date)" if summary["status"] == "up to date" else ""
    heading = f"{summary['name']}: {len(summary['scenes'])} scenes, {len(rows)} runs{stale}"
    used = {row["verdict"] for row in rows} | {*list(VERDICTS)[:-1]}
    key = ", ".join(f"{letter} {verdict}" for verdict, letter in VERDICTS.items() if verdict in used)
    lines = [
        heading,
        "",
        compared(summary["equal_error"]),
        "",
        f"verdicts, a letter for each setting, the coarsest first: {key}",
        "",
    ]
    methods = len(summary["methods"])
    lines += table(["scene", *summary["methods"]], _letters(summary), left=range(methods + 1))
    lines += ["", "time of the fastest accurate run (processor time), and of the fastest accurate rival", ""]
    heads = ["scene", "exact error", "exact s", "rival s", "ratio", "rival"]
    lines += table(heads, list(map(_equal, summary["equal_error"])), left=range(6), flow=5)
    if any(one["reference"] == "exact" and not one["no_reference"] for one in summary["equal_error"]):
        lines += ["", "* the exact engine is its own reference here; reference: digits60 checks it"]
    without = [one for one in summary["equal_error"] if one["no_reference"]]
    lines += [""] * bool(without)
    lines += [f"{one['scene']}: no reference, so errors are unknown: {one['no_reference']}" for one in without]
    return "\n".join(lines)


def _letters(summary: dict[str, Any]) -> list[list[str]]:
    """A line for each scene: the verdicts of each method's settings, those with other friction after a stroke."""
    lines = []
    for scene in summary["scenes"]:
        line = [scene]
        for method in summary["methods"]:
            groups: dict[str, str] = {}
            for row in summary["runs"]:
                if row["scene"] == scene and row["method"] == method:
                    groups[row["friction"]] = groups.get(row["friction"], "") + VERDICTS[row["verdict"]]
            line.append("/".join(groups.values()))
        lines.append(line)
    return lines


def _equal(one: dict[str, Any]) -> list[str]:
    mark = "*" if one["reference"] == "exact" else ""
    error = one["exact_relative_error"]
    return [
        one["scene"],
        "-" if error is None else f"{error:.0e}{mark}",
        _seconds(one["exact_seconds"]),
        _seconds(one["rival_seconds"]),
        "-" if one["ratio"] is None else f"{one['ratio']:.3g}",
        one["rival"] or ("no reference" if one["no_reference"] else "none is accurate"),
    ]


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.1e}"
