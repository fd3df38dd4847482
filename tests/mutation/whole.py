"""Files of which every change was tried: a table at the end of `scores.md`, kept by `campaign.py --note`."""

import datetime
from pathlib import Path

SCORES = Path(__file__).with_name("scores.md")
TITLE = "## Files tried whole"
HEAD = f"""\
{TITLE}

Every change of a file, by the tests that `table.py` lists for it: `python tests/mutation/campaign.py --note FILE`.
*Explained* ones are in `accepted.toml`.

| file | changes | killed | explained | survived | date |
|---|---|---|---|---|---|
"""


def rows() -> dict[str, str]:
    """The rows that are there, by file."""
    _, _, told = SCORES.read_text().partition(TITLE)
    return {line.split("`")[1]: line for line in told.splitlines() if line.startswith("| `")}


def section(more: dict[str, str] | None = None) -> str:
    """The table, with rows that take the place of those of the same files."""
    return HEAD + "".join(f"{line}\n" for _, line in sorted((rows() | (more or {})).items()))


def note(name: str, *, changes: int, killed: int, explained: int, survived: int) -> None:
    """Put the counts of a file into `scores.md`, with today's date."""
    today = datetime.date.today()
    line = f"| `{name}` | {changes} | {killed} | {explained} | {survived} | {today:%Y-%m-%d} |"
    before, _, _ = SCORES.read_text().partition(TITLE)
    SCORES.write_text(f"{before.rstrip()}\n\n{section({name: line})}")
