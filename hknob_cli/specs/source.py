"""A YAML file as plain values, with the line and column of every key and value.

YAML 1.2 by ruamel.yaml's parser, read as a tree of nodes: that tree has the positions, shows every duplicate key, and
constructs nothing but plain scalars, lists and mappings.
"""

import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.scanner import RoundTripScanner, ScannerError

from hknob_cli.errors import Fault, SpecError, UsageError
from hknob_cli.specs.named_file import MAX_DEPTH, given, is_stdin, size_limit

Path_ = tuple[str | int, ...]

_VERSION = re.compile(r"^%YAML[ \t]+(\S+)", re.MULTILINE)
_PLAIN = {
    "tag:yaml.org,2002:int",
    "tag:yaml.org,2002:float",
    "tag:yaml.org,2002:bool",
    "tag:yaml.org,2002:null",
    "tag:yaml.org,2002:str",
}
_MANY = {"tag:yaml.org,2002:seq", "tag:yaml.org,2002:map"}
_LONGEST_KEY = 60  # of which more is not said
_MOST_BITS = 1023  # of a whole number, which is as large as a float may be


class _Scanner(RoundTripScanner):
    """Gives up what is nested too deeply where it is: to read on takes seconds, and runs out of recursion."""

    def fetch_flow_collection_start(self, *arguments: Any, **named: Any) -> None:
        self._refuse_deeper()
        super().fetch_flow_collection_start(*arguments, **named)

    def add_indent(self, column: int) -> bool:
        self._refuse_deeper()
        return bool(super().add_indent(column))

    def _refuse_deeper(self) -> None:
        if self.flow_level + len(self.indents) > MAX_DEPTH:
            raise ScannerError(None, None, f"more than {MAX_DEPTH} levels", self.reader.get_mark())


class _TooManyError(MarkedYAMLError):
    """A text has more keys and values than a spec may."""


class _Composer(Composer):
    """Gives up what has too much in it where that begins: to read on takes half a minute a megabyte."""

    def __init__(self, loader: YAML) -> None:
        super().__init__(loader=loader)
        self.nodes, self.limit = 0, size_limit()

    def compose_node(self, parent: Any, index: Any) -> Any:
        self.nodes += 1
        if self.nodes > self.limit.values:
            raise _TooManyError(problem=self.limit.too_many, problem_mark=self.loader.parser.peek_event().start_mark)
        return super().compose_node(parent, index)


class Source:
    """Values of one spec and where they stand.

    ``keys`` and ``values`` give line and column by key path; ``overridden`` what set a path from outside the file.
    ``inherited``: where in a preset's file the value of a path is. ``waiting``: folders named in it whose results are
    yet to be made.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.value: Any = None
        self.keys: dict[Path_, tuple[int, int]] = {}
        self.values: dict[Path_, tuple[int, int]] = {}
        self.overridden: dict[Path_, str] = {}
        self.inherited: dict[Path_, str] = {}
        self.waiting: frozenset[str] = frozenset()

    def fault(self, path: Path_, message: str, *, at_key: bool = False) -> Fault:
        """Fault at ``path``: at its value or key, else at the nearest enclosing one; in the option that set it."""
        key = dotted(path)
        for end in range(len(path), -1, -1):
            part = path[:end]
            if part in self.overridden:
                return Fault(self.overridden[part], 0, 0, key, message)
            listed = bool(part) and isinstance(part[-1], int)  # an item of a list has no key
            place = self.keys if (at_key or end < len(path)) and not listed else self.values
            if part in place:
                line, column = place[part]
                return Fault(self.name, line, column, key, message)
            if part in self.inherited:
                return self._of_preset(part, message)._replace(key=key)
        return Fault(self.name, 1, 1, key, message)

    def _of_preset(self, path: Path_, message: str) -> Fault:
        """Fault of a value that a preset gives: where the preset is named, and where its file has the value."""
        scene = path[: path.index("scene")] if "scene" in path else path[: path.index("grid")]
        return self.fault((*scene, "scene", "from"), f"{message}; the preset has it at {self.inherited[path]}")


def dotted(path: Path_) -> str:
    """Key path as the user writes it: ``scene.wall.stiffness``, ``grid.sample_rate_hz[2]``."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
            continue
        name = part if len(part) <= _LONGEST_KEY else f"{part[: _LONGEST_KEY - 3]}..."
        if "." in part:
            text += f'["{name}"]' if text else f'"{name}"'
        else:
            text += f".{name}" if text else name
    return text


def paths_in(value: Any) -> Iterator[Path_]:
    """Paths of all keys in mappings of mappings."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield (key,)
            yield from ((key, *rest) for rest in paths_in(inner))


def read(path: Path) -> Source:
    """Read a spec file.

    Raises `UsageError` if it cannot be read at all, `SpecError` for bad YAML, duplicate keys, foreign tags.
    """
    limit = size_limit()
    try:
        if is_stdin(path):
            data = given(limit.bytes)
        elif path.is_dir():
            raise UsageError(f"{path}: is a folder, where a YAML file is wanted")
        elif path.is_fifo() and path.parts[1:2] not in (("dev",), ("proc",)):  # one might wait for it forever
            raise UsageError(f"{path}: is a pipe, where a YAML file is wanted")
        else:
            with path.open("rb") as stream:
                data = stream.read(limit.bytes + 1)
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror or error}") from None
    if len(data) > limit.bytes:
        raise UsageError(f"{path}: larger than {limit.bytes // 1_000_000} MB; {limit.advice}")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SpecError([Fault(str(path), line, 1, "", f"not UTF-8 text: byte 0x{data[error.start]:02x}")]) from None
    return parse(text, str(path))


def parse(text: str, name: str) -> Source:
    """Read a spec from text; ``name`` stands for the file in faults. Raises `SpecError`."""
    source = Source(name)
    version = _VERSION.search(text)
    if version and version[1] != "1.2":
        line = text.count("\n", 0, version.start()) + 1
        raise SpecError([Fault(name, line, 1, "", f"must be YAML 1.2, not {version[1][:20]}")])
    try:
        node = _composed(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        what = " ".join(filter(None, [error.problem, error.context and f"({error.context})"]))
        what = what if isinstance(error, _TooManyError) else f"not YAML: {what}"
        raise SpecError([Fault(name, line, column, "", what)]) from None
    except (YAMLError, ValueError, RecursionError) as error:
        first = str(error).strip().splitlines()[:1] or [type(error).__name__]
        raise SpecError([Fault(name, 1, 1, "", f"not YAML: {first[0]}")]) from None
    if node is None:
        raise SpecError([Fault(name, 1, 1, "", "empty; a spec starts with 'kind: ...'")])
    if not isinstance(node, MappingNode):
        raise SpecError([Fault(name, *_place(node), "", "a spec is a mapping of keys to values")])
    reader = _Reader(source)
    source.value = reader.construct(node, ())
    if reader.faults:
        raise SpecError(reader.faults)
    return source


@lru_cache(maxsize=2)  # a spec's kind is asked before the spec is loaded
def _composed(text: str) -> Node | None:
    """The tree of a text, which nobody changes. Raises what the parser does."""
    loader = YAML(typ="rt", pure=True)
    loader.Scanner, loader.Composer = _Scanner, _Composer  # type: ignore[assignment]
    loader.composer.warn_double_anchors = False  # YAML 1.2 lets an anchor be used again
    node: Node | None = loader.compose(text)
    return node


def span_of(text: str, path: tuple[str, ...]) -> tuple[int, int]:
    """Where in a text the value at a path of keys begins and ends. Raises `KeyError` if there is none."""
    node = _composed(text)
    for step in path:
        inside = node.value if isinstance(node, MappingNode) else []
        node = {str(key.value): value for key, value in inside}[step]
    assert node is not None
    return node.start_mark.index, node.end_mark.index


def parse_value(text: str) -> Any:
    """Value of an override, read as YAML. Raises `ValueError` with the reason."""
    try:
        source = parse(f"value: {text}", "")
    except SpecError as error:
        raise ValueError(error.faults[0].message) from None
    if list(source.value) != ["value"]:
        raise ValueError("must be one value")
    return source.value["value"]


def is_text(value: str) -> bool:
    """Whether text can be written to a file, and be the name of one; escapes can say what cannot."""
    return "\0" not in value and not any("\ud800" <= letter <= "\udfff" for letter in value)


def _place(node: Node) -> tuple[int, int]:
    return node.start_mark.line + 1, node.start_mark.column + 1


class _Reader:
    """Turns nodes into values and notes positions and faults on the way."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.constructor = YAML(typ="rt", pure=True).constructor  # of this reading: it does not forget what failed
        self.faults: list[Fault] = []
        self.count = 0
        self.limit = size_limit()

    def fail(self, node: Node, path: Path_, message: str) -> None:
        self.faults.append(Fault(self.source.name, *_place(node), dotted(path), message))

    def construct(self, node: Node, path: Path_) -> Any:
        self.count += 1
        if self.count > self.limit.values:
            self.fail(node, (), self.limit.too_many)
            raise SpecError(self.faults)
        if len(path) > MAX_DEPTH:
            self.fail(node, (), f"more than {MAX_DEPTH} levels of keys and lists, aliases expanded")
            raise SpecError(self.faults)
        self.source.values[path] = _place(node)
        if isinstance(node, ScalarNode):
            return self.scalar(node, path)
        if str(node.tag) not in _MANY:
            self.fail(node, path, f"tag {str(node.tag)[:200]!r} is not allowed here; lists and mappings need none")
            return None
        if isinstance(node, SequenceNode):
            return [self.construct(item, (*path, i)) for i, item in enumerate(node.value)]
        if isinstance(node, MappingNode):
            return self.mapping(node, path)
        raise AssertionError(node)

    def scalar(self, node: ScalarNode, path: Path_) -> Any:
        tag = str(node.tag)
        if tag not in _PLAIN:
            self.fail(node, path, f"tag {tag[:200]!r} is not allowed here; numbers, text, true, false and null are")
            return None
        if not is_text(str(node.value)):
            self.fail(node, path, "must be text that a file can have: without NUL, and without half a character")
            return None
        if tag.endswith(":str"):
            # The round-trip parser marks where folded text (">") was broken with a bell.
            return str(node.value).replace("\a", "") if node.style == ">" else str(node.value)
        try:
            value = self.constructor.construct_object(node)
        except (YAMLError, ValueError, OverflowError) as error:
            self.fail(node, path, f"cannot be read as a number: {str(error)[:200]}")
            return None
        except IndexError:  # !!int of nothing
            self.fail(node, path, f"must be a number, got '{str(node.value)[:60]}'")
            return None
        except KeyError:  # !!bool with another word
            self.fail(node, path, f"must be true or false, got '{str(node.value)[:60]}'")
            return None
        # The parser's own kinds of numbers remember how they were written; plain ones are wanted.
        if isinstance(value, bool) or value is None:
            return value
        if isinstance(value, int) and value.bit_length() > _MOST_BITS:
            self.fail(node, path, "must be a number below 1e308, which no value here comes near")
            return None
        return int(value) if isinstance(value, int) else float(value)

    def mapping(self, node: MappingNode, path: Path_) -> dict[str, Any]:
        result: dict[str, Any] = {}
        if len(node.value) > self.limit.keys:
            self.fail(node, path, f"more than {self.limit.keys} keys in one mapping; {self.limit.advice}")
            return result
        for key_node, value_node in node.value:
            if not isinstance(key_node, ScalarNode):
                self.fail(key_node, path, "a key must be a word")
                continue
            key = str(key_node.value)
            if not is_text(key):
                self.fail(key_node, path, "a key must be text that a file can have")
                continue
            if key in result:
                first = self.source.keys[(*path, key)][0]
                self.fail(key_node, (*path, key), f"duplicate key, first given at line {first}")
                continue
            self.source.keys[(*path, key)] = _place(key_node)
            result[key] = self.construct(value_node, (*path, key))
        return result
