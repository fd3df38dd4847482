"""From a file (and overrides) to what it says, or to the list of its faults with their places."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from hknob_cli.errors import Fault, SpecError, UsageError
from hknob_cli.specs import source as yaml
from hknob_cli.specs.bench import Case, CaseFile, DfaSpec, PredictSpec
from hknob_cli.specs.cells import cells_over
from hknob_cli.specs.grid import MAX_CELLS, Grid
from hknob_cli.specs.hand import PopulationSpec
from hknob_cli.specs.messages import closest, shown, unknown
from hknob_cli.specs.named_file import digest_of
from hknob_cli.specs.plan import COUNTS, PERSON, RATE, Axes, DfaPlan, Hand, Plan, PredictPlan, SweepPlan
from hknob_cli.specs.preset import take_preset
from hknob_cli.specs.refusals import Limit, contradictions, refusals, resolve_axes, too_many
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.specs.scene_paths import axis_unit, faults_of
from hknob_cli.specs.source import Source
from hknob_cli.specs.stage_plans import PipelinePlan, StagePlan
from hknob_cli.specs.sweep import MOST_CELLS, LimitsSpec, SweepSpec
from hknob_cli.stage_table import KINDS, PIPELINE, SCHEMAS, SPECS, STAGES, loaded

if TYPE_CHECKING:
    from hknob_cli.specs.find_people import Population

Spec = SweepSpec | DfaSpec | PredictSpec


def load(
    path: Path,
    overrides: tuple[str, ...] = (),
    *,
    kind: str | None = None,
    label: str = "--set ",
    waiting: frozenset[str] = frozenset(),
) -> Plan:
    """Read and validate one spec.

    ``overrides`` are ``key.path=value`` strings, and ``label`` says in faults where they are from; ``kind`` is the kind
    required, any if None. Of a pipeline it is the one stage of that kind. Hands from folders that are ``waiting`` for
    their results have no numbers. Raises `UsageError` if the file cannot be read, `SpecError` with every fault found.
    """
    source = yaml.read(path)
    source.waiting = waiting
    if kind in KINDS and source.value.get("kind") == PIPELINE:
        return _only_stage(source, overrides, str(kind))
    apply_overrides(source, overrides, label)
    return validate(source, kind=kind)


def load_text(text: str, name: str, overrides: tuple[str, ...] = (), *, kind: str | None = None) -> Plan:
    """Validate the text of a spec; ``name`` stands for its file in faults, and paths in it are relative to it.

    Raises `SpecError` with every fault found.
    """
    source = yaml.parse(text, name)
    apply_overrides(source, overrides, "--set ")
    return validate(source, kind=kind)


def kind_of(path: Path) -> object:
    """What a spec file says its kind is. Raises as `load`."""
    return yaml.read(path).value.get("kind")


def is_ledger(path: Path) -> bool:
    """Whether a file is a ledger of claims, which has no kind. Raises as `load`."""
    return isinstance(yaml.read(path).value.get("claims"), list)


def load_pipeline(path: Path, overrides: tuple[str, ...] = ()) -> PipelinePlan:
    """Read and validate a pipeline; of its stages' specs only that they are named.

    A spec of another kind is a pipeline of one stage. Raises as `load`.
    """
    source = yaml.read(path)
    kind = source.value.get("kind")
    if kind in KINDS:
        name = str(load(path, overrides).name)
        return PipelinePlan(name, {str(kind): StagePlan(str(kind), path, overrides, {}, "--set ")}, source.value)
    apply_overrides(source, overrides, "--set ")
    if kind != PIPELINE:
        raise SpecError([source.fault(("kind",), _kind_fault(kind, SPECS))])
    from hknob_cli.specs.pipeline import validate_pipeline

    return validate_pipeline(source)


def _only_stage(source: Source, overrides: tuple[str, ...], kind: str) -> Plan:
    """The stage of a kind in a pipeline, where there is one that needs no other."""
    from hknob_cli.specs.pipeline import validate_pipeline

    pipeline = validate_pipeline(source)
    stages = [stage for stage in pipeline.stages.values() if stage.spec and kind_of(stage.spec) == kind]
    if len(stages) != 1 or stages[0].inputs or not stages[0].spec:
        found = ", ".join(str(stage.spec) for stage in stages) or "none"
        text = f"is a pipeline; hknob run runs it. Specs of its {kind} stages: {found}"
        raise SpecError([source.fault(("kind",), text)])
    return load(stages[0].spec, (*stages[0].settings, *overrides), kind=kind)


def apply_overrides(source: Source, overrides: tuple[str, ...], label: str) -> None:
    """Apply overrides to the values of a source. Raises `SpecError`."""
    faults = [fault for text in overrides if (fault := _override(source, text, label))]
    if faults:
        raise SpecError(faults)


def validate(source: Source, *, kind: str | None = None, presets: bool = True) -> Plan:
    """Validate the values of ``source``; ``presets``: its scene may be from one. Raises `SpecError`."""
    given = source.value.get("kind")
    if given is None:
        raise SpecError([source.fault(("kind",), _kind_fault(None, SPECS))])
    known = isinstance(given, str) and given in KINDS
    if not known or (kind is not None and given != kind):
        allowed = (kind,) if kind else KINDS if given == PIPELINE else SPECS
        raise SpecError([source.fault(("kind",), _kind_fault(given, allowed))])
    preset = take_preset(source) if presets else None
    make_plan = STAGES[given].validate
    made: Any = loaded(make_plan)(source) if make_plan else _validated(source, given)
    plan: Plan = made._replace(preset=preset) if preset else made
    return plan


def _validated(source: Source, kind: str) -> SweepPlan | DfaPlan | PredictPlan:
    """The plan of a spec of a kind that has a scene and a grid. Raises `SpecError`."""
    model: type[Spec] = spec_model(kind)
    faults: list[Fault] = []
    scene: SceneSpec | None = None
    try:
        spec = model.model_validate(source.value)
        grid, scene = spec.grid, spec.scene
    except ValidationError as error:
        faults += faults_of(source, model, error)
        try:
            grid = Grid.model_validate(source.value.get("grid"))
        except ValidationError:
            raise SpecError(faults) from None
    limit = _limit(source, model)
    axes, points, more = resolve_axes(source, grid, scene, limit)
    if scene and scene.hand and scene.hand.from_:
        from hknob_cli.specs.hand_from import take_hand

        faults += [source.fault(path, text) for path, text in take_hand(source, scene.hand, axes)]
    faults += more + _missing_axes(source, scene) + _refused(source, scene, axes)
    if scene:
        faults += [source.fault(path, text) for path, text in contradictions(scene, axes)]
    people: Population | None = None
    if not faults and isinstance(spec, SweepSpec):
        if spec.population:
            people, axes = _people(source, spec, spec.population, axes)
            count = len(cells_over(axes, points))
            if count > limit.cells:
                faults.append(source.fault(("population",), too_many(count, limit, " with the grid")))
        faults += [source.fault(path, text, at_key=True) for path, text in spec.contradictions(axes, points)]
    if faults:
        raise SpecError(faults)
    plan = spec.plan(axes, {name: axis_unit(name) for name in axes}, source.value)._replace(points=points)
    if people:
        return plan._replace(scene=plan.scene._replace(hand=Hand(by_person=people.hands, origin=people.origin)))
    if isinstance(spec, PredictSpec) and isinstance(plan, PredictPlan) and isinstance(spec.constant, CaseFile):
        constant, digest = _read_case(source, spec.constant.case)
        return plan._replace(constant=constant, case_sha256=digest, case_file=_case_file(source, spec.constant.case))
    return plan


def _kind_fault(given: object, allowed: Sequence[str]) -> str:
    """What is wrong with what a spec says of its kind."""
    if given is None:
        return f"missing, and required; {'one of: ' if len(allowed) > 1 else 'must be '}{', '.join(allowed)}"
    close = closest(given, list(allowed)) if isinstance(given, str) and len(allowed) > 1 else None
    hint = f"; did you mean '{close}'?" if close else ""
    names = f"one of: {', '.join(allowed)};" if len(allowed) > 1 else f"{allowed[0]},"
    return f"must be {names} got {shown(given)}{hint}"


def _people(source: Source, spec: SweepSpec, population: PopulationSpec, axes: Axes) -> "tuple[Population, Axes]":
    """The people of a population, and the axes with them. Raises `SpecError`."""
    from hknob_cli.specs.find_people import find_people

    found = find_people(source, population, min(axes.get("knob.inertia", [spec.scene.knob.inertia])))
    faults = [source.fault(path, text) for path, text in found.faults]
    if faults:
        raise SpecError(faults)
    return found, {**axes, PERSON: list(range(1, len(found.hands) + 1))}


def _case_file(source: Source, name: str) -> Path:
    return Path(source.name).parent / name


def _read_case(source: Source, name: str) -> tuple[float, str]:
    """C of the known case in a file, and the file's digest. Raises `SpecError` with the faults of either file."""
    path = _case_file(source, name)
    try:
        digest = digest_of(path)
        case_source = yaml.read(path)
    except UsageError as error:
        if isinstance(error, SpecError):
            raise
        raise SpecError([source.fault(("constant", "case"), str(error))]) from None
    try:
        case = Case.model_validate(case_source.value)
    except ValidationError as error:
        raise SpecError(faults_of(case_source, Case, error)) from None
    return case.constant(), digest


def _missing_axes(source: Source, scene: SceneSpec | None) -> list[Fault]:
    """Faults of a grid that lacks what its scene needs."""
    needed = {RATE: scene is None or scene.sampling != "continuous", COUNTS: scene is None or scene.encoder != "none"}
    given = source.value.get("grid") or {}
    return [
        source.fault(("grid", name), "missing, and required")
        for name, need in needed.items()
        if need and given.get(name) is None
    ]


def _refused(source: Source, scene: SceneSpec | None, axes: Axes) -> list[Fault]:
    """Faults of scene values that this kind of spec cannot have."""
    column = {"dfa": "describing", "predict": "formulas"}.get(source.value["kind"])
    methods = source.value.get("methods") or ["sampled"]
    if column == "describing" and isinstance(methods, list) and "sampled" in methods:  # another value is a fault itself
        column = "relay"
    found = refusals(scene, axes, [column]) if scene and column else []
    return [source.fault(place, text, at_key=place[0] == "grid") for place, text in found]


def _limit(source: Source, model: type[Spec]) -> Limit:
    """How many cells the spec may span; told from its values alone, whatever else may be wrong with them."""
    if model is not SweepSpec:
        return Limit(MAX_CELLS, f"{source.value['kind']} keeps all in memory")
    try:
        cells = LimitsSpec.model_validate(source.value.get("limits") or {}).max_cells
        return Limit(cells, f"limits.max_cells allows up to {MOST_CELLS:g}")
    except ValidationError:
        return Limit(MOST_CELLS, "")


def _override(source: Source, text: str, label: str) -> Fault | None:
    """Apply one ``key.path=value``; the fault if it cannot be."""
    where = f"{label}{text}"
    path_text, sign, value_text = text.partition("=")
    if not sign or not all(part.strip() for part in path_text.split(".")):
        return Fault(where, 0, 0, "", "must be key.path=value")
    if not yaml.is_text(text):
        return Fault(where, 0, 0, "", "must be key.path=value in UTF-8")
    path = tuple(path_text.strip().split("."))
    if path[0] == "grid" and len(path) > 2:
        form = path[-1:] if path[-1] in ("log", "lin") or path[1] == "design" else ()
        path = ("grid", ".".join(path[1 : len(path) - len(form)]), *form)
    if path[0] in ("choices", "present") and len(path) > 2:  # of a design: by dotted path
        path = (path[0], ".".join(path[1:]))
    if path[0] == "stages" and path[2:3] == ("set",) and len(path) > 4:
        path = (*path[:3], ".".join(path[3:]))
    if wrong := _unknown(source, path_text.strip()):
        return Fault(where, 0, 0, path_text.strip(), wrong)
    try:
        value = yaml.parse_value(value_text)
    except ValueError as error:
        return Fault(where, 0, 0, path_text.strip(), str(error))
    target = source.value
    for part in path[:-1]:
        inner = target.get(part)
        if inner is None:
            inner = target[part] = {}
        if not isinstance(inner, dict):
            return Fault(where, 0, 0, path_text.strip(), f"must lead through mappings, but '{part}' is a value")
        target = inner
    target[path[-1]] = value
    for place in [place for place in (*source.keys, *source.values) if place[: len(path)] == path]:
        source.keys.pop(place, None)
        source.values.pop(place, None)
    source.overridden[path] = where
    return None


def _unknown(source: Source, path: str) -> str | None:
    """What is wrong with a path that an override names, if a spec of this kind has no such key."""
    kind = source.value.get("kind")
    if not isinstance(kind, str) or kind not in SPECS:
        return None
    from hknob_cli.specs.scene_paths import unknown_path

    stages = source.value.get("stages")
    return unknown_path(spec_model(kind), path, list(stages) if isinstance(stages, dict) else ())


def spec_model(kind: str) -> Any:
    """Model of one kind of spec, a class of pydantic. Raises `UsageError` for an unknown kind."""
    if kind not in SPECS:
        raise UsageError(unknown("kind", kind, SCHEMAS))
    return loaded(STAGES[kind].model if kind in STAGES else "hknob_cli.specs.pipeline:PipelineSpec")
