"""docs/reference/presets.md, made of the presets that ship: each number with its source, and what is left out."""

from collections.abc import Iterator
from pathlib import Path

from hknob_cli.specs.preset import names, read_preset

_HEAD = """\
# Presets

This page is made from the files in `data/knobs/` (`make schemas`). `scene: {from: smartknob}` starts a scene from one
of them; what the spec says beside `from` is merged over it, and `null` removes a part. A grid without a sample rate
or counts takes the preset's. `hknob check SPEC.yaml` prints these lines for the preset that a spec uses, without the
values that it overrides. [Which of these knobs buzz](../explanation/knobs.md) is computed there.

A file of your own works too: `scene: {from: ./my_knob.yaml}`, relative to the spec. It has `title`, `about`, `scene`,
`grid` and `left_out` as the files in `data/knobs/` do. A value stands there with a `source` or with what is `assumed`,
or bare.
"""


def page() -> str:
    """The page as Markdown."""
    return "\n".join([_HEAD, *(line for name in names() for line in _section(name))])


def _section(name: str) -> Iterator[str]:
    preset = read_preset(name, Path()).preset
    yield f"## {name}"
    yield ""
    yield f"{preset.title}. From: {preset.about}."
    yield ""
    yield "| number | value | source, or what is assumed |"
    yield "|---|---|---|"
    for one in preset.values:
        said = f"**assumed**: {one.assumed}" if one.assumed else one.source
        yield f"| `{one.path.partition('.')[2]}` | {one.value} | {said} |"
    yield ""
    yield "Left out:"
    yield ""
    yield from (f"- {' '.join(one.split())}" for one in preset.left_out)
    yield ""
