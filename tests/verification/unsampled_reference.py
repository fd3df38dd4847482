"""A 50-digit knob without a sample clock, in SI, that shares no formula with the package.

The equation of motion is J theta'' + b theta' + k theta = tau - g, with tau from the measured angle at once. Within a
count the motion is a sum of exponentials, or a polynomial; events are bisected.
"""

from dataclasses import dataclass
from typing import Any

from tests import digits as mp


@dataclass(frozen=True, kw_only=True)
class Ball:
    """Knob and wall; ``quantum``: angle of a count, the encoder rounding down."""

    inertia: Any
    damping: Any
    stiffness: Any
    wall: Any
    bias: Any
    quantum: Any

    def motion(self, theta: Any, omega: Any, torque: Any) -> Any:
        """Angle and velocity as functions of the time from (``theta``, ``omega``) under ``torque``."""
        push = (torque - self.bias) / self.inertia
        a, c = self.damping / self.inertia, self.stiffness / self.inertia
        if c == 0 and a == 0:
            return lambda t: (theta + omega * t + push * t * t / 2, omega + push * t)
        if c == 0:
            final = push / a
            return lambda t: (
                theta + final * t + (omega - final) * (1 - mp.exp(-a * t)) / a,
                final + (omega - final) * mp.exp(-a * t),
            )
        root = mp.sqrt(mp.mpc(a * a / 4 - c))
        s1, s2 = -a / 2 + root, -a / 2 - root
        still = push / c
        c1 = (omega - s2 * (theta - still)) / (s1 - s2)
        c2 = (theta - still) - c1
        return lambda t: (
            (still + c1 * mp.exp(s1 * t) + c2 * mp.exp(s2 * t)).real,
            (s1 * c1 * mp.exp(s1 * t) + s2 * c2 * mp.exp(s2 * t)).real,
        )

    def torque(self, level: int) -> Any:
        """Wall torque while the encoder reads ``level``."""
        return -self.wall * level * self.quantum if level < 0 else mp.mpf(0)

    def run(self, theta: Any, omega: Any, count: int) -> list[tuple[Any, Any, Any, int]]:
        """The first ``count`` count edges inside the wall and turning points: (time, theta, omega, level after)."""
        theta, omega = mp.mpf(theta), mp.mpf(omega)
        level = min(int(mp.floor(theta / self.quantum)), 0)
        time, found = mp.mpf(0), []
        step = mp.mpf("1e-4")
        while len(found) < count:
            move = self.motion(theta, omega, self.torque(level))
            low, high = level * self.quantum, (level + 1) * self.quantum if level < 0 else mp.inf
            way = 1 if omega > 0 or (omega == 0 and move(step / 1000)[1] > 0) else -1

            def over(t: Any, move: Any = move, low: Any = low, high: Any = high, way: int = way) -> bool:
                x, v = move(t)
                return v * way < 0 or x > high or x < low

            # Steps far shorter than the crossing of a count; the first that is over holds the event.
            start = mp.mpf(0)
            while not over(start + step):
                start += step
            end = start + step
            for _ in range(165):
                middle = (start + end) / 2
                if over(middle):
                    end = middle
                else:
                    start = middle
            x, v = move(end)
            time += end
            if x > high or x < low:
                theta, omega = (high, v) if x > high else (low, v)
                level += way
            else:
                theta, omega = x, mp.mpf(0)
            found.append((time, theta, omega, level))
        return found
