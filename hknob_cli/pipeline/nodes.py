"""A step of a pipeline, its files and values, in the form that pytask's programmatic build takes.

The classes follow pytask's protocols (``PNode``, ``PTask``) without importing it, so that whether anything has changed
can be said before it is loaded.
"""

import hashlib
import os
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

from hknob_cli.errors import ComputationError
from hknob_cli.results.files import read_digest


class FileNode:
    """A file, or a folder of results, that a step reads or writes.

    It is named from the folder of the record, and its state is the digest of its content.
    """

    def __init__(self, path: Path, root: Path) -> None:
        self.file = path.absolute()
        self.shown = str(path)
        self.name = Path(os.path.relpath(path, root)).as_posix()
        self.attributes: dict[Any, Any] = {}

    @property
    def signature(self) -> str:
        """What tells nodes apart."""
        return f"file {self.file}"

    def state(self) -> str | None:
        """Digest of the content; None if there is no file. Raises `ComputationError` if it cannot be read."""
        try:
            return read_digest(self.file)
        except OSError as error:
            raise ComputationError(f"{self.shown}: cannot be read: {error.strerror or error}") from None

    def load(self, is_product: bool = False) -> Path:  # noqa: ARG002
        """The path."""
        return self.file

    def save(self, value: Any) -> None:
        """Steps write their files themselves."""
        raise NotImplementedError


class ValueNode:
    """Something a step depends on that is no file: settings, the version of the program."""

    def __init__(self, name: str, value: str) -> None:
        self.name = name
        self.value = value
        self.attributes: dict[Any, Any] = {}

    @property
    def signature(self) -> str:
        """What tells nodes apart."""
        return f"value {self.name}"

    def state(self) -> str:
        """Digest of the value."""
        return hashlib.sha256(self.value.encode()).hexdigest()

    def load(self, is_product: bool = False) -> str:  # noqa: ARG002
        """The value."""
        return self.value

    def save(self, value: Any) -> None:
        """Values are not written."""
        raise NotImplementedError


class Step:
    """One stage to run: what it ``reads``, what it ``writes``, the ``values`` it depends on by name, and how to run it.

    ``needs`` are the files of other steps; ``root`` is the folder of the record. ``run`` says whether anything had to
    be computed, which ``computed`` keeps, and raises `HknobError`.
    """

    def __init__(
        self,
        name: str,
        *,
        reads: tuple[Path, ...],
        needs: tuple[Path, ...],
        writes: tuple[Path, ...],
        values: dict[str, str],
        root: Path,
        run: Callable[[], bool],
    ) -> None:
        self.name = name
        self.reads = reads
        self.needs = needs
        self.writes = writes
        self.run = run
        self.values = values
        self.root = root
        self.markers: list[Any] = []
        self.report_sections: list[tuple[str, str, str]] = []
        self.attributes: dict[Any, Any] = {}
        self.function = run
        self.computed = False

    @cached_property
    def depends_on(self) -> dict[str, Any]:
        """Nodes that it waits for."""
        files = [FileNode(path, self.root) for path in dict.fromkeys((*self.reads, *self.needs))]
        values = [ValueNode(f"{self.name}: {name}", value) for name, value in self.values.items()]
        return {"inputs": [*files, *values]}

    @cached_property
    def produces(self) -> dict[str, Any]:
        """Nodes that it makes."""
        return {"outputs": [FileNode(path, self.root) for path in self.writes]}

    @property
    def signature(self) -> str:
        """What tells steps apart."""
        return f"step {self.name}"

    def state(self) -> str:
        """What it depends on is in its inputs."""
        return "1"

    def execute(self, **_inputs: Any) -> None:
        """Run it."""
        self.computed = self.run()
