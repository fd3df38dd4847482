"""Controllers written once more from their sources, one trial and one sample at a time, in SI units.

Nothing is imported from the package: both sides are built from the same plain dictionaries, the ``scene`` of a spec.
The plant's hold is one matrix exponential of the augmented matrix (Franklin, Powell & Workman, sec. 4.3), in floats or
in 60 digits.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import floor
from typing import Any

import numpy as np

from tests import digits as mp

Pieces = list[tuple[Any, Any]]  # torque [N m], duration [s]


@dataclass
class Rig:
    """Hand, knob, wall and encoder of a ``scene``, sampled; ``number``: float or mp.mpf. No ``counts``: none.

    ``braked``: damping by a motor or a brake [N m s/rad], which the scene's knob and hand do not have.
    """

    scene: dict[str, Any]
    rate_hz: float
    counts: Any  # of a revolution of the knob, None of a continuous sensor
    number: Callable[..., Any] = float
    braked: Any = 0.0
    _holds: dict[Any, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Take the numbers."""
        number, hand, bias = self.number, self.scene.get("hand", {}), self.scene.get("bias", {})
        self.inertia = number(self.scene["knob"]["inertia"]) + number(hand.get("inertia", 0.0))
        self.damping = number(self.scene["knob"].get("damping", 0.0)) + number(hand.get("damping", 0.0))
        self.damping += number(self.braked)
        self.stiffness = number(hand.get("stiffness", 0.0))
        self.wall = number(self.scene["wall"]["stiffness"])
        self.period = 1 / number(self.rate_hz)
        self.quantum = 2 * (mp.pi if number is mp.mpf else number(np.pi)) / self.counts if self.counts else None
        half = bias.get("half_quantum")
        self.push = self.wall * self.quantum / 2 if half else number(bias.get("torque", 0.0))
        encoder = self.scene.get("encoder", {}) if self.counts else {}
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
        if self.quantum is None:
            return theta
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
    silent = False  # whether nothing at all is commanded now
    energy: Any = 0  # of a passivity controller [J]

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


class PlainWall(Law):
    """No controller: the wall by itself."""

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        """The wall's torque."""
        return self.rig.spring(shown)


def law_of(rig: Rig, controller: dict[str, Any] | None) -> Law:
    """The controller of a spec, as its file in `laws` has it."""
    from tests.controllers.laws import LAWS

    if not controller:
        return PlainWall(rig)
    law: Law = LAWS[controller["kind"]].Source(rig, **{key: one for key, one in controller.items() if key != "kind"})
    return law
