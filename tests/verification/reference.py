"""A 60-digit model of the sampled knob, in SI units, that shares no formula with the package.

Plant: J theta'' + b theta' + k theta = tau - g (the theory). Phi and Gamma of the zero-order hold come from one matrix
exponential of the augmented continuous matrix (Franklin, Powell & Workman, sec. 4.3); integrals over a hold and the
velocity between samples from its two eigenvalues; extrema from bracketed zeros of the velocity, refined numerically.
Nothing is imported from `hknob_cli`: both sides are built from the same plain dictionary, the ``scene`` of a spec.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from tests import digits as mp

State = tuple[Any, Any]  # theta [rad], omega [rad/s]
Hold = tuple[Any, Any]  # torque of the wall [N m], duration [s]


@dataclass(frozen=True)
class Plant:
    """Hand and knob as one body: J ``inertia`` [kg m^2], b ``damping`` [N m s/rad], k ``stiffness`` [N m/rad].

    ``bias`` g [N m] pushes into the wall.
    """

    inertia: Any
    damping: Any
    stiffness: Any
    bias: Any
    _holds: dict[Any, Any] = field(default_factory=dict, compare=False, repr=False)

    def matrices(self, duration: Any) -> tuple[Any, ...]:
        """(Phi11, Phi12, Phi21, Phi22, Gamma1, Gamma2) of a hold of ``duration`` [s]; Gamma is per N m."""
        if duration not in self._holds:
            with mp.extradps(30):  # squaring in expm loses some digits when a hold is many time constants
                inverse = 1 / self.inertia
                augmented = mp.matrix(
                    [[0, 1, 0], [-self.stiffness * inverse, -self.damping * inverse, inverse], [0, 0, 0]]
                )
                e = mp.expm(augmented * duration)
            self._holds[duration] = tuple(+e[i, j] for i, j in [(0, 0), (0, 1), (1, 0), (1, 1), (0, 2), (1, 2)])
        return self._holds[duration]

    def move(self, state: State, hold: Hold) -> State:
        """State at the end of a hold."""
        p11, p12, p21, p22, g1, g2 = self.matrices(hold[1])
        theta, omega = state
        torque = hold[0] - self.bias
        return p11 * theta + p12 * omega + g1 * torque, p21 * theta + p22 * omega + g2 * torque

    @cached_property
    def eigenvalues(self) -> tuple[Any, Any]:
        """Roots of J s^2 + b s + k [1/s], complex or real; distinct, or the model does not apply."""
        root = mp.sqrt(mp.mpc(self.damping**2 - 4 * self.inertia * self.stiffness))
        assert root != 0
        assert self.stiffness > 0
        return (-self.damping + root) / (2 * self.inertia), (-self.damping - root) / (2 * self.inertia)

    def modes(self, state: State, torque: Any) -> tuple[Any, Any, Any]:
        """(theta_e, c1, c2) of theta(t) = theta_e + c1 exp(s1 t) + c2 exp(s2 t) under a constant wall ``torque``."""
        s1, s2 = self.eigenvalues
        still = (torque - self.bias) / self.stiffness
        away = state[0] - still
        c1 = (state[1] - s2 * away) / (s1 - s2)
        return still, c1, away - c1


@dataclass(frozen=True)
class Cell:
    """A scene at one ``period`` [s] and one ``quantum`` [rad].

    The wall's torque is -K theta_measured where theta_measured < 0, else 0; the encoder reads
    quantum (round(theta/quantum - offset) + offset); commands act ``delay`` sample periods after their sample.
    """

    plant: Plant
    wall_stiffness: Any
    quantum: Any
    period: Any
    rounding: str = "floor"
    offset: Any = 0
    delay: Any = 0

    @property
    def older(self) -> int:
        """Number of earlier commands still under way at a sample."""
        return int(mp.ceil(self.delay))

    def counts(self, theta: Any) -> Any:
        """Angle in counts from the encoder edge at the wall, before rounding."""
        return theta / self.quantum - self.offset

    def level(self, theta: Any) -> int:
        """Whole number that the encoder shows."""
        counts = self.counts(theta)
        if self.rounding == "floor":
            return int(mp.floor(counts))
        if self.rounding == "ceil":
            return int(mp.ceil(counts))
        assert self.rounding == "nearest"
        return int(mp.floor(counts + mp.mpf(1) / 2))

    def margin(self, theta: Any) -> Any:
        """Distance to the nearest count edge, in counts."""
        shifted = self.counts(theta) + (mp.mpf(1) / 2 if self.rounding == "nearest" else 0)
        part = shifted - mp.floor(shifted)
        return min(part, 1 - part)

    def command(self, theta: Any) -> Any:
        """Torque that the wall commands at ``theta`` [N m]."""
        measured = self.quantum * (self.level(theta) + self.offset)
        return -self.wall_stiffness * measured if measured < 0 else mp.mpf(0)

    def holds(self, queue: list[Any], theta: Any) -> tuple[list[Hold], list[Any]]:
        """The holds of one sample interval and the queue after it; ``queue`` has the earlier commands, oldest first."""
        commands = [*queue, self.command(theta)]
        part = self.delay - mp.floor(self.delay)
        if part == 0:
            return [(commands[0], self.period)], commands[1:]
        # With a delay of D + f samples the first f of interval i runs under command i - D - 1, the rest under i - D.
        split = self.period * part
        return [(commands[0], split), (commands[1], self.period - split)], commands[1:]

    def start(self, state: State, phase: int, phases: int) -> State:
        """State at the first sample, ((phase + 1/2)/phases) T after the start, torque zero before it."""
        return self.plant.move(state, (mp.mpf(0), self.period * (2 * phase + 1) / (2 * phases)))

    def run(self, state: State, samples: int) -> Iterator[tuple[State, int]]:
        """State and encoder level at each of ``samples`` samples, the first at ``state``."""
        queue = [mp.mpf(0)] * self.older
        for _ in range(samples):
            yield state, self.level(state[0])
            holds, queue = self.holds(queue, state[0])
            for hold in holds:
                state = self.plant.move(state, hold)


def build_cell(scene: dict[str, Any], *, sample_rate_hz: float, counts_per_rev: int) -> Cell:
    """The cell of a spec's ``scene``; each number enters as exactly the double that the spec holds."""
    knob, hand, wall = scene["knob"], scene.get("hand", {}), scene["wall"]
    encoder, actuator = scene.get("encoder", {}), scene.get("actuator", {})
    quantum = 2 * mp.pi / counts_per_rev
    stiffness = mp.mpf(wall["stiffness"])
    bias = scene.get("bias", {"torque": 0.0})
    return Cell(
        plant=Plant(
            inertia=mp.mpf(knob["inertia"]) + mp.mpf(hand.get("inertia", 0.0)),
            damping=mp.mpf(knob.get("damping", 0.0)) + mp.mpf(hand.get("damping", 0.0)),
            stiffness=mp.mpf(hand.get("stiffness", 0.0)),
            bias=stiffness * quantum / 2 if bias.get("half_quantum") else mp.mpf(bias["torque"]),
        ),
        wall_stiffness=stiffness,
        quantum=quantum,
        period=1 / mp.mpf(sample_rate_hz),
        rounding=encoder.get("rounding", "floor"),
        offset=mp.mpf(encoder.get("offset_counts", 0.0)),
        delay=mp.mpf(actuator.get("delay_samples", 0.0)),
    )


@dataclass(frozen=True)
class Orbit:
    """A periodic motion: ``states`` at its n samples, encoder ``levels`` there, ``margins`` to the nearest count edge.

    ``same_levels``: the motion visits the levels it was solved for, and its queue of commands closes; then it is an
    orbit of the sampled system. ``holds``: one row of holds for each sample interval.
    """

    cell: Cell
    states: tuple[State, ...]
    levels: tuple[int, ...]
    margins: tuple[Any, ...]
    holds: tuple[tuple[Hold, ...], ...]
    same_levels: bool

    @property
    def period_s(self) -> Any:
        """Duration of one period."""
        return self.cell.period * len(self.states)

    def is_minimal(self) -> bool:
        """Whether no shorter period repeats the levels."""
        n = len(self.levels)
        return not any(n % d == 0 and self.levels == self.levels[:d] * (n // d) for d in range(1, n))

    @cached_property
    def pieces(self) -> list[tuple[State, Hold]]:
        """Every hold with the state that it starts from; the last piece repeats the first state."""
        row = []
        for state, holds in zip(self.states, self.holds, strict=True):
            for hold in holds:
                row.append((state, hold))
                state = self.cell.plant.move(state, hold)
        return row

    @cached_property
    def extrema(self) -> tuple[list[Any], list[Any]]:
        """All local maxima and all local minima of theta(t) over one period [rad]."""
        maxima: list[Any] = []
        minima: list[Any] = []
        for state, hold in self.pieces:
            for theta, is_maximum in turning_points(self.cell.plant, state, hold):
                (maxima if is_maximum else minima).append(theta)
        return maxima, minima

    @cached_property
    def integrals(self) -> tuple[Any, Any, Any, Any]:
        """Over one period: integrals of theta, theta^2, omega^2 dt, and the work of the wall torque."""
        plant = self.cell.plant
        s1, s2 = plant.eigenvalues
        known: dict[Any, tuple[Any, ...]] = {}
        first = second = speed = work = mp.mpf(0)
        for state, hold in self.pieces:
            torque, t = hold
            if t not in known:
                known[t] = tuple((mp.exp(s * t) - 1) / s for s in (s1, s2, 2 * s1, 2 * s2, s1 + s2))
            i1, i2, i11, i22, i12 = known[t]
            still, c1, c2 = plant.modes(state, torque)
            linear = (c1 * i1 + c2 * i2).real
            first += still * t + linear
            second += still**2 * t + 2 * still * linear + (c1**2 * i11 + c2**2 * i22 + 2 * c1 * c2 * i12).real
            d1, d2 = s1 * c1, s2 * c2
            speed += (d1**2 * i11 + d2**2 * i22 + 2 * d1 * d2 * i12).real
            work += torque * (plant.move(state, hold)[0] - state[0])
        return first, second, speed, work

    def measures(self) -> dict[str, Any]:
        """The measures of docs/reference/glossary.md, and the two sides of the energy balance [J]."""
        maxima, minima = self.extrema
        first, second, speed, work = self.integrals
        mean = first / self.period_s
        return {
            "cycles": len(maxima),
            "p2p_rad": mp.fsum(maxima) / len(maxima) - mp.fsum(minima) / len(minima),
            "min_rad": min(minima),
            "max_rad": max(maxima),
            "rms_rad": mp.sqrt(second / self.period_s - mean**2),
            "frequency_hz": len(maxima) / self.period_s,
            "wall_work_j": work,
            "damping_loss_j": self.cell.plant.damping * speed,
        }


def turning_points(plant: Plant, state: State, hold: Hold) -> Iterator[tuple[Any, bool]]:
    """Local extrema of theta within one hold, in time order: (theta [rad], whether it is a maximum).

    The velocity is a sum of two exponentials. Real eigenvalues leave it at most one zero; complex ones space its zeros
    pi/Im(s) apart. Nodes a third of that apart hold at most one zero between them, and do where the sign changes.
    """
    torque, duration = hold
    s1, s2 = plant.eigenvalues
    still, c1, c2 = plant.modes(state, torque)
    parts = 1 + int(3 * abs(s1.imag) * duration / mp.pi)

    def theta(t: Any) -> Any:
        return still + (c1 * mp.exp(s1 * t) + c2 * mp.exp(s2 * t)).real

    def rates(t: Any) -> tuple[Any, Any]:
        d1, d2 = s1 * c1 * mp.exp(s1 * t), s2 * c2 * mp.exp(s2 * t)
        return (d1 + d2).real, (s1 * d1 + s2 * d2).real

    end = plant.move(state, hold)[1]
    nodes = [mp.mpf(0), *(duration * i / parts for i in range(1, parts)), duration]
    speeds = [state[1], *(rates(t)[0] for t in nodes[1:-1]), end]
    for left, right, before, after in zip(nodes, nodes[1:], speeds, speeds[1:], strict=False):
        assert before * after != 0, "a turning point on a node: not generic, and not handled"
        if (before > 0) != (after > 0):
            yield theta(bracketed_zero(rates, left, right, before > 0)), bool(before > 0)


def bracketed_zero(rates: Any, left: Any, right: Any, falling: bool) -> Any:
    """Zero between ``left`` and ``right``, where the sign changes: Newton steps, bisection where they leave it.

    ``rates(t)`` gives value and slope. Near an extremum theta is flat: an error of 1e-35 in t, relative to the bracket,
    is one of 1e-70 in theta.
    """
    tolerance = (right - left) * mp.mpf(10) ** -35
    t = (left + right) / 2
    for _ in range(200):
        value, slope = rates(t)
        if (value > 0) == falling:
            left = t
        else:
            right = t
        following = t - value / slope if slope != 0 else left
        if not left < following < right:
            following = (left + right) / 2
        if abs(following - t) <= tolerance:
            return following
        t = following
    raise AssertionError("no zero found in the bracket")


def solve_orbit(cell: Cell, state: State, queue: list[Any], n: int) -> Orbit:
    """The periodic motion whose n levels are those that a motion from ``state`` and ``queue`` visits.

    ``queue``: commands under way at ``state`` [N m], oldest first. The fixed point x = Phi^n x + r is solved with Phi^n
    from one matrix exponential over the whole period, and run again to see whether it visits the levels solved for.
    """
    levels, holds, commands = [], [], list(queue)
    forced: State = (mp.mpf(0), mp.mpf(0))
    for _ in range(n):
        levels.append(cell.level(state[0]))
        row, commands = cell.holds(commands, state[0])
        holds.append(tuple(row))
        for hold in row:
            state = cell.plant.move(state, hold)
            forced = cell.plant.move(forced, hold)
    p11, p12, p21, p22, _, _ = cell.plant.matrices(cell.period * n)
    fixed = mp.lu_solve(mp.matrix([[1 - p11, -p12], [-p21, 1 - p22]]), mp.matrix(forced))
    state = (fixed[0], fixed[1])
    states, visited, margins = [], [], []
    for row in holds:
        states.append(state)
        visited.append(cell.level(state[0]))
        margins.append(cell.margin(state[0]))
        for hold in row:
            state = cell.plant.move(state, hold)
    closure = max(abs(state[0] - fixed[0]), abs(state[1] - fixed[1]) * cell.period)
    assert closure < cell.quantum * mp.mpf(10) ** -(mp.DIGITS - 15), f"reference orbit does not close: {closure}"
    return Orbit(
        cell=cell,
        states=tuple(states),
        levels=tuple(visited),
        margins=tuple(margins),
        holds=tuple(holds),
        same_levels=visited == levels and commands == list(queue),
    )
