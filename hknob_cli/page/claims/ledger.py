"""The ledger as a file: claims with their place, printed value, computation, readings and tolerance.

A place is written in one way only: ``abstract``, ``6.4.2``, ``10.2, item 3``, ``A.1``, ``Figure N``, ``Table N``,
``Equation N``. A chapter is a section of one number.

When a computed number agrees with a printed one.
"""

import re
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, ValidationError, model_validator

from hknob_cli.errors import Fault, SpecError
from hknob_cli.page.claims.checks import check_fault
from hknob_cli.specs import source as yaml
from hknob_cli.specs.named_file import open_named
from hknob_cli.specs.scene import Part
from hknob_cli.specs.scene_paths import faults_of

_AND = r"(?:\s*,\s*and\s+|\s*,\s*|\s+and\s+|\s+to\s+|\s*-\s*)"
_WHOLE = r"\d{1,2}(?!\.?\d)"
_SECTION = r"\d{1,2}(?:\.\d{1,2}){0,2}(?!\.?\d)"
_LETTER = r"[A-D](?:\.\d)?(?![\w])"
_KINDS = (
    ("", r"(?:sections?|secs?\b\.?|chapters?|ch\.)", _SECTION),
    ("", r"(?:appendix|appendices|apps?\.)", _LETTER),
    ("Figure ", r"(?:figures?|figs?\b\.?)", _WHOLE),
    ("Table ", r"(?:tables?)", _WHOLE),
    ("Equation ", r"(?:equations?|eqs?\.)", _WHOLE),
)
_CITED = tuple(
    (name, number, re.compile(rf"\b(?i:{word})\s*({number}(?:{_AND}{number})*)(?:,\s*items?\s+(\d)(?!\d))?"))
    for name, word, number in _KINDS
)
_RANGE = re.compile(r"(\S+?)(?:\s*-\s*|\s+to\s+)(\S+?)(?=,|\s|$)")
_ABSTRACT = re.compile(r"\babstract\b", re.IGNORECASE)


def places(text: str) -> tuple[str, ...]:
    """The places that a text names, each once, those of one kind after another in the order of the text."""
    text = " ".join(text.split())
    found = ["abstract"] if _ABSTRACT.search(text) else []
    for name, number, pattern in _CITED:
        for match in pattern.finditer(text):
            several = _numbers(match[1], number)
            if match[2]:
                several.append(f"{several[-1]}, item {match[2]}")
            found += [f"{name}{one}" for one in several]
    return tuple(dict.fromkeys(found))


def _numbers(text: str, number: str) -> list[str]:
    """Numbers of a list such as "29, 30, 33-36", with those between the ends of a range."""
    spelled = _RANGE.sub(lambda match: ", ".join(_between(match[1], match[2])), text)
    return re.findall(number, spelled)


def _between(first: str, last: str) -> list[str]:
    """All places from the first to the last, of which only the end of the name differs."""
    (head, low), (other, high) = (_split(one) for one in (first, last))
    if head != other or low.isdigit() != high.isdigit():
        return [first, last]
    if low.isdigit():
        return [f"{head}{one}" for one in range(int(low), int(high) + 1)]
    return [f"{head}{chr(one)}" for one in range(ord(low), ord(high) + 1)]


def _split(place: str) -> tuple[str, str]:
    head, dot, end = place.rpartition(".")
    return head + dot, end


Real = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]

Text = Annotated[str, Field(min_length=1)]
Arguments = dict[str, Any]


class Bounds(Part):
    """An interval of computed values, about the printed value or absolute. What is not given does not bind."""

    within: Annotated[Positive | None, Field(description="largest difference from the printed value")] = None
    within_percent: Annotated[Positive | None, Field(description="the same, in % of the printed value")] = None
    at_least: Real | None = None
    at_most: Real | None = None

    @model_validator(mode="after")
    def _binds(self) -> Self:
        if all(value is None for value in (self.within, self.within_percent, self.at_least, self.at_most)):
            raise ValueError("must give at least one of within, within_percent, at_least, at_most")
        return self

    @property
    def relative(self) -> bool:
        """Whether a printed value is needed."""
        return self.within is not None or self.within_percent is not None

    def hold(self, computed: float, printed: float | None) -> bool:
        """Whether a computed value lies within; a bound itself does, up to rounding in the last digits."""
        slack = 1e-9 * max(abs(computed), abs(printed or 0.0))
        if printed is not None:
            off = abs(computed - printed) - slack
            if self.within is not None and off > self.within:
                return False
            if self.within_percent is not None and off > 0.01 * self.within_percent * abs(printed):
                return False
        if self.at_least is not None and computed < self.at_least - slack:
            return False
        return self.at_most is None or computed <= self.at_most + slack


class Reading(Part):
    """One way to read a claim: arguments of its computation that differ, by a name that says which reading."""

    name: Text
    arguments: Annotated[Arguments, Field(alias="with", default_factory=dict)]
    excluded: Annotated[Text | None, Field(description="why the print does not allow this reading; null: it does")] = (
        None
    )


class Claim(Part):
    """One number or statement of the text.

    Verdicts: `reproduced` where a reading that the print allows is within ``holds``; `differs` where one is within
    ``near``; `contradicted` where none is; `not testable` where no computation exists, or what it needs does not.
    A reading that is ``excluded`` is computed and shown, and decides nothing.
    """

    id: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9.-]*$", max_length=60)]
    place: Annotated[Text, Field(description="section, table, figure or equation")]
    says: Annotated[Text, Field(description="what the text says, in its words or in short")]
    printed: Annotated[Real | None, Field(description="the printed value; null: a statement")] = None
    unit: str = ""
    check: Annotated[str | None, Field(description="the computation, by name")] = None
    arguments: Annotated[Arguments, Field(alias="with", default_factory=dict)]
    readings: Annotated[list[Reading], Field(default_factory=list, description="default: one, as printed")]
    holds: Bounds | None = None
    near: Bounds | None = None
    because: Annotated[Text | None, Field(description="why this tolerance")] = None
    untestable: Annotated[Text | None, Field(description="why there is no computation")] = None
    finding: Annotated[Text | None, Field(description="what is known beside the number: why, and how it shows")] = None
    figure: Annotated[str | None, Field(description="id of the figure that shows it")] = None

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if (self.check is None) == (self.untestable is None):
            raise ValueError("must have either a check, or the reason why it is untestable")
        if self.check is not None and (self.holds is None or self.because is None):
            raise ValueError("must say when it holds, and because of what, beside its check")
        if self.printed is None and any(bounds and bounds.relative for bounds in (self.holds, self.near)):
            raise ValueError("must have a printed value for within or within_percent")
        return self

    @property
    def all_readings(self) -> list[Reading]:
        """Its readings, or the only one."""
        return self.readings or [Reading.model_validate({"name": "as printed"})]


class Ledger(Part):
    """A list of claims about one text."""

    text: Annotated[Text, Field(description="the text that is checked")]
    claims: Annotated[list[Claim], Field(min_length=1)]


def load_ledger(path: Path) -> Ledger:
    """Read a ledger. Raises `SpecError` with every fault and its place, `UsageError` where it cannot be read."""
    with open_named(path):
        source = yaml.read(path)
    try:
        ledger = Ledger.model_validate(source.value)
    except ValidationError as error:
        raise SpecError(faults_of(source, Ledger, error)) from None
    faults: list[Fault] = []
    seen: dict[str, int] = {}
    for i, claim in enumerate(ledger.claims):
        if claim.id in seen:
            faults.append(source.fault(("claims", i, "id"), f"must be unique; claim {seen[claim.id] + 1} has it, too"))
        seen.setdefault(claim.id, i)
        for reading in claim.all_readings if claim.check else ():
            wrong = check_fault(str(claim.check), {**claim.arguments, **reading.arguments})
            if wrong:
                faults.append(source.fault(("claims", i, "check"), wrong))
    if faults:
        raise SpecError(faults)
    return ledger
