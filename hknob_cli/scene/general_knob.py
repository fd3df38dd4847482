"""One cell of a scene with more in it than the plain loop has, and one trial of any sampled scene, exact.

More is friction, a finger, lag, limits, a continuous sensor. Like `scene.plain_knob`, in counts and sample periods;
without an encoder a count is a milliradian.
"""

from collections.abc import Callable
from math import inf, isfinite, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller, read
from hknob_cli.engine.general.torque_table import HEAD, RISE_BELOW, TURN
from hknob_cli.errors import ComputationError
from hknob_cli.scene.general_body import make_body, turns_of
from hknob_cli.scene.torque_over_angle import Clock, curve_of, is_shaped, table_of
from hknob_cli.specs.parts import SampleClock
from hknob_cli.specs.plan import Actuator, Encoder, Hand, Scene

Array = NDArray[np.float64]

MOST_TURNS = 1e5  # in a sample interval: each is an event that is followed
UNIT_RAD = 1e-3  # a "count" of a continuous sensor


class GeneralKnob(NamedTuple):
    """A scene sampled: its body and controller without dimensions, and the scales back to SI.

    ``period_s``: of a clock that jitters the longest interval; ``inertia_kg_m2``: of all that turns with the knob;
    ``rate``: of the slowest mode that decays, per sample; ``behind``: whether the body that is sensed is a motor, and
    the finger the knob with its hand behind a gear.
    """

    body: Body
    wall: Controller
    quantum_rad: float
    period_s: float
    inertia_kg_m2: float
    shift: float
    delay_line: int
    rate: float
    behind: bool = False

    def angle_rad(self, x: float) -> float:
        """Angle of a position ``x``."""
        return (x + self.shift) * self.quantum_rad

    def position(self, angle_rad: float) -> float:
        """Position, in counts, at an angle."""
        return angle_rad / self.quantum_rad - self.shift

    def speed(self, velocity_rad_s: float) -> float:
        """Velocity in counts per sample."""
        return velocity_rad_s * self.period_s / self.quantum_rad

    def start(self, angle_rad: float, velocity_rad_s: float) -> list[float]:
        """State at the start of a trial: the finger moves with the knob, no torque acts."""
        return [self.position(angle_rad), self.speed(velocity_rad_s), *([0.0] * (self.body.order - 2))]

    @property
    def torque_nm(self) -> float:
        """Torque of a unit acceleration of the knob."""
        return self.inertia_kg_m2 * self.quantum_rad / self.period_s**2

    @property
    def energy_j(self) -> float:
        """One unit of energy, J (counts per sample)², in joules."""
        return self.inertia_kg_m2 * (self.quantum_rad / self.period_s) ** 2


def sample_general(
    scene: Scene, *, sample_rate_hz: float, counts_per_rev: int | None, walled: bool = True
) -> GeneralKnob:
    """Reduce a scene to one cell. ``walled``: whether the wall's torque is the loop's, and not a law's.

    Raises `ComputationError` if its numbers overflow, if it rings so often in an interval that nobody waits for it, or
    if the loop without a law does not remember all that it takes.
    """
    actuator = scene.actuator or Actuator()
    encoder = scene.encoder or Encoder()
    hand = scene.hand or Hand()
    jitter = scene.clock.jitter if scene.clock else 0.0
    period = (1.0 + jitter) / sample_rate_hz  # the longest
    quantum = 2.0 * pi / (counts_per_rev * scene.turns) if counts_per_rev else UNIT_RAD
    inertia = scene.knob.inertia + hand.inertia
    square = period * period / inertia
    nearest = scene.encoder is not None and encoder.rounding == "nearest"
    shift = encoder.offset_counts - (0.5 if nearest else 0.0) if scene.encoder else 0.0
    whole = int(actuator.delay_samples)
    split = float(actuator.delay_samples - whole)
    wall = _controller_of(
        scene, period=period, square=square, quantum=quantum, counts_per_rev=counts_per_rev, split=split, walled=walled
    )
    if walled and wall.hysteresis > 0.0 and wall.damping > 0.0:
        raise ComputationError("virtual damping beside hysteresis of the encoder is followed under a law")
    body, slowest = make_body(scene, period=period, quantum=quantum, shift=shift, split=split)
    if _overflows(wall, body):
        place = f"at {sample_rate_hz:g} Hz" + (f" and {counts_per_rev} counts" if counts_per_rev else "")
        raise ComputationError(f"{place} the scene's numbers overflow")
    turns = turns_of(body)
    if turns > MOST_TURNS:
        often = f"it rings to and fro {turns:.2g} times in each interval"
        raise ComputationError(
            f"at {sample_rate_hz:g} Hz the scene cannot be followed: {often}, at most {MOST_TURNS:g}"
        )
    return GeneralKnob(
        body=body,
        wall=wall,
        quantum_rad=quantum,
        period_s=period,
        inertia_kg_m2=inertia,
        shift=shift,
        delay_line=whole + 1 if actuator.delay_samples > 0.0 else 0,
        rate=slowest,
        behind=scene.behind,
    )


def _controller_of(
    scene: Scene,
    *,
    period: float,
    square: float,
    quantum: float,
    counts_per_rev: int | None,
    split: float,
    walled: bool,
) -> Controller:
    """How a scene's wall reads and commands; ``square``: period² over inertia."""
    actuator, encoder = scene.actuator or Actuator(), scene.encoder or Encoder()
    jitter = scene.clock.jitter if scene.clock else 0.0
    inertia = scene.knob.inertia + (scene.hand or Hand()).inertia
    offset = encoder.offset_counts if scene.encoder else 0.0
    kappa, table, curve = scene.wall.stiffness * square, None, None
    if is_shaped(scene) and scene.encoder is None:
        curve = curve_of(scene, quantum_rad=quantum, unit_nm=quantum / square)
    elif is_shaped(scene):
        if counts_per_rev is None:
            raise ComputationError("a torque over the angle needs an encoder's counts, or a continuous sensor")
        clock, apart = Clock(counts_per_rev, quantum, offset), 0.0 if walled else kappa
        table = table_of(scene, clock, kappa=kappa - apart, unit_nm=quantum / square)
        kappa = apart - float(table[RISE_BELOW] / table[TURN])
    return Controller(
        kappa=kappa,
        damping=scene.wall.damping * (1.0 + jitter) * period / inertia,  # firmware divides by the period meant
        sense=-1.0 if encoder.rounding in ("ceil", "truncate") else 1.0,
        truncate=1.0 if encoder.rounding == "truncate" else 0.0,
        offset=offset,
        analog=0.0 if scene.encoder else 1.0,
        step=actuator.torque_step * square / quantum,
        limit=inf if actuator.torque_limit is None else actuator.torque_limit * square / quantum,
        split=split,
        table=table,
        band=actuator.dead_band * square / quantum,
        hysteresis=encoder.width_counts(quantum) if scene.encoder else 0.0,
        clock=_clock(scene.clock) if scene.clock and jitter > 0.0 else None,
        curve=curve,
    )


def _overflows(wall: Controller, body: Body) -> bool:
    """Whether a number of a cell, or its square, is not finite."""
    table, curve = wall.table, wall.curve
    commands = [] if table is None else table[HEAD : HEAD + (len(table) - HEAD) // 3].tolist()
    commands += [] if curve is None else curve[~np.isinf(curve)].tolist()
    numbers = [*wall[: wall._fields.index("limit")], wall.band, *commands, body.friction, body.push, body.play]
    numbers += [*body.matrices, *body.vectors, *(body.cogs or [])]
    return not all(isfinite(value * value) for value in numbers)


def _clock(clock: SampleClock) -> Array:
    """A clock as `engine.general.interval` has it, at its beginning."""
    longest = 1.0 + clock.jitter
    shortest, spread = (1.0 - clock.jitter) / longest, 2.0 * clock.jitter / longest
    return np.array([1.0, shortest, spread, float(clock.seed), 0.0, 1.0 / longest])


class Trial(NamedTuple):
    """State at every sample, (samples + 1,) each, and the actuator's torque on the knob just after it."""

    time_s: Array
    angle_rad: Array
    velocity_rad_s: Array
    torque_nm: Array


def simulate(
    scene: Scene,
    *,
    sample_rate_hz: float,
    counts_per_rev: int | None,
    angle_rad: float,
    velocity_rad_s: float = 0.0,
    phase: float = 0.5,
    samples: int,
    compiled: bool = False,
) -> Trial:
    """Run one trial of a scene as `follow_knob`.

    Raises `ComputationError` if the scene's numbers overflow, or if it has no sample clock.
    """
    if not scene.sampled:
        raise ComputationError("a scene without a sample clock has no samples")
    knob = sample_general(scene, sample_rate_hz=sample_rate_hz, counts_per_rev=counts_per_rev)
    return follow_knob(
        knob, angle_rad=angle_rad, velocity_rad_s=velocity_rad_s, phase=phase, samples=samples, compiled=compiled
    )


def follow_knob(
    knob: GeneralKnob,
    *,
    angle_rad: float,
    velocity_rad_s: float,
    phase: float,
    samples: int,
    compiled: bool = False,
    look: Callable[[], None] = lambda: None,
) -> Trial:
    """Run one trial exactly, for ``samples`` intervals from its first sample, ``phase`` of a period after the start.

    ``compiled``: by the compiled engine, to the same last bit. ``look`` is called whenever the trial has become twice
    as long, and may end it by raising.
    """
    from hknob_cli.engine.general.ensemble import begin
    from hknob_cli.engine.general.interval import begin_clock, jitters, next_span
    from hknob_cli.engine.general.search import as_compiled, as_list
    from hknob_cli.engine.general.trace import Rows, run
    from hknob_cli.engine.jit import compiled as compiled_functions

    functions = compiled_functions("general") if compiled else None
    order, delay = knob.body.order, knob.delay_line
    body, wall = as_compiled(knob.body, knob.wall) if compiled else (knob.body, as_list(knob.wall))

    def zeros(count: int) -> Any:
        return np.zeros(count) if compiled else [0.0] * count

    pad = zeros(2 * order)
    state, ring = zeros(order), zeros(delay)
    table, torques = np.zeros((samples + 1, order)), np.zeros(samples + 1)
    start: Any = knob.start(angle_rad, velocity_rad_s)
    first = functions["general.begin"] if functions else begin
    through = functions["general.run"] if functions else run
    first(state, np.array(start) if compiled else start, phase, body, pad)
    before, head, done = read(state[0], wall), 0, 0
    begin_clock(wall.clock, 0.0)
    while True:  # an interval may take seconds
        count = min(max(done, 1), samples - done)
        part = slice(done, done + count + 1)
        rows = Rows(table[part].reshape(-1), torques[part])
        before, head = through(state, before, ring, head, body, wall, pad, rows)
        done += count
        if done == samples:
            break
        look()
    times = np.arange(samples + 1, dtype=np.float64)
    if jitters(wall.clock):
        begin_clock(wall.clock, 0.0)
        times[1:] = np.cumsum([next_span(wall.clock) for _ in range(samples)])
    return Trial(
        time_s=(phase + times) * knob.period_s,
        angle_rad=(table[:, 0] + knob.shift) * knob.quantum_rad,
        velocity_rad_s=table[:, 1] * (knob.quantum_rad / knob.period_s),
        torque_nm=torques * knob.torque_nm,
    )
