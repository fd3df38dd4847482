"""A spec to go on with, from that of a sweep or of remedies: the same knob, hand, grid and starts, asked anew.

The values stand as their author wrote them. What a trial of remedies tries, and what a design chooses from, are in
proportion to the knob; the part that a bounded lag keeps is that of its rule (`theory.staircase`).
"""

import math
from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.specs import source as yaml
from hknob_cli.specs.bench import merged
from hknob_cli.specs.load import apply_overrides, load, validate
from hknob_cli.specs.messages import unknown
from hknob_cli.specs.named_file import is_stdin
from hknob_cli.specs.plan import COUNTS, RATE, Hand, Scene, SweepPlan
from hknob_cli.theory.staircase import best_keep, slowness

FROM = ("sweep", "remedies")  # kinds that a spec can begin from
_TIME_CONSTANT_S = 0.2
_FEW = 16  # clock phases
_KNOB_RADIUS = {"knob_radius": "8.9 mm"}


class _Given(NamedTuple):
    """What a spec says of its knob: as its author wrote it, and ``plan``, its numbers."""

    name: str
    scene: dict[str, Any]  # with its hand, if there is one
    grid: dict[str, Any]
    starts: dict[str, Any]
    perceive: dict[str, Any] | None
    plan: Scene
    rate: float | None  # the only one
    counts: int | None


def begin_from(
    kind: str, path: Path, name: str, beside: Path, overrides: tuple[str, ...] = (), remedy: str | None = None
) -> str:
    """The text of a spec of a ``kind`` with the knob of the spec at ``path``; it would lie in the folder ``beside``.

    ``name``: of the new spec; empty: that of the file, and the kind. ``overrides`` of the spec are ``key.path=value``
    strings. ``remedy``: of a spec of remedies the one that its knob has.

    Raises `UsageError` for kinds that cannot begin from another spec, one that cannot be begun from, and one whose
    parts the kind refuses; `SpecError` and `UsageError` as reading ``path`` does.
    """
    if kind not in KINDS:
        raise UsageError(f"--from: a spec of kind {kind} cannot begin from another spec; {', '.join(KINDS)} can")
    given = _given(path, overrides, remedy)
    whose, stem = (given.name, given.name) if is_stdin(path) else (path.name, path.stem)
    head = f"# The knob of {whose}. In words: hknob explain FILE. All keys: hknob schema {kind}.\n"
    made = {"kind": kind, "name": name or f"{stem}-{kind}", **_MADE[kind](given)}
    if "base" in made and made["base"]["starts"] != given.starts:
        head += (
            f"# {_FEW} phases of the sample clock answer soon; every phase, proven, takes minutes: leave phases out.\n"
        )
    text = head + _text(made)
    try:
        validate(yaml.parse(text, str(beside / "spec.yaml")), kind=kind)
    except SpecError as error:
        said = "; ".join(f"{fault.key}: {fault.message}" for fault in error.faults)
        raise UsageError(f"--from: a spec of kind {kind} cannot begin from {path}: {said}") from None
    return text


def _given(path: Path, overrides: tuple[str, ...], remedy: str | None) -> _Given:
    source = yaml.read(path)
    apply_overrides(source, overrides, "--set ")
    value = source.value
    if value.get("kind") not in FROM:
        raise UsageError(
            f"--from: {path} is a spec of kind {value.get('kind')}; {' and '.join(FROM)} can be begun from"
        )
    load(path, overrides)  # so that its faults are told as its own
    sweep = value
    if remedy is not None and remedy not in value.get("remedies", {}):
        raise UsageError(f"--remedy: {unknown('remedy', remedy, list(value.get('remedies', {})))}")
    if remedy is not None and value["remedies"][remedy].get("tune"):
        raise UsageError(f"--remedy: '{remedy}' is tuned cell by cell; name one that is a change alone")
    if value["kind"] == "remedies":  # the sweep of its base by its first hand
        base, hand = value["base"], next(iter(value["hands"].values()))
        shared = {"perceive": value["perceive"]} if value.get("perceive") else {}
        sweep = {"kind": "sweep", "name": "base", **base, **shared, "scene": {**base["scene"], "hand": hand}}
        sweep = merged(sweep, value["remedies"][remedy].get("change", {})) if remedy is not None else sweep
    plan = validate(yaml.parse(_text(sweep), str(path)), kind="sweep")
    assert isinstance(plan, SweepPlan)
    single: dict[str, Any] = {name: values[0] for name, values in plan.axes.items() if len(values) == 1}
    return _Given(
        name=str(value["name"]),
        scene=sweep["scene"],
        grid=sweep.get("grid") or {},
        starts=sweep.get("starts") or {},
        perceive=sweep.get("perceive"),
        plan=plan.scene,
        rate=single.get(RATE),
        counts=single.get(COUNTS),
    )


def _analysis(given: _Given) -> dict[str, Any]:
    return {"scene": given.scene, **_grid(given)}


def _grid(given: _Given) -> dict[str, Any]:
    """The grid; none where the knob's preset has it."""
    return {"grid": given.grid} if given.grid else {}


def _starts(given: _Given) -> dict[str, Any]:
    """The starts; a few clock phases of one start, where friction or an actuator makes it long to follow all."""
    starts = given.starts
    frictional = given.plan.knob.coulomb_torque > 0.0 or "knob.coulomb_torque" in given.grid
    every = isinstance(starts, dict) and not isinstance(starts.get("angle"), list) and "phases" not in starts
    return {**starts, "phases": _FEW} if every and (frictional or "actuator" in given.scene) else starts


def _remedies(given: _Given) -> dict[str, Any]:
    cell = {"cases": {"this knob": {RATE: given.rate, COUNTS: given.counts}}} if given.rate and given.counts else {}
    return {
        "base": {"scene": _without_hand(given), **_grid(given), "starts": _starts(given)},
        "hands": {"this hand": given.scene.get("hand", {})},
        **cell,
        **({"perceive": given.perceive} if given.perceive else {}),
        "reference": "plain wall",
        "remedies": {"plain wall": {}, **_changes(given)},
    }


def _design(given: _Given) -> dict[str, Any]:
    if not given.rate or not given.counts:
        raise UsageError("--from: a design begins from a knob of one sample rate and one number of counts")
    hand = given.scene.get("hand")
    people = hand if isinstance(hand, dict) and set(hand) == {"table", "grip_n"} else {"table": 1, "grip_n": 0.71}
    stiffness = given.plan.wall.stiffness
    return {
        "base": {"scene": _without_hand(given), "starts": _starts(given)},
        "people": {**people, "people": 3, "seed": 1},
        "perceive": {**(given.perceive or _KNOB_RADIUS), "extrapolate": True},
        "choices": {
            RATE: [{"value": given.rate, "cost": 0}, {"value": 4 * given.rate, "cost": 1}],
            COUNTS: [{"value": given.counts, "cost": 0}, {"value": 4 * given.counts, "cost": 3}],
        },
        "present": {RATE: given.rate, COUNTS: given.counts},
        "reference": "plain wall",
        "remedies": {
            "plain wall": {},
            **{name: {"cost": 0.1, "change": one["change"]} for name, one in _lag(given).items()},
        },
        "constraints": {"stiffness": {"at_least": _short(0.75 * stiffness)}, "touch": {"above_present": 0}},
        "objective": "cost",
    }


def _sweep(given: _Given) -> dict[str, Any]:
    shared = {"perceive": given.perceive} if given.perceive else {}
    return {"scene": given.scene, **_grid(given), "starts": given.starts, **shared}


_MADE = {"sweep": _sweep, "remedies": _remedies, "design": _design, "predict": _analysis, "dfa": _analysis}
KINDS = tuple(_MADE)  # kinds that can begin so


def _without_hand(given: _Given) -> dict[str, Any]:
    return {key: value for key, value in given.scene.items() if key != "hand"}


def _changes(given: _Given) -> dict[str, Any]:
    """What is tried on the knob, from what costs nothing to other parts."""
    knob, stiffness = given.plan.knob, given.plan.wall.stiffness
    varied = {name for name in given.grid if "." in name}
    found: dict[str, Any] = {}
    if stiffness > 0.0 and "wall.stiffness" not in varied:
        found["softer wall"] = _change(
            {"scene": {"wall": {"stiffness": _short(0.5 * stiffness)}}}, "half the stiffness"
        )
    found |= _lag(given)
    if knob.coulomb_torque > 0.0 and "knob.coulomb_torque" not in varied:
        twice = {"scene": {"knob": {"coulomb_torque": _short(2.0 * knob.coulomb_torque)}}}
        found["friction x 2"] = _change(twice, "a brake")
    if "knob.damping" not in varied:
        name, extra = _damping(given)
        more = {"scene": {"knob": {"damping": _short(knob.damping + extra)}}}
        found[name] = _change(more, "grease, or an eddy brake")
    if given.rate:
        found["rate x 2"] = _change({"grid": {RATE: 2 * given.rate}}, "a faster loop")
    if given.counts:
        found["counts x 4"] = _change({"grid": {COUNTS: 4 * given.counts}}, "a finer encoder")
    return found


def _lag(given: _Given) -> dict[str, Any]:
    """The bounded lag by its rule, where it can help and the knob has no controller yet."""
    scene = given.plan
    hand = scene.hand or Hand()
    r = slowness(
        inertia_kg_m2=scene.knob.inertia + hand.inertia,
        damping_nm_s_per_rad=scene.knob.damping + hand.damping,
        time_constant_s=_TIME_CONSTANT_S,
    )
    if r >= 1.0 or scene.controller is not None or scene.wall.stiffness == 0.0:
        return {}
    lag = {"kind": "bounded_lag", "keep": _short(best_keep(r), 3), "time_constant": _TIME_CONSTANT_S}
    return {"bounded lag": _change({"scene": {"controller": lag}}, "a running mean, one multiplication")}


def _damping(given: _Given) -> tuple[str, float]:
    """Damping to add: three times that of knob and hand, or a hundredth of sqrt(K J) where there is none."""
    scene = given.plan
    hand = scene.hand or Hand()
    damping = scene.knob.damping + hand.damping
    if damping > 0.0:
        return "damping x 4", 3.0 * damping
    return "some damping", 0.01 * math.sqrt((scene.knob.inertia + hand.inertia) * (scene.wall.stiffness or 1.0))


def _change(change: Mapping[str, Any], needs: str) -> dict[str, Any]:
    return {"change": change, "needs": needs}


def _short(value: float, digits: int = 6) -> float:
    return float(f"{value:.{digits}g}")


def _text(value: Mapping[str, Any]) -> str:
    """As YAML: mappings and lists of scalars in a line each, keys in their order."""
    from ruamel.yaml import YAML

    writer: Any = YAML(typ="safe", pure=True)
    writer.default_flow_style, writer.width, writer.sort_base_mapping_type_on_output = None, 120, False
    stream = StringIO()
    writer.dump(value, stream)
    return stream.getvalue()
