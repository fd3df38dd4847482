"""The page of ``hknob explore`` as one HTML file: the cells of a sweep as its engine takes them, or why not.

It is a knob to play with, with an engine of its own: ``engine/`` has exact motion and the cycle reached,
``remedies.js`` what can be changed, ``view/`` what is seen and heard.
"""

import itertools
import json
from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli import __version__
from hknob_cli.errors import UsageError
from hknob_cli.page.template_files import digest, packaged, template_of
from hknob_cli.perception.touch import thresholds
from hknob_cli.report.table import short
from hknob_cli.specs.capabilities import PARTS, parts_of, reason, takes
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.controller import KINDS as ALL_KINDS
from hknob_cli.specs.controller import KINDS as EVERY
from hknob_cli.specs.controller import Controller
from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.plan import BESIDE, COUNTS, RATE, Actuator, Bias, Cell, Encoder, Scene, SweepPlan, placed, scene_at
from hknob_cli.stages.work import counted

KINDS = {  # controllers that the page follows, each with the numbers that it takes from a spec
    "bounded_lag": ("keep", "time_constant"),
    "first_order_hold": ("correct",),
    "half_sample": (),
    "matched_wall": (),
    "stiffening": ("surface", "depth"),
    "velocity_damping": ("damping", "window", "low_pass", "everywhere"),
}
MOST_CELLS = 400  # that the page lists
RADIUS_M = 8.9e-3  # of a knob of which the spec does not say it: the dissertation's small one

_UNITS = {RATE: "Hz", COUNTS: "counts"}


class Knobs(NamedTuple):
    """What the page begins with: cells, each a ``label`` and a ``scene`` in SI units; ``notes``: what it leaves out.

    ``touch``: the thresholds by which levels are told, and the radius of the knob.
    """

    name: str
    cells: list[dict[str, Any]]
    notes: list[str]
    touch: dict[str, Any]


def knobs_of(plan: SweepPlan, spec: str) -> Knobs:
    """The cells of a sweep as the page takes them. Raises `UsageError` for parts that its engine does not follow.

    Args:
        plan: what the spec says.
        spec: how the spec is called in messages.
    """
    if faults := faults_of(plan):
        instead = f"{spec}: hknob sweep computes this scene"
        raise UsageError("\n".join([*(f"{spec}: scene.{fault}" for fault in faults), instead]))
    some = _listed_cells(plan)
    made = [{"label": _label(cell, plan), "scene": _scene(scene_at(plan.scene, cell), cell, plan)} for cell in some]
    return Knobs(plan.name, made, list(_notes(plan, len(cells_of(plan)))), _touch(plan.perceive))


def page_of(name: str) -> Path:
    """Where the page of a sweep of this name is written if nothing else is said."""
    return Path("results") / f"{name}-explore.html"


def faults_of(plan: SweepPlan) -> list[str]:
    """The key of each part of a sweep's cells that the page does not follow, and why; empty if it follows all."""
    return list(dict.fromkeys(fault for cell in _listed_cells(plan) for fault in _faults(placed(plan.scene, cell))))


def _listed_cells(plan: SweepPlan) -> list[Cell]:
    return list(itertools.islice(iter(cells_of(plan)), MOST_CELLS))


def _faults(scene: Scene) -> Iterator[str]:
    """The key of each part that the page does not follow, and why."""
    for part in sorted(parts_of(scene)):
        if not takes("explore", {part}):
            path = PARTS[part].path or "controller"  # what a controller does within an interval is no key
            yield f"{path}: {PARTS[part].title} is not in explore: {reason(part, 'explore')}"
    control = scene.controller
    if control and control.kind not in KINDS:
        yield f"controller.kind: '{control.kind}' is not in explore; there are: {', '.join(KINDS)}"
    elif control:
        left_out = [key for key in ALL_KINDS[control.kind].keys if key not in (*KINDS[control.kind], "velocity")]
        for key in left_out:
            if getattr(control, key) != Controller._field_defaults[key]:
                yield f"controller.{key}: it is not in explore, which has of {control.kind} {_listed(control.kind)}"


def _listed(kind: str) -> str:
    """The numbers of a kind of controller that the page takes."""
    return ", ".join(KINDS[kind]) or "no numbers"


def _scene(scene: Scene, cell: Cell, plan: SweepPlan) -> dict[str, Any]:
    """One cell in SI units, by the names that the engine of the page has."""
    hand, bias, starts = scene.hand, scene.bias or Bias(torque=0.0), plan.starts
    encoder, actuator = scene.encoder or Encoder(), scene.actuator or Actuator()
    begin = BESIDE if starts.anywhere else starts
    limit = actuator.torque_limit
    return {
        "inertia": scene.knob.inertia,
        "damping": scene.knob.damping,
        "friction": scene.knob.coulomb_torque,
        "hand": {"inertia": hand.inertia, "damping": hand.damping, "stiffness": hand.stiffness} if hand else None,
        "stiffness": scene.wall.stiffness,
        "wallDamping": scene.wall.damping,
        "push": bias.torque or 0.0,
        "halfQuantum": bool(bias.half_quantum),
        "rate": cell[RATE],
        "counts": cell[COUNTS],
        "rounding": encoder.rounding,
        "offset": encoder.offset_counts,
        "delay": actuator.delay_samples,
        "limit": None if limit in (None, inf) else limit,
        "step": actuator.torque_step,
        "band": actuator.dead_band,
        "controller": _controller(scene.controller) if scene.controller else None,
        "start": {"angle": begin.angle, "velocity": begin.velocity, "phase": 0.5},
    }


def _controller(control: Controller) -> dict[str, Any]:
    return {"kind": control.kind, **{key: getattr(control, key) for key in KINDS[control.kind]}}


def _label(cell: Cell, plan: SweepPlan) -> str:
    """A cell in words: the values of the axes that vary, or of the grid's own two where none does."""
    wide = [name for name, values in plan.axes.items() if len(values) > 1] or [RATE, COUNTS]
    return ", ".join(_value(name, cell[name], plan.units.get(name, "")) for name in wide)


def _value(name: str, value: float, unit: str) -> str:
    if name in _UNITS:
        return f"{short(value)} {_UNITS[name]}"
    return f"{name} {short(value)}{f' {unit}' if unit and unit != '1' else ''}"


def _notes(plan: SweepPlan, cells: int) -> Iterator[str]:
    """What the spec asks for and the page does not do."""
    if cells > MOST_CELLS:
        yield f"The spec has {counted(cells, 'cell')}. The first {MOST_CELLS} are here."
    if plan.starts.many:
        what = "anywhere" if plan.starts.anywhere else "in ranges of angle and velocity"
        yield f"The spec asks for starts {what}. This page follows one start at a time, which you can move."
    asked = {"record": plan.record, "growth": plan.growth_s, "basins": plan.basins}
    if there := [name for name, value in asked.items() if value is not None]:
        yield f"The spec asks for {' and '.join(there)}, which this page does not do: hknob sweep does."
    if plan.perceive is None:
        yield "The spec has no knob radius. Touch levels are those of a radius of 8.9 mm."
    elif plan.perceive.extrapolate:
        yield "The spec extrapolates thresholds. This page has levels only where they are published."


def _touch(perceive: Perceive | None) -> dict[str, Any]:
    """The thresholds of touch, and how levels are told from them."""
    from hknob_cli.perception.level import threshold_set

    how = perceive or Perceive(knob_radius=RADIUS_M)
    found, told = thresholds(how.thresholds), threshold_set("touch", how.thresholds)
    return {
        "points": found.points.tolist(),
        "low": found.low_hz,
        "high": found.high_hz,
        "radius": how.knob_radius,
        "combine": how.combine,
        "title": told["title"],
        "source": found.source,
    }


_FOLDER = "explore"
# Each script is the files of a folder, or one file.
_ENGINE = ("plant", "controllers", "cell", "motion", "trial", "cycle", "measure", "solve")
_VIEW = ("words", "sliders", "answer", "clock", "window", "pictures", "sound", "begin")
MARK = "<!-- hknob explore -->"  # in the second line: by it the command knows its own files


def sheet(knobs: Knobs) -> str:
    """HTML of the page; the same text for the same knobs. Its policy allows only the scripts and the style in it."""
    from markupsafe import Markup

    style = packaged(_FOLDER, "page.css")
    scripts = [engine(), packaged(_FOLDER, "remedies.js"), _joined("view", _VIEW)]
    data = {"cells": knobs.cells, "touch": knobs.touch, "slug": knobs.name}
    left_out = ", ".join(_words(kind) for kind in EVERY if kind not in KINDS)
    return template_of(_FOLDER).render(
        mark=Markup(MARK),
        name=knobs.name,
        notes=knobs.notes,
        touch=knobs.touch,
        carried="plain wall, virtual damping, rounding, "
        + ", ".join(_words(kind) for kind in KINDS)
        + ", and changes of the knob itself",
        left_out=f"Not in this page, and not approximated: {left_out}, velocity sensors and estimators, a finger apart "
        "from the knob, lag, torque over the angle, continuous sensors. The command has them.",
        style=Markup(style),
        scripts=[Markup(text) for text in scripts],
        hashes={"style": _hash(style), "scripts": " ".join(map(_hash, scripts))},
        data=Markup(_in_html(data)),
        versions=f"Made by hknob explore, hknob {__version__}.",
    )


def engine() -> str:
    """The script that makes ``Knob``, the engine: it follows trials, and needs no page."""
    return f"const Knob = {_joined('engine', _ENGINE)}"


def _joined(folder: str, names: tuple[str, ...]) -> str:
    """Files of a folder as one function that is called at once."""
    return '(() => {\n"use strict";\n' + "".join(packaged(_FOLDER, f"{folder}/{name}.js") for name in names) + "})();\n"


def _hash(text: str) -> str:
    """A script or style as a content security policy names it."""
    return f"'{digest(text)}'"


def _in_html(data: dict[str, Any]) -> str:
    """JSON that no HTML parser takes for the end of its element, or for another one's beginning."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _words(kind: str) -> str:
    return kind.replace("_", " ")
