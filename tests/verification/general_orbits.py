"""A limit cycle of the whole scene solved again at 60 digits, and its measures by quadrature.

From the package come the period and a state near the orbit. The 60-digit model runs the period; Newton's method, with
differences 1e-30 apart, finds the state at which it closes. Commands under way are never taken from the package where
there is an encoder: they are those that the readings of a period command. All integrals are Gauss-Legendre quadratures
over pieces between events, cut, for the leak, where the knob passes an angle at which an immediate wall would jump.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from hknob_cli.engine.attractors import Attractor
from hknob_cli.scene.general_knob import GeneralKnob
from tests import digits as mp

from .general_reference import Control, build
from .reference_bodies import BITS, COMMAND, CURRENT, FINGER_SPEED, KNOB, ONE, SPEED, STUCK, TORQUE, Bodies, powers
from .reference_friction import Friction

NEAR = mp.mpf(10) ** -30  # step of the differences
CLOSED = mp.mpf(10) ** -38  # residual, in counts, of a solved orbit
# The same over corners of cogging, where a step is halved until its event is known to 2^-60 of it.
NEAR_CORNERS, CLOSED_OVER_CORNERS = mp.mpf(10) ** -10, mp.mpf(10) ** -16
# Of a quadrature over 2 time constants of the fastest motion, whose squares grow by 4: by its remainder, (n!)^4 4^2n /
# ((2n + 1) (2n)!^3), 10 nodes are off by 6e-19 of the integrand.
NODES = 10
COARSE = 1 << (BITS - 170)  # 51 digits of an angle in radians, for what is measured to ten


def legendre(n: int) -> list[tuple[Any, Any]]:
    """Nodes and weights of Gauss-Legendre quadrature on [0, 1]."""
    found = []
    for near in np.polynomial.legendre.leggauss(n)[0]:
        x = mp.mpf(float(near))
        for _ in range(4):
            before, here = mp.one, x
            for k in range(1, n):
                before, here = here, ((2 * k + 1) * x * here - k * before) / (k + 1)
            slope = n * (x * here - before) / (x * x - 1)
            x -= here / slope
        found.append(((x + 1) / 2, 1 / ((1 - x * x) * slope * slope)))
    return found


RULE = legendre(NODES)
AT_NODES = [powers(mp.whole(mp.ldexp(node, BITS)), 200) for node, _ in RULE]


@dataclass
class Piece:
    """A stretch of motion in one mode under one command."""

    mode: int
    start: tuple[Any, ...]
    length: Any
    command: Any


class Recorder(Friction):
    """Motion that keeps its pieces."""

    pieces: list[Piece]

    def hold(self, command: Any, duration: Any) -> None:
        """Move through one hold; its pieces are appended."""
        self.acting, self.left = command, duration
        super().hold(command, duration)

    def _to_event(self, left: Any, whole: bool) -> Any:
        mode, start = self.mode, self.z
        moved = super()._to_event(left, whole)
        self.pieces.append(Piece(mode, start, left if moved is None else moved, self.acting))
        return moved

    def _leave(self, left: Any, order: int) -> Any:
        mode, start = self.mode, self.z
        moved = super()._leave(left, order)
        self.pieces.append(Piece(mode, start, moved, self.acting))
        return moved


@dataclass
class Run:
    """Samples of one or more periods: states and readings (one more), commands emitted, line left, pieces."""

    states: list[tuple[Any, ...]]
    readings: list[Any]
    emitted: list[Any]
    line: list[Any]
    pieces: list[Piece] = field(default_factory=list)
    closest: float = float("inf")
    corners: int = 0  # of cogging that were passed


@dataclass
class Solved:
    """The orbit: its run over one period, and of the map there the residual [counts], and whether it is small enough.

    Over corners of cogging there are no pieces, so that nothing is measured.
    """

    run: Run
    residual: float
    closes: bool
    control: Control
    bodies: Bodies
    edge: Any  # the immediate wall acts below this angle

    @cached_property
    def parts(self) -> "list[Part]":
        """The orbit, in parts short enough for one quadrature."""
        return parts(self)


def run(
    bodies: Bodies, control: Control, z: Any, line: list[Any], before: Any, samples: int, *, record: bool = False
) -> Run:
    """Run from a state [SI] just before a sample."""
    made = Run([], [], [], list(line))
    motion = Recorder(bodies, control.period, tuple(z), find_turns=record)
    motion.pieces = made.pieces
    part = control.delay - mp.floor(control.delay)
    for _ in range(samples):
        made.states.append(motion.z)
        shown = control.measured(motion.z[KNOB])
        made.readings.append(shown)
        u = control.command(control.wanted(shown, shown if before is None else before))
        before = shown
        made.emitted.append(u)
        older = u
        if made.line:
            older, *made.line = [*made.line, u]
            u = made.line[0]
        if part:
            motion.hold(older, part * control.period)
        motion.hold(u, (1 - part) * control.period)
    made.states.append(motion.z)
    made.closest, made.corners = motion.closest, motion.parted
    return made


def to_si(knob: GeneralKnob, control: Control, state: list[float], bodies: Bodies | None = None) -> list[Any]:
    """The package's state as the model's."""
    unit = control.quantum or mp.mpf(knob.quantum_rad)
    pace = unit / control.period
    theta, omega = (mp.mpf(state[0]) + mp.mpf(knob.shift)) * unit, mp.mpf(state[1]) * pace
    finger, finger_speed = mp.zero, mp.zero
    if knob.body.ratio:
        finger, finger_speed = theta - mp.mpf(state[2]) * unit, omega - mp.mpf(state[3]) * pace
    torque = mp.mpf(state[-1]) * mp.mpf(knob.torque_nm) if knob.body.lag else mp.zero
    current = mp.zero
    if bodies and knob.body.coil:  # a spring of Kt^2 / L turned by y has the torque -Kt i
        current = -mp.mpf(state[4 if knob.body.ratio else 2]) * unit * bodies.torque_constant / bodies.inductance
    if bodies and bodies.driven:  # the package has what the voltage drives apart from what the speed does
        current += mp.mpf(state[-1]) * mp.mpf(knob.torque_nm) / bodies.torque_constant
        torque = mp.zero
    return [theta, omega, finger, finger_speed, torque, mp.zero, mp.one, current]


def unknowns(knob: GeneralKnob, bodies: Bodies | None = None) -> list[int]:
    """Which entries of the model's state are free."""
    found = [0, 1, *([2, 3] if knob.body.ratio else []), *([TORQUE] if knob.body.lag else [])]
    if bodies and bodies.torque_constant:
        return [*(i for i in found if i != TORQUE or not bodies.driven), CURRENT]
    return found


def solve(scene: dict[str, Any], rate_hz: float, counts: int | None, knob: GeneralKnob, one: Attractor) -> Solved:
    """The orbit near the package's."""
    bodies, control = build(scene, sample_rate_hz=rate_hz, counts_per_rev=counts)
    one_slope = bodies.cogs and (bodies.play or counts is None)  # a proven cycle is on one
    if one_slope:
        bodies = bodies.on(bodies.slope(to_si(knob, control, [one.x, one.v, *one.state], bodies)[KNOB]))
    if bodies.play:  # and its teeth press on one flank
        bodies = bodies.teeth[1 if one.state[0] > 0.0 else -1]
    unit = control.quantum or mp.mpf(knob.quantum_rad)
    torque = mp.mpf(knob.torque_nm)
    current = torque / bodies.torque_constant if bodies.torque_constant else mp.one
    units = [unit, unit / control.period, unit, unit / control.period, torque, mp.zero, mp.one, current]
    z = to_si(knob, control, [one.x, one.v, *one.state], bodies)
    line = [mp.mpf(u) * mp.mpf(knob.torque_nm) for u in one.line]
    analog = counts is None
    before = (mp.mpf(one.before) + mp.mpf(knob.shift)) * unit if analog else None
    if not analog:
        # Exact commands and reading before, from the readings of one period.
        first = (mp.mpf(one.before) + control.offset) * unit
        found = run(bodies, control, z, line, first, one.period)
        before = found.readings[-1]
        line = [found.emitted[-1 - k % one.period] for k in reversed(range(len(line)))]
        if bodies.cogs and not found.corners:
            bodies = bodies.on(bodies.slope(z[KNOB]))
    over = bodies.cogs is not None
    near, closed = (NEAR_CORNERS, CLOSED_OVER_CORNERS) if over else (NEAR, CLOSED)
    free = unknowns(knob, bodies)
    extra = len(line) + 1 if analog else 0

    def pack(state: Any, under_way: list[Any], last: Any) -> list[Any]:
        values = [state[i] / units[i] for i in free]
        return values + ([u / units[4] for u in under_way] + [last / unit] if extra else [])

    def unpack(values: list[Any]) -> tuple[list[Any], list[Any], Any]:
        state = list(z)
        for value, i in zip(values, free, strict=False):
            state[i] = value * units[i]
        if not extra:
            return state, line, before
        rest = values[len(free) :]
        return state, [u * units[4] for u in rest[:-1]], rest[-1] * unit

    def residual(values: list[Any]) -> list[Any]:
        moved = run(bodies, control, *unpack(values), one.period)
        after = pack(moved.states[-1], moved.line, moved.readings[-1])
        return [b - a for a, b in zip(values, after, strict=True)]

    values = pack(z, line, before)
    off = residual(values)
    for _ in range(6):
        if max(map(abs, off)) < closed:
            break
        slopes = mp.matrix(len(values), len(values))
        for j in range(len(values)):
            nudged = [v + (near if i == j else 0) for i, v in enumerate(values)]
            for i, value in enumerate(residual(nudged)):
                slopes[i, j] = (value - off[i]) / near
        change = mp.lu_solve(slopes, mp.matrix([-value for value in off]))
        values = [v + change[i] for i, v in enumerate(values)]
        off = residual(values)
    made = run(bodies, control, *unpack(values), one.period, record=not over)
    edge = mp.zero
    if not analog:
        nearest = mp.mpf(1) / 2 if control.rounding == "nearest" else 0
        ceil = control.rounding in ("ceil", "truncate")
        edge = (control.offset - nearest - (1 if ceil else 0)) * control.quantum
    residual = float(max(map(abs, off)))
    return Solved(made, residual, residual < 10 * closed, control, bodies, edge)


def with_command(bodies: Bodies, piece: Piece) -> tuple[Any, ...]:
    """The start of a piece with the inputs that act in it."""
    z = list(piece.start)
    z[TORQUE] = z[TORQUE] if bodies.lag else piece.command
    z[COMMAND], z[ONE] = piece.command, mp.one
    return tuple(z)


class Part:
    """A part of a piece, short enough for one series and one quadrature; times run from 0 to 1 in it."""

    def __init__(self, bodies: Bodies, piece: Piece, start: tuple[Any, ...], length: Any) -> None:
        self.bodies, self.mode, self.command, self.length = bodies, piece.mode, piece.command, length
        self.start = start
        self.columns = list(zip(*bodies.series(piece.mode, start, length, COARSE), strict=True))
        assert len(self.columns[0]) <= len(AT_NODES[0])

    def at(self, t: Any) -> tuple[Any, ...]:
        """State at a time."""
        x = powers(mp.whole(mp.ldexp(mp.mpf(t), BITS)), len(self.columns[0]))
        return self.bodies.at(self.start, self.columns, x)

    def nodes(self) -> Iterator[tuple[Any, tuple[Any, ...]]]:
        """Weight and state at each node of the quadrature."""
        for (_, weight), x in zip(RULE, AT_NODES, strict=True):
            yield weight * self.length, self.bodies.at(self.start, self.columns, x)


def parts(solved: Solved) -> list[Part]:
    """The orbit in parts."""
    made, bodies = [], solved.bodies
    for piece in solved.run.pieces:
        count = 1 + int(bodies.fastest * float(piece.length) / 2)
        z = with_command(bodies, piece)
        for _ in range(count):
            made.append(Part(bodies, piece, z, piece.length / count))
            z = made[-1].at(1)
    return made


def measure(solved: Solved) -> dict[str, Any]:
    """Measures of the orbit, all by quadrature of what the names say."""
    bodies, control = solved.bodies, solved.control
    total = dict.fromkeys(("x", "xx", "work", "loss", "rub"), mp.zero)
    for part in solved.parts:
        for w, z in part.nodes():
            v, torque = z[SPEED], z[TORQUE] if bodies.lag else part.command
            if bodies.driven:  # all of it, of which the resistance takes nothing
                torque = bodies.torque_constant * z[CURRENT]
            total["x"] += w * z[KNOB]
            total["xx"] += w * z[KNOB] ** 2
            total["work"] += w * torque * v
            loss = bodies.damping * v * v
            if bodies.finger:
                loss += bodies.pad_damping * (v - z[FINGER_SPEED]) ** 2
                loss += bodies.finger_damping * z[FINGER_SPEED] ** 2
            if bodies.torque_constant and not bodies.driven:
                loss += bodies.resistance * z[CURRENT] ** 2
            total["loss"] += w * loss
            total["rub"] += w * bodies.friction * abs(v)
    duration = control.period * (len(solved.run.states) - 1)
    sliding = [piece for piece in solved.run.pieces if piece.mode != STUCK]
    highs = [b.start[KNOB] for a, b in zip([sliding[-1], *sliding], sliding, strict=False) if a.mode > b.mode]
    lows = [b.start[KNOB] for a, b in zip([sliding[-1], *sliding], sliding, strict=False) if a.mode < b.mode]
    mean = total["x"] / duration
    return {
        "cycles": len(highs),
        "p2p_rad": mp.fsum(highs) / len(highs) - mp.fsum(lows) / len(lows),
        "min_rad": min(lows),
        "max_rad": max(highs),
        "rms_rad": mp.sqrt(total["xx"] / duration - mean * mean),
        "frequency_hz": len(highs) / duration,
        "wall_work_j": total["work"],
        "damping_loss_j": total["loss"],
        "friction_loss_j": total["rub"],
    }


def immediate(solved: Solved, theta: Any) -> Any:
    """Torque of a wall of the same counts and stiffness that answers at once; just off a jump."""
    control = solved.control
    measured = control.measured(theta)
    return -control.stiffness * measured if theta < solved.edge else mp.zero


def leak(solved: Solved) -> dict[str, Any]:
    """(torque - that of an immediate wall) x velocity, over the times of late entry, of late exit, and the others."""
    control = solved.control
    total = dict.fromkeys(("late_entry_j", "late_exit_j", "staircase_j"), mp.zero)
    for part in solved.parts:
        if part.mode == STUCK:
            continue
        first, last = part.at(0)[KNOB], part.at(1)[KNOB]
        times = [mp.zero, *sorted(_time_at(part, a) for a in _jumps(solved, first, last)), mp.one]
        for a, b in pairwise(times):
            middle = part.at((a + b) / 2)[KNOB]
            inside = middle < solved.edge
            name = "late_exit_j" if not inside else "staircase_j" if part.command else "late_entry_j"
            for node, weight in RULE:
                z = part.at(a + (b - a) * node)
                ideal = -control.stiffness * z[KNOB] if control.quantum is None else immediate(solved, middle)
                total[name] += weight * (b - a) * part.length * (part.command - (ideal if inside else 0)) * z[SPEED]
    return total


def _jumps(solved: Solved, first: Any, last: Any) -> list[Any]:
    """Angles between two at which the immediate wall jumps."""
    control, (low, high) = solved.control, sorted((first, last))
    if control.quantum is None:
        return [mp.zero] if low < 0 < high else []
    k, found = int(mp.floor((low - solved.edge) / control.quantum)), []
    while solved.edge + k * control.quantum < high:
        angle = solved.edge + k * control.quantum
        if low < angle and k <= 0:
            found.append(angle)
        k += 1
    return found


def _time_at(part: Part, angle: Any) -> Any:
    """When the angle is passed; it is monotone within a part."""
    low, high = mp.zero, mp.one
    for _ in range(12):  # to a few thousandths, for Newton
        middle = (low + high) / 2
        above = part.at(middle)[KNOB] > angle
        low, high = (low, middle) if above == (part.mode > 0) else (middle, high)
    t = (low + high) / 2
    for _ in range(8):
        z = part.at(t)
        t = min(high, max(low, t - (z[KNOB] - angle) / (z[SPEED] * part.length))) if z[SPEED] else t
    return t
