"""Knob, hand and actuator of the 60-digit model (`general_reference`): exact motion between the events of friction.

The state is z = (theta_b, omega_b, theta_a, omega_a, tau, u, 1, i): knob, finger (absent from a hand of second order),
torque on the knob, command, the constant that carries bias and friction, and the current of a winding (absent from most
scenes; L di/dt + R i = V - Kt omega_b, V = u R / Kt where it is driven). Within a hold, between the events of friction,
dz/dt = A z; exp(A t) is one matrix exponential (kept for durations that recur) or, for a short time to or from an
event, its Taylor series. A gear that yields is knob and finger, too: the motor over the ratio, and knob and hand behind
the mesh, with the push on them. On each slope of its triangle cogging is one more spring to ground, with a neutral
angle of its own.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import sqrt
from operator import mul
from typing import Any

from tests import digits as mp

Vector = tuple[Any, ...]

KNOB, SPEED, FINGER, FINGER_SPEED, TORQUE, COMMAND, ONE, CURRENT = range(8)
UP, DOWN, STUCK = 1, -1, 0
BITS = 400  # after the point of the whole numbers that a Taylor series is summed in: 120 digits of an angle in radians
KEPT = 6  # of a step that recurs, the halvings whose matrices are kept
CLOCK = 1e-3  # time unit of that sum [s]: with it all of a state is of the order of its angles


def dot(row: list[tuple[int, Any]], z: Vector) -> Any:
    """Product of a sparse row and a vector."""
    total = mp.zero
    for j, value in row:
        total += value * z[j]
    return total


def powers(x: int, count: int) -> list[int]:
    """1, x, x^2, ... in fixed point."""
    found = [mp.whole(mp.ldexp(mp.one, BITS))]
    while len(found) < count:
        found.append(found[-1] * x >> BITS)
    return found


def horner(coefficients: list[int], x: int) -> int:
    """Value at ``x`` of a polynomial, lowest coefficient first, in fixed point."""
    value = 0
    for c in reversed(coefficients):
        value = (value * x >> BITS) + c
    return value


class NotHandledError(Exception):
    """A motion that is not generic, which this model does not follow."""


@dataclass(frozen=True)
class Bodies:
    """Knob, hand and actuator, in SI units; ``lag`` 0: the torque is the command. Finger terms 0 without a finger."""

    inertia: Any
    damping: Any
    stiffness: Any
    friction: Any
    bias: Any
    lag: Any
    finger: bool = False
    finger_inertia: Any = 1
    finger_damping: Any = 0
    finger_stiffness: Any = 0
    pad_damping: Any = 0
    pad_stiffness: Any = 0
    torque_constant: Any = 0  # of a winding with inductance; 0 without one
    resistance: Any = 1
    inductance: Any = 1
    driven: bool = False  # by a voltage; else it is shorted
    push: Any = 0  # of the user on the finger
    play: Any = 0  # of teeth between knob and finger [rad]
    cogs: tuple[Any, Any, Any] | None = None  # peak [N m], periods a turn, and an angle of rest [rad]
    _kept: dict[Any, Any] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def torque_sum(self) -> list[tuple[int, Any]]:
        """Row of the sum of torques on the knob other than friction and those of its own velocity."""
        return [
            (KNOB, -(self.stiffness + self.pad_stiffness)),
            (FINGER, self.pad_stiffness),
            (FINGER_SPEED, self.pad_damping),
            (TORQUE, mp.mpf(0 if self.driven else 1)),
            (ONE, -self.bias),
            (CURRENT, self.torque_constant),
        ]

    @cached_property
    def rows(self) -> dict[int, list[list[tuple[int, Any]]]]:
        """A for each mode, as sparse rows."""
        lag = [(TORQUE, -1 / self.lag), (COMMAND, 1 / self.lag)] if self.lag else []
        finger: list[list[tuple[int, Any]]] = [[], []]
        if self.finger:
            j = self.finger_inertia
            finger = [
                [(FINGER_SPEED, mp.mpf(1))],
                [
                    (KNOB, self.pad_stiffness / j),
                    (SPEED, self.pad_damping / j),
                    (FINGER, -(self.finger_stiffness + self.pad_stiffness) / j),
                    (FINGER_SPEED, -(self.finger_damping + self.pad_damping) / j),
                    (ONE, -self.push / j),
                ],
            ]
        own: list[tuple[int, Any]] = []
        if self.torque_constant:
            own = [(CURRENT, -self.resistance / self.inductance)]
        if self.driven:
            own.append((COMMAND, self.resistance / self.torque_constant / self.inductance))
        made: dict[int, list[list[tuple[int, Any]]]] = {STUCK: [[], [], *finger, lag, [], [], own]}
        own = [*own, (SPEED, -self.torque_constant / self.inductance)]
        for sign in (UP, DOWN):
            speed = [(j, value / self.inertia) for j, value in self.torque_sum]
            speed.append((SPEED, -(self.damping + self.pad_damping) / self.inertia))
            speed.append((ONE, -sign * self.friction / self.inertia))
            made[sign] = [[(SPEED, mp.mpf(1))], speed, *finger, lag, [], [], own]
        return {mode: [[(j, v) for j, v in row if v != 0] for row in table] for mode, table in made.items()}

    @cached_property
    def teeth(self) -> dict[int, "Bodies"]:
        """The bodies on each flank: 1 and -1, and 0 with teeth that do not press."""
        loose = replace(self, pad_damping=mp.zero, pad_stiffness=mp.zero, play=mp.zero, _kept={})
        away = self.pad_stiffness * self.play  # what the other flank presses less than this one would
        back = replace(self, bias=self.bias + away, push=self.push - away, play=mp.zero, _kept={})
        return {1: replace(self, play=mp.zero, _kept={}), 0: loose, -1: back}

    def presses(self, z: Vector, flank: int) -> bool:
        """Whether teeth press on a flank: they overlap, and their spring and damper do not pull."""
        turn, rate = z[KNOB] - z[FINGER], z[SPEED] - z[FINGER_SPEED]
        overlap = turn if flank > 0 else -(turn + self.play)
        return bool(overlap > 0 and self.pad_stiffness * overlap + flank * self.pad_damping * rate > 0)

    def slope(self, theta: Any) -> int:
        """Number of the slope of the triangle at an angle; the even ones fall, to an angle of rest and beyond it."""
        assert self.cogs
        _, often, rest = self.cogs
        return int(mp.floor((theta - rest) * often / mp.pi + mp.mpf(1) / 2))

    def on(self, slope: int) -> "Bodies":
        """The bodies with the spring of a slope in place of cogging."""
        assert self.cogs
        kept: dict[Any, Bodies] = self._kept.setdefault("slopes", {})
        if slope not in kept:
            peak, often, rest = self.cogs
            spring = peak / (mp.pi / often / 2) * (-1) ** slope
            neutral = rest + slope * mp.pi / often
            kept[slope] = replace(
                self, stiffness=self.stiffness + spring, bias=self.bias - spring * neutral, cogs=None, _kept={}
            )
        return kept[slope]

    def rate(self, mode: int, z: Vector) -> Vector:
        """A z."""
        return tuple(dot(row, z) if row else mp.zero for row in self.rows[mode])

    @cached_property
    def fastest(self) -> float:
        """Bound of the growth of Taylor terms [1/s]: a norm of A with velocities in units that balance it."""
        roots = [(self.stiffness + self.pad_stiffness) / self.inertia]
        own = [(self.damping + self.pad_damping) / self.inertia]
        if self.finger:
            roots.append((self.finger_stiffness + self.pad_stiffness) / self.finger_inertia)
            own.append((self.finger_damping + self.pad_damping) / self.finger_inertia)
            root = self.pad_stiffness / mp.sqrt(self.inertia * self.finger_inertia)
            roots.append(root)
            own.append(self.pad_damping / mp.sqrt(self.inertia * self.finger_inertia))
        if self.lag:
            own.append(1 / self.lag)
        if self.torque_constant:
            own.append(self.resistance / self.inductance)
            roots.append(self.torque_constant**2 / self.inductance / self.inertia)
        return float(2 * (mp.fsum(mp.sqrt(abs(root)) for root in roots) + mp.fsum(own)))

    def move(self, mode: int, z: Vector, duration: Any, *, recurs: bool) -> Vector:
        """exp(A t) z; a matrix for a duration that ``recurs`` and has been met before, kept, else a Taylor series."""
        key = (mode, duration)
        if recurs and key in self._kept:
            kept = self._kept[key] = self._kept[key] or self._exponential(mode, duration)
            return tuple(dot(row, z) if row else mp.zero for row in kept)
        if recurs:
            self._kept[key] = None
        parts = 1 + int(self.fastest * float(duration) / 8)
        if parts > 40:
            return tuple(dot(row, z) for row in self._exponential(mode, duration))
        for _ in range(parts):
            terms = self.series(mode, z, duration / parts)
            z = self.at(z, list(zip(*terms, strict=True)), powers(1 << BITS, len(terms)))
        return z

    def _exponential(self, mode: int, duration: Any) -> list[list[tuple[int, Any]]]:
        with mp.extradps(30):  # squaring loses digits when a hold is many time constants
            a = mp.matrix(8, 8)
            for i, row in enumerate(self.rows[mode]):
                for j, value in row:
                    a[i, j] += value * duration
            e = mp.expm(a)
        return [[(j, +e[i, j]) for j in range(8) if e[i, j] != 0] for i in range(8)]

    @cached_property
    def units(self) -> Vector:
        """Factors that turn a state into angles, for sums in fixed point."""
        turn = mp.mpf(CLOCK) ** 2 / self.inertia
        current = turn * self.torque_constant if self.torque_constant else mp.one
        return (mp.one, mp.mpf(CLOCK), mp.one, mp.mpf(CLOCK), turn, turn, mp.one, current)

    @cached_property
    def _whole_rows(self) -> dict[int, list[list[tuple[int, int]]]]:
        """A per ``CLOCK``, between states as angles, in fixed point."""
        with mp.workdps(BITS // 3):
            return {
                mode: [
                    [(j, mp.whole(mp.ldexp(v * self.units[i] / self.units[j] * CLOCK, BITS))) for j, v in row]
                    for i, row in enumerate(table)
                ]
                for mode, table in self.rows.items()
            }

    def series(self, mode: int, z: Vector, step: Any, least: int = 1 << 20) -> list[list[int]]:
        """Terms A^k z step^k / k!, as angles in fixed point, until three are at most ``least``."""
        rows, factor = self._whole_rows[mode], mp.whole(mp.ldexp(step / mp.mpf(CLOCK), BITS))
        term = [mp.whole(mp.ldexp(x * unit, BITS)) for x, unit in zip(z, self.units, strict=True)]
        terms, quiet = [term], 0
        for k in range(1, 1000):
            term = [((sum([v * term[j] for j, v in row]) >> BITS) * factor >> BITS) // k for row in rows]
            terms.append(term)
            quiet = quiet + 1 if max(map(abs, term)) <= least else 0
            if quiet == 3:
                return terms
        raise AssertionError("Taylor series too long")

    def at(self, z: Vector, columns: list[tuple[int, ...]], x: list[int]) -> Vector:
        """State at a part of a series' step, given by its powers ``x``, with the constants of ``z``.

        ``columns``: the terms of each number of the state.
        """
        moving = (*range(5), CURRENT)
        sums = [mp.ldexp(mp.mpf(sum(map(mul, columns[i], x))), -2 * BITS) / self.units[i] for i in moving]
        return (*sums[:5], *z[5:CURRENT], sums[5])

    def energy_root(self, mode: int, w: Vector) -> float:
        """Root of twice the energy of a motion ``w`` without inputs; it does not grow while its torque is 0."""
        inertia, pad = float(self.inertia), float(self.pad_stiffness)
        x = [float(value) for value in w[:5]]
        twice = float(self.stiffness) * x[0] ** 2
        if mode != STUCK:
            twice += inertia * x[1] ** 2
        if self.finger:
            twice += float(self.finger_inertia) * x[3] ** 2 + pad * (x[2] - x[0]) ** 2
            twice += float(self.finger_stiffness) * x[2] ** 2
        if self.torque_constant:
            twice += float(self.inductance) * float(w[CURRENT]) ** 2
        return sqrt(twice)

    def speed_bound(self, mode: int, w: Vector, duration: float) -> float:
        """Bound of |omega_b| over ``duration`` for a motion ``w`` (a derivative of the state, so without constants)."""
        fed = abs(float(w[TORQUE])) * min(duration, float(self.lag) or duration) / sqrt(float(self.inertia))
        return 1.0001 * (self.energy_root(mode, w) + fed) / sqrt(float(self.inertia))

    def sum_bound(self, w: Vector) -> float:
        """Bound from now on of the torque sum's rate for such a motion of a stuck knob."""
        root = self.energy_root(STUCK, w) if self.finger else 0.0
        by_speed = float(self.pad_damping) / sqrt(float(self.finger_inertia))
        springs = float(self.pad_stiffness + self.finger_stiffness)
        by_angle = float(self.pad_stiffness) / sqrt(springs) if springs > 0 else 0.0
        wound = abs(float(self.torque_constant) * float(w[CURRENT]))
        return 1.0001 * (abs(float(w[TORQUE])) + wound + (by_speed + by_angle) * root)
