"""The pipeline's spec: stages by name, each a spec file, with inputs from one another."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from hknob_cli.errors import Fault, SpecError
from hknob_cli.specs.messages import unknown
from hknob_cli.specs.scene import Part
from hknob_cli.specs.scene_paths import faults_of
from hknob_cli.specs.source import Source
from hknob_cli.specs.stage_plans import PipelinePlan, StagePlan
from hknob_cli.specs.sweep import Name

FROM = "from"
ALL = "all"
RESERVED = ("pytask.lock", "pytask.lock.journal", "pytask.lock.tmp", "pipeline.json")  # in the results folder


class StageSpec(Part):
    """A stage: a spec file, and values set in it; or a folder of results that are taken as they are."""

    spec: Annotated[str | None, Field(min_length=1, description="spec file of the stage, relative to this file")] = None
    folder: Annotated[
        str | None,
        Field(min_length=1, description="results that are a source: recorded or measured once, never run from here"),
    ] = None
    set: Annotated[
        dict[str, Any],
        Field(
            default_factory=dict,
            description="values of the spec to override, by dotted path; {from: STAGE} is the results folder of a "
            "stage, {from: [STAGE, ...]} of several by name, {from: all} of all others",
        ),
    ]


class PipelineSpec(Part):
    """Stages that are run in the order of their inputs, and only where something they depend on has changed."""

    kind: Literal["pipeline"]
    name: Annotated[Name, Field(description="names the results folder; each stage has a folder of its name in it")]
    stages: Annotated[dict[Name, StageSpec], Field(min_length=1)]


def validate_pipeline(source: Source) -> PipelinePlan:
    """A pipeline's spec as plain values. Raises `SpecError`."""
    try:
        spec = PipelineSpec.model_validate(source.value)
    except ValidationError as error:
        raise SpecError(faults_of(source, PipelineSpec, error)) from None
    faults: list[Fault] = []
    stages: dict[str, StagePlan] = {}
    for name, stage in spec.stages.items():
        if name in RESERVED:
            faults.append(
                source.fault(("stages", name), "must be another name: this is a file of the run", at_key=True)
            )
        if (stage.spec is None) == (stage.folder is None) or (stage.folder is not None and stage.set):
            faults.append(source.fault(("stages", name), "must have either spec (and set), or folder", at_key=True))
            continue
        inputs: dict[str, tuple[str, ...] | str] = {}
        for path, value in stage.set.items():
            if isinstance(value, dict) and list(value) == [FROM]:
                place = ("stages", name, "set", path)
                wrong = _input_fault(value, name, list(spec.stages))
                if wrong:
                    faults.append(source.fault(place, wrong))
                    continue
                found = [other for other in spec.stages if other != name] if value[FROM] == ALL else value[FROM]
                inputs[path] = found if isinstance(found, str) else tuple(found)
        settings = {path: value for path, value in stage.set.items() if path not in inputs}
        stages[name] = StagePlan(
            name=name,
            spec=Path(source.name).parent / stage.spec if stage.spec is not None else None,
            folder=Path(source.name).parent / stage.folder if stage.folder is not None else None,
            settings=tuple(f"{path}={json.dumps(value)}" for path, value in settings.items()),
            inputs=inputs,
            where=str(source.fault(("stages", name, "spec"), "")).removesuffix(": "),
        )
    faults += _cycles(source, stages)
    if faults:
        raise SpecError(faults)
    return PipelinePlan(spec.name, stages, source.value)


def _input_fault(value: dict[str, Any], name: str, stages: list[str]) -> str | None:
    """What is wrong with a ``{from: ...}``; None if nothing is."""
    found = value[FROM]
    if found == ALL:
        return None
    names = found if isinstance(found, list) else [found]
    if not names or not all(isinstance(one, str) for one in names):
        return f"must be {{from: STAGE}}, a list of stages, or all, got {found!r}"
    for one in names:
        if one == name:
            return f"must be another stage, got '{one}'"
        if one not in stages:
            return unknown("stage", one, [stage for stage in stages if stage != name])
    return None


def _cycles(source: Source, stages: dict[str, StagePlan]) -> list[Fault]:
    """Faults of stages that wait for one another."""
    import graphlib

    try:
        graphlib.TopologicalSorter({name: stage.needs for name, stage in stages.items()}).prepare()
    except graphlib.CycleError as error:
        chain = error.args[1]
        return [source.fault(("stages", chain[0]), f"must not wait for itself: {' -> '.join(reversed(chain))}")]
    return []
