"""Starters: for each kind of spec a short commented file to begin from, with a user's own knob or a preset's."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.specs.from_preset import SCENES
from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.specs.preset import Read, read_preset
from hknob_cli.stage_table import PIPELINE, STAGES

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
