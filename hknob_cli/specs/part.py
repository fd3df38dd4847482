"""What every mapping of a spec is: immutable, without unknown keys; and where in a spec something stands."""

from functools import cache
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, create_model
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from hknob_cli.specs.quantity import Place as Place
from hknob_cli.specs.quantity import is_declared


class Part(BaseModel):
    """A piece of a spec: immutable, no unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


def model_of(kind: Any) -> type[BaseModel] | None:
    """The model of a type that is a part of a spec: its own, or the one that is made of it; None of other types."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return kind
    return _model_of_declared(kind) if is_declared(kind) else None


@cache
def _model_of_declared(kind: Any) -> type[BaseModel]:
    """The model that validates a named tuple of `quantity.declared`."""
    made: type[BaseModel] = model_with_fields(
        kind, f"{kind.__name__}Spec", but=kind.unread, json_schema_extra=kind.json_schema_extra
    )
    return made


def model_with_fields(kind: Any, name: str, *, but: tuple[str, ...] = (), **config: Any) -> Any:
    """A model called ``name`` with the fields of a named tuple, ``but`` some; ``config`` as pydantic takes it."""
    fields: dict[str, Any] = {
        key: (_described(annotation), _default(kind._field_defaults.get(key, ...)))
        for key, annotation in kind.__annotations__.items()
        if key not in but
    }
    module = kind.__module__
    return create_model(name, __base__=Part, __doc__=kind.__doc__, __module__=module, __cls_kwargs__=config, **fields)


def _default(value: Any) -> Any:
    """A default as pydantic takes it; that of a part is made anew, and is not written into the JSON Schema."""
    return Field(default_factory=lambda: value) if is_declared(type(value)) else value


def _described(annotation: Any) -> Any:
    """An annotation with its text as pydantic takes it."""
    if not hasattr(annotation, "__metadata__"):
        return annotation
    held = (Field(description=one) if isinstance(one, str) else one for one in annotation.__metadata__)
    return Annotated[(annotation.__origin__, *held)]


def validator_of(kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
    """Validate by the model, then make the named tuple."""

    def make(read: BaseModel) -> Any:
        made = kind(**dict(read))
        if wrong := made.wrong() if hasattr(made, "wrong") else "":
            raise PydanticCustomError("wrong", "{text}", {"text": wrong})
        return made

    return core_schema.no_info_after_validator_function(make, handler.generate_schema(_model_of_declared(kind)))


def default_of(part: Any, key: str) -> Any:
    """Value of a key of a part where it is not listed; `...` where it must be."""
    if hasattr(part, "_field_defaults"):
        return part._field_defaults.get(key, ...)
    return type(part).model_fields[key].default
