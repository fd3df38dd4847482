"""A 60-digit model of the whole scene: friction with stick, finger, lag, delay, torque step, limit, virtual damping.

It shares no formula with the package and imports nothing from it: both are built from the ``scene`` of a spec, a plain
dictionary. Bodies and their motion are in `reference_bodies`, what happens in a hold in `reference_friction`. Here are
encoder, wall and actuator, and the run from sample to sample.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from tests import digits as mp

from .over_angle_reference import along_angle, jumps, over_angle
from .reference_bodies import KNOB, SPEED, TORQUE, Bodies, NotHandledError
from .reference_friction import Friction


@dataclass(frozen=True)
class Control:
    """Encoder, wall and what the actuator does to a command; ``quantum`` None: a continuous sensor."""

    stiffness: Any
    damping: Any
    period: Any
    quantum: Any
    rounding: str
    offset: Any
    step: Any
    limit: Any
    delay: Any
    dead_band: Any = 0  # smaller torques are not sent [N m]
    over_angle: Any = None  # torque [N m] at a count, beside the wall; of a continuous sensor at its angle [rad]
    jumps: Any = None  # distance of an angle to where that jumps, of a continuous sensor [rad]
    hysteresis: Any = 0  # between the angles at which an edge is passed on the way up and down [counts]

    def counts(self, theta: Any) -> Any:
        """Angle in counts from an encoder edge, shifted such that a level changes at whole numbers."""
        return theta / self.quantum - self.offset + (mp.mpf(1) / 2 if self.rounding == "nearest" else 0)

    def measured(self, theta: Any) -> Any:
        """Angle that the sensor reports [rad]."""
        if self.quantum is None:
            return theta
        counts = self.counts(theta)
        if self.rounding == "ceil" or (self.rounding == "truncate" and counts < 0):
            level = mp.ceil(counts)
        else:
            level = mp.floor(counts)
        return (level + self.offset) * self.quantum

    def edge_distance(self, theta: Any) -> float:
        """Distance to where the command jumps [rad]; a continuous sensor's wall edge counts where there is damping."""
        if self.quantum is None:
            jump = self.jumps(theta) if self.jumps else float("inf")
            return min(float(abs(theta)), jump) if self.damping else jump
        near = [self.counts(theta) + shift for shift in (self.hysteresis / 2, -self.hysteresis / 2)]
        return float(min(abs(counts - mp.nint(counts)) for counts in near) * self.quantum)

    def wanted(self, measured: Any, before: Any) -> Any:
        """Wall's command before the torque step [N m]."""
        other = mp.zero
        if self.over_angle is not None:
            other = self.beside(measured)
        if not measured < 0:
            return other
        return other - self.stiffness * measured - self.damping * (measured - before) / self.period

    def beside(self, measured: Any) -> Any:
        """Torque over the angle at what the sensor reports [N m]."""
        if self.quantum is None:
            return self.over_angle(measured)
        return self.over_angle(int(mp.nint(measured / self.quantum - self.offset)))

    def command(self, wanted: Any) -> Any:
        """Command that the actuator takes [N m]."""
        if abs(wanted) < self.dead_band:
            return mp.zero
        u = self.step * mp.floor(wanted / self.step + mp.mpf(1) / 2) if self.step else wanted
        return u if self.limit is None else max(-self.limit, min(self.limit, u))

    def step_distance(self, wanted: Any) -> float:
        """Distance of a command to where its rounding jumps [N m]."""
        band = float(abs(abs(wanted) - self.dead_band)) if self.dead_band else float("inf")
        if not self.step or wanted == 0:
            return band
        part = wanted / self.step + mp.mpf(1) / 2
        return min(band, float(abs(part - mp.nint(part)) * self.step))


class Relays:
    """An encoder with hysteresis as a row of relays, one an edge: on from half its width above, off from half below.

    ``on``: by edge; the count is the highest that is on. ``log``: of what was seen, the sample that it led to, whether
    it was a turning point, the angle, and its least distance [counts] to where a relay of the wall would have turned,
    or would not have; ``everywhere``: or any relay.
    """

    def __init__(self, control: Control, theta: Any, *, everywhere: bool = False) -> None:
        self.control, self.half, self.everywhere = control, control.hysteresis / 2, everywhere
        count = int(mp.nint(control.measured(theta) / control.quantum - control.offset))
        self.on = {edge: self.above(edge) <= count for edge in range(-300, 300) if self.above(edge) is not None}
        self.log: list[tuple[int, bool, Any, float]] = []

    def above(self, edge: int) -> Any:
        """The count above an edge; None where there is no edge, in the middle of the count 0 of `truncate`."""
        if self.control.rounding == "truncate":
            return None if edge == 0 else edge if edge > 0 else edge + 1
        return edge + 1 if self.control.rounding == "ceil" else edge

    def see(self, theta: Any, sample: int, *, turn: bool) -> None:
        """Go to an angle, from the last one without turning round."""
        gap = float("inf")
        at = self.control.counts(theta)
        for edge, on in self.on.items():
            goes = at < edge - self.half if on else at >= edge + self.half
            self.on[edge] = on != goes
            if self.everywhere or self.above(edge) <= 0:
                gap = min(gap, float(abs(at - (edge - self.half if on else edge + self.half))))
        self.log.append((sample, turn, theta, gap))

    def read(self) -> Any:
        """Angle that the encoder reports [rad]. Raises `NotHandledError` past the last relay."""
        count = max((self.above(edge) for edge, on in self.on.items() if on), default=None)
        if count is None or all(self.on.values()):
            raise NotHandledError("turned further than there are relays")
        return (count + self.control.offset) * self.control.quantum


@dataclass(frozen=True)
class Sample:
    """Knob and torque at one sample instant: ``torque`` [N m] acts just after it. ``mode`` of the hold before it."""

    time: Any
    angle: Any
    velocity: Any
    torque: Any
    mode: int


@dataclass
class Trial:
    """A run: its samples, and how far it stayed from every jump that rounding could flip.

    ``edge``: least distance of a sample to an encoder edge [rad]; ``step``: of a command to a jump of its rounding
    [N m]; ``largest_angle`` [rad], ``largest_speed`` [rad/s] at samples and ``largest_torque`` [N m] set the scale.
    """

    friction: Friction
    control: Control
    samples: list[Sample] = field(default_factory=list)
    edge: float = float("inf")
    step: float = float("inf")
    largest_command: float = 0.0
    levels: set[float] = field(default_factory=set)
    relays: Relays | None = None

    @property
    def largest_angle(self) -> float:
        """Of the samples [rad]."""
        return max(float(abs(s.angle)) for s in self.samples)

    @property
    def largest_speed(self) -> float:
        """Of the samples [rad/s]."""
        return max(float(abs(s.velocity)) for s in self.samples)


def magnetic_damping(scene: dict[str, Any]) -> Any:
    """Damping by an eddy brake, and by a winding without inductance [N m s/rad]."""
    motor, brake = scene.get("motor"), scene.get("eddy_brake")
    found = mp.zero
    if brake:
        density, radius = mp.mpf(brake["flux_density"]), mp.mpf(brake["radius"])
        found = mp.mpf(brake["share"]) * mp.mpf(brake["conductivity"]) * mp.mpf(brake["thickness"])
        found *= mp.mpf(brake["area"]) * density**2 * radius**2
    if motor and motor["winding"] != "current" and not motor.get("inductance"):
        found += mp.mpf(motor["torque_constant"]) ** 2 / mp.mpf(motor["resistance"])
    return found


def build(scene: dict[str, Any], *, sample_rate_hz: float, counts_per_rev: int | None) -> tuple[Bodies, Control]:
    """The model of a spec's ``scene``; each number enters as exactly the double that the spec holds."""

    def number(part: dict[str, Any], name: str) -> Any:
        return mp.mpf(part.get(name) or 0.0)

    if scene.get("gear"):
        scene = _seen_from_the_knob(scene)
    knob, hand, wall = scene["knob"], scene.get("hand") or {}, scene.get("wall") or {"stiffness": 0.0}
    finger, pad = hand.get("finger"), hand.get("fingerpad")
    actuator, bias, encoder = scene.get("actuator") or {}, scene.get("bias") or {}, scene.get("encoder", {})
    ratio = mp.mpf(scene.get("turns", 1))
    quantum = None if encoder == "none" or counts_per_rev is None else 2 * mp.pi / counts_per_rev / ratio
    shape = encoder if isinstance(encoder, dict) else {}
    limit = actuator.get("torque_limit")
    parts: dict[str, Any] = {}
    if finger is not None:
        parts = {
            "finger": True,
            "finger_inertia": number(finger, "inertia"),
            "finger_damping": number(finger, "damping"),
            "finger_stiffness": number(finger, "stiffness"),
            "pad_damping": number(pad, "damping"),
            "pad_stiffness": number(pad, "stiffness"),
        }
    motor = scene.get("motor")
    lag, limit_of_supply = number(actuator, "time_constant"), None
    if motor:
        kt, r, inductance = (number(motor, name) for name in ("torque_constant", "resistance", "inductance"))
        if motor["winding"] != "current" and inductance:
            driven = motor["winding"] == "voltage"
            parts |= {"torque_constant": kt, "resistance": r, "inductance": inductance, "driven": driven}
        if motor.get("bandwidth"):
            lag = 1 / (2 * mp.pi * number(motor, "bandwidth"))
        if motor.get("supply_voltage"):
            limit_of_supply = kt / r * number(motor, "supply_voltage")
    bodies = Bodies(
        inertia=number(knob, "inertia") + number(hand, "inertia"),
        damping=number(knob, "damping") + number(hand, "damping") + magnetic_damping(scene),
        stiffness=number(hand, "stiffness"),
        friction=number(knob, "coulomb_torque"),
        bias=mp.mpf(wall["stiffness"]) * quantum / 2 if bias.get("half_quantum") else number(bias, "torque"),
        lag=lag,
        **parts,
    )
    if "turns" in scene:
        bodies = replace(bodies, bias=mp.zero, push=bodies.bias, play=number(scene, "play"), _kept={})
    cogging = scene.get("cogging")
    if cogging and cogging["torque"]:
        shape_of = (mp.mpf(cogging["torque"]), mp.mpf(cogging["per_revolution"]), number(cogging, "centre"))
        bodies = replace(bodies, cogs=shape_of, _kept={})
    control = Control(
        stiffness=number(wall, "stiffness"),
        damping=number(wall, "damping"),
        period=1 / mp.mpf(sample_rate_hz),
        quantum=quantum,
        rounding=shape.get("rounding", "floor"),
        offset=number(shape, "offset_counts"),
        step=number(actuator, "torque_step"),
        limit=limit_of_supply if limit is None else mp.mpf(limit),
        delay=number(actuator, "delay_samples"),
        dead_band=number(actuator, "dead_band"),
        over_angle=over_angle(scene, counts_per_rev) if quantum is not None else along_angle(scene),
        jumps=jumps(scene) if quantum is None else None,
        hysteresis=number(shape, "hysteresis_counts") + (number(shape, "backlash") / quantum if quantum else 0),
    )
    return bodies, control


def _seen_from_the_knob(scene: dict[str, Any]) -> dict[str, Any]:
    """A gear with a stiffness as knob and finger: the motor over its ratio, and what the user turns behind the mesh."""
    gear, hand, knob = scene["gear"], scene.get("hand") or {}, scene["knob"]
    n = mp.mpf(gear["ratio"])
    brake = {"eddy_brake": scene.get("eddy_brake")}  # on the knob's shaft

    def times(part: dict[str, Any], keys: tuple[str, ...], factor: Any) -> dict[str, Any]:
        return {key: factor * mp.mpf(value) if key in keys and value else value for key, value in part.items()}

    motor = {
        "inertia": n * n * mp.mpf(gear["motor_inertia"]),
        "damping": n * n * mp.mpf(gear.get("motor_damping", 0.0)),
        "coulomb_torque": n * mp.mpf(gear.get("motor_coulomb_torque", 0.0)),
    }
    own = {
        "inertia": mp.mpf(knob["inertia"]) + mp.mpf(hand.get("inertia", 0.0)),
        "damping": mp.mpf(knob.get("damping", 0.0)) + mp.mpf(hand.get("damping", 0.0)) + magnetic_damping(brake),
        "stiffness": mp.mpf(hand.get("stiffness", 0.0)),
    }
    found = {**scene, "knob": motor, "gear": None, "eddy_brake": None, "turns": n, "play": gear.get("backlash", 0.0)}
    found["hand"] = {
        "finger": own,
        "fingerpad": {"damping": gear.get("mesh_damping", 0.0), "stiffness": gear["stiffness"]},
    }
    if scene.get("actuator"):
        found["actuator"] = times(scene["actuator"], ("torque_limit", "torque_step", "dead_band"), n)
    if scene.get("motor"):
        found["motor"] = times(scene["motor"], ("torque_constant",), n)
    if scene.get("cogging"):
        own_angle = times(scene["cogging"], ("centre",), 1 / n)
        found["cogging"] = times(own_angle, ("torque", "per_revolution"), n)
    return found


def simulate(
    scene: dict[str, Any],
    *,
    sample_rate_hz: float,
    counts_per_rev: int | None,
    angle_rad: Any,
    velocity_rad_s: Any,
    phase: Any = 0.5,
    samples: int,
    find_turns: bool = False,
    nudge: Any = 0,
    intervals: Any = None,
) -> Trial:
    """Run a trial: the state is given at time 0, the first of ``samples`` + 1 samples is taken ``phase`` periods later.

    ``nudge``: relative change made to angle and velocity at every sample, to see how a run amplifies small errors.
    ``intervals``: lengths of the sample intervals, in periods, beside whole delays.
    """
    bodies, control = build(scene, sample_rate_hz=sample_rate_hz, counts_per_rev=counts_per_rev)
    angle, velocity = mp.mpf(angle_rad), mp.mpf(velocity_rad_s)
    zero = mp.zero
    start = (angle, velocity, angle, velocity, zero, zero, mp.one, zero) if bodies.finger else None
    state = start or (angle, velocity, zero, zero, zero, zero, mp.one, zero)
    friction = Friction(bodies, control.period, state, find_turns=find_turns or control.hysteresis > 0)
    trial = Trial(friction, control)
    friction.hold(zero, mp.mpf(phase) * control.period)
    commands: list[Any] = []
    before = None
    largest = 0.0
    for i, (row, durations) in enumerate(_schedule(control, samples + 1)):
        z = friction.z
        if nudge:
            z = friction.z = (z[0] * (1 + nudge), z[1] * (1 + nudge), *z[2:])
        measured = control.measured(z[KNOB])
        if control.hysteresis:
            trial.relays = trial.relays or Relays(control, z[KNOB], everywhere=control.damping > 0)
            for angle in friction.turns if i else []:
                trial.relays.see(angle, i, turn=True)
            trial.relays.see(z[KNOB], i, turn=False)
            trial.edge = min(trial.edge, trial.relays.log[-1][3] * float(control.quantum))
            friction.turns.clear()
            measured = trial.relays.read()
        wanted = control.wanted(measured, measured if before is None else before)
        before = measured
        commands.append(control.command(wanted))
        acting = [commands[j] if j >= 0 else zero for j in row]
        torque = z[TORQUE] if bodies.lag else acting[0]
        passed = i if intervals is None else mp.fsum(intervals[:i])
        trial.samples.append(
            Sample((passed + mp.mpf(phase)) * control.period, z[KNOB], z[SPEED], torque, friction.mode)
        )
        trial.edge = min(trial.edge, control.edge_distance(z[KNOB]))
        trial.step = min(trial.step, control.step_distance(wanted))
        trial.levels.add(float(measured) if control.quantum is not None else float(measured < 0))
        largest = max(largest, float(abs(wanted)), float(abs(control.damping * measured / control.period)))
        if i < samples and intervals is not None:
            friction.hold(acting[0], intervals[i] * control.period)
        elif i < samples:
            for command, duration in zip(acting, durations, strict=True):
                friction.hold(command, duration)
    trial.largest_command = largest
    return trial


def _schedule(control: Control, samples: int) -> Iterator[tuple[list[int], list[Any]]]:
    """For each sample interval the indices of the commands that act in it, in order, and for how long each does.

    Command j arrives at sample j + delay: what of an interval lies before a command arrives runs under the last.
    """
    whole = int(mp.floor(control.delay))
    part = control.delay - whole
    for i in range(samples):
        if part == 0:
            yield [i - whole], [control.period]
        else:
            yield [i - whole - 1, i - whole], [part * control.period, (1 - part) * control.period]
