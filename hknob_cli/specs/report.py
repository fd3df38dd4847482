"""The report's spec: which results go on the page, what is said of them, and in which figures."""

from pathlib import Path
from string import Formatter
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from hknob_cli.errors import Fault, SpecError, UsageError
from hknob_cli.specs.drawings import Draw
from hknob_cli.specs.named_file import as_typed, read_named
from hknob_cli.specs.scene import Part
from hknob_cli.specs.scene_paths import faults_of
from hknob_cli.specs.source import Path_, Source
from hknob_cli.specs.stage_plans import ChapterPlan, FigurePlan, Listen, ReportPlan, Sentence
from hknob_cli.specs.sweep import Name

Text = Annotated[str, Field(min_length=1)]
Anchor = Annotated[str, Field(pattern=r"^fig-[a-z0-9.-]+$", max_length=40)]
LONGEST = 80  # letters of the name of a result
Options = Annotated[dict[str, Any], Field(alias="with", default_factory=dict)]


class ValueSpec(Part):
    """A number to put into a sentence: a computation, as claims have them, and how to write it."""

    check: Text
    arguments: Options
    scale: Annotated[float, Field(allow_inf_nan=False, description="factor, as 1000 for mrad")] = 1.0
    format: Annotated[str, Field(pattern=r"^[+]?(\.[0-9])?[fge]?$", description="Python's, such as .1f")] = ".3g"


class SentenceSpec(Part):
    """A sentence with numbers in it: ``{name}`` in ``text`` is replaced by the value of that name."""

    text: Text
    values: dict[str, ValueSpec]


class ListenSpec(Part):
    """A clip of a recorded cycle, beside the figure; those of one figure are loud by one factor."""

    name: Annotated[str, Field(min_length=1, max_length=80, description="what it is called beside its player")]
    of: Annotated[Text, Field(description="name of the result that has the recording")]
    at: Annotated[
        dict[str, float], Field(default_factory=dict, description="which recording, by columns; default: trial 0")
    ]


class FigureSpec(Part):
    """A figure: a drawing ``of`` one result or several, its title, and what to see in it."""

    id: Anchor
    draw: Draw
    of: Annotated[
        str | list[str], Field(default_factory=list, description="name of the result it is drawn from, or several")
    ]
    options: Options
    title: Text
    caption: Annotated[Text, Field(description="what to see; with values, {name} in it is replaced as in the summary")]
    values: Annotated[dict[str, ValueSpec], Field(default_factory=dict)]
    alt: Annotated[str, Field(description="the figure in words, for those who do not see it; default: the title")] = ""
    listen: Annotated[list[ListenSpec], Field(default_factory=list, max_length=8, description="cycles to listen to")]


class ChapterSpec(Part):
    """A part of the page."""

    title: Text
    text: Annotated[str, Field(description="paragraphs, an empty line between them")] = ""
    figures: Annotated[list[FigureSpec], Field(default_factory=list)]


class ReportSpec(Part):
    """One page of results: figures, claims with verdicts, and where everything comes from."""

    kind: Literal["report"]
    name: Annotated[Name, Field(description="names the results folder")]
    title: Annotated[Text | None, Field(description="title of the page; default: the name")] = None
    results: Annotated[
        dict[str, str] | Annotated[list[str], Field(min_length=1)],
        Field(min_length=1, description="results folders by the name that figures and claims use; or a list of them"),
    ]
    claims: Annotated[str | None, Field(description="ledger of claims, relative to this file")] = None
    contents: Annotated[
        str | None,
        Field(description="the text's table of contents, in Markdown: a table a section; relative to this file"),
    ] = None
    summary: Annotated[list[str | SentenceSpec], Field(default_factory=list, description="what the page found")]
    lead: Annotated[list[Anchor], Field(default_factory=list, max_length=3, description="figures of the summary")]
    chapters: Annotated[
        list[ChapterSpec], Field(default_factory=list, description="default: one for each result, with its pictures")
    ]
    rerun: Annotated[list[Text], Field(default_factory=list, description="command lines that make the page again")]

    @property
    def folders(self) -> dict[str, str]:
        """Folders by name; those of a list are named by their last parts."""
        if isinstance(self.results, dict):
            return self.results
        return {Path(folder).name: folder for folder in self.results}


def validate_report(source: Source) -> ReportPlan:
    """A report's spec as plain values. Raises `SpecError`."""
    try:
        spec = ReportSpec.model_validate(source.value)
    except ValidationError as error:
        raise SpecError(faults_of(source, ReportSpec, error)) from None
    faults = [
        *_same_names(source, spec),
        *_long_names(source, spec),
        *_anchors(source, spec),
        *_names(source, spec),
        *_readable(source, "claims", spec.claims),
        *_readable(source, "contents", spec.contents),
    ]
    if faults:
        raise SpecError(faults)

    def where(*path: str | int) -> str:
        return str(source.fault(path, "")).removesuffix(": ")

    return ReportPlan(
        name=spec.name,
        title=spec.title or spec.name,
        results=spec.folders,
        claims=str(Path(source.name).parent / spec.claims) if spec.claims else None,
        contents=str(Path(source.name).parent / spec.contents) if spec.contents else None,
        summary=tuple(
            Sentence(item) if isinstance(item, str) else _sentence(item.text, item.values, where("summary", i))
            for i, item in enumerate(spec.summary)
        ),
        lead=tuple(spec.lead),
        chapters=tuple(
            ChapterPlan(
                chapter.title,
                chapter.text,
                tuple(_figure(one, where("chapters", i, "figures", j)) for j, one in enumerate(chapter.figures)),
            )
            for i, chapter in enumerate(spec.chapters)
        ),
        rerun=tuple(spec.rerun) or (f"hknob report {as_typed(Path(source.name).name)}",),
        values=source.value,
    )


def _same_names(source: Source, spec: ReportSpec) -> list[Fault]:
    """Faults of a list of folders of which two have the same last part."""
    if isinstance(spec.results, dict) or len(spec.folders) == len(spec.results):
        return []
    names = [Path(folder).name for folder in spec.results]
    again = next(i for i, name in enumerate(names) if name in names[:i])
    return [
        source.fault(("results", again), f"must have a name of its own: '{names[again]}' is there; use NAME: FOLDER")
    ]


def _long_names(source: Source, spec: ReportSpec) -> list[Fault]:
    """Faults of names of results that no file of a figure can have."""
    listed = isinstance(spec.results, list)
    return [
        source.fault(
            ("results", i if listed else name), f"must have a name of at most {LONGEST} letters, has {len(name)}"
        )
        for i, name in enumerate(spec.folders)
        if len(name) > LONGEST
    ]


def _anchors(source: Source, spec: ReportSpec) -> list[Fault]:
    """Faults of figure ids: given twice, or named in the summary and nowhere else."""
    faults, seen = [], set()
    for i, chapter in enumerate(spec.chapters):
        for j, figure in enumerate(chapter.figures):
            if figure.id in seen:
                place = ("chapters", i, "figures", j, "id")
                faults.append(source.fault(place, f"must be unique, got '{figure.id}' again"))
            seen.add(figure.id)
    for i, name in enumerate(spec.lead):
        if not spec.chapters:
            faults.append(source.fault(("lead", i), "must be absent without chapters: the page chooses"))
        elif name not in seen:
            faults.append(source.fault(("lead", i), f"must be the id of a figure, got '{name}'"))
    return faults


def _names(source: Source, spec: ReportSpec) -> list[Fault]:
    """Faults of the placeholders of sentences and captions."""
    faults: list[Fault] = []
    for i, item in enumerate(spec.summary):
        if isinstance(item, SentenceSpec):
            faults += _placeholders(source, ("summary", i), item.text, item.values)
    for i, chapter in enumerate(spec.chapters):
        for j, figure in enumerate(chapter.figures):
            if figure.values:
                faults += _placeholders(source, ("chapters", i, "figures", j), figure.caption, figure.values)
    return faults


def _readable(source: Source, key: str, name: str | None) -> list[Fault]:
    """The fault of a file that is named and cannot be read."""
    if name is None:
        return []
    try:
        read_named(Path(source.name).parent / name)
    except UsageError as error:
        return [source.fault((key,), str(error))]
    return []


def _placeholders(source: Source, place: Path_, text: str, values: dict[str, ValueSpec]) -> list[Fault]:
    """Faults of one text: names in it without a value, and values that it does not name."""
    try:
        fields = [field for field in Formatter().parse(text) if field[1] is not None]
    except ValueError as error:
        return [source.fault(place, f"must be text with {{names}}: {error}")]
    used = {str(name) for _, name, _, _ in fields}
    odd = [name for _, name, form, conversion in fields if form or conversion or not str(name).isidentifier()]
    if odd:
        return [source.fault(place, f"must have {{names}} of letters, digits and '_' only, got {{{odd[0]}}}")]
    return [
        source.fault(place, f"'{name}' {'has no value' if name in used else 'is not in the text'}")
        for name in sorted(used ^ set(values))
    ]


def _sentence(text: str, values: dict[str, ValueSpec], where: str) -> Sentence:
    found = {name: (value.check, value.arguments, value.scale, value.format) for name, value in values.items()}
    return Sentence(text, found, where)


def _figure(spec: FigureSpec, where: str) -> FigurePlan:
    of = (spec.of,) if isinstance(spec.of, str) else tuple(spec.of)
    caption = _sentence(spec.caption, spec.values, where)
    listen = tuple(Listen(one.name, one.of, tuple(one.at.items())) for one in spec.listen)
    return FigurePlan(spec.id, spec.draw, of, spec.options, spec.title, caption, spec.alt or spec.title, where, listen)
