"""docs/reference/contents.md: the dissertation's table of contents, and where the program has each place.

``python docs/make/contents.py``. What the dissertation has is in data/contents.yaml. Where the program has it is read
from the places that its own texts name: the ledger of claims, the figures of the page, the heads of the experiments,
docstrings.
"""

import ast
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.page.claims.ledger import Claim, load_ledger, places
from hknob_cli.specs import source

_ROOT = Path(__file__).parent.parent.parent
_EXPERIMENTS, _PACKAGE = _ROOT / "experiments", _ROOT / "hknob_cli"
_HEAD = """\
# The dissertation, place by place

Every section, figure, table and displayed equation of C. J. Hasser's dissertation, and where this program has it. This
page is made from the program itself (`make schemas`): from the places that the claims (`data/claims.yaml`), the figures
of the page (`experiments/dissertation_report.yaml`), the experiments and the code name. The list of places is
`data/contents.yaml`.

- An experiment is run by the command before it: `hknob sweep experiments/NAME.yaml`. `make paper` runs those that the
  page needs.
- Figures and claims are on the page that `make paper` makes. A claim that is not testable is named with its reason.
- The print numbers two equations. The others that it displays are lettered here, in the order of their section.
"""
_Named = tuple[tuple[str, str], ...]
_KINDS = ("sections", "figures", "tables", "equations")
_ANSWERS = {"nothing": "Nothing to compute", "not_built": "Not built", "missing": "Missing"}
_REPORT = "dissertation_report.yaml"
_STAGE = re.compile(r"^kind: ([a-z-]+)$", re.MULTILINE)
_DRAWN = re.compile(r"\(([^()]*(?:dissertation|section)[^()]*)\)$")
# Docstrings cite other works, too. The dissertation's places follow its name, or are written out: "Section 4.2.3".
_NAMED = re.compile(r"(?:Hasser|[Dd]issertation)\b[^);]{0,70}")
_WRITTEN_OUT = re.compile(r"\b(?:Sections?|Chapters?|Appendix|Appendices|Equations?|Tables?)\s[^);]{0,40}")


class Where(NamedTuple):
    """What the program has of one place: names, as the page writes them."""

    experiments: tuple[tuple[str, str], ...]  # kind and name
    figures: tuple[str, ...]
    claims: tuple[Claim, ...]
    files: tuple[str, ...]
    named: tuple[str, ...]  # by the list of places itself: claims, or functions of the program


class Row(NamedTuple):
    """A place: its name, the section it stands in, what it is, what the program has of it, and what not."""

    id: str
    section: str
    title: str
    where: Where
    lacks: str  # one of _ANSWERS, or empty
    reason: str
    parts: bool  # whether it is a section with sections of its own


def rows(contents: dict[str, Any] | None = None) -> list[Row]:
    """Every place, in the order of the text. Raises `ValueError` for a place without answer, with two, or unknown."""
    given = contents or source.read(_ROOT / "data" / "contents.yaml").value
    ids = [one["id"] for kind in _KINDS for one in given[kind]]
    known, *named = _texts()
    experiments, figures, claims, files = (_tags(texts, ids) for texts in named)
    tables = {f"Table {one['number']}": f"data/printed/{one['file']}" for one in _printed()}
    found = []
    for kind in _KINDS:
        for one in given[kind]:
            name = one["id"]
            where = Where(
                tuple((_kind(path), path) for path in experiments[name]),
                tuple(figures[name]),
                tuple(known[claim] for claim in claims[name]),
                (*((tables[name],) if name in tables else ()), *files[name]),
                tuple(_existing(by, known) for by in one.get("by", ())),
            )
            lacks = next((key for key in _ANSWERS if key in one), "")
            parts = any(other.startswith(f"{name}.") for other in ids)
            row = Row(
                name, one.get("section", name.partition(",")[0]), one["title"], where, lacks, one.get(lacks, ""), parts
            )
            found.append(_answered(row))
    return found


def _answered(row: Row) -> Row:
    said = _has(row.where)
    there = any(row.where._replace(claims=())) or any(claim.check for claim in row.where.claims)
    if there and row.lacks in ("nothing", "not_built"):
        raise ValueError(f"{row.id}: data/contents.yaml says '{row.lacks}', but it is there: {said}")
    if not (said or row.parts) and row.lacks not in ("nothing", "not_built"):
        raise ValueError(f"{row.id}: nothing names it, and data/contents.yaml does not say why")
    if row.where.files and not any(row.where._replace(files=())) and not (row.parts or row.lacks):
        raise ValueError(f"{row.id}: docstrings alone name it; a claim, a figure, an experiment or a 'by' must, too")
    if row.id.startswith("Figure ") and not (row.where.figures or row.lacks):
        raise ValueError(f"{row.id}: no figure of the page draws it, and data/contents.yaml does not say why")
    return row


@cache
def _texts() -> tuple[dict[str, Claim], _Named, _Named, _Named, _Named]:
    """Claims by their id; then names with what they cite: of experiments, figures, claims and files."""
    claims = {claim.id: claim for claim in load_ledger(_ROOT / "data" / "claims.yaml").claims}
    cited = tuple((claim.id, claim.place) for claim in claims.values())
    return claims, tuple(_experiments()), tuple(_figures()), cited, tuple(_docstrings())


def _tags(texts: Iterable[tuple[str, str]], ids: list[str]) -> dict[str, list[str]]:
    """By place, what names it. Raises `ValueError` for a place that the dissertation does not have."""
    found = defaultdict(list)
    for name, text in texts:
        for place in places(text):
            if place not in ids:
                raise ValueError(f"{name} names {place}, which data/contents.yaml does not have")
            if name not in found[place]:
                found[place].append(name)
    return found


def _experiments() -> Iterator[tuple[str, str]]:
    """Name and head of each experiment but of the page, whose figures speak for themselves."""
    for path in sorted(_EXPERIMENTS.glob("*.yaml")):
        lines = path.read_text(encoding="utf-8").splitlines()
        head = [line for line in lines[: lines.index(f"kind: {_kind(path.stem)}")] if line.startswith("#")]
        if path.name != _REPORT:
            yield path.stem, " ".join(line.removeprefix("#") for line in head)


def _kind(experiment: str) -> str:
    text = (_EXPERIMENTS / f"{experiment}.yaml").read_text(encoding="utf-8")
    return _STAGE.findall(text)[0]


def _figures() -> Iterator[tuple[str, str]]:
    """Id of each figure of the page, and the places in the brackets at the end of its title."""
    for chapter in source.read(_EXPERIMENTS / _REPORT).value["chapters"]:
        for figure in chapter.get("figures", ()):
            cited = _DRAWN.search(figure["title"])
            yield figure["id"], cited[1] if cited else ""


def _docstrings() -> Iterator[tuple[str, str]]:
    """Every file of the program with what its docstrings cite of the dissertation."""
    for path in sorted(_PACKAGE.rglob("*.py")):
        written = path.read_text(encoding="utf-8")
        if not any(pattern.search(" ".join(written.split())) for pattern in (_NAMED, _WRITTEN_OUT)):
            continue
        nodes = (ast.Module, ast.ClassDef, ast.FunctionDef)
        for node in ast.walk(ast.parse(written)):
            text = " ".join((ast.get_docstring(node) or "").split()) if isinstance(node, nodes) else ""
            for pattern in (_NAMED, _WRITTEN_OUT):
                for cited in pattern.findall(text):
                    yield str(path.relative_to(_ROOT)), cited


def _printed() -> list[dict[str, Any]]:
    return source.read(_ROOT / "data" / "printed" / "tables.yaml").value["tables"]


def _existing(by: str, claims: dict[str, Claim]) -> str:
    """The name of a claim, or the file and name of a function. Raises `ValueError` where there is none."""
    if by in claims:
        return by
    module, _, name = by.partition(":")
    try:
        getattr(import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise ValueError(f"data/contents.yaml names '{by}': {error}") from None
    return f"{module.replace('.', '/')}.py, {name}"


def page() -> str:
    """The text, in Markdown."""
    return "\n".join(_lines(rows())) + "\n"


def _lines(found: list[Row]) -> Iterator[str]:
    yield _HEAD
    counts = {key: sum(row.lacks == key for row in found) for key in _ANSWERS}
    there = len(found) - counts["nothing"] - counts["not_built"]
    absent = f" {counts['not_built']} are not built." if counts["not_built"] else ""
    yield (
        f"Of {len(found)} places {there} are there, {counts['missing']} of these in part.{absent} In the other\n"
        f"{counts['nothing']} there is nothing to compute.\n"
    )
    for chapter in (row for row in found if row.id == row.section and "." not in row.id):
        yield f"## {_chapter(chapter)}\n"
        yield "| place | what it is | where it is here |"
        yield "|---|---|---|"
        inside = [row for row in found if row.section.partition(".")[0].partition(",")[0] == chapter.id]
        sections = [row for row in inside if row.id == row.section]
        for section in sections:
            yield _line(section)
            yield from (_line(row) for row in inside if row.section == section.id and row is not section)
        yield ""


def _chapter(row: Row) -> str:
    if row.id == "abstract":
        return "Abstract"
    return f"{'Chapter' if row.id.isdigit() else 'Appendix'} {row.id}: {row.title}"


def _line(row: Row) -> str:
    said = f"{_ANSWERS[row.lacks]}: {row.reason}." if row.lacks else ""
    has = _has(row.where) or ("In its sections." if not said else "")
    name = f"**{row.id}**" if row.id == row.section else row.id
    return f"| {name} | {row.title.replace('|', '&#124;')} | {' '.join(filter(None, (has, said)))} |"


def _has(where: Where) -> str:
    """What the program has of a place, in words."""
    told = []
    for kind in sorted({kind for kind, _ in where.experiments}):
        told.append(f"`hknob {kind}`: {_listed(name for one, name in where.experiments if one == kind)}")
    tested = [claim.id for claim in where.claims if claim.check]
    for title, names in (
        ("figures", where.figures),
        ("claims", tested),
        ("by", where.named),
        ("files", where.files),
    ):
        if names:
            told.append(f"{title}: {_listed(names)}")
    told += [f"not testable: `{claim.id}` ({claim.untestable})" for claim in where.claims if not claim.check]
    return "; ".join(told) + "." if told else ""


def _listed(names: Any) -> str:
    return ", ".join(f"`{name}`" for name in names)


if __name__ == "__main__":
    print(page(), end="")
