"""Knobs with cogging, and their motion from corner to corner by matrix exponentials; the end of a mode is bracketed.

Built from a body's physical numbers: of its matrices, and of what bounds events, it knows nothing. An event that begins
and ends within a step of 1/64 of a sample is missed.
"""

from functools import cache
from random import Random
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cogging import CENTRE, LENGTH, SLOPE
from hknob_cli.scene.general_knob import make_body, sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.verification.general_scenes import TWO_PARTS, scene

Array = NDArray[np.float64]
STEPS = 64  # of a sample
HALVINGS = 46  # of a step
CLOSE = 1e-9  # of the size of the state: far above roundings, far below any event that is missed
SEEDS = range(10)
FREE = 2
TURNED, RISEN, FALLEN = 1, 2, 3

WEAK = {"torque": 2e-4, "per_revolution": 84, "centre": 0.01}
STRONG = {"torque": 6e-3, "per_revolution": 84, "centre": 0.01}
DENSE = {"torque": 1e-3, "per_revolution": 700, "centre": 1e-4}  # several corners in a sample
COIL = {"torque_constant": 0.0234, "resistance": 2.32, "inductance": 2.38e-4, "winding": "shorted"}
LIGHT = {"coulomb_torque": 6e-5}
SCENES: dict[str, dict[str, Any]] = {
    "weak": scene(cogging=WEAK),
    "strong": scene(cogging=STRONG),
    "dense": scene(cogging=DENSE),
    "finger, lag": scene(hand=TWO_PARTS, actuator={"time_constant": 3e-4}, cogging=STRONG),
    "winding": scene(motor=COIL, cogging=STRONG),
    "rubs": scene(knob=LIGHT, cogging=STRONG),
    "rubs, dense": scene(knob=LIGHT, cogging=DENSE),
    "rubs, lag": scene(knob=LIGHT, actuator={"time_constant": 3e-4}, cogging=STRONG),
    "rubs, finger": scene(knob=LIGHT, hand=TWO_PARTS, cogging=STRONG),
    "rubs, finger, winding, lag": scene(
        knob=LIGHT, hand=TWO_PARTS, motor=COIL, actuator={"time_constant": 3e-4}, cogging=DENSE
    ),
}


@cache
def body_of(name: str) -> Body:
    """The body of a scene at 1 kHz and 1024 counts."""
    plain = reduced(SceneSpec.model_validate(SCENES[name]).plain())
    return sample_general(plain, sample_rate_hz=1000.0, counts_per_rev=1024).body


class Event(NamedTuple):
    """When a mode has ended (samples), how, in which state, and the slope and the mode from then on."""

    time: float
    end: int
    state: Array
    slope: float
    mode: int


class Cogged:
    """The motion of a knob with cogging under one torque, from a state on.

    ``ways``: whether turning points end a mode without friction, too.
    """

    def __init__(self, body: Body, state: Any, u: float, *, ways: bool = False) -> None:
        self.body = body
        self.z = np.array([*state, 1.0, u])
        self.ways = ways or body.friction > 0.0
        self.slope = float(np.floor((self.z[0] - body.cogs[CENTRE]) / body.cogs[LENGTH] + 0.5))
        self.mode = self.way() if self.ways else FREE
        self.events: list[Event] = []
        self.time = 0.0

    def pull(self) -> Array:
        """Row of the acceleration without friction, by the state, 1 and the torque commanded."""
        body, n = self.body, self.body.order
        row = np.zeros(n + 2)
        row[1] = -body.alpha
        if body.ratio > 0.0:
            row[2:4] = -body.pad_stiffness, -body.pad_damping
        else:
            row[0] = -body.beta
        row[n] = -body.push - (0.0 if body.ratio > 0.0 else body.beta * body.shift)
        if body.coil > 0.0:
            row[4 if body.ratio > 0.0 else 2] = -body.coil
        row[n - 1 if body.lag > 0.0 else n + 1] = 1.0
        spring = body.cogs[SLOPE] * (1.0 if self.slope % 2.0 == 0.0 else -1.0)
        row[0] -= spring
        row[n] += spring * (body.cogs[CENTRE] + self.slope * body.cogs[LENGTH])
        return row

    def rates(self) -> Array:
        """Matrix of the motion in the mode that it is in."""
        body, n = self.body, self.body.order
        a = np.zeros((n + 2, n + 2))
        held = self.mode == 0
        if not held:
            a[0, 1] = 1.0
            a[1] = self.pull()
            if self.mode != FREE:
                a[1, n] -= self.mode * body.friction
        if body.ratio > 0.0:
            finger = np.zeros(n + 2)
            finger[:4] = -body.finger_stiffness, -body.finger_damping, body.finger_stiffness, body.finger_damping
            finger[2:4] += np.array([body.pad_stiffness, body.pad_damping]) * body.ratio
            finger[n] = -body.finger_stiffness * body.shift
            a[2, 3] = 1.0
            a[3] = a[1] - finger
            if held:
                a[3, 1] = 0.0
        if body.coil > 0.0:
            at = 4 if body.ratio > 0.0 else 2
            a[at, 1], a[at, at] = (0.0 if held else 1.0), -body.coil_rate
        if body.lag > 0.0:
            a[n - 1, n - 1], a[n - 1, n + 1] = -body.lag, body.lag
        return a

    def level(self) -> float:
        """How far the torque is from the friction level; below 0 where that holds the knob."""
        return float(abs(self.pull() @ self.z) - self.body.friction)

    def room(self) -> float:
        """Distance to the nearer corner of the slope."""
        middle = self.body.cogs[CENTRE] + self.slope * self.body.cogs[LENGTH]
        return float(0.5 * self.body.cogs[LENGTH] - abs(self.z[0] - middle))

    def way(self) -> int:
        if self.z[1] != 0.0:
            return 1 if self.z[1] > 0.0 else -1
        if self.level() <= 0.0:
            return 0
        return 1 if self.pull() @ self.z > 0.0 else -1

    def ended(self, z: Array) -> int:
        """Which end a state is past, in the mode that the motion is in."""
        if self.mode == 0:
            return TURNED if abs(self.pull() @ z) > self.body.friction else 0
        if self.mode != FREE and z[1] * self.mode < 0.0:
            return TURNED
        away = z[0] - (self.body.cogs[CENTRE] + self.slope * self.body.cogs[LENGTH])
        if abs(away) > 0.5 * self.body.cogs[LENGTH] and away * z[1] > 0.0:
            return RISEN if away > 0.0 else FALLEN
        return 0

    def pass_on(self, end: int) -> None:
        """Slope and mode after an end."""
        if end == TURNED:
            if self.mode == 0:
                self.mode = 1 if self.pull() @ self.z > 0.0 else -1
            else:
                self.z[1] = 0.0
                self.mode = self.way()
        else:
            self.slope += 1.0 if end == RISEN else -1.0

    def move(self, steps: int, most: int = 1000) -> list[Event]:
        """Go on for so many steps of 1/64 of a sample, or ends of modes; the events."""
        for _ in range(steps):
            left = 1.0 / STEPS
            over = expm(self.rates() * left)
            while self.ended(over @ self.z):
                low, high = 0.0, 1.0
                a = self.rates() * left
                for _ in range(HALVINGS):
                    middle = 0.5 * (low + high)
                    if self.ended(expm(a * middle) @ self.z):
                        high = middle
                    else:
                        low = middle
                z = expm(a * high) @ self.z
                end = self.ended(z)
                self.z = z
                self.time += high * left
                self.pass_on(end)
                self.events.append(Event(self.time, end, self.z[:-2].copy(), self.slope, self.mode))
                if len(self.events) == most:
                    return self.events
                left *= 1.0 - high
                over = expm(self.rates() * left)
            self.z = over @ self.z
            self.time += left
        return self.events

    @property
    def state(self) -> Array:
        return np.array(self.z[:-2])


def begun(body: Body, chance: Any) -> tuple[list[float], float]:
    """A state anywhere, still or not, and a torque that moves it on."""
    length = body.cogs[LENGTH]
    fast = length * 10.0 ** chance.uniform(-0.5, 1.0)
    x = body.cogs[CENTRE] + chance.uniform(-3.0, 3.0) * length
    z = [x, chance.gauss(0, fast)]
    if body.ratio > 0.0:
        z += [chance.gauss(0, 0.2 * length), chance.gauss(0, fast)]
    z += [chance.gauss(0, 0.2 * length)] * (body.coil > 0.0)
    if chance.random() < 0.3:
        z[1] = 0.0
    z += [0.0] * (body.lag > 0.0)
    known = Cogged(body, z, 0.0)
    balance = -float(known.pull() @ known.z)  # under which it stands, if it does
    near, far = 2.0 * body.friction + 0.01, 3.0
    u = balance + chance.gauss(0, chance.choice([near, far]))
    if body.lag > 0.0:
        z[-1] = balance + chance.gauss(0, chance.choice([0.3 * body.friction + 0.01, far]))
    return z, u


def by_hand(alpha: float = 1.0, beta: float = 1.0, friction: float = 0.0, push: float = 0.0, cogs: Any = None) -> Body:
    """A body of second order in counts and samples, with numbers of cogs that its matrices know nothing of."""
    made = {
        "knob": {"inertia": 1.0, "damping": alpha, "coulomb_torque": friction},
        "hand": {"stiffness": beta},
        "wall": {"stiffness": 0.0},
    }
    plain = SceneSpec.model_validate(made).plain()
    one = make_body(plain, period=1.0, quantum=1.0, shift=0.0, split=0.0)[0]
    return one._replace(push=abs(push), drive=-push, cogs=cogs)


class Case:
    """One motion over a time of so many 64ths of a sample, and what the exponentials make of it.

    ``slow``: whether friction may stop it within the sample, and exceed the torque.
    """

    def __init__(self, name: str, seed: int, *, ways: bool = False, slow: bool = False) -> None:
        self.body = body_of(name)
        chance = Random(f"{name} {seed}")
        self.z, self.u = begun(self.body, chance)
        if slow:
            self.z[1] = chance.gauss(0, 0.3 * self.body.friction)
            known = Cogged(self.body, self.z, 0.0)
            if self.body.lag > 0.0:
                known.z[-3] = 0.0
            self.u = chance.gauss(0, self.body.friction) - float(known.pull() @ known.z)
            if self.body.lag > 0.0:
                self.z[-1] = self.u
        self.steps = chance.choice([1, 24, 63, 64, 64, 64])
        self.ways = ways
        self.known = self.begin()
        self.events = self.known.move(self.steps)
        self.end = self.known.state
        self.size = 1.0 + float(np.abs(self.end).max())
        self.pad = [0.0] * (4 * self.body.order)

    def begin(self) -> Cogged:
        return Cogged(self.body, self.z, self.u, ways=self.ways)

    @property
    def span(self) -> float:
        return self.steps / 64.0

    def near(self, found: Any, expected: Any) -> bool:
        n = self.body.order
        return bool(np.abs(np.array(found[:n]) - np.array(expected[:n])).max() <= CLOSE * self.size)


@cache
def case_of(name: str, seed: int, ways: bool) -> Case:
    return Case(name, seed, ways=ways)


# By hand: slopes of 1/4, 8 counts long, the stable one about a place of rest at 0, the next one about 8.
COGS = [0.25, 8.0, 0.0, 1.0, 0.5, 8.0]
PLAIN = by_hand(cogs=COGS)
RUBS = by_hand(friction=2.0, cogs=COGS)


class Script:
    """Ends of modes as they are written down: time, end; then position and speed of the knob."""

    def __init__(self, patch: Any, module: Any, steps: list[tuple[float, int, float, float]]) -> None:
        self.steps, self.asked = steps, list[Any]()
        patch.setattr(module, "roll", self.roll)

    def roll(self, z: Any, u: float, slope: float, mode: int, left: float, fresh: bool, body: Body, pad: Any) -> Any:
        self.asked.append((slope, mode, left, fresh))
        t, end, z[0], z[1] = self.steps[len(self.asked) - 1]
        return t, end
