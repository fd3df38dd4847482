"""A controller of a spec as the compiled general loop runs it: its function by name, and the numbers of one cell.

The numbers, the memory and the parts of an interval are those of the controller's own file in `controllers`.
"""

from itertools import pairwise
from math import inf
from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.controller import ControlLaw, Differencing, make_control_law
from hknob_cli.controllers.estimated_velocity import LEAST, LONGEST, EstimatedVelocity, Fading
from hknob_cli.controllers.plant_batch import PlantBatch
from hknob_cli.engine.general.body import ADDED
from hknob_cli.engine.general.follow import CYCLE_EXPANDS
from hknob_cli.engine.general.laws.law import BLOCK, CYCLE_NOT_AFFINE, PIECE, Law
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.scene.general_knob import GeneralKnob, add_spans, sample_general
from hknob_cli.specs.controller import Controller
from hknob_cli.specs.plan import Scene

LINE = 8.0  # sum of the weights of torques on a line that is fitted, drawn out and corrected, at most
KALMAN = 4.0  # units in the last place of an estimate, at most, by the roundings of its updates, times a turn
SAME = 1e-12  # of two instants in an interval that are one


class LawKnob(NamedTuple):
    """A cell under a controller: its ``knob``, whose body has the pieces of an interval, and its ``law``.

    ``rate``: of the slowest mode that decays, the law's memory included, per sample.
    """

    knob: GeneralKnob
    law: Law
    rate: float


class ReducedLaw(NamedTuple):
    """A controller's function by name, its numbers, its memory before the first sample, and what of that fades.

    The first ``places`` rows of the memory begin with the place that the encoder shows.
    """

    act: str
    fixed: list[float]
    first: list[float]
    places: int
    fading: Fading


def reduce_law(plan: Controller, control: ControlLaw, lane: PlantBatch) -> ReducedLaw:
    """Reduce a controller to the numbers of one lane."""
    fixed, fading = _numbers(plan, control, lane)
    first = [float(one) for one in control.recall(lane, np.zeros(1))[:, 0]]
    places = control.places if isinstance(control, Differencing) else 0
    first[:places] = [0.0] * places
    if plan.kind == "passivity":
        first = [*first, 0.0]
    act = control.law if isinstance(control, EstimatedVelocity) else plan.kind
    return ReducedLaw(act, [float(one) for one in fixed], first, places, fading)


def make_law(scene: Scene, *, sample_rate_hz: float, counts_per_rev: int) -> LawKnob:
    """Reduce a scene with a controller to one cell. Raises `ComputationError` as `general_knob.sample_general`."""
    assert scene.controller
    knob = sample_general(scene, sample_rate_hz=sample_rate_hz, counts_per_rev=counts_per_rev)
    plan, stiffness = scene.controller, scene.wall.stiffness
    control = make_control_law(plan)
    lane = _lane(knob, stiffness)
    act, fixed, first, places, fading = reduce_law(plan, control, lane)
    rows = len(first)
    split = knob.wall.split
    whole = int(scene.actuator.delay_samples) if scene.actuator else 0
    ages = whole + 1 + (1 if split > 0.0 else 0)
    looks, parts = len(control.looks), len(control.parts)
    line = rows + 1 + looks
    pieces = _pieces(control, split, ages - 1 - whole, rows + 1, line, knob)
    body = add_spans(knob.body, [piece[0] for piece in pieces])
    outside = control.reads_outside or knob.wall.damping > 0.0
    stepped = (knob.wall.step > 0.0 or knob.wall.band > 0.0) and fading.weight > 0.0
    known = body.order + ages - 1 if control.senses_speed else 0  # numbers that a period's map is of
    law = Law(
        act=act,
        fixed=fixed,
        first=first,
        rows=rows,
        places=places,
        looks=looks,
        line=line,
        parts=parts,
        ages=ages,
        pieces=len(pieces),
        sched=[float(number) for piece in pieces for number in piece],
        fading=fading.row,
        fade=float(fading.fade),
        weight=float(fading.weight * knob.wall.kappa),
        coarse=_coarseness(plan, fixed, fading),
        guarded=fading.guarded or stepped,
        anchor=3 if plan.kind == "passivity" else -1,
        drifts=2 if plan.kind == "passivity" else -1,
        senses=control.senses_speed,
        provable=fading.fade < 1.0 and not (control.senses_speed and body.friction > 0.0),
        unproven=CYCLE_EXPANDS if control.senses_speed else CYCLE_NOT_AFFINE,
        watch=knob.wall._replace(damping=1.0 if outside else 0.0),
        out=[0.0] * (2 * parts),
        room=[0.0],
        beside=[0.0] * (line + ages * parts),
        periodic=[0.0] * (line + ages * parts),
        affine=[0.0] * ((known + 1) * known),
        slopes=[0.0] * BLOCK,
        noise=[0.0] * (3 * known),
        pair=list(fading.pair),
    )
    settling = float(control.settling(lane)[0])
    rate = min(knob.rate, 1.0 / settling) if settling > 0.0 else knob.rate
    return LawKnob(knob._replace(body=body), law, rate)


def _lane(knob: GeneralKnob, stiffness: float) -> PlantBatch:
    """The knob as the controller's model of it: one body."""
    body, wall = knob.body, knob.wall
    sense = 0.0 if wall.truncate > 0.0 else wall.sense
    numbers = (
        body.alpha,
        body.beta,
        wall.kappa,
        body.push,
        sense,
        wall.offset,
        inf,
        knob.period_s,
        knob.quantum_rad,
        stiffness,
    )
    return PlantBatch(*(np.array([one]) for one in numbers))


def _numbers(plan: Controller, control: ControlLaw, lane: PlantBatch) -> tuple[list[float], Fading]:
    """Numbers that a kind's function takes, the offset first, and what of its memory fades."""
    if isinstance(control, EstimatedVelocity):
        return control.numbers(lane), control.fading(lane)
    offset = float(lane.offset[0])
    own = [float(one[0]) for one in control.constants(lane)]
    sensor = 1.0 if control.senses_speed else 0.0
    if plan.kind == "bounded_lag":
        stays = min(float(np.exp(-lane.period_s[0] / plan.time_constant)), LONGEST)
        return [offset, own[0], plan.keep], Fading(0, stays, 1.0 - plan.keep)
    if plan.kind == "first_order_hold":
        return [offset, float(plan.correct), float(len(control.looks)), float(plan.steps)], Fading()
    if plan.kind == "impulse_damping":
        return [offset, plan.pulse, plan.gain, float(len(control.looks))], Fading()
    if plan.kind == "passivity":
        return [*own, float(plan.reset)], Fading()
    if plan.kind == "phase_damping":
        fading = Fading(1, 63.0 / 64.0, 0.0, guarded=True)
        kalman = 1.0 if plan.estimate == "kalman" else 0.0
        both = 1.0 if plan.crossings == "both" else 0.0
        return [offset, plan.height, plan.degrees / 360.0, both, kalman], fading
    if plan.kind == "stiffening":
        return [offset, *own, plan.surface], Fading()
    if plan.kind == "velocity_damping":
        _, gain, goes, most = own
        numbers = [offset, gain, sensor, float(plan.everywhere), float(plan.window), goes, most]
        if plan.low_pass == 0.0:
            return numbers, Fading()
        stays = min(float(np.exp(-lane.period_s[0] / plan.low_pass)), LONGEST)
        if plan.cut_off is None:
            return numbers, Fading(plan.window, stays, abs(gain))
        return numbers, Fading(plan.window, stays, max(abs(gain), LEAST), guarded=True)
    return [*own, sensor], Fading()  # half_sample, matched_wall


def _coarseness(plan: Controller, fixed: list[float], fading: Fading) -> float:
    """By how much a kind's numbers enlarge what they are multiplied with, before terms may cancel."""
    if plan.kind == "impulse_damping":
        return 1.0 + abs(plan.gain) * plan.detections / plan.pulse
    if plan.kind == "first_order_hold" and (plan.detections > 1 or plan.steps > 1):
        return LINE
    if plan.kind == "phase_damping" and plan.estimate == "kalman":
        return 1.0 + KALMAN * plan.height
    if plan.kind == "velocity_damping":  # a filter adds up what its updates round
        return 1.0 + abs(fixed[1]) * (1.0 / (1.0 - fading.fade) if fading.row >= 0 else 1.0)
    return 1.0 + abs(fixed[1]) + abs(fixed[2]) if plan.kind == "matched_wall" else 1.0


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
        part = min(int(np.searchsorted(ends, phase, side="right")), parts - 1)
        torque = line + (0 if older else late) * parts + part
        look = next((looks + i for i, one in enumerate(control.looks) if abs(one - end) <= SAME), -1)
        span = end - begin
        s, g, f = hold_coefficients(knob.body.alpha, knob.body.beta, span) if knob.body.order == 2 else (0.0, 0.0, 0.0)
        found.append((span, s, g, f, torque, look, float(ADDED + len(found))))
    assert all(len(piece) == PIECE for piece in found)
    return found
