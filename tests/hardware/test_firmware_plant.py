"""The target's simulated knob: against 40 digits, events found by a fine net and bisection, and the person's formulas.

The tolerance is 1e-12 of the greatest angle, and of the greatest speed: a sample costs some ten roundings of 1.1e-16 of
these, and what comes of them dies away (friction and damping only bring two motions closer), within some hundred
samples in the least damped scene here.
"""

import ctypes as c
import math
from typing import Any

import numpy as np
import pytest

from hknob_cli.hardware.port import Simulated, Sine
from tests import digits as mp
from tests.hardware.firmware import CSimulated, library

TOLERANCE = 1e-12
NET = 48  # points of the net over half a turn


def followed(simulated: Simulated, interval_s: float, torques: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles and speeds of the target's knob."""
    angle, speed = np.zeros(torques.size + 1), np.zeros(torques.size + 1)
    place = [array.ctypes.data for array in (np.ascontiguousarray(torques), angle, speed)]
    assert library().scripted_follow(c.byref(CSimulated.of(simulated)), interval_s, torques.size, *place)
    return angle, speed


class Reference:
    """One knob at 40 digits, time in seconds; of a motion one way by the matrix exponential or its eigenvalues."""

    def __init__(self, simulated: Simulated, interval_s: float) -> None:
        self.j, self.b, self.k, self.level, self.angle = (mp.mpf(x) for x in simulated[:5])
        self.speed, self.interval = mp.mpf(0), mp.mpf(interval_s)
        root = mp.sqrt(mp.mpc((self.b / self.j) ** 2 / 4 - self.k / self.j))
        self.roots = -self.b / self.j / 2 + root, -self.b / self.j / 2 - root
        self.tables: dict[Any, Any] = {}

    def moved(self, torque: Any, t: Any) -> tuple[Any, Any]:
        """Angle and speed after a time under a constant torque, friction not counted."""
        if t not in self.tables:
            self.tables = {
                t: mp.expm(mp.matrix([[0, 1, 0], [-self.k / self.j, -self.b / self.j, 1 / self.j], [0, 0, 0]]) * t)
            }
        state = self.tables[t] * mp.matrix([self.angle, self.speed, torque])
        return state[0], state[1]

    def speed_after(self, torque: Any, t: Any) -> Any:
        """The speed alone, by eigenvalues."""
        r, s = self.roots
        pull = (torque - self.k * self.angle - self.b * self.speed) / self.j
        first = (pull - s * self.speed) / (r - s)
        return mp.re(first * mp.exp(r * t) + (self.speed - first) * mp.exp(s * t))

    def hold(self, torque: float) -> None:
        """On by one interval."""
        left = self.interval
        while left > 0:
            pull = torque - self.k * self.angle
            if self.level == 0:
                self.angle, self.speed = self.moved(mp.mpf(torque), left)
                return
            way = mp.sign(self.speed) if self.speed else mp.sign(pull) if abs(pull) > self.level else 0
            if way == 0:
                return
            other = torque - way * self.level
            t = self._vanishes(other, way, left)
            self.angle, self.speed = self.moved(other, left if t is None else t)
            if t is None:
                return
            self.speed, left = mp.mpf(0), left - t

    def _vanishes(self, torque: Any, way: Any, left: Any) -> Any:
        turn = abs(mp.im(self.roots[0])) / mp.pi
        points = max(4, math.ceil(NET * float(turn * left)))
        before = left * mp.mpf(2) ** -60
        for i in range(1, points + 1):
            t = left * i / points
            if way * self.speed_after(torque, t) < 0:
                low, high = before, t
                for _ in range(120):
                    middle = (low + high) / 2
                    low, high = (middle, high) if way * self.speed_after(torque, middle) > 0 else (low, middle)
                return high
            before = t
        return None


def scene(seed: int) -> tuple[Simulated, float, np.ndarray]:
    """A random knob, interval, and torques with steps such as a wall's, resting points included."""
    rng = np.random.default_rng(seed)
    inertia = 10 ** rng.uniform(-6.5, -5)
    interval = 10 ** rng.uniform(-3.7, -2.5)
    turn = 10 ** rng.uniform(-1.5, 0.9)  # half turns of the free motion in an interval
    stiffness = inertia * (turn * math.pi / interval) ** 2
    ratio = 10 ** rng.uniform(-0.8, 0.8)
    damping = 2.0 * ratio * math.sqrt(inertia * stiffness)
    size = 0.01 * stiffness
    coulomb = size * 10 ** rng.uniform(-2, -0.3) if seed % 3 else 0.0
    torques = np.repeat(size * rng.normal(size=30), rng.integers(1, 6, size=30))
    return Simulated(inertia, damping, stiffness, coulomb, rng.normal() * 0.01, 0.0, 0.0, 0.1, 0.0), interval, torques


@pytest.mark.one_in(2)
@pytest.mark.parametrize("seed", range(18))
def test_motion_is_that_of_40_digits(seed: int) -> None:
    simulated, interval, torques = scene(seed)
    angle, speed = followed(simulated, interval, torques)
    reference = Reference(simulated, interval)
    worst_angle, worst_speed, greatest = 0.0, 0.0, 1e-3
    for i, torque in enumerate(torques):
        reference.hold(float(torque))
        worst_angle = max(worst_angle, abs(float(reference.angle - mp.mpf(angle[i + 1]))))
        worst_speed = max(worst_speed, abs(float(reference.speed - mp.mpf(speed[i + 1]))))
        greatest = max(greatest, abs(float(reference.angle)))
    fastest = max(np.abs(speed).max(), greatest * math.sqrt(simulated.stiffness / simulated.inertia))
    assert worst_angle <= TOLERANCE * greatest
    assert worst_speed <= TOLERANCE * fastest


def test_scenes_stick_slip_and_turn() -> None:
    """The random scenes go through every branch: held, sliding on, stopping for good, turning within a hold."""
    held = moving = 0
    for seed in range(18):
        simulated, interval, torques = scene(seed)
        if simulated.coulomb_nm:
            _, speed = followed(simulated, interval, torques)
            held += int((speed[1:] == 0.0).sum())
            moving += int((speed[1:] != 0.0).sum())
    assert held > 50
    assert moving > 200


def test_critical_damping() -> None:
    """Both roots equal: the speed has the form (a + b t) exp(-r t)."""
    simulated = Simulated(1.0, 2.0, 1.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0)
    angle, speed = followed(simulated, 0.25, np.zeros(40))
    t = 0.25 * np.arange(41)
    assert np.abs(angle - 0.5 * (1 + t) * np.exp(-t)).max() < 1e-15
    assert np.abs(speed + 0.5 * t * np.exp(-t)).max() < 1e-15
    # With friction, from rest at 1, its speed never vanishes: it comes to 0.25 at infinity.
    angle, speed = followed(simulated._replace(coulomb_nm=0.25, angle_rad=1.0), 0.25, np.zeros(40))
    assert np.abs(angle - (0.25 + 0.75 * (1 + t) * np.exp(-t))).max() < 1e-15


def test_without_stiffness_friction_stops_a_throw_where_it_must() -> None:
    """Torque 3 for a second, then none, friction 1, inertia 2: its speed 1 is gone two seconds later, at 0.5 + 1."""
    simulated = Simulated(2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    angle, speed = followed(simulated, 1.0, np.array([3.0, 0.0, 0.0, 0.0, 1.0, -1.0, -1.5]))
    # The last torque exceeds friction by 0.5: a quarter of rad/s^2.
    assert angle.tolist() == [0.0, 0.5, 1.25, 1.5, 1.5, 1.5, 1.5, 1.375]
    assert speed.tolist() == [0.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, -0.25]


def test_a_stop_inside_a_hold_without_stiffness_but_damping() -> None:
    """m v' = -b v - c stops at t = (m / b) ln(1 + b v / c), having gone v m / b - c t / b."""
    simulated = Simulated(1.0, 0.5, 0.0, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0)
    angle, speed = followed(simulated, 1.0, np.array([1.25, 0.0, 0.0, 0.0]))
    v = 2.0 * (1.0 - math.exp(-0.5))
    start = 2.0 * (1.0 - v)
    stops = 2.0 * math.log1p(2.0 * v)
    assert 1.0 < stops < 2.0
    assert speed[1] == pytest.approx(v, rel=1e-14)
    assert angle[1] == pytest.approx(start, rel=1e-14)
    assert speed[3:].tolist() == [0.0, 0.0]
    assert angle[3] == pytest.approx(start + 2.0 * v - 0.5 * stops, rel=1e-14)


def test_too_fast_a_motion_is_refused() -> None:
    simulated = Simulated(1e-12, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    nothing = (c.c_double * 2)()
    assert not library().scripted_follow(c.byref(CSimulated.of(simulated)), 1e-3, 0, nothing, nothing, nothing)


def test_the_person_is_as_described() -> None:
    """A sine's argument of at most 2 pi 10 Hz 3 s + 1 is rounded to 1.4e-14 at most."""
    pushes, grips = (Sine(2e-3, 1.5, 0.3), Sine(1e-4, 9.0, -1.0)), (Sine(0.03, 10.0, 0.5),)
    simulated = Simulated(1e-6, 1e-4, 0.04, 0.0, 0.02, 1e-3, 0.71, 0.2, 0.125, pushes, grips)
    push, grip = np.zeros(3000), np.zeros(3000)
    library().scripted_person(c.byref(CSimulated.of(simulated)), 1e-3, 3000, push.ctypes.data, grip.ctypes.data)
    t = 1e-3 * np.arange(3000)

    def sum_of(sines: tuple[Sine, ...]) -> np.ndarray:
        return sum((s.amplitude * np.sin(math.tau * s.frequency_hz * t + s.phase) for s in sines), np.zeros(t.size))

    assert np.abs(push - np.maximum(0.0, 1e-3 + sum_of(pushes))).max() < 2e-16
    assert (push == 0.0).any()
    assert np.abs(grip - (0.71 * -np.expm1(-t / 0.2) + sum_of(grips) + 0.125)).max() < 2e-15
