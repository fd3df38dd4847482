"""A controller of a spec as the compiled general loop runs it: its function by name, and the numbers of one cell."""

from itertools import pairwise
from math import inf
from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.controller import ControlLaw, Plant, make_control_law
from hknob_cli.controllers.plain_wall import PlainWall
from hknob_cli.engine.general.body import ADDED
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.follow import CYCLE_EXPANDS
from hknob_cli.engine.general.interval import meant_pace
from hknob_cli.engine.general.laws.law import BLOCK, CYCLE_NOT_AFFINE, PIECE, Law
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.scene.general_body import add_spans
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.plan import Scene

UNIT = 1.0  # N·m/rad: where there is no wall, a controller's torques are in steps of one so stiff
SAME = 1e-12  # of two instants in an interval that are one


class LawKnob(NamedTuple):
    """A cell under a controller: its ``knob``, whose body has the pieces of an interval, and its ``law``.

    ``rate``: of the slowest mode that decays, the law's memory included, per sample.
    """

    knob: GeneralKnob
    law: Law
    rate: float


def make_law(scene: Scene, *, sample_rate_hz: float, counts_per_rev: int | None) -> LawKnob:
    """Reduce a scene to one cell under its controller, or the plain wall as one.

    Raises `ComputationError` as `general_knob.sample_general`.
    """
    knob = sample_general(scene, sample_rate_hz=sample_rate_hz, counts_per_rev=counts_per_rev, walled=False)
    control = make_control_law(scene.controller) if scene.controller else PlainWall()
    plant = _plant(knob, scene.wall.stiffness)
    unit = plant.stiffness * (knob.period_s * knob.period_s / knob.inertia_kg_m2)
    fixed, first, fading = control.numbers(plant), control.first(), control.fading(plant)
    rows = len(first)
    split = knob.wall.split
    whole = int(scene.actuator.delay_samples) if scene.actuator else 0
    ages = whole + 1 + (1 if split > 0.0 else 0)
    looks, parts = len(control.looks), len(control.parts)
    line = rows + 1 + looks + (1 if knob.wall.hysteresis > 0.0 else 0)
    pieces = _pieces(control, split, ages - 1 - whole, rows + 1, line, knob)
    body = add_spans(knob.body, [piece[0] for piece in pieces])
    analog = knob.wall.analog > 0.0
    outside = (control.reads_outside or knob.wall.damping > 0.0 or knob.wall.table is not None) and not analog
    stepped = (knob.wall.step > 0.0 or knob.wall.band > 0.0) and fading.weight > 0.0
    known = body.order + ages - 1 if control.senses_speed else 0  # numbers that a period's map is of
    law = Law(
        act=control.act,
        unit=unit,
        fixed=fixed,
        first=first,
        rows=rows,
        places=control.places,
        looks=looks,
        line=line,
        parts=parts,
        ages=ages,
        pieces=len(pieces),
        sched=[float(number) for piece in pieces for number in piece],
        fading=fading.row,
        fade=float(fading.fade),
        weight=float(fading.weight * unit),
        coarse=control.coarseness(plant),
        guarded=fading.guarded or stepped,
        anchor=control.anchor,
        drifts=control.drifts,
        senses=control.senses_speed,
        provable=fading.fade < 1.0
        and not analog
        and not (
            control.senses_speed
            and (body.friction > 0.0 or body.play > 0.0 or knob.wall.hysteresis > 0.0 or body.cogs is not None)
        ),
        cuts=control.cuts,
        unproven=CYCLE_EXPANDS if control.senses_speed or analog else CYCLE_NOT_AFFINE,
        watch=_watched(knob.wall, outside=outside),
        out=[0.0] * (2 * parts),
        room=[0.0],
        beside=[0.0] * (line + ages * parts),
        periodic=[0.0] * (line + ages * parts),
        affine=[0.0] * ((known + 1) * known),
        slopes=[0.0] * BLOCK,
        noise=[0.0] * (4 * known),
        pair=list(fading.pair),
    )
    settling = control.settling(plant)
    rate = min(knob.rate, 1.0 / settling) if settling > 0.0 else knob.rate
    return LawKnob(knob._replace(body=body), law, rate)


def _watched(wall: Controller, *, outside: bool) -> Controller:
    """The wall whose edges change a command, as `Law.watch` has it.

    Those of a continuous sensor are the wall's edge, and the knees of a torque over the angle.
    """
    if wall.analog > 0.0:
        kappa = 0.0 if wall.curve is None else wall.kappa
        return wall._replace(kappa=kappa, damping=0.0, step=0.0, limit=inf, band=0.0)
    return wall._replace(damping=1.0 if outside else 0.0)


def _plant(knob: GeneralKnob, stiffness: float) -> Plant:
    """The knob as the controller's model of it: one body, sampled with the period that is meant."""
    body, walled = knob.body, stiffness > 0.0
    stiffness = stiffness if walled else UNIT
    meant = float(meant_pace(1.0, knob.wall.clock))
    period = meant * knob.period_s
    return Plant(
        alpha=meant * body.alpha,
        beta=meant * meant * body.beta,
        kappa=stiffness * (period * period / knob.inertia_kg_m2),
        offset=knob.wall.offset,
        period_s=period,
        quantum_rad=knob.quantum_rad,
        stiffness=stiffness,
        walled=walled,
    )


def _pieces(
    control: ControlLaw, split: float, late: int, looks: int, line: int, knob: GeneralKnob
) -> list[tuple[float, ...]]:
    """Pieces of an interval between changes of torque and looks, as `Law.sched` has them.

    ``split``: how long the torques of the interval before still act, ``late``: 1 where they do; ``looks``, ``line``:
    where looks and torques begin in what is remembered.
    """
    ends = np.cumsum(control.parts)
    inner = [float(end) for end in ends[:-1]]
    at = {split, *((end + split) % 1.0 for end in inner), *control.looks}
    cuts = [0.0]
    for one in sorted(at):
        if one - cuts[-1] > SAME and 1.0 - one > SAME:
            cuts.append(one)
    cuts.append(1.0)
    parts = len(control.parts)
    found: list[tuple[float, ...]] = []
    for begin, end in pairwise(cuts):
        middle = 0.5 * (begin + end)
        older = middle < split
        phase = middle - split + (1.0 if older else 0.0)
        part = int(np.searchsorted(ends, phase, side="right"))
        torque = line + (0 if older else late) * parts + part
        look = next((looks + i for i, one in enumerate(control.looks) if abs(one - end) <= SAME), -1)
        span = end - begin
        s, g, f = hold_coefficients(knob.body.alpha, knob.body.beta, span) if knob.body.order == 2 else (0.0, 0.0, 0.0)
        found.append((span, s, g, f, torque, look, float(ADDED + len(found))))
    assert all(len(piece) == PIECE for piece in found)
    return found
