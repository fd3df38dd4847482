"""A 60-digit model of the whole scene: friction with stick, finger, lag, delay, torque step, limit, virtual damping.

It shares no formula with the package and imports nothing from it: both are built from the ``scene`` of a spec, a plain
dictionary. The state is z = (theta_b, omega_b, theta_a, omega_a, tau, u, 1, i): knob, finger (absent from a hand of
second order), torque on the knob, command, the constant that carries bias and friction, and the current of a winding
(absent from most scenes; L di/dt + R i = V - Kt omega_b, V = u R / Kt where it is driven). Within a hold, between the
events of friction, dz/dt = A z; exp(A t) is one matrix exponential (kept for durations that recur) or, for a short
time to or from an event, its Taylor series.

Coulomb friction switches between three matrices: knob turning up, turning down, and stuck. The knob sticks where its
velocity is 0 and the sum of the other torques on it is at most the friction; it is released where that sum exceeds it.
Both events are zeros of a component f(t) of the state. *All* zeros in a hold are found, by exclusion, not by sampling:
an interval of length h with ``|f| > h max|f'|`` at its left end has none, one with ``|f'| > h max|f''|`` at most
one, which shows in the signs at its ends, and any other interval is halved. The maxima come from the energy of the
derivatives' motion, which passive bodies cannot gain and which only the lag, decaying, can feed.

A gear that yields is knob and finger, too: the motor over the ratio, and knob and hand behind the mesh, with the push
on them. Teeth with play press on one flank, on the other, or on none, so that each mode of friction is three.
Their events are bracketed by halving a step, and no zeros are excluded: what begins and ends within a step is missed. A
step is at most 1/64 of a sample, and a quarter of what the fastest body takes for a radian: teeth of a stiff mesh part
for less than the former. Cogging is followed so, too: on each slope of its triangle it is one more spring to ground,
with a neutral angle of its own.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import sqrt
from operator import mul
from typing import Any

from tests import digits as mp

from .over_angle_reference import along_angle, jumps, over_angle

Vector = tuple[Any, ...]

KNOB, SPEED, FINGER, FINGER_SPEED, TORQUE, COMMAND, ONE, CURRENT = range(8)
UP, DOWN, STUCK = 1, -1, 0
BITS = 400  # after the point of the whole numbers that a Taylor series is summed in: 120 digits of an angle in radians
KEPT = 6  # of a step that recurs, the halvings whose matrices are kept
CLOCK = 1e-3  # time unit of that sum [s]: with it all of a state is of the order of its angles


def _dot(row: list[tuple[int, Any]], z: Vector) -> Any:
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


def _horner(coefficients: list[int], x: int) -> int:
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
        return tuple(_dot(row, z) if row else mp.zero for row in self.rows[mode])

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
            return tuple(_dot(row, z) if row else mp.zero for row in kept)
        if recurs:
            self._kept[key] = None
        parts = 1 + int(self.fastest * float(duration) / 8)
        if parts > 40:
            return tuple(_dot(row, z) for row in self._exponential(mode, duration))
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


@dataclass
class Friction:
    """The knob's motion through holds, event by event.

    ``mode``: turning up, down, or stuck. ``stops`` counts reversals and sticks, ``releases`` the others; ``closest`` is
    the least distance from the friction, relative to it, at which the knob stuck, reversed or rested: where it is not
    far above an engine's rounding, whether it sticks is not decided by the physics. ``turns``: angles of reversals.
    """

    bodies: Bodies
    period: Any
    z: Vector
    mode: int = UP
    stops: int = 0
    sticks: int = 0
    releases: int = 0
    closest: float = float("inf")
    turns: list[Any] = field(default_factory=list)
    find_turns: bool = False
    flank: int = 1
    slope: int = 0  # of cogging
    parted: int = 0  # times that teeth have, or that a slope has ended

    def hold(self, command: Any, duration: Any) -> None:
        """Move through one hold of ``command``."""
        bodies = self.bodies
        torque = self.z[TORQUE] if bodies.lag else command
        self.z = (*self.z[:4], torque, command, mp.one, self.z[CURRENT])
        if bodies.play or bodies.cogs:
            self._hold_in_steps(duration)
            return
        if bodies.friction == 0 and not self.find_turns:
            self.mode = UP
            self.z = bodies.move(UP, self.z, duration, recurs=True)
            return
        passed, whole = mp.zero, True
        if self.z[SPEED] == 0:
            self._start()
            if self.mode != STUCK:
                passed = self._leave(duration, order=1)
                whole = passed == 0
        else:
            self.mode = UP if self.z[SPEED] > 0 else DOWN
        while passed < duration:
            left = duration - passed
            moved = self._to_event(left, whole)
            whole = False
            if moved is None:
                return
            passed += moved
            if self.mode == STUCK:
                self.releases += 1
                self.mode = UP if self._sum() > 0 else DOWN
                passed += self._leave(duration - passed, order=2)
            else:
                self.stops += 1
                self.turns.append(self.z[KNOB])
                self._start()
                if self.mode != STUCK:
                    passed += self._leave(duration - passed, order=1)
                else:
                    self.sticks += 1

    def _hold_in_steps(self, duration: Any) -> None:
        """Step by step, each halved where it brings an event."""
        flanks = [flank for flank in (1, -1) if self.bodies.presses(self.z, flank)]
        self.flank = flanks[0] if flanks else 0
        if self.bodies.cogs:
            self.slope = self.bodies.slope(self.z[KNOB])
        if self.z[SPEED] == 0:
            self._start()
        else:
            self.mode = UP if self.z[SPEED] > 0 else DOWN
        swings = float(self.period) * self.bodies.fastest if self.bodies.play else 0.0
        step = self.period / int(mp.ceil(max(64, 4 * swings)))
        for _ in range(int(mp.floor(duration / step))):
            self._step(step, 0, recurs=True)
            duration -= step
        if duration > 0:
            self._step(duration, 0, recurs=False)

    def _step(self, step: Any, level: int, *, recurs: bool) -> None:
        then = self._acting().move(self.mode, self.z, step, recurs=recurs and level < KEPT)
        turned, sprung, passed = self._events(then)
        if not turned and not sprung and not passed:
            self.z = then
        elif level < 60:
            self._step(step / 2, level + 1, recurs=recurs)
            self._step(step / 2, level + 1, recurs=recurs)
        else:
            self.z = then
            if passed:
                self.parted += 1
                self.slope += 1 if then[SPEED] > 0 else -1
            if sprung:
                self.parted += self.flank != 0
                self.flank = 0 if self.flank else (1 if self.bodies.presses(then, 1) else -1)
            if turned and self.mode != STUCK:
                self.stops += 1
                self.turns.append(then[KNOB])
                self._start()
                if self.mode == STUCK:  # else it keeps what speed it has: a motion is smooth in where it began
                    self.z = (then[KNOB], mp.zero, *then[2:])
                    self.sticks += 1
            elif turned:
                self.releases += 1
                self.mode = UP if self._sum() > 0 else DOWN
            elif self.mode == STUCK:
                self._start()

    def _acting(self) -> Bodies:
        bodies = self.bodies.on(self.slope) if self.bodies.cogs else self.bodies
        return bodies.teeth[self.flank] if bodies.play else bodies

    def _events(self, z: Vector) -> tuple[bool, bool, bool]:
        """Whether the knob has turned round, or is released; whether teeth have met or parted; and a slope ended."""
        sprung = passed = False
        if self.bodies.cogs:
            there = self.bodies.slope(z[KNOB])
            passed = there > self.slope if z[SPEED] > 0 else there < self.slope
        if not self.bodies.play:
            pass
        elif self.flank:
            sprung = not self.bodies.presses(z, self.flank)
        else:
            sprung = self.bodies.presses(z, 1) or self.bodies.presses(z, -1)
        if self.mode == STUCK:
            return abs(_dot(self._acting().torque_sum, z)) > self.bodies.friction, sprung, passed
        return z[SPEED] * self.mode < 0, sprung, passed

    def _sum(self) -> Any:
        return _dot(self._acting().torque_sum, self.z)

    def _start(self) -> None:
        """Set the mode of a knob at rest."""
        torque, friction = self._sum(), self.bodies.friction
        if friction:
            self.closest = min(self.closest, float(abs(abs(torque) / friction - 1)))
        self.mode = STUCK if abs(torque) <= friction else UP if torque > 0 else DOWN

    def _leave(self, left: Any, order: int) -> Any:
        """Move from rest to where the velocity is certainly not 0 again; the time that takes.

        omega = c t^order/order! + ..., its next derivative bounded by m: no zero before (order + 1) c/m.
        """
        w = self.bodies.rate(self.mode, self.z)
        for _ in range(order - 1):
            w = self.bodies.rate(self.mode, w)
        lead = w[SPEED] * self.mode
        assert lead > 0, "released without being pushed: not generic, and not handled"
        bound = self.bodies.speed_bound(self.mode, self.bodies.rate(self.mode, w), float(left))
        step = min(left, (order + 1) * lead / (2 * mp.mpf(bound))) if bound else left
        self.z = self.bodies.move(self.mode, self.z, step, recurs=False)
        return step

    def _to_event(self, left: Any, whole: bool) -> Any:
        """Move to the next event and give the time that takes; None where there is none, having moved all ``left``."""
        bodies, mode = self.bodies, self.mode
        if mode == STUCK and not (bodies.finger or bodies.lag or bodies.torque_constant):
            return None
        grid = self.period / 2 ** int(mp.ceil(mp.log2(self.period / left))) if not whole else left
        pieces = [(self.z, left, True)] if whole else [(self.z, min(grid, left), grid <= left)]
        done = mp.zero
        while True:
            z, length, recurs = pieces.pop()
            found, end = self._look(z, length, recurs)
            if found == "halve":
                if not length > left * mp.mpf(10) ** -25:
                    raise NotHandledError("velocity and acceleration vanish together")
                middle = bodies.move(mode, z, length / 2, recurs=recurs)
                pieces += [(middle, length / 2, recurs), (z, length / 2, recurs)]
                continue
            if found == "inside":
                offset, self.z = self._refine(z, length, recurs)
                return done + offset
            done += length
            if not pieces:
                if done >= left or left - done < left * mp.mpf(10) ** -58:
                    self.z = end
                    return None
                rest = left - done
                while grid > rest and grid > self.period / 64:
                    grid /= 2
                pieces = [(end, grid, True) if grid <= rest else (end, rest, False)]

    def _functions(self, z: Vector) -> list[Any]:
        """What is positive until the event."""
        if self.mode != STUCK:
            return [z[SPEED] * self.mode]
        torque = _dot(self.bodies.torque_sum, z)
        return [self.bodies.friction - torque, self.bodies.friction + torque]

    def _look(self, z: Vector, length: Any, recurs: bool) -> tuple[str, Vector | None]:
        """Whether an event lies ``inside`` the interval after ``z``, certainly not, or the interval is to ``halve``."""
        bodies, mode = self.bodies, self.mode
        v = bodies.rate(mode, z)
        h = float(length)
        values = self._functions(z)
        least = float(min(values))
        first = bodies.sum_bound(v) if mode == STUCK else bodies.speed_bound(mode, v, h)
        if least > first * h:
            return "none", bodies.move(mode, z, length, recurs=recurs)
        w = bodies.rate(mode, v)
        second = bodies.sum_bound(w) if mode == STUCK else bodies.speed_bound(mode, w, h)
        slope = float(_dot(bodies.torque_sum[:-1], v)) if mode == STUCK else float(v[SPEED])
        if not abs(slope) > second * h * 1.0001:
            # A stuck knob's two functions have the same slope except for its sign: monotone together.
            return "halve", None
        end = bodies.move(mode, z, length, recurs=recurs)
        return ("inside" if min(self._functions(end)) < 0 else "none"), end

    def _refine(self, z: Vector, length: Any, recurs: bool) -> tuple[Any, Vector]:
        """Time of the only zero after ``z`` within ``length``, where f is monotone, and the state there."""
        bodies, mode = self.bodies, self.mode
        offset = mp.zero
        while bodies.fastest * float(length) > 2:
            length /= 2
            middle = bodies.move(mode, z, length, recurs=recurs)
            if min(self._functions(middle)) > 0:
                z, offset = middle, offset + length
        terms = bodies.series(mode, z, length)
        if mode == STUCK:
            # Of the two functions, the one that falls.
            sign = -1 if _dot(bodies.torque_sum[:-1], bodies.rate(mode, z)) > 0 else 1
            row = [(j, sign * v / bodies.units[j]) for j, v in bodies.torque_sum]
            start = bodies.friction
        else:
            row, start = [(SPEED, mp.mpf(mode))], mp.zero
        whole = [(j, mp.whole(mp.ldexp(v, BITS))) for j, v in row]
        f = [sum(v * term[j] for j, v in whole) >> BITS for term in terms]
        f[0] += mp.whole(mp.ldexp(start, BITS))
        slope = [k * c for k, c in enumerate(f)][1:]
        low, high = 0, 1 << BITS
        x = high // 2
        for _ in range(400):
            value = _horner(f, x)
            low, high = (x, high) if value > 0 else (low, x)
            incline = _horner(slope, x)
            following = x - (value << BITS) // incline if incline else low
            if not low < following < high:
                following = (low + high) // 2
            done, x = abs(following - x) < 1 << (BITS - 230), following  # 2^-230 of the bracket: 69 digits
            if done:
                break
        else:
            raise AssertionError("no zero found in the bracket")
        state = list(bodies.at(z, list(zip(*terms, strict=True)), powers(x, len(terms))))
        if mode != STUCK:
            state[SPEED] = mp.zero
        return offset + mp.ldexp(mp.mpf(x), -BITS) * length, tuple(state)


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
