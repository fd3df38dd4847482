"""`velocity_damping`: virtual damping beside the spring, on a velocity as firmware has it."""

from math import exp
from typing import Any

import numpy as np

from tests import digits as mp
from tests.controllers.page_blocks import Page
from tests.controllers.reference import Law

# Variants by name, with numbers that make them act; and those of which the page's block is run.
CONTROLLERS: dict[str, dict[str, Any]] = {
    "damping, differenced": {"kind": "velocity_damping", "damping": 3.0e-4},
    "damping, sensor": {"kind": "velocity_damping", "damping": 1.0e-3, "velocity": "sensor"},
    "damping, negative": {"kind": "velocity_damping", "damping": -1.0e-4, "velocity": "sensor", "everywhere": True},
    "velocity, cut off": {"kind": "velocity_damping", "damping": 1.0e-4, "window": 2, "cut_off": 2.0},
    "velocity, filtered": {"kind": "velocity_damping", "damping": 2.0e-4, "low_pass": 0.004, "everywhere": True},
    "velocity, filtered, cut off": {
        "kind": "velocity_damping",
        "damping": 2.0e-4,
        "window": 3,
        "low_pass": 0.01,
        "cut_off": 2.0,
    },
    "velocity, windowed": {"kind": "velocity_damping", "damping": 3.0e-4, "window": 5},
}
VARIANTS: list[dict[str, Any]] = list(CONTROLLERS.values())
# Those that the compiled general loop alone has.
LOOP_ONLY: dict[str, dict[str, Any]] = {
    "speed, timed": {"kind": "velocity_damping", "damping": 2.0e-4, "velocity": "timed", "time_out": 0.03},
    "speed, timed, filtered": {
        "kind": "velocity_damping",
        "damping": 2.0e-4,
        "velocity": "timed",
        "time_out": 0.02,
        "detections": 5,
        "low_pass": 0.003,
        "cut_off": 1.5,
    },
    "speed, adaptive": {"kind": "velocity_damping", "damping": 2.0e-4, "velocity": "adaptive", "window": 12},
    "speed, adaptive, filtered": {
        "kind": "velocity_damping",
        "damping": 2.0e-4,
        "velocity": "adaptive",
        "window": 5,
        "low_pass": 0.002,
        "angle": "filtered",
        "everywhere": True,
    },
    "speed, tracked": {"kind": "velocity_damping", "damping": 2.0e-4, "velocity": "tracking", "bandwidth": 200.0},
    "speed and angle, tracked": {
        "kind": "velocity_damping",
        "damping": 1.0e-4,
        "velocity": "tracking",
        "bandwidth": 150.0,
        "angle": "filtered",
        "cut_off": 2.0,
    },
    "speed, Kalman": {"kind": "velocity_damping", "damping": 2.0e-4, "velocity": "kalman", "acceleration": 300.0},
    "angle, filtered": {"kind": "velocity_damping", "damping": 0.0, "low_pass": 0.002, "angle": "filtered"},
    "speed and angle, filtered": {
        "kind": "velocity_damping",
        "damping": 1.0e-4,
        "window": 3,
        "low_pass": 0.002,
        "angle": "filtered",
    },
}


def longest_line(places: list[Any], within: Any) -> Any:
    """Slope of the line of Janabi-Sharifi et al. from the newest place, the last, to the oldest that it may."""
    newest, slope = places[-1], None
    for n in range(1, len(places)):
        tried = (newest - places[-1 - n]) / n
        if any(abs(newest - tried * j - places[-1 - j]) > within for j in range(1, n)):
            break
        slope = tried
    return slope


def riccati(acceleration: Any, period: Any, error: Any) -> tuple[Any, Any]:
    """The gains where a Kalman filter's covariance has settled, by its recursion from a start that knows nothing."""
    drive = [period * period / 2, period]
    p = [[error**2 * 10**6, error * 0], [error * 0, (error / period) ** 2 * 10**6]]
    last, gains = None, (error * 0, error * 0)
    while last is None or max(abs(a - b) for a, b in zip(gains, last, strict=True)) > abs(gains[0]) * 1e-38:
        ahead = [[p[0][0] + period * p[1][0], p[0][1] + period * p[1][1]], p[1]]
        p = [[row[0] + period * row[1], row[1]] for row in ahead]
        p = [[p[i][j] + acceleration**2 * drive[i] * drive[j] for j in range(2)] for i in range(2)]
        last, total = gains, p[0][0] + error**2
        gains = (p[0][0] / total, p[1][0] / total)
        p = [[p[i][j] - gains[i] * p[0][j] for j in range(2)] for i in range(2)]
    return gains


class Source(Law):
    """The controller as its source has it."""

    def begin(self) -> None:
        self.filtered = self.zero
        self.seen: list[Any] = []
        self.angle: Any = None
        self.clock, self.changed_at, self.last = 0, 0, None
        self.pace = self.zero
        if self.numbers.get("velocity") == "kalman":
            with mp.workdps(50):
                exact = [mp.mpf(one) for one in (self.numbers["acceleration"], self.rig.period, self.rig.quantum)]
                self.gains = [self.rig.number(one) for one in riccati(exact[0], exact[1], exact[2] / mp.sqrt(12))]

    def act(self, shown: Any, speed: Any, before: Any, looks: list[Any]) -> Any:
        window, velocity = self.numbers.get("window", 1), self.numbers.get("velocity")
        self.seen = [*(self.seen or [shown] * window), shown][-window - 1 :]
        if self.angle is None:
            self.angle = shown
        at = shown
        if velocity == "timed":
            speed = self.timed([*looks, shown], before)
        elif velocity == "adaptive":
            # Readings are whole counts, so that a line that is a count off is so up to rounding.
            speed = longest_line(self.seen, self.rig.quantum * (1 + mp.mpf(10) ** -12)) / self.rig.period
        elif velocity in ("tracking", "kalman"):
            time, w = self.rig.period, self.numbers.get("bandwidth")
            near, fast = self.gains if w is None else (time * 2 * w, time * w * w)
            self.angle += time * self.filtered
            error = shown - self.angle
            self.angle += near * error
            self.filtered += fast * error
            speed, at = self.filtered, self.angle
        elif window > 1:
            speed = (shown - self.seen[0]) / (window * self.rig.period)
        if "low_pass" in self.numbers:
            whole = mp.exp if self.rig.number is mp.mpf else np.exp
            r = whole(-self.rig.period / self.numbers["low_pass"])
            speed = self.filtered = r * self.filtered + (1 - r) * speed
            self.angle = at = r * self.angle + (1 - r) * shown
        if self.numbers.get("angle") != "filtered":
            at = shown
        self.silent = "cut_off" in self.numbers and bool(abs(speed) > self.numbers["cut_off"])
        if self.silent:
            return self.zero
        acts = at < 0 or self.numbers.get("everywhere", False)
        return self.rig.spring(at) - (self.numbers["damping"] * speed if acts else self.zero)

    def timed(self, readings: list[Any], before: Any) -> Any:
        """By a clock that never stops: the time of each change is kept, to a part of a sample."""
        each = self.rig.period / len(readings)
        still = len(readings) * max(1, round(self.numbers["time_out"] / self.rig.period))
        start = before if self.last is None else self.last
        last, newest = start, None
        for reading in readings:
            self.clock += 1
            if reading != last:
                newest = self.clock
            last = reading
        self.last = last
        if newest is not None:
            self.pace = (last - start) / (min(newest - self.changed_at, still) * each)
            self.changed_at = newest
        since = self.clock - self.changed_at
        if since >= still:
            self.pace = self.zero
        elif since > 0 and abs(self.pace) > self.rig.quantum / (since * each):
            self.pace = (1 if self.pace > 0 else -1) * self.rig.quantum / (since * each)
        return self.pace


class Block(Page):
    """The page's block."""

    def first(self) -> None:
        self.y = 0.0
        self.p: float | None = None
        self.s, self.z = 0, 0.0
        self.places: list[float] = []

    def block(self) -> float:
        n = self.key.get("window", 1)
        if not self.places:
            self.places = [self.th] * n
            self.p = self.last = self.th
        x = self.speed(n)
        self.places.append(self.th)
        assert self.p is not None
        if self.key.get("velocity") == "tracking":
            e = self.th - (self.p + x * self.T)
            self.p += x * self.T + 2.0 * self.key["bandwidth"] * self.T * e
            self.y = x = x + self.key["bandwidth"] ** 2 * self.T * e
        elif self.key.get("velocity") == "kalman":
            g = self.key["acceleration"] * self.T**2 * 12.0**0.5 / self.D
            d = ((8.0 * g + g * g) ** 0.5 - g) / 4.0
            e = self.th - (self.p + x * self.T)
            self.p += x * self.T + d * (2.0 - d) * e
            self.y = x = x + 2.0 * d * d * e / self.T
        elif "low_pass" in self.key:
            a = 1.0 - exp(-self.T / self.key["low_pass"])
            self.y = self.y + a * (x - self.y)
            self.p = self.p + a * (self.th - self.p)
            x = self.y
        at = self.p if self.key.get("angle") == "filtered" else self.th
        torque = self.wall(at)
        if at < 0.0 or self.key.get("everywhere", False):
            torque = torque - self.key["damping"] * x
        return 0.0 if abs(x) > self.key.get("cut_off", float("inf")) else torque

    def speed(self, n: int) -> float:
        velocity = self.key.get("velocity", "differenced")
        if velocity == "sensor":
            return self.v
        if velocity == "differenced":
            return (self.th - self.places[-n]) / (n * self.T)
        if velocity in ("tracking", "kalman"):
            return self.y
        if velocity == "adaptive":
            counts = [round(place / self.D) for place in [*self.places[-n:], self.th]]
            found = 0.0
            for m in range(1, n + 1):
                # c_j m >= ... in whole numbers: |c - (c - c_m) j/m - c_j| <= 1
                if any(
                    abs((counts[-1] - counts[-1 - j]) * m - (counts[-1] - counts[-1 - m]) * j) > m for j in range(m)
                ):
                    break
                found = (counts[-1] - counts[-1 - m]) * self.D / (m * self.T)
            return found
        d = self.key.get("detections", 1)
        still = d * max(1, round(self.key["time_out"] / self.T))
        first, u = self.last, 0
        for reading in [*self.looks, self.th]:
            self.s = min(self.s + 1, still)
            if reading != self.last:
                u, self.s = u + self.s, 0
            self.last = reading
        if u > 0:
            self.z = (self.th - first) * d / (min(u, still) * self.T)
        if self.s > 0:
            bound = self.D * d / (self.s * self.T)
            self.z = min(max(self.z, -bound), bound)
        if self.s == still:
            self.z = 0.0
        return self.z
