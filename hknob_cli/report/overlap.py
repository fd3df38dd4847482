"""How much of a grid a sweep covers that predictions are compared with."""

from typing import Any


def overlap_text(summary: dict[str, Any]) -> list[str]:
    """A line where the sweep has some of the cells only; nothing where it has all, or there is none."""
    found = summary.get("overlap")
    if not found or found["with_partner"] == found["cells"]:
        return []
    return [f"{found['with_partner']} of {found['cells']} cells are in the sweep, too; only these are compared with it"]
