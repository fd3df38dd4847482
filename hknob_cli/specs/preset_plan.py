"""A preset as plain values: which knob a spec is from, where each of its numbers is from, and what it leaves out."""

from pathlib import Path
from typing import Any, NamedTuple


class PresetValue(NamedTuple):
    """A value by its dotted path in scene or grid, as written; ``source``: where it is from; ``assumed``: why this one.

    One of the two texts is empty. Both are where the file says nothing about the value.
    """

    path: str
    value: Any
    source: str = ""
    assumed: str = ""

    @property
    def text(self) -> str:
        """The value, and what is said about it."""
        said = f"assumed: {self.assumed}" if self.assumed else self.source or "no source"
        return f"{self.path} = {self.value}: {said}"


class Preset(NamedTuple):
    """A preset in use: its name or path as a spec has it, what it is, its file and digest, and what it leaves out.

    ``about``: where to read more. ``values`` of a spec's own are not among these.
    """

    name: str
    title: str
    about: str
    file: Path
    sha256: str
    values: tuple[PresetValue, ...]
    left_out: tuple[str, ...]

    @property
    def lines(self) -> list[str]:
        """What a user is told of the preset, a line each."""
        return [
            f"preset {self.name}: {self.title}",
            *([f"  from: {self.about}"] if self.about else []),
            *(f"  {one.text}" for one in self.values),
            *(f"  left out: {one}" for one in self.left_out),
        ]
