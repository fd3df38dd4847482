"""The relay with delay that a quantised, sampled wall is close to, what is attached to its plant, and its cycles.

While the knob stays within a count of one encoder edge, and the bias is half of the torque step there, the loop is a
symmetric relay of +-M behind a delay: M = K q / 2, and the zero-order hold counts as half a sample of delay (Hasser,
sec. 7.2). Angles are in counts, times in samples, as in the engine. `df` methods keep the first N odd harmonics of the
relay's square wave; `tsypkin` keeps all of them, in closed form. The Nyquist picture is the plant's curve, and where
each sample rate meets it: the describing function of a relay, 4M/(pi A), has a real negative inverse, and the half
sample of delay of the hold turns it counter-clockwise by omega T/2 (Hasser, sec. 7.2, Figs 45, 46).

Attached to one body are a finger behind its pad, a lag of the torque, dry friction. The text expects describing
functions to take further linear components easily (Hasser, sec. 7.4). These are their frequency responses, torques as
accelerations of the knob. The describing function of friction F sign(v) is that of a relay on the velocity, 4 F/(pi V)
of a velocity amplitude V (Gelb & Vander Velde 1968, ch. 2): beside the wall's relay it is a torque 4 F/pi a quarter of
a turn ahead of the angle, whatever the amplitude.
"""

from collections.abc import Callable
from math import floor, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero, zero_spacing
from hknob_cli.scene.plain_knob import SampledKnob

Complex = NDArray[np.complexfloating[Any, Any]]


class Attached(NamedTuple):
    """Beside the body with its damping and stiffness; 0 for what is not there.

    ``ratio``: inertia of the knob over the finger's; ``pad_...``: per inertia of the knob; ``finger_...``: per inertia
    of the finger; ``lag``: sample period over the time constant; ``friction``: acceleration by dry friction.
    """

    ratio: float = 0.0
    pad_damping: float = 0.0
    pad_stiffness: float = 0.0
    finger_damping: float = 0.0
    finger_stiffness: float = 0.0
    lag: float = 0.0
    friction: float = 0.0

    @property
    def stiffness(self) -> float:
        """Of pad and finger in series, per inertia of the knob."""
        grounded = self.finger_stiffness / self.ratio if self.ratio else 0.0
        both = self.pad_stiffness + grounded
        return self.pad_stiffness * grounded / both if both > 0.0 else 0.0

    @property
    def inertia(self) -> float:
        """Of knob and finger together, over the knob's."""
        return 1.0 + (1.0 / self.ratio if self.ratio else 0.0)

    def held_by(self, s: Complex) -> Complex:
        """Torque by which pad and finger hold the knob, per angle."""
        if not self.ratio:
            return np.zeros_like(s)
        pad = self.pad_stiffness + self.pad_damping * s
        finger = self.finger_stiffness + (self.finger_damping + s) * s
        found: Complex = pad * finger / (finger + self.ratio * pad)
        return found

    def late(self, s: Complex) -> Complex:
        """The lag's response from commanded to actual torque."""
        found: Complex = self.lag / (self.lag + s) if self.lag else np.ones_like(s)
        return found


def attached_to(body: Body) -> Attached | None:
    """What a body of the general loop has beside its damping and stiffness; None for nothing."""
    found = Attached(
        ratio=body.ratio,
        pad_damping=body.pad_damping,
        pad_stiffness=body.pad_stiffness,
        finger_damping=body.finger_damping,
        finger_stiffness=body.finger_stiffness,
        lag=body.lag,
        friction=body.friction,
    )
    return found if any(found) else None


Array = NDArray[np.float64]

_BISECTIONS = 70
_PHASES = 1024


class Relay(NamedTuple):
    """Plant x'' + alpha x' + beta x = u, u = -+ ``level`` by the sign of x, ``delay`` samples late.

    ``attached``: a finger, a lag, friction beside it, which `describing_function` knows; friction with one harmonic.
    ``turn``: how far beyond zero x must come until the relay turns, half the width of its hysteresis.
    """

    alpha: float
    beta: float
    level: float
    delay: float
    attached: Attached | None = None
    turn: float = 0.0


class RelayCycle(NamedTuple):
    """A predicted limit cycle: angular frequency in rad/sample, amplitude (half of peak to peak) in counts.

    ``single``: whether the wave crosses the edge only twice a cycle, as a relay's cycle must.
    """

    omega: float
    amplitude: float
    single: bool


def response(relay: Relay, omega: Array) -> NDArray[np.complex128]:
    """Frequency response of plant and delay at ``omega`` (rad/sample), for a relay of level 1.

    Friction is a second relay, on the velocity: its torque leads by a quarter of a turn.
    """
    s = 1j * omega
    torque, held = np.exp(-s * relay.delay), s * s + relay.alpha * s + relay.beta
    if more := relay.attached:
        torque, held = torque * more.late(s) + 1j * more.friction / relay.level, held + more.held_by(s)
    value: NDArray[np.complex128] = torque / held
    return value


def lowest_omega(relay: Relay, harmonics: int) -> float:
    """A frequency below which no cycle is; below resonance the plant leads the crossing that a cycle needs."""
    beta = relay.beta
    if more := relay.attached:
        beta = (beta + more.stiffness) / more.inertia
    if beta > 0.0:
        return 0.4 * sqrt(beta) / (2 * harmonics - 1)
    low = 1e-3 * sqrt(relay.alpha / max(relay.delay, 1e-6)) if relay.alpha > 0.0 else 1e-3
    # Nothing holds the knob: from edge to edge it takes the longer, the wider they are apart.
    return min(low, 0.1 * relay.level / (relay.alpha * relay.turn)) if relay.alpha * relay.turn > 0.0 else low


def _roots(values: Array, grid: Array, function: Callable[[float], float]) -> list[float]:
    """Roots of ``function`` by bisection in the intervals of ``grid`` where ``values`` changes sign."""
    found = []
    for i in np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0):
        low, high, below = float(grid[i]), float(grid[i + 1]), float(values[i])
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            if (function(middle) < 0.0) == (below < 0.0):
                low = middle
            else:
                high = middle
        found.append(0.5 * (low + high))
    return found


def describing_function(relay: Relay, harmonics: int) -> list[RelayCycle]:
    """Limit cycles by the first ``harmonics`` odd harmonics, up to the Nyquist frequency, slowest first.

    The relay switches where its input is zero, sum of Im[W(jhw)]/h = 0 over odd h, falling there, sum of Re[W(jhw)]
    below 0; the peak to peak is that of the waveform with the same harmonics. One harmonic is the classic describing
    function 4M/(pi A) (Slotine & Li 1991, sec. 5.4). With hysteresis the sum is -pi d/(4M), d the ``turn``: one
    harmonic is then 4M/(pi A) (sqrt(1 - (d/A)^2) - j d/A) (Gelb & Vander Velde 1968).
    """
    odd = np.arange(1, 2 * harmonics, 2, dtype=float)
    low = lowest_omega(relay, harmonics)
    if low >= pi:
        return []
    # Above the eighth, harmonics weigh too little (1/h^3) to add a root of their own.
    points = int(min(400 + 24 * relay.delay * (2 * min(harmonics, 8) - 1), 20_000))
    grid = np.unique(np.concatenate([np.geomspace(low, pi, points), np.linspace(low, pi, points)]))

    def switching(omega: Array) -> Array:
        total: Array = (response(relay, np.multiply.outer(omega, odd)).imag / odd).sum(axis=-1)
        return total + late

    late = 0.25 * pi * relay.turn / relay.level
    cycles = []
    chunk = max(1, 2_000_000 // len(odd))
    values = np.concatenate([switching(grid[i : i + chunk]) for i in range(0, len(grid), chunk)])
    for omega in _roots(values, grid, lambda at: float(switching(np.array([at]))[0])):
        line = response(relay, omega * odd)
        if line.real.sum() < 0.0:
            lines = relay.level * 4.0 / pi * line / odd
            cycles.append(RelayCycle(omega, _peak(lines, odd), _crosses_twice(_wave(lines, odd), relay.turn)))
    return cycles


def _peak(lines: NDArray[np.complex128], odd: Array) -> float:
    """Largest value of the sum of ``lines`` as sines at odd multiples of the fundamental; Newton from a fine grid."""
    if len(odd) == 1:
        return float(abs(lines[0]))
    phase = np.linspace(0.0, 2.0 * pi, min(64 * int(odd[-1]), _PHASES) + 1)
    best = 0.0
    wave = _wave(lines, odd)
    at = float(phase[int(np.argmax(wave))])
    for _ in range(8):
        turn = lines * np.exp(1j * odd * at)
        slope, bend = float((odd * turn).real.sum()), -float((odd * odd * turn).imag.sum())
        best = float(turn.imag.sum())
        if bend >= 0.0:
            break
        at -= slope / bend
    return max(best, float(wave.max()))


def _wave(lines: NDArray[np.complex128], odd: Array) -> Array:
    """One period of the sum of ``lines`` as sines, from the switch on, at even steps."""
    phase = np.linspace(0.0, 2.0 * pi, min(64 * int(odd[-1]), _PHASES) + 1)
    wave = np.zeros_like(phase)
    for line, h in zip(lines, odd, strict=True):
        wave += (line * np.exp(1j * h * phase)).imag
    return wave


def _crosses_twice(wave: Array, turn: float) -> bool:
    """Whether a period that begins at a switch has one more, in its middle; ripple at the switches is rounding."""
    half = wave[1 : len(wave) // 2]
    most = turn + 1e-9 * abs(half).max()
    return bool((half < most).all() or (half > -most).all())


def start_of_half(relay: Relay, half: float) -> tuple[float, float]:
    """State where the torque turns outward, of the symmetric motion with half period ``half`` (samples).

    x(half) = -x(0): x0 = -(I + Phi)^-1 Gamma M.
    """
    s, g, f = hold_coefficients(relay.alpha, relay.beta, half)
    a, d = 2.0 - relay.beta * g, 1.0 + f
    det = a * d + relay.beta * s * s
    gx, gv = g * relay.level, s * relay.level
    return -(d * gx - s * gv) / det, -(a * gv + relay.beta * s * gx) / det


def _moved(relay: Relay, x: float, v: float, t: float) -> tuple[float, float]:
    s, g, f = hold_coefficients(relay.alpha, relay.beta, t)
    y = relay.level - relay.beta * x
    return x + (s * v + g * y), f * v + s * y


def at_switch(relay: Relay, half: float) -> tuple[float, float]:
    """Position and velocity where the relay is told to turn inward, ``delay`` before the torque does.

    A cycle crosses zero there, upward.
    """
    turns = floor(relay.delay / half)
    x, v = _moved(relay, *start_of_half(relay, half), half - (relay.delay - turns * half))
    return (x, v) if turns % 2 == 0 else (-x, -v)


def _input(relay: Relay, half: float, t: float) -> float:
    """Input of the relay a time ``t`` after it is told to turn inward, of the motion with half period ``half``."""
    at = half - relay.delay + t
    turns = floor(at / half)
    x = _moved(relay, *start_of_half(relay, half), at - turns * half)[0]
    return x if turns % 2 == 0 else -x


def tsypkin(relay: Relay) -> list[RelayCycle]:
    """Limit cycles with all harmonics of the relay (Tsypkin 1984), up to the Nyquist frequency, slowest first."""
    low = lowest_omega(relay, 1)
    if low >= pi:
        return []
    points = int(min(400 + 24 * relay.delay, 20_000))
    grid = np.geomspace(1.0, pi / low, points)
    values = np.array([at_switch(relay, float(half))[0] for half in grid]) - relay.turn
    cycles = []
    for half in _roots(values, grid, lambda at: at_switch(relay, at)[0] - relay.turn):
        if at_switch(relay, half)[1] > 0.0:
            steps = np.linspace(0.0, 1.0, 129)
            wave = np.array([_input(relay, half, float(step) * half) for step in steps])
            cycles.append(
                RelayCycle(pi / half, _largest(relay, half), _crosses_twice(np.concatenate([wave, -wave]), relay.turn))
            )
    return cycles[::-1]


def _largest(relay: Relay, half: float) -> float:
    """Largest deflection over half a period, at turning points."""
    x, v = start_of_half(relay, half)
    t = first_zero(v, relay.level - relay.beta * x, relay.alpha, relay.beta)
    spacing = zero_spacing(relay.alpha, relay.beta)
    largest = abs(x)
    while t < half:
        largest = max(largest, abs(_moved(relay, x, v, t)[0]))
        t += spacing
    return largest


class Crossing(NamedTuple):
    """Where the turned inverse of the describing function meets the plant's curve.

    ``point``: G in rad/(N m); ``omega``: rad/s; ``amplitude_rad``: half of peak to peak, |G| 4M/pi.
    """

    rate_hz: float
    omega: float
    point: complex
    amplitude_rad: float

    @property
    def frequency_hz(self) -> float:
        """Cycles per second."""
        return self.omega / (2.0 * pi)


def crossing(knob: SampledKnob) -> Crossing | None:
    """The slowest cycle by one harmonic; None if there is none below the Nyquist frequency."""
    loop = knob.loop
    delay = 0.5 + max(0, knob.delay_line - 1) + loop.split
    found = describing_function(Relay(loop.alpha, loop.beta, 1.0, delay), 1)
    if not found:
        return None
    omega = found[0].omega
    bare = Relay(loop.alpha, loop.beta, 1.0, 0.0)
    point = complex(response(bare, np.array([omega]))[0]) * knob.period_s**2 / knob.inertia_kg_m2
    level = 0.5 * loop.kappa * knob.quantum_rad * knob.inertia_kg_m2 / knob.period_s**2
    return Crossing(1.0 / knob.period_s, omega / knob.period_s, point, abs(point) * 4.0 * level / pi)


def plant_curve(knob: SampledKnob, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Frequency response of hand and knob, rad/(N m), at ``omega`` (rad/s)."""
    inertia = knob.inertia_kg_m2
    damping = knob.loop.alpha * inertia / knob.period_s
    stiffness = knob.loop.beta * inertia / knob.period_s**2
    return np.asarray(1.0 / (stiffness - inertia * omega**2 + 1j * damping * omega), dtype=np.complex128)
