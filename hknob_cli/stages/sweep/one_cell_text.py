"""A sweep of one cell in a sentence: does it buzz, how large, at what pitch, from what share of the starts, proven?"""

from typing import Any

from hknob_cli.report.matrix import short
from hknob_cli.report.table import table

Row = dict[str, Any]
MOST_ORBITS = 20  # lines
_ALMOST = 1.0 - 1e-9  # of the starts, all


def describe_one(orbits: list[Row]) -> list[Row]:
    """The ends of the trials as plain data: what each is, how large, at what pitch, of how many, and if proven."""
    keys = ("outcome", "p2p_rad", "frequency_hz", "basin_fraction", "certified", "reason")
    return [{key: row[key] for key in keys} for row in orbits]


def one_cell_text(orbits: list[Row]) -> list[str]:
    """The sentence, and a table where there are several cycles."""
    cycles = sorted((row for row in orbits if row["outcome"] == "cycle"), key=lambda row: -row["p2p_rad"])
    if not cycles:
        return [_without_cycle(orbits)]
    share = sum(row["basin_fraction"] for row in cycles)
    worst = cycles[0]
    of = "" if len(cycles) == 1 else f" in the largest of {len(cycles)} limit cycles"
    sentence = (
        f"It buzzes, from {_share(share)}: {short(1e3 * worst['p2p_rad'])} mrad peak to peak at "
        f"{short(worst['frequency_hz'])} Hz{of} ({_proof(cycles)})."
    )
    if len(cycles) > 1:
        size, pitch = (sum(row["basin_fraction"] * row[name] for row in cycles) for name in ("p2p_rad", "frequency_hz"))
        if share > 0.0:
            mean = f"{short(1e3 * size / share)} mrad at {short(pitch / share)} Hz"
            sentence += f" The mean of the starts that cycle is {mean}."
    others = [row for row in orbits if row["outcome"] != "cycle"]
    if others:
        sentence += f" The others: {_ends(others)}."
    if len(cycles) == 1:
        return [sentence]
    body = [
        [
            short(1e3 * row["p2p_rad"]),
            short(row["frequency_hz"]),
            short(100.0 * row["basin_fraction"]),
            "yes" if row["certified"] else "no",
        ]
        for row in cycles[:MOST_ORBITS]
    ]
    more = [f"... and {len(cycles) - MOST_ORBITS} smaller ones in orbits.parquet"] if len(cycles) > MOST_ORBITS else []
    return [sentence, "", *table(["p2p mrad", "frequency Hz", "% of starts", "proven"], body), *more]


def _without_cycle(orbits: list[Row]) -> str:
    rest = [row for row in orbits if row["outcome"] == "rest"]
    if rest and len(rest) == len(orbits):
        return f"It does not buzz: it comes to rest, from {_share(1.0)} ({_proof(rest)})."
    return f"No limit cycle was found: {_ends(orbits)}."


def _ends(orbits: list[Row]) -> str:
    """How trials end that do not cycle, by share of the starts."""
    words = {"rest": "come to rest", "diverged": "diverge", "undecided": "are undecided"}
    shares = {
        word: sum(row["basin_fraction"] for row in orbits if row["outcome"] == outcome)
        for outcome, word in words.items()
    }
    return ", ".join(f"{short(100.0 * share)} % of the starts {word}" for word, share in shares.items() if share > 0.0)


def _share(share: float) -> str:
    return "every start tried" if share > _ALMOST else f"{short(100.0 * share)} % of the starts tried"


def _proof(orbits: list[Row]) -> str:
    if all(row["certified"] for row in orbits):
        return "proven"
    return "some of it not proven" if any(row["certified"] for row in orbits) else "not proven"
