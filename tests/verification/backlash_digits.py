"""A gear with backlash at 60 digits: two shafts, the motor in its own turns, angles from the middle of the play.

Teeth that touch are a spring and a damper that never pull. Each of the three linear modes has its matrix exponential;
a mode's end is bracketed by halving a step a hundred times. It shares no formula with the package.
"""

from typing import Any, NamedTuple

from tests import digits as mp

from .test_gear import Matrix, apply, exponential

STEPS = 64  # of a sample; a mode that began and ended within one would be missed
HALVINGS = 100  # of a step: what is left moves nothing by 1e-30


class Sample(NamedTuple):
    """Angles (rad) and speeds (rad/s) of the motor over the ratio, from the wall's flank, and of the knob."""

    motor: Any
    motor_speed: Any
    knob: Any
    knob_speed: Any


class Teeth:
    """State (φ, φ', θ, θ', 1, command), and on which flank the teeth press."""

    def __init__(self, scene: dict[str, Any], *, rate_hz: float, counts: int) -> None:
        gear, hand, knob = scene["gear"], scene["hand"], scene["knob"]
        self.n, self.half = mp.mpf(gear["ratio"]), mp.mpf(gear["backlash"]) / 2
        self.k, self.c = mp.mpf(gear["stiffness"]), mp.mpf(gear.get("mesh_damping", 0.0))
        self.wall, self.count = mp.mpf(scene["wall"]["stiffness"]), 2 * mp.pi / counts
        motor, inertia = mp.mpf(gear["motor_inertia"]), mp.mpf(knob["inertia"]) + mp.mpf(hand["inertia"])
        resisting, own = (
            mp.mpf(knob.get("damping", 0.0)) + mp.mpf(hand["damping"]),
            mp.mpf(gear.get("motor_damping", 0.0)),
        )
        self.step = 1 / mp.mpf(rate_hz) / STEPS
        self.over: dict[int, list[Matrix]] = {}
        for flank in (1, 0, -1):
            press = [self.k / self.n, self.c / self.n, -self.k, -self.c, -self.k * self.half * flank]
            zero = mp.mpf(0)
            press = [value if flank else zero for value in press]
            a = [[zero] * 6 for _ in range(6)]
            a[0][1] = a[2][3] = mp.mpf(1)
            a[1][:5] = [-value / self.n / motor for value in press]
            a[1][1] -= own / motor
            a[1][5] = 1 / motor
            a[3][:5] = [value / inertia for value in press]
            a[3][2] -= mp.mpf(hand["stiffness"]) / inertia
            a[3][3] -= resisting / inertia
            a[3][4] -= mp.mpf(scene["bias"]["torque"]) / inertia
            self.over[flank] = [exponential(a, mp.ldexp(self.step, -i)) for i in range(HALVINGS)]
        self.closest, self.events = mp.mpf(1), 0  # of all runs: counts to the nearest edge, ends of modes

    def presses(self, state: list[Any], flank: int) -> bool:
        overlap = flank * (state[0] / self.n - state[2]) - self.half
        return bool(overlap > 0 and self.k * overlap + self.c * flank * (state[1] / self.n - state[3]) > 0)

    def goes_on(self, state: list[Any], flank: int) -> bool:
        if flank:
            return self.presses(state, flank)
        return not (self.presses(state, 1) or self.presses(state, -1))

    def move(self, state: list[Any], flank: int, level: int = 0) -> tuple[list[Any], int]:
        """State and flank after 2^-``level`` of a step: at once if the mode goes on, else by both halves."""
        then = apply(self.over[flank][level], state)
        if self.goes_on(then, flank):
            return then, flank
        if level + 1 == HALVINGS:
            self.events += 1
            return then, 0 if flank else (1 if self.presses(then, 1) else -1)
        state, flank = self.move(state, flank, level + 1)
        return self.move(state, flank, level + 1)

    def run(self, angle: float, samples: int) -> list[Sample]:
        """States at the samples; the first is half a period after a start at rest, on the flank of the wall."""
        n, zero = self.n, mp.mpf(0)
        state = [n * (mp.mpf(angle) + self.half), zero, mp.mpf(angle), zero, mp.mpf(1), zero]
        flank, found = 1, []
        for i in range(samples + 1):
            for _ in range(STEPS // 2 if i == 0 else STEPS):
                state, flank = self.move(state, flank)
            motor = state[0] / n - self.half
            at = n * motor / self.count
            count = mp.floor(at)
            self.closest = min(self.closest, at - count, count + 1 - at)
            state[5] = -self.wall * count * self.count / n / n if count < 0 else zero
            found.append(Sample(motor, state[1] / n, state[2], state[3]))
        return found
