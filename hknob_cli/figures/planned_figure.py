"""A figure of one result as a page plans it: its anchor, title and caption."""

from typing import Any

from hknob_cli.results.result_set import Result
from hknob_cli.specs.page_plan import FigurePlan, Sentence


def planned(result: Result, draw: str, what: str, caption: str, **options: Any) -> FigurePlan:
    """The plan of a drawing of a result; ``what`` it shows names it, so that no two figures are alike in that."""
    slug = "".join(letter if letter.isalnum() else "-" for letter in f"{result.name}-{what}".lower()).strip("-")
    title = f"{result.name}: {what}"
    return FigurePlan(f"fig-{slug}", draw, (result.name,), options, title, Sentence(caption), title)
