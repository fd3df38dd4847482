"""The motion of the 60-digit model (`general_reference`) through a hold: friction with stick, teeth, cogging.

Coulomb friction switches between three matrices: knob turning up, turning down, and stuck. The knob sticks where its
velocity is 0 and the sum of the other torques on it is at most the friction; it is released where that sum exceeds it.
Both events are zeros of a component f(t) of the state. *All* zeros in a hold are found, by exclusion, not by sampling:
an interval of length h with ``|f| > h max|f'|`` at its left end has none, one with ``|f'| > h max|f''|`` at most
one, which shows in the signs at its ends, and any other interval is halved. The maxima come from the energy of the
derivatives' motion, which passive bodies cannot gain and which only the lag, decaying, can feed.

Teeth with play press on one flank, on the other, or on none, so that each mode of friction is three.
Their events are bracketed by halving a step, and no zeros are excluded: what begins and ends within a step is missed. A
step is at most 1/64 of a sample, and a quarter of what the fastest body takes for a radian: teeth of a stiff mesh part
for less than the former. Cogging is followed so, too, from slope to slope.
"""

from dataclasses import dataclass, field
from typing import Any

from tests import digits as mp

from .reference_bodies import (
    BITS,
    CURRENT,
    DOWN,
    KEPT,
    KNOB,
    SPEED,
    STUCK,
    TORQUE,
    UP,
    Bodies,
    NotHandledError,
    Vector,
    dot,
    horner,
    powers,
)


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
            return abs(dot(self._acting().torque_sum, z)) > self.bodies.friction, sprung, passed
        return z[SPEED] * self.mode < 0, sprung, passed

    def _sum(self) -> Any:
        return dot(self._acting().torque_sum, self.z)

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
        """Move to the next event: the time that takes. None if there is no event; all of ``left`` is over then."""
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
        torque = dot(self.bodies.torque_sum, z)
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
        slope = float(dot(bodies.torque_sum[:-1], v)) if mode == STUCK else float(v[SPEED])
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
            sign = -1 if dot(bodies.torque_sum[:-1], bodies.rate(mode, z)) > 0 else 1
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
            value = horner(f, x)
            low, high = (x, high) if value > 0 else (low, x)
            incline = horner(slope, x)
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
