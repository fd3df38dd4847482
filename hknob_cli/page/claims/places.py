"""Places of a text that a sentence names: "sec. 6.4.2, Figs 33-35; sec. 10.2, item 3".

A place is written in one way only: ``abstract``, ``6.4.2``, ``10.2, item 3``, ``A.1``, ``Figure N``, ``Table N``,
``Equation N``. A chapter is a section of one number.
"""

import re

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
