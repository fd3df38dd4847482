"""The 60-digit model of the whole scene (`general_reference`) under the controllers of `tests.controllers.laws`.

The controllers have each law as its source has it, sample by sample; the bodies, their friction and the
actuator are those of the model without controllers. A torque commanded at t acts at t + delay: what is commanded over
time is kept as one waveform, of which each hold is a piece.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from tests import digits as mp
from tests.controllers.reference import Law, Rig, law_of

from .general_reference import Control, Relays, build, magnetic_damping
from .reference_bodies import KNOB, SPEED
from .reference_friction import Friction

# Samples of readings, at least, until a memory can have settled. Phase damping does nothing before it has seen
# crossings, and its mean of 64 samples takes 64 log(10^36) to be what it stays.
LEAST = {False: 3, True: 5400}
UNIT = 1e-3  # in place of a count where there is none: distances from the wall's edge, rad
CONSTANTS = 90.0  # time constants in which a memory comes within 10^-36 of where it ends, and a few more

Pieces = list[tuple[Any, Any]]  # torque [N m], duration [s]


class Firmware:
    """A controller with encoder and amplifier: from what the sensor shows to the torques of the next interval."""

    def __init__(self, scene: dict[str, Any], rate_hz: float, counts: int | None, control: Control) -> None:
        """Nothing has happened yet."""
        plain = {name: part for name, part in scene.items() if name != "controller"}
        self.control = control
        ratio = mp.mpf((scene.get("gear") or {}).get("ratio", 1))
        self.rig = Rig(plain, rate_hz, counts and counts * ratio, mp.mpf, magnetic_damping(scene))
        self.law: Law = law_of(self.rig, scene.get("controller"))
        self.before: Any = None
        self.step = float("inf")  # least distance of a torque to where the D/A converter rounds it otherwise, N m

    def command(self, shown: Any, omega: Any, looks: list[Any]) -> Pieces:
        """Torques of the interval that begins."""
        control, before = self.control, shown if self.before is None else self.before
        self.before = shown
        brake = control.damping * (shown - before) / control.period if shown < 0 else mp.zero
        pieces = self.law.command(shown, omega, looks)
        beside = mp.zero
        if control.over_angle is not None and not self.law.silent:
            beside = control.beside(shown)
        found = []
        for torque, _ in pieces:
            wanted = torque - brake + beside
            self.step = min(self.step, control.step_distance(wanted))
            found.append(control.command(wanted))
        lengths = [duration for _, duration in pieces[:-1]]
        return list(zip(found, [*lengths, control.period - sum(lengths)], strict=True))


def stretched(wave: list[Pieces], late: int, length: Any) -> Pieces:
    """What acts in an interval of another length, in periods: the torques of ``late`` samples ago, all parts longer."""
    at = len(wave) - 1 - late
    if at < 0:
        return [(mp.zero, length * sum(duration for _, duration in wave[0]))]
    return [(torque, length * duration) for torque, duration in wave[at]]


def window(wave: list[Pieces], begin: Any, end: Any, period: Any) -> Pieces:
    """What a waveform, one list an interval, has between two times; before its begin nothing."""
    found: Pieces = []
    if begin < 0:
        found.append((mp.zero, min(end, mp.zero) - begin))
    first = max(0, int(mp.floor(begin / period)))
    for i in range(first, len(wave)):
        time = i * period
        if time >= end:
            break
        for torque, duration in wave[i]:
            low, high = max(begin, time), min(end, time + duration)
            if high - low > period * mp.mpf(10) ** -35:
                found.append((torque, high - low))
            time += duration
    return found


class Encoder:
    """What is shown of a motion: with hysteresis by relays, which see its turning points as well."""

    def __init__(self, control: Control, motion: Friction) -> None:
        self.control, self.motion, self.relays = control, motion, None
        self.clear = float("inf")  # least distance to where the count would have been another, counts

    def show(self) -> Any:
        """Angle that the encoder reports now [rad]."""
        control, theta = self.control, self.motion.z[KNOB]
        if control.quantum is None:
            self.clear = min(self.clear, float(abs(theta)) / UNIT, control.jumps(theta) / UNIT)
            return theta
        if not control.hysteresis:
            self.clear = min(self.clear, control.edge_distance(theta) / float(control.quantum))
            return control.measured(theta)
        if self.relays is None:
            self.relays = Relays(control, theta, everywhere=True)
            self.motion.turns.clear()
        for angle in self.motion.turns:
            self.relays.see(angle, 0, turn=True)
        self.motion.turns.clear()
        self.relays.see(theta, 0, turn=False)
        self.clear = min(self.clear, *(gap for _, _, _, gap in self.relays.log))
        self.relays.log.clear()
        return self.relays.read()


def move(
    motion: Friction, pieces: Pieces, control: Control, detections: int, encoder: Encoder, length: Any = 1
) -> list[Any]:
    """Move through an interval, of ``length`` periods; what the encoder shows at each look."""
    looks, time = [], mp.zero
    due = [length * control.period * k / detections for k in range(1, detections)]
    for torque, duration in pieces:
        end = time + duration
        while due and due[0] <= end:
            if due[0] > time:
                motion.hold(torque, due[0] - time)
            time = due.pop(0)
            looks.append(encoder.show())
        if end - time > control.period * mp.mpf(10) ** -35:
            motion.hold(torque, end - time)
        time = end
    return looks


@dataclass
class Pushed(Friction):
    """Motion whose bodies become ``after`` at ``release`` [s]: those without the pulse."""

    after: Any = None
    release: Any = 0
    time: Any = 0

    def hold(self, command: Any, duration: Any) -> None:
        """Move through one hold, in two parts where the pulse ends within it."""
        end = self.time + duration
        if self.bodies is not self.after and self.release <= end:
            if self.release > self.time:
                super().hold(command, self.release - self.time)
            self.bodies, self.time = self.after, self.release
        if end > self.time:
            super().hold(command, end - self.time)
        self.time = end


def simulate_law(
    scene: dict[str, Any],
    rate_hz: float,
    counts: int | None,
    *,
    angle: float,
    velocity: float,
    phase: Any,
    pulse: dict[str, float] | None = None,
    intervals: Iterator[Any] | None = None,
) -> Iterator[tuple[Any, Any, Any]]:
    """Angle and velocity at every sample, and the least distance so far to where rounding could change a command.

    ``intervals``: lengths of the sample intervals, in periods, beside whole delays. ``pulse``: its torque on the knob,
    away from the wall, and its duration from the start, as a recording has it.
    """
    bodies, control = build(scene, sample_rate_hz=rate_hz, counts_per_rev=counts)
    at = mp.mpf(angle), mp.mpf(velocity)
    start = (*at, *(at if bodies.finger else (mp.zero, mp.zero)), mp.zero, mp.zero, mp.one, mp.zero)
    motion = Friction(bodies, control.period, start, find_turns=control.hysteresis > 0)
    if pulse:
        key = "push" if scene.get("gear") else "bias"  # of knob and hand behind a gear, or of the knob
        pushed = replace(bodies, **{key: getattr(bodies, key) - mp.mpf(pulse["torque"])}, _kept={})
        turns = control.hysteresis > 0
        motion = Pushed(
            pushed, control.period, start, find_turns=turns, after=bodies, release=mp.mpf(pulse["duration"])
        )
    motion.hold(mp.zero, mp.mpf(phase) * control.period)
    firmware = Firmware(scene, rate_hz, counts, control)
    detections = firmware.law.detections
    encoder = Encoder(control, motion)
    looks = [encoder.show()] * (detections - 1)
    wave: list[Pieces] = []
    clear = float("inf")
    i = 0
    while True:
        theta = motion.z[KNOB]
        wave.append(firmware.command(encoder.show(), motion.z[SPEED], looks))
        clear = min(clear, encoder.clear)
        if control.step:
            clear = min(clear, firmware.step / float((control.stiffness or 1) * (control.quantum or UNIT)))
        yield theta, motion.z[SPEED], clear
        if intervals is not None:
            length = next(intervals)
            pieces = stretched(wave, int(control.delay), length)
            looks = move(motion, pieces, control, detections, encoder, length)
            continue
        begin = (i - control.delay) * control.period
        looks = move(motion, window(wave, begin, begin + control.period, control.period), control, detections, encoder)
        i += 1


def periodic_wave(
    scene: dict[str, Any],
    rate_hz: float,
    counts: int,
    control: Control,
    shown: list[Any],
    looks: list[list[Any]],
    energy: Any = None,
) -> list[Pieces]:
    """Torques of a period of readings that has gone on for so long that the beginning is forgotten to 40 digits.

    ``looks``: those in the interval *before* each sample. ``energy``: that a passivity controller begins with which
    never begins anew, and so forgets nothing [J].
    """
    firmware = Firmware(scene, rate_hz, counts, control)
    if energy is not None:
        firmware.law.energy = energy
    n = len(shown)
    law, actuator = scene.get("controller") or {}, scene.get("actuator") or {}
    least = LEAST[law.get("kind") == "phase_damping"] + n + law.get("window", 1)
    if "cut_off" in law or actuator.keys() & {"torque_step", "torque_limit", "dead_band"}:
        # Torques may come back to the digit long before the memory does: it is given its time.
        fades = law.get("low_pass") or law.get("time_constant") or 2.0 / law.get("bandwidth", float("inf"))
        least += int(CONSTANTS * fades * rate_hz)
    last: list[Pieces] = []
    for lap in range(100_000):
        wave = [firmware.command(shown[i], mp.zero, looks[i]) for i in range(n)]
        if lap * n >= least and all(
            abs(one[0] - other[0]) <= mp.mpf(10) ** -34
            for a, b in zip(wave, last, strict=True)
            for one, other in zip(a, b, strict=True)
        ):
            return wave
        last = wave
    raise AssertionError("the controller's memory does not settle")


def run_closed(
    motion: Friction, firmware: Firmware, last: Any, under_way: list[Any], samples: int
) -> tuple[list[Any], list[Any]]:
    """Run samples of a controller that senses the velocity: angles at them and one more, and all torques.

    ``last``: what the sensor showed before; ``under_way``: torques of the intervals before, the oldest first.
    """
    control = firmware.control
    firmware.before = firmware.law.before = last
    wave: list[Pieces] = [[(u, control.period)] for u in under_way]
    encoder, thetas = Encoder(control, motion), []
    for i in range(samples):
        thetas.append(motion.z[KNOB])
        wave.append(firmware.command(control.measured(motion.z[KNOB]), motion.z[SPEED], []))
        begin = (len(under_way) + i - control.delay) * control.period
        move(motion, window(wave, begin, begin + control.period, control.period), control, 1, encoder)
    thetas.append(motion.z[KNOB])
    return thetas, [torque for pieces in wave for torque, _ in pieces]


def run_period(
    motion: Friction, wave: list[Pieces], control: Control, detections: int, readings: list[Any] | None = None
) -> tuple[list[Any], list[list[Any]]]:
    """Run a period of torques that has always gone on: angles at its samples and one more, looks in each interval.

    ``readings``: takes what the encoder shows at the samples of a second period, after a first one.
    """
    n, encoder = len(wave), Encoder(control, motion)
    back = int(mp.ceil(control.delay / n)) + 1 if control.delay else 0
    long = wave * (back + 1)
    thetas, looks = [], []
    for i in range(n if readings is None else 2 * n):
        thetas.append(motion.z[KNOB])
        shown = encoder.show()
        if readings is not None and i >= n:
            readings.append(shown)
        begin = (back * n + i % n - control.delay) * control.period
        pieces = window(long, begin, begin + control.period, control.period)
        looks.append(move(motion, pieces, control, detections, encoder))
    thetas.append(motion.z[KNOB])
    return thetas, looks
