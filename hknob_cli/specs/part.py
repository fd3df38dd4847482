"""What every mapping of a spec is: immutable, without unknown keys; and where in a spec something stands."""

from pydantic import BaseModel, ConfigDict

Place = tuple[str | int, ...]


class Part(BaseModel):
    """A piece of a spec: immutable, no unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)
