"""Recordings of a sweep: the exact motion of the first trials of every cell, row by row."""

from collections.abc import Iterator
from itertools import product
from math import ceil, nan
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa

from hknob_cli.engine.general.advance import advance_span
from hknob_cli.engine.general.body import CONSTANT, CONSTANT_HELD, CONSTANT_STUCK, Body
from hknob_cli.engine.general.controller import command, read, read_after
from hknob_cli.engine.general.hysteresis import turn_and_count
from hknob_cli.engine.general.interval import begin_clock, jitters, next_span
from hknob_cli.engine.general.search import as_list
from hknob_cli.measure.unsampled import events
from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import AT_KNOB, FINGER, START, TRAJECTORY, axis_column
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.scene.plain_knob import reduce_unsampled
from hknob_cli.specs.capabilities import TRIALS, engine_of
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.motor import Cogging
from hknob_cli.specs.plan import (
    COUNTS,
    RATE,
    YIELDS,
    Bias,
    Cell,
    Hand,
    Record,
    Scene,
    SweepPlan,
    knob_counts,
    may_have,
    scene_at,
)

# Of recordings that are drawn and not kept.
_FEW = 16  # trials, at most
_TIME_CONSTANTS = 14.0
_PERIODS = 4.0  # beside
_MOST_SAMPLES = 10_000


class Instant(NamedTuple):
    """One row: time (s), what happens then, angles (rad), velocities (rad/s), torque of the actuator after it (N·m)."""

    time: float
    event: str
    angle: float
    velocity: float
    torque: float
    finger: float = nan
    finger_velocity: float = nan


def trajectories(plan: SweepPlan) -> Iterator[tuple[Cell, float, int, Iterator[Instant]]]:
    """Cell, angle of the start (rad), number of the trial and instants of each trial that a sweep records.

    Going through the instants raises `ComputationError` if a scene's numbers overflow.
    """
    assert plan.record
    for cell in cells_of(plan):
        scene = scene_at(plan.scene, cell)
        trials = min(plan.record.trials, plan.starts.phases) if scene.sampled else 1
        for start, trial in product(plan.record.angles or (plan.starts.angle,), range(trials)):
            yield cell, start, trial, _instants(plan, scene, cell, trial, start)


def record_sweep(plan: SweepPlan) -> pa.Table:
    """Trajectories of a sweep that asks for them. Raises `ComputationError` if a scene's numbers overflow."""
    assert plan.record
    rows: list[dict[str, Any]] = []
    for cell, start, trial, instants in trajectories(plan):
        scene = scene_at(plan.scene, cell)
        push = _push(scene, cell)
        kept = (one for one in instants if one.time >= plan.record.since)
        rows += ({**cell, "start_rad": start, "trial": trial, **_row(one, scene, push)} for one in kept)
    axes = [axis_column(name, plan.units[name]) for name in plan.axes]
    finger = plan.scene.hand is not None and plan.scene.hand.finger is not None
    starts = START if plan.record.angles else ()
    behind = AT_KNOB if may_have(plan.scene, plan.axes, *YIELDS) else ()
    return build_table([*axes, *starts, *TRAJECTORY, *(FINGER if finger else ()), *behind], rows)


def record_one(plan: SweepPlan, orbits: list[dict[str, Any]], *, last: int) -> pa.Table:
    """Trajectories of a few trials of a sweep of one cell, whose ``orbits`` are known, until they should have settled.

    ``last``: how many periods of the longest cycle are kept of each trial; all of it where nothing cycles. Raises
    `ComputationError` if a scene's numbers overflow.
    """
    cell = next(iter(cells_of(plan)))
    scene = scene_at(plan.scene, cell)
    periods = [row["cycles_per_period"] / row["frequency_hz"] for row in orbits if row["outcome"] == "cycle"]
    period = max(periods, default=0.0)
    duration = _TIME_CONSTANTS * _slowest(scene) + _PERIODS * period
    if RATE in cell:
        duration = min(duration, _MOST_SAMPLES / cell[RATE])
    interval = max(min(periods, default=duration / 5.0) / 200.0, duration / _MOST_SAMPLES)
    since = duration - last * period - 2.0 * interval if periods else 0.0  # a last row may come an interval early
    few = min(plan.starts.phases, _FEW)
    starts = plan.starts._replace(phases=few)
    return record_sweep(plan._replace(record=Record(duration, interval, few, since=since), starts=starts))


def _slowest(scene: Scene) -> float:
    """The longest time constant of knob and hand (s), roughly; a tenth of a second where nothing damps them."""
    hand = scene.hand or Hand()
    own = hand.finger if scene.behind and hand.finger else hand
    inertia, damping = scene.knob.inertia + own.inertia, scene.knob.damping + own.damping
    found = [2.0 * inertia / damping] if damping > 0.0 else []
    found += [damping / own.stiffness] if own.stiffness > 0.0 and damping > 0.0 else []
    return min(max(found, default=0.1), 10.0)


def _instants(plan: SweepPlan, scene: Scene, cell: Cell, trial: int, angle: float) -> Iterator[Instant]:
    assert plan.record
    counts = int(cell[COUNTS]) if COUNTS in cell else None
    if not scene.sampled:
        return _unsampled(plan, scene, counts, angle)
    if engine_of(scene, TRIALS) == "laws":
        return _with_law(plan, cell, trial, angle)
    knob = sample_general(scene, sample_rate_hz=cell[RATE], counts_per_rev=counts)
    phase = (trial + 0.5) / plan.starts.phases
    return record_trial(knob, plan.record, angle=angle, velocity=plan.starts.velocity, phase=phase, trial=trial)


def _row(one: Instant, scene: Scene, push: float) -> dict[str, Any]:
    return {
        "time_s": one.time,
        "event": one.event,
        "angle_rad": one.angle,
        "velocity_rad_s": one.velocity,
        "torque_nm": one.torque,
        "energy_j": energy(scene, push, one),
        "knob_angle_rad": one.finger if scene.behind else one.angle,
        "knob_velocity_rad_s": one.finger_velocity if scene.behind else one.velocity,
        "finger_angle_rad": one.finger,
        "finger_velocity_rad_s": one.finger_velocity,
    }


def _push(scene: Scene, cell: Cell) -> float:
    bias = scene.bias or Bias(torque=0.0)
    if bias.half_quantum:
        return np.pi * scene.wall.stiffness / knob_counts(scene, cell)
    return bias.torque or 0.0


def energy(scene: Scene, push: float, one: Instant) -> float:
    """Energy of the masses, of the hand's springs, of cogging and of the push into the wall, J; the wall has none."""
    hand = scene.hand or Hand()
    total = 0.5 * (scene.knob.inertia + hand.inertia) * one.velocity**2
    total += push * (one.finger if scene.behind else one.angle)
    if scene.cogging:
        total += _stored_by_cogs(scene.cogging, one.angle)
    if hand.finger and hand.fingerpad:
        total += 0.5 * hand.finger.inertia * one.finger_velocity**2 + 0.5 * hand.finger.stiffness * one.finger**2
        twist = one.angle - one.finger
        if scene.play:
            twist = max(twist, 0.0, -(twist + scene.play))
        return total + 0.5 * hand.fingerpad.stiffness * twist**2
    return total + 0.5 * hand.stiffness * one.angle**2


def _stored_by_cogs(cogging: Cogging, angle: float) -> float:
    """Energy of cogging at an angle, J; 0 at a place of rest."""
    slope = 2.0 * cogging.torque * cogging.per_revolution / np.pi  # of the torque, N*m/rad
    apart = 2.0 * np.pi / cogging.per_revolution
    away = abs((angle - cogging.centre + 0.5 * apart) % apart - 0.5 * apart)
    beyond = max(away - 0.25 * apart, 0.0)
    return float(0.5 * slope * away**2 - slope * beyond**2)


def pulsed(body: Body, torque: float, *, behind: bool = False) -> Body:
    """The body with one more constant torque, as an acceleration of what is sensed.

    ``behind``: whether it acts on the knob behind a gear, and not on what is sensed.
    """
    vectors = list(body.vectors)
    n = body.order
    if behind:
        for constant in (CONSTANT, CONSTANT_HELD, CONSTANT_STUCK):
            if constant * n + 3 < len(vectors):
                vectors[constant * n + 3] -= body.ratio * torque
        return body._replace(vectors=vectors)
    vectors[CONSTANT * n + 1] += torque
    if body.ratio > 0.0:
        vectors[CONSTANT * n + 3] += torque
    return body._replace(vectors=vectors, drive=body.drive + torque)


def _pulse_on(knob: GeneralKnob, record: Record) -> tuple[Body, float] | None:
    """The body while the recording's pulse acts on it, and when that ends, in sample periods; None without one."""
    if not record.pulse:
        return None
    body = pulsed(knob.body, record.pulse.torque / knob.torque_nm, behind=knob.behind)
    return body, record.pulse.duration / knob.period_s


def record_trial(
    knob: GeneralKnob, record: Record, *, angle: float, velocity: float, phase: float, trial: int = 0
) -> Iterator[Instant]:
    """Motion of one trial: at every sample, wherever the command that acts changes, and between at the interval asked.

    ``angle`` (rad) and ``velocity`` (rad/s) at the start; the first sample comes ``phase`` of a period later.
    ``trial``: its number, by which a clock that jitters has its intervals.
    """
    wall, n = as_list(knob.wall), knob.body.order
    body, until = _pulse_on(knob, record) or (knob.body, 0.0)
    z, pad = knob.start(angle, velocity), [0.0] * (2 * n)
    ring, head = [0.0] * knob.delay_line, 0
    before, acting, later, t = read(z[0], wall), 0.0, 0.0, 0.0
    first = True
    begin_clock(wall.clock, float(trial))
    for time, event in _stops(knob, record, phase, until, wall.clock):
        while t < time:
            step = min(time - t, 1.0)
            if wall.hysteresis > 0.0:
                before, _ = turn_and_count(z, acting, step, before, body, wall, pad)
            else:
                advance_span(z, acting, step, body, pad)
            t = time if step == time - t else t + step
        if event == "sample":
            shown = read(z[0], wall) if first else read_after(z[0], before, wall)
            before = shown if first else before
            u = command(shown, before, wall)
            before, first = shown, False
            later = acting = u
            if ring:
                acting, ring[head] = ring[head], u
                head = (head + 1) % len(ring)
                later = ring[head]
                acting = acting if wall.split > 0.0 else later
        elif event == "command":
            acting = later
        elif event == "pulse ends":
            body = knob.body
        yield _instant(knob, time, event, z, z[n - 1] if body.lag > 0.0 else acting)


def _stops(
    knob: GeneralKnob, record: Record, phase: float, pulse_ends: float, clock: Any = None
) -> list[tuple[float, str]]:
    """Instants of rows in their order, in sample periods, and what happens then; "" at the interval asked."""
    end, interval, split = record.duration / knob.period_s, record.interval / knob.period_s, knob.wall.split
    stops = [(phase + i, "sample") for i in range(ceil(end) + 1)]
    if jitters(clock):
        at, stops = phase, []
        while at <= end:
            stops.append((at, "sample"))
            at += next_span(clock)
    first = max(int(record.since / record.interval), 0)
    stops += [(min(i * interval, end), "") for i in range(first, int(end / interval * (1.0 + 1e-12)) + 1)]
    if split > 0.0:
        stops += [(phase + i + split, "command") for i in range(ceil(end) + 1)]
    if record.pulse:
        stops.append((pulse_ends, "pulse ends"))
    # What happens at an instant takes the place of a row that was only due.
    named = {time for time, event in stops if event}
    return sorted(stop for stop in stops if stop[0] <= end and (stop[1] or stop[0] not in named))


def _with_law(plan: SweepPlan, cell: Cell, trial: int, angle_rad: float) -> Iterator[Instant]:
    """Motion under a controller: every sample, every change of its torque, and between them at the interval asked."""
    from hknob_cli.controllers.scalar_law import make_law
    from hknob_cli.stages.sweep.law_record import follow_law

    assert plan.record
    counts = int(cell[COUNTS]) if COUNTS in cell else None
    made = make_law(scene_at(plan.scene, cell), sample_rate_hz=cell[RATE], counts_per_rev=counts)
    knob = made.knob
    start, phase = knob.start(angle_rad, plan.starts.velocity), (trial + 0.5) / plan.starts.phases
    every, pulse = plan.record.interval / knob.period_s, _pulse_on(knob, plan.record)
    until = plan.record.duration / knob.period_s
    for one in follow_law(made, start, phase=phase, until=until, every=every, pulse=pulse, trial=trial):
        yield _instant(knob, one.time, one.event, one.state, one.torque)


def _instant(knob: GeneralKnob, time: float, event: str, z: list[float], torque: float) -> Instant:
    """A moment in SI units, from sample periods, counts, and the torque that acts as an acceleration."""
    speed = knob.quantum_rad / knob.period_s
    found = Instant(time * knob.period_s, event, knob.angle_rad(z[0]), z[1] * speed, torque * knob.torque_nm)
    if knob.body.ratio > 0.0:
        found = found._replace(finger=knob.angle_rad(z[0] - z[2]), finger_velocity=(z[1] - z[3]) * speed)
    return found


def _unsampled(plan: SweepPlan, scene: Scene, counts: int | None, angle_rad: float) -> Iterator[Instant]:
    """Motion without a sample clock: every event, and between them at the interval asked."""
    assert plan.record
    record = plan.record
    motion = events(
        reduce_unsampled(scene, counts_per_rev=counts),
        angle_rad=angle_rad,
        velocity_rad_s=plan.starts.velocity,
        duration_s=record.duration,
    )
    between = np.arange(int(record.duration / record.interval * (1.0 + 1e-12)) + 1, dtype=np.float64) * record.interval
    between = between[~np.isin(between, motion.time_s) & (between <= record.duration)]
    rows = list(zip(motion.time_s, motion.angle_rad, motion.velocity_rad_s, motion.torque_nm, strict=True))
    found = [Instant(float(t), "event", float(a), float(v), float(u)) for t, a, v, u in rows]
    angle, velocity, torque = motion.at(between)
    found += [
        Instant(float(t), "", float(a), float(v), float(u))
        for t, a, v, u in zip(between, angle, velocity, torque, strict=True)
    ]
    return iter(sorted(found))
