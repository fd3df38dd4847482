"""Starters: for each kind of spec a short commented file to begin from, with what a person answers or a preset's knob.

A question belongs to a place in the text of a starter, or to a line there that is a comment until it is wanted. It is
asked only if the text has that: a preset has its own knob, so nobody is asked for the inertia.
"""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.errors import Fault, SpecError, UsageError
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.specs.preset import SCENES, Read, read_preset
from hknob_cli.specs.quantity import to_si
from hknob_cli.specs.source import parse, parse_value, span_of
from hknob_cli.stage_table import KINDS, PIPELINE, STAGES

_ROOT = Path(__file__).parents[2]
WITH_SCENE = tuple(SCENES)  # kinds whose knob can be a preset
# What a preset replaces stands between these lines: the knob and its wall, and the sample rate and counts.
_BLOCK = re.compile(r"^#\{(\w+)\n(.*?)^#\}\n", re.MULTILINE | re.DOTALL)
_WIDTH = 120
_RATE, _COUNTS, _STIFFNESS = ("grid", RATE), ("grid", COUNTS), ("scene", "wall", "stiffness")
# Numbers in blocks of that name: how many times what of the starter's own knob.
_NUMBERS = (
    ("1000", _RATE, 1),
    ("4000", _RATE, 4),
    ("1024", _COUNTS, 1),
    ("8192", _COUNTS, 8),
    ("0.2", _STIFFNESS, 0.75),
    ("0.135", _STIFFNESS, 0.5),
)


def starter(kind: str, preset: str = "", beside: Path = Path()) -> str:
    """The text of a starter of a kind of spec; with a ``preset`` its knob is that one.

    The path of a preset's own file is relative to ``beside``, the folder of the spec. Raises `UsageError` for a kind
    without a scene, a preset that there is not, and one whose parts the kind refuses.
    """
    if not preset:
        return own_starter(kind, {}, {})
    if kind not in WITH_SCENE:
        raise UsageError(f"--from: a spec of kind {kind} cannot begin from a preset; {', '.join(WITH_SCENE)} can")
    read = read_preset(preset, beside)
    made = _BLOCK.sub(lambda found: _of_preset(found[1], found[2], preset, read), _read(kind))
    made = re.sub(r"^name: \S+( *)", lambda found: _named(found, preset), made, count=1, flags=re.MULTILINE)
    _validate(made, kind, preset, beside)
    return made


def own_starter(kind: str, scene: Mapping[str, Any], grid: Mapping[str, Any]) -> str:
    """The text of a starter, with what is in proportion to its knob in proportion to this wall, rate and counts."""

    def filled(found: re.Match[str]) -> str:
        return _in_proportion(found[2], scene, grid) if found[1] == "numbers" else found[2]

    return _BLOCK.sub(filled, _read(kind))


def _read(kind: str) -> str:
    """The starter in the folder of a stage's work, or of the pipeline."""
    work = "hknob_cli.pipeline.steps" if kind == PIPELINE else STAGES[kind].work
    return _ROOT.joinpath(*work.split(".")[:-1], "starter.yaml").read_text(encoding="utf-8")


def _of_preset(block: str, own: str, preset: str, read: Read) -> str:
    """What stands in the place of a block: the preset, with its values as comments that can be overridden."""
    if block == "numbers":
        return _in_proportion(own, read.scene, read.grid)
    if block == "grid":
        return own if len(read.grid) < 2 else _grid_of_preset(own, read)
    indent = own[: len(own) - len(own.lstrip())]
    lines = [f"from: {preset}", *_comment(read.preset.title)]
    lines += [line for path, value in _leaves(read.scene) for line in _comment(f"{path} = {value}")]
    lines += [line for text in read.preset.left_out for line in _comment(f"left out: {text}")]
    lines += _comment("Keys listed below override the preset, as wall: {stiffness: 0.3}. Sources: hknob check")
    return "".join(f"{indent}{line}\n" for line in lines)


def _grid_of_preset(own: str, read: Read) -> str:
    """The sample rate and counts of a preset, as the comment that they are."""
    indent = own[: len(own) - len(own.lstrip())]
    given = ", ".join(f"{name}: {value}" for name, value in read.grid.items())
    return f"{indent}# grid: {{{given}}}   # the preset's; lists vary it\n"


def _in_proportion(own: str, scene: Mapping[str, Any], grid: Mapping[str, Any]) -> str:
    """Numbers of a starter's own knob, to another knob; what that does not have as a number stays."""
    found = {}
    for text, path, times in _NUMBERS:
        value: object = {"scene": scene, "grid": grid}
        for step in path:
            value = value.get(step) if isinstance(value, dict) else None
        if isinstance(value, int | float):
            found[text] = f"{value * times:.12g}" if isinstance(times, float) else str(value * times)
    return re.sub(r"(?<![\w.])[\d.]+(?![\w.])", lambda number: found.get(number[0], number[0]), own)


def _leaves(part: dict[str, object], above: str = "") -> list[tuple[str, object]]:
    """Values of mappings in mappings, by their dotted paths."""
    found: list[tuple[str, object]] = []
    for key, value in part.items():
        found += _leaves(value, f"{above}{key}.") if isinstance(value, dict) else [(f"{above}{key}", value)]
    return found


def _comment(text: str) -> list[str]:
    """A text as lines of a comment."""
    from textwrap import wrap

    return wrap(text, _WIDTH - 8, initial_indent="# ", subsequent_indent="#   ", break_long_words=False)


def _named(found: re.Match[str], preset: str) -> str:
    """The line of the name, after the preset, with its comment where it was."""
    name = re.sub(r"[^A-Za-z0-9._-]", "-", Path(preset).stem)
    return f"name: my-{name}".ljust(len(found[0]) - 1) + " "


def _validate(text: str, kind: str, preset: str, beside: Path) -> None:
    """Raise `UsageError` where a kind refuses what a preset has."""
    from hknob_cli.specs.load import validate
    from hknob_cli.specs.source import parse

    try:
        validate(parse(text, str(beside / "starter.yaml")), kind=kind)
    except SpecError as error:
        said = "; ".join(f"{fault.key}: {fault.message}" for fault in error.faults)
        raise UsageError(f"--from: a spec of kind {kind} cannot begin from {preset}: {said}") from None


def about(kind: str) -> str:
    """What a kind of spec is about, in a sentence: that of its stage, or of a pipeline."""
    return "Run several stages, each after those that it needs." if kind == PIPELINE else STAGES[kind].summary


Place = tuple[str, ...]
YES, NO = "yes", "no"


class Question(NamedTuple):
    """What is asked, what Enter stands for, and what an answer changes.

    ``place``: it is the value there. ``comment``: it makes the line of this key active, with the answer in
    ``inside``, or as the line is if the answer is yes; ``instead``: the key of what then goes. ``unit``: of a number
    that others of the starter are in proportion to. ``many``: the answer is a list of words.
    """

    asked: str
    default: str = ""
    place: Place = ()
    comment: str = ""
    inside: str = "{}"
    instead: str = ""
    unit: str = ""
    many: bool = False


def _knob(scene: Place, push: Place, grid: Place) -> tuple[Question, ...]:
    return (
        Question("Inertia of knob and motor, kg*m^2 or with a unit", place=(*scene, "knob", "inertia")),
        Question("Friction, N*m or with a unit", "none", comment="coulomb_torque"),
        Question("Stiffness of the wall, N*m/rad", place=(*scene, "wall", "stiffness"), unit="N*m/rad"),
        Question("Push of the hand into the wall, N*m or with a unit", place=push),
        Question("Sample rate, Hz", place=(*grid, RATE), unit="Hz"),
        Question("Encoder counts per revolution", place=(*grid, COUNTS), unit="1"),
    )


_ALONE = _knob(("scene",), ("scene", "bias", "torque"), ("grid",))
_EVERY = Question(
    "Let it go in every way within 50 mrad and 5 rad/s, not in one only? (yes or no)",
    NO, comment="starts", instead="starts",
)  # fmt: skip
_FELT = Question(
    "Radius of the knob, to ask who feels it; in m or with a unit",
    "do not ask", comment="perceive", inside="{{knob_radius: {}}}",
)  # fmt: skip
_BASE, _BASE_PUSH = ("base", "scene"), ("base", "scene", "bias", "torque")
_QUESTIONS: dict[str, tuple[Question, ...]] = {
    "sweep": (*_ALONE, _EVERY, _FELT),
    "dfa": _ALONE,
    "predict": _ALONE,
    "remedies": (*_knob(_BASE, _BASE_PUSH, ("base", "grid")), _FELT),
    "design": _knob(_BASE, _BASE_PUSH, ("present",)),
    "bench": _knob(_BASE, _BASE_PUSH, ("base",)),
    "hw-run": _knob((), ("person", "push"), ("grid",)),
    "sysid": (
        Question(
            "Recordings: files, with blanks between",
            "simulated ones",
            comment="recordings",
            instead="virtual",
            many=True,
        ),
    ),
    "report": (Question("Folders of results, with blanks between", place=("results",), many=True),),
    PIPELINE: (
        Question("Spec of the first stage", place=("stages", "knob", "spec")),
        Question("Spec of the page", place=("stages", "page", "spec")),
    ),
}


def questions(kind: str, text: str) -> Iterator[Question]:
    """What is asked about a text of a kind, each with the default that the text has."""
    for one in _QUESTIONS.get(kind, ()):
        if one.comment:
            if _commented(one.comment).search(text):
                yield one
            continue
        try:
            begin, end = span_of(text, one.place)
        except KeyError:
            continue
        shown = text[begin:end]
        yield one._replace(default=shown.strip("[]").replace(",", "") if one.many else shown)


def answered(kind: str, text: str, answers: Mapping[Question, str]) -> str:
    """A text of `starter` with these answers. Those that are the defaults change nothing."""
    given = {one: answer for one, answer in answers.items() if answer != one.default}
    scale = {one.place[-1]: _number(answer, one.unit) for one, answer in given.items() if one.unit}
    if scale and text == own_starter(kind, {}, {}):
        text = own_starter(kind, {"wall": scale}, scale)
    for one, answer in given.items():
        words = f"[{', '.join(map(json.dumps, answer.split()))}]" if one.many else answer
        text = _made_active(text, one, words) if one.comment else put(text, one.place, words)
    return text


def put(text: str, place: Place, words: str) -> str:
    """A text with other words at a place. Raises `KeyError` if there is none."""
    begin, end = span_of(text, place)
    return text[:begin] + words + _moved(text[end:], len(words) - (end - begin))


def refuse(kind: str, text: str, answers: Mapping[Question, str], beside: Path) -> None:
    """Raise `SpecError` if a text with these answers, the newest last, is no spec of its kind in a folder."""
    newest, answer = list(answers.items())[-1]
    if newest.default == NO and answer != YES:
        raise SpecError([Fault("", 0, 0, newest.comment, f"must be {YES} or {NO}")])
    source = parse(answered(kind, text, answers), str(beside / "starter.yaml"))
    if kind in KINDS and not newest.many:  # files and folders may come later
        validate(source, kind=kind)


def _number(answer: str, unit: str) -> float | None:
    """The first number of an answer, in SI; None if there is none."""
    try:
        value = parse_value(answer)
        first = value[0] if isinstance(value, list) and value else value
        number = to_si(first, unit) if isinstance(first, str) else first
    except ValueError:
        return None
    if isinstance(number, bool) or not isinstance(number, int | float):
        return None
    return int(number) if float(number).is_integer() else number


def _commented(key: str) -> re.Pattern[str]:
    """A line that is a comment until it is wanted: its indent, its value, and what it says beside that."""
    return re.compile(rf"^( *)# {key}: (\{{.*?\}}|\[.*?\]|[^#\n]*?)( +#[^\n]*)?\n", re.MULTILINE)


def _made_active(text: str, one: Question, words: str) -> str:
    found = _commented(one.comment).search(text)
    assert found is not None
    value = found[2] if words == YES else one.inside.format(words)
    before, after = text[: found.start()], text[found.end() :]
    if one.instead:
        before = re.sub(rf"^{one.instead}:.*\n(?: .*\n)*", "", before, count=1, flags=re.MULTILINE)
    line = f"{found[1]}{one.comment}: {value}"
    rest = f"{found[3] or ''}\n{after}"
    return f"{before}{line}{_moved(rest, len(line) - (found.end(2) - found.start()))}"


def _moved(rest: str, by: int) -> str:
    """What follows in a line that has become longer, the comment in it in the column where it was, if there is room."""
    return re.sub(r"^([^\n#]*?)( +)(?=#)", lambda gap: gap[1] + " " * max(1, len(gap[2]) - by), rest, count=1)
