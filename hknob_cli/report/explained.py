"""What `hknob explain` says of a spec: the answer first, then parts, numbers, and what is not proven or ignored."""

from typing import Any, NamedTuple

from hknob_cli.report.derived_numbers import Number
from hknob_cli.report.table import folded


class Explained(NamedTuple):
    """What a spec describes: its ``kind``, ``name``, and the ``answer`` in a sentence.

    ``sections``: sentences by title; ``numbers``: what follows from a scene; ``next``: the command to run then.
    """

    kind: str
    name: str
    answer: str
    sections: dict[str, list[str]]
    numbers: list[Number]
    next: str


def as_data(found: Explained) -> dict[str, Any]:
    """The same as plain data, numbers in SI units."""
    numbers = [
        {"name": one.name, "unit": one.unit, "least": one.least, "largest": one.largest, "means": one.means}
        for one in found.numbers
    ]
    sections = {title.replace(" ", "_"): lines for title, lines in found.sections.items()}
    return {"kind": found.kind, "name": found.name, "answer": found.answer, **sections, "numbers": numbers}


def explained_text(found: Explained) -> str:
    """The same for the terminal."""
    lines = [found.answer]
    for title, said in found.sections.items():
        if said:
            lines += ["", f"{title[0].upper()}{title[1:]}:", *(f"  {line}" for line in said)]
    if found.numbers:
        lines += ["", "What follows:", *(f"  {one.name}: {one.text} ({one.means})" for one in found.numbers)]
    return folded("\n".join([*lines, "", f"next: {found.next}"]))
