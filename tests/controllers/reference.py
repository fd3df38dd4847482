"""Controllers written once more from their sources, one trial and one sample at a time, in SI units.

Nothing is imported from the package: both sides are built from the same plain dictionaries, the ``scene`` of a spec.
The plant's hold is one matrix exponential of the augmented matrix (Franklin, Powell & Workman, sec. 4.3), in floats or
in 40 digits.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import floor
from typing import Any

import mpmath
import numpy as np

mp = mpmath.MPContext()
mp.dps = 40

Pieces = list[tuple[Any, Any]]  # torque [N m], duration [s]


@dataclass
class Rig:
    """Hand, knob, wall and encoder of a ``scene``, sampled; ``number``: float or mp.mpf."""

    scene: dict[str, Any]
    rate_hz: float
    counts: int
    number: Callable[..., Any] = float
    _holds: dict[Any, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Take the numbers."""
        number, hand, bias = self.number, self.scene.get("hand", {}), self.scene.get("bias", {})
        self.inertia = number(self.scene["knob"]["inertia"]) + number(hand.get("inertia", 0.0))
        self.damping = number(self.scene["knob"].get("damping", 0.0)) + number(hand.get("damping", 0.0))
        self.stiffness = number(hand.get("stiffness", 0.0))
        self.wall = number(self.scene["wall"]["stiffness"])
        self.period = 1 / number(self.rate_hz)
        self.quantum = 2 * (mp.pi if number is mp.mpf else number(np.pi)) / self.counts
        half = bias.get("half_quantum")
        self.push = self.wall * self.quantum / 2 if half else number(bias.get("torque", 0.0))
        encoder = self.scene.get("encoder", {})
        self.rounding, self.offset = encoder.get("rounding", "floor"), number(encoder.get("offset_counts", 0.0))
        limit = self.scene.get("actuator", {}).get("torque_limit")
        self.limit = None if limit is None else number(limit)

    def hold(self, duration: Any) -> Any:
        """(Phi, Gamma) per N m of a hold."""
        if duration not in self._holds:
            j, b, k = self.inertia, self.damping, self.stiffness
            rows = [[0, 1, 0], [-mp.mpf(k) / j, -mp.mpf(b) / j, mp.mpf(1) / j], [0, 0, 0]]
            with mp.extradps(20):
                e = mp.expm(mp.matrix(rows) * duration).tolist()
            if self.number is float:  # of which each element is right, as those of an exponential in floats are not
                e = [[float(one) for one in row] for row in e]
            self._holds[duration] = e
        return self._holds[duration]

    def move(self, state: tuple[Any, Any], torque: Any, duration: Any) -> tuple[Any, Any]:
        """State after a hold of a torque; the user pushes as well."""
        p, (theta, omega), u = self.hold(duration), state, torque - self.push
        return tuple(row[0] * theta + row[1] * omega + row[2] * u for row in p[:2])  # type: ignore[return-value]

    def measured(self, theta: Any) -> Any:
        """Angle that the encoder shows."""
        ratio = theta / self.quantum - self.offset
        if self.rounding == "nearest":
            level = floor(ratio + 0.5)
        elif self.rounding == "ceil" or (self.rounding == "truncate" and ratio < 0):
            level = -floor(-ratio)
        else:
            level = floor(ratio)
        return (level + self.offset) * self.quantum

    def spring(self, shown: Any) -> Any:
        """Torque of the plain wall for what the encoder shows."""
        return -self.wall * shown if shown < 0 else self.number(0)

    def trial(self, law: "Law", angle: float, velocity: float, phase: float) -> Iterator[tuple[Any, Any, Pieces]]:
        """State and torques at every sample; the first comes after ``phase`` of an interval."""
        state = (self.number(angle), self.number(velocity))
        state = self.move(state, self.number(0), self.number(phase) * self.period)
        shown = self.measured(state[0])
        looks = [shown] * (law.detections - 1)
        while True:
            shown = self.measured(state[0])
            pieces = law.command(shown, state[1], looks)
            if self.limit is not None:
                pieces = [(min(max(torque, -self.limit), self.limit), time) for torque, time in pieces]
            yield (*state, pieces)
            looks = [self._look(state, pieces, self.period * k / law.detections) for k in range(1, law.detections)]
            for torque, duration in pieces:
                state = self.move(state, torque, duration)

    def _look(self, state: tuple[Any, Any], pieces: Pieces, time: Any) -> Any:
        for torque, duration in pieces:
            if time <= duration:
                return self.measured(self.move(state, torque, time)[0])
            state, time = self.move(state, torque, duration), time - duration
        raise AssertionError


class Law:
    """A controller: ``command`` is given what the encoder shows, the true velocity, and what it showed in between."""

    detections = 1

    def __init__(self, rig: Rig, **numbers: Any) -> None:
        """Nothing has happened yet."""
        self.rig = rig
        self.numbers = {key: rig.number(value) if type(value) is float else value for key, value in numbers.items()}
        self.detections = numbers.get("detections", 1)
        self.before: Any = None
        self.zero = rig.number(0)
        self.torques = [self.zero, self.zero]  # of the wall, the last two
        self.begin()

    def begin(self) -> None:
        """What a kind of its own remembers."""

    def command(self, shown: Any, omega: Any, looks: list[Any]) -> Pieces:
        """Torques of this interval."""
        before = shown if self.before is None else self.before
        speed = omega if self.numbers.get("velocity") == "sensor" else (shown - before) / self.rig.period
        found = self.act(shown, speed, before, looks)
        self.before = shown
        self.torques = [self.rig.spring(shown), self.torques[0]]
        return found if isinstance(found, list) else [(found, self.rig.period)]

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        """One torque, or pieces."""
        raise NotImplementedError


class FirstOrderHold(Law):
    """Ellis et al.: mean of the torque and the next one, extrapolated; the error of the last prediction is added."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        now, (last, earlier) = self.rig.spring(shown), self.torques
        anticipated = now + (now - last)
        torque = (now + anticipated) / 2
        if self.numbers.get("correct", True):
            was_anticipated = last + (last - earlier)
            torque += (last + now) / 2 - (last + was_anticipated) / 2
        return torque


class HalfSample(Law):
    """Gillespie & Cutkosky: the wall's torque where the model is half an interval ahead under that torque."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        row = self.rig.hold(self.rig.period / 2)[0]
        free = row[0] * shown + row[1] * speed
        # torque u = -K (free + row[2] u) inside
        return -self.rig.wall * free / (1 + self.rig.wall * row[2]) if free < 0 else self.zero


class MatchedWall(Law):
    """Full state feedback that puts the poles where those of the continuous wall are, sampled."""

    def begin(self) -> None:
        rig = self.rig
        exact = Rig(rig.scene, rig.rate_hz, rig.counts, mp.mpf)
        (p11, p12, g1), (p21, p22, g2) = exact.hold(exact.period)[:2]
        half = exact.damping / (2 * exact.inertia)
        root = mp.sqrt(mp.mpc(half**2 - (exact.stiffness + exact.wall) / exact.inertia))
        z1, z2 = (mp.exp(s * exact.period) for s in (-half + root, -half - root))
        trace, product = mp.re(z1 + z2), mp.re(z1 * z2)
        # det(zI - Phi + Gamma l): the trace and the determinant of Phi - Gamma l, both linear in l
        left = mp.matrix([[g1, g2], [g1 * p22 - g2 * p12, g2 * p11 - g1 * p21]])
        right = mp.matrix([p11 + p22 - trace, p11 * p22 - p12 * p21 - product])
        self.gains = [rig.number(one) for one in mp.lu_solve(left, right)]

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        return -(self.gains[0] * shown + self.gains[1] * speed) if shown < 0 else self.zero


class VelocityDamping(Law):
    """Virtual damping beside the spring."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        acts = shown < 0 or self.numbers.get("everywhere", False)
        return self.rig.spring(shown) - (self.numbers["damping"] * speed if acts else self.zero)


class ImpulseDamping(Law):
    """Section 11.2: the torque-time integral that was wrong since a crossing, given back in a pulse."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        period, count = self.rig.period, self.detections
        now = self.rig.spring(shown)
        torques = [self.torques[0], *(self.rig.spring(one) for one in looks), now]
        wrong = self.zero
        for i in range(count):
            crossed = (i + self.rig.number(1) / 2) * period / count  # on average, before it is seen
            wrong += (torques[i + 1] - torques[i]) * (period - crossed)
        pulse = self.numbers.get("pulse", self.rig.number(0.025)) * period
        high = now + self.numbers.get("gain", 1) * wrong / pulse
        return [(high, pulse), (now, period - pulse)] if pulse < period else high


class PhaseDamping(Law):
    """Section 11.3: a cosine of the time since the edge was crossed, against the velocity that is guessed from it."""

    def begin(self) -> None:
        self.mean = self.zero
        self.sample = -1
        self.crossed: dict[bool, int] = {}  # sample of the last way in (True) and out
        self.last: bool | None = None
        self.times: dict[bool, int] = {}
        self.was_in = False

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        both = self.numbers.get("crossings", "in") == "both"
        self.sample += 1
        now = self.rig.spring(shown)
        self.mean += (now - self.mean) / 64
        is_in = now > self.mean
        if is_in != self.was_in and (is_in or both):
            if both and self.last is not None:
                self.times[not is_in] = self.sample - self.crossed[self.last]  # time spent on the side that is left
            elif not both and is_in in self.crossed:
                self.times[is_in] = self.sample - self.crossed[is_in]
            self.crossed[is_in], self.last = self.sample, is_in
        self.was_in = is_in
        if self.last is None or self.last not in self.times:
            return now
        since = self.sample - self.crossed[self.last] + self.rig.number(1) / 2
        turn = since / self.times[self.last] / (2 if both else 1)
        if turn > self.numbers.get("degrees", 360.0) / 360:
            return now
        wave = mp.cos(2 * mp.pi * turn) if self.rig.number is mp.mpf else np.cos(2 * np.pi * turn)
        height = self.numbers.get("height", self.rig.number(0.5)) * self.rig.wall * self.rig.quantum
        return now + height * wave * (1 if self.last else -1)


class Passivity(Law):
    """Hannaford & Ryu: energy observed, and a damper that takes back what the wall has given out."""

    def begin(self) -> None:
        self.energy = self.zero
        self.held = self.zero

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        torque = self.rig.spring(shown)
        still = shown == before
        self.energy -= self.held * (shown - before)
        if self.energy < 0 and not still:
            speed = (shown - before) / self.rig.period
            damper = min(-self.energy / (speed * speed * self.rig.period), self.numbers["damping"])
            torque -= damper * speed
        if self.numbers.get("reset", True) and still and shown >= 0:
            self.energy = self.zero
        self.held = torque
        return torque


class Stiffening(Law):
    """Section 11: a stiffness that rises with depth."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        surface = self.numbers.get("surface", self.rig.number(0.3))
        part = min(-shown / self.numbers.get("depth", self.rig.number(0.01)), self.rig.number(1))
        return self.rig.spring(shown) * (surface + (1 - surface) * part)


class BoundedLag(Law):
    """The wall, and of its distance to its running mean, up to one count's step, only a part."""

    def begin(self) -> None:
        self.mean = self.zero

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        now, step = self.rig.spring(shown), self.rig.wall * self.rig.quantum
        ratio = self.rig.period / self.numbers.get("time_constant", self.rig.number(0.2))
        self.mean += (now - self.mean) * (-mp.expm1(-ratio) if self.rig.number is mp.mpf else -np.expm1(-ratio))
        late = min(max(now - self.mean, -step), step)
        return now - (1 - self.numbers.get("keep", self.rig.number(0.2))) * late


LAWS: dict[str, type[Law]] = {
    "bounded_lag": BoundedLag,
    "first_order_hold": FirstOrderHold,
    "half_sample": HalfSample,
    "impulse_damping": ImpulseDamping,
    "matched_wall": MatchedWall,
    "passivity": Passivity,
    "phase_damping": PhaseDamping,
    "stiffening": Stiffening,
    "velocity_damping": VelocityDamping,
}
# Every kind and variant, with numbers that make it act.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "bounded lag": {"kind": "bounded_lag", "keep": 0.15, "time_constant": 0.02},
    "first-order hold": {"kind": "first_order_hold", "correct": False},
    "first-order hold, corrected": {"kind": "first_order_hold"},
    "half sample": {"kind": "half_sample"},
    "half sample, sensor": {"kind": "half_sample", "velocity": "sensor"},
    "impulse, whole": {"kind": "impulse_damping", "pulse": 1.0},
    "impulse, short": {"kind": "impulse_damping"},
    "impulse, timed": {"kind": "impulse_damping", "detections": 20, "gain": 0.7},
    "matched wall": {"kind": "matched_wall"},
    "matched wall, sensor": {"kind": "matched_wall", "velocity": "sensor"},
    "passivity": {"kind": "passivity", "damping": 3.0e-4},
    "passivity, no reset": {"kind": "passivity", "damping": 1.0e-3, "reset": False},
    "phase, 360": {"kind": "phase_damping"},
    "phase, 90": {"kind": "phase_damping", "degrees": 90.0, "height": 0.8},
    "phase, both": {"kind": "phase_damping", "degrees": 90.0, "crossings": "both"},
    "stiffening": {"kind": "stiffening", "depth": 0.02},
    "damping, differenced": {"kind": "velocity_damping", "damping": 3.0e-4},
    "damping, sensor": {"kind": "velocity_damping", "damping": 1.0e-3, "velocity": "sensor"},
    "damping, negative": {"kind": "velocity_damping", "damping": -1.0e-4, "velocity": "sensor", "everywhere": True},
}


def law_of(rig: Rig, controller: dict[str, Any]) -> Law:
    """The controller of a spec, as written here."""
    return LAWS[controller["kind"]](rig, **{key: value for key, value in controller.items() if key != "kind"})
