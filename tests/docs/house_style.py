"""How the pages are written: the house's rules, made of proselint's parts, and which of proselint's own do not fit.

A rule is a `Check`. Its pattern sees prose as `prose` lays it out: a piece of code is `CODE`, the words of a link stand
between `LINK` marks, and `END` closes a paragraph, a heading, or a cell of a table.
"""

import re
from collections.abc import Iterator
from functools import partial

from proselint.registry.checks import Check, CheckResult, engine, types

CODE = "\N{BULLET}"
LINK = ("\N{SINGLE LEFT-POINTING ANGLE QUOTATION MARK}", "\N{SINGLE RIGHT-POINTING ANGLE QUOTATION MARK}")
END = "\N{PILCROW SIGN}"

LONGEST, SHORT = 40, 30  # words of a sentence; a piece of code, or a list of such, is a word
_WORD = rf"{CODE}(?:,\s{CODE})*|\w[\w'.,/-]*"

# Of proselint, but not of this house.
OFF = (
    "typography.symbols",  # straight quotes and three dots, as a terminal prints them; 0x10 is a number
    "cliches.misc.write_good",  # "in a pinch" is how a hand holds a knob
)

# Headings of the dissertation are quoted as they are printed, and a cell of that table is a list.
OFF_IN = {"docs/reference/contents.md": ("house.words", "weasel_words", "house.length")}

# Pages that a newcomer reads have shorter sentences.
FOR_NEWCOMERS = ("README.md", "docs/index.md", "docs/tutorials/", "docs/howto/")

# One word for one thing, as docs/reference/glossary.md has it, and British spelling.
WORDS = {
    "sampling rate": "sample rate",
    "sampling frequency": "sample rate",
    "sampling period": "sample period",
    "sampling interval": "sample period",
    "limit-cycle": "limit cycle",
    "limit-cycles": "limit cycles",
    "zero order hold": "zero-order hold",
    "deadband": "dead band",
    "deadzone": "dead zone",
    "color": "colour",
    "colors": "colours",
    "center": "centre",
    "labeled": "labelled",
    "gray": "grey",
}

# What a reader stumbles over.
PLAIN = {
    "but for": "except",
    "save for": "except for",
    "told as such": "reported",
    "to be had": "available",
    "of one's own": "of your own",
}

_VERB = "(?:is|are|was|were|has|have|had|can|could|may|might|must|will|would|does|do|did|cannot)"
_STARTS = rf"(?:(?<=[.!?:]\s)|(?<={END}\n))"
_BUT = r"(?!(?:that|which|who|whose|where|when|and|or|if|whether)\b)"  # such a clause has its own verb


def _pattern(path: str, message: str, *patterns: str) -> Check:
    whole = "|".join(patterns)
    return Check(types.ExistenceSimple(whole), engine.Fancy(engine.RegexOptions(case_insensitive=False)), path, message)


def _preferred(path: str, words: dict[str, str]) -> Check:
    return Check(types.PreferredFormsSimple(words), path=path, message="write '{}', not '{}'")


def _at_most(words: int, path: str) -> Check:
    message = "a sentence of {} words; {} at most: make two of it"
    return Check(partial(_long_sentences, words), path=path, message=message)


def off_in(page: str) -> tuple[str, ...]:
    """Rules that do not hold in a page, by its path in the checkout."""
    return (*OFF_IN.get(page, ()), "house.length" if page.startswith(FOR_NEWCOMERS) else "house.short")


def _long_sentences(most: int, text: str, check: Check) -> Iterator[CheckResult]:
    for block in re.finditer(f"[^{END}]+", text):
        for one in re.finditer(r"\S.*?(?:[.!?][\"')\]]*(?=\s+[^a-z])|\Z)", block[0], re.DOTALL):
            words = len(re.findall(_WORD, one[0]))
            if words > most:
                start = block.start() + one.start()
                message = check.message.format(words, most)
                yield CheckResult(check.path, message, (start, start + 1), None)


RULES = (
    _at_most(LONGEST, "house.length"),
    _at_most(SHORT, "house.short"),
    _preferred("house.words", WORDS),
    _preferred("house.plain", PLAIN),
    _pattern(
        "house.because",
        "'{}': write 'because'",
        rf"\bfor (?:it|they|there|nothing|nobody|none|this|these)\s+(?:\w+\s+)?{_VERB}\b",
        rf"[,;:]\s+for (?:the|an?|all|every|each|its|their|no)\s+(?:{_BUT}[\w-]+\s+){{1,4}}?{_VERB}\b",
    ),
    _pattern(
        "house.subject_first",
        "'{}': begin with the subject",
        rf"{_STARTS}What\b(?=[^{END}.!?]*\.)",
        rf"{_STARTS}(?:Of|Nor) (?!course|the |these |\d)[^\s{END}]+",
        r"\b[Ss]o (?:is|are|does|do|has|have) (?:the|a|an|those|what)\b",
    ),
)
