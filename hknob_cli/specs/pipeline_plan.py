"""A pipeline as plain values: its stages, and what each waits for."""

from pathlib import Path
from typing import Any, NamedTuple


class StagePlan(NamedTuple):
    """A stage of a pipeline: its ``spec``, or the ``folder`` of results that are taken as they are.

    ``settings``: overrides of its spec; ``inputs``: by path in its spec, the stage or stages whose folders go there;
    ``where``: the place in the pipeline's file.
    """

    name: str
    spec: Path | None
    settings: tuple[str, ...]
    inputs: dict[str, tuple[str, ...] | str]
    where: str
    folder: Path | None = None

    @property
    def needs(self) -> tuple[str, ...]:
        """Stages that it waits for."""
        return tuple(
            dict.fromkeys(
                name for found in self.inputs.values() for name in ((found,) if isinstance(found, str) else found)
            )
        )


class PipelinePlan(NamedTuple):
    """A pipeline of stages by name."""

    name: str
    stages: dict[str, StagePlan]
    values: dict[str, Any]
