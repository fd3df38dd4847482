"""The whole scene by SciPy's DOP853: friction by events, the finger, the lag and the delay as differential equations.

Slow and of about ten digits; it shares nothing with the package nor with the 60-digit model but the definitions.
"""

from itertools import pairwise
from math import ceil, floor, isclose, pi, trunc
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

RELATIVE, ABSOLUTE = 1e-12, 1e-15


class Run(NamedTuple):
    """Knob and torque at the samples; ``stuck``: whether it was so there."""

    time_s: np.ndarray
    angle_rad: np.ndarray
    velocity_rad_s: np.ndarray
    torque_nm: np.ndarray
    stuck: np.ndarray


def measured_angle(theta: float, quantum: float | None, rounding: str, offset: float) -> float:
    """What the encoder reports [rad]."""
    if quantum is None:
        return theta
    to_level = {"floor": floor, "ceil": ceil, "truncate": trunc, "nearest": lambda x: floor(x + 0.5)}[rounding]
    return (to_level(theta / quantum - offset) + offset) * quantum


class Motion:
    """Knob, finger and torque between events; y = (theta_b, omega_b, theta_a, omega_a, tau)."""

    def __init__(self, scene: dict[str, Any], bias: float, step_s: float) -> None:
        knob, hand = scene["knob"], scene.get("hand") or {}
        self.finger, self.pad = hand.get("finger"), hand.get("fingerpad")
        self.inertia = knob["inertia"] + hand.get("inertia", 0.0)
        self.damping = knob.get("damping", 0.0) + hand.get("damping", 0.0)
        self.stiffness = hand.get("stiffness", 0.0)
        self.friction = knob.get("coulomb_torque", 0.0)
        self.lag = (scene.get("actuator") or {}).get("time_constant", 0.0)
        self.bias = bias
        self.step_s = step_s

    def pad_torque(self, y: np.ndarray) -> float:
        """Torque of the fingerpad on the knob."""
        if self.pad is None:
            return 0.0
        return self.pad.get("stiffness", 0.0) * (y[2] - y[0]) + self.pad.get("damping", 0.0) * (y[3] - y[1])

    def applied(self, y: np.ndarray) -> float:
        """Sum of the torques on the knob but friction."""
        return y[4] - self.bias - self.damping * y[1] - self.stiffness * y[0] + self.pad_torque(y)

    def rates(self, y: np.ndarray, direction: int, command: float) -> list[float]:
        """dy/dt while the knob turns in a ``direction``, or is stuck (0)."""
        rows = [0.0, 0.0, 0.0, 0.0, 0.0]
        if direction:
            rows[:2] = y[1], (self.applied(y) - direction * self.friction) / self.inertia
        if self.finger is not None:
            ground = self.finger.get("stiffness", 0.0) * y[2] + self.finger.get("damping", 0.0) * y[3]
            rows[2:4] = y[3], (-ground - self.pad_torque(y)) / self.finger["inertia"]
        if self.lag:
            rows[4] = (command - y[4]) / self.lag
        return rows

    def direction(self, y: np.ndarray) -> int:
        """Where the knob turns, or starts to; 0: stuck."""
        if y[1] != 0:
            return int(np.sign(y[1]))
        return int(np.sign(self.applied(y))) if abs(self.applied(y)) > self.friction else 0

    def hold(self, y: np.ndarray, command: float, duration: float) -> np.ndarray:
        """State after a hold."""
        if not self.lag:
            y = np.array([*y[:4], command])
        passed, direction = 0.0, self.direction(y)
        while passed < duration and not isclose(passed, duration, rel_tol=1e-15):
            turning = self.friction and direction

            def stop(_: float, y: np.ndarray, direction: int = direction) -> float:
                return direction * y[1]

            def up(_: float, y: np.ndarray) -> float:
                return self.friction - self.applied(y)

            def down(_: float, y: np.ndarray) -> float:
                return self.friction + self.applied(y)

            events = [stop] if turning else [up, down] if not direction else []
            for event in events:
                event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
            if not self.friction:
                direction = direction or 1
            done = solve_ivp(
                lambda _, y, direction=direction: self.rates(y, direction, command),
                (passed, duration),
                y,
                method="DOP853",
                rtol=RELATIVE,
                atol=ABSOLUTE * np.array([1, 1e3, 1, 1e3, 1e-2]),
                max_step=self.step_s,
                events=events or None,
            )
            assert done.success, done.message
            y, passed = done.y[:, -1], float(done.t[-1])
            if done.status == 1:
                if direction:
                    y[1] = 0.0
                    direction = self.direction(y)
                else:
                    direction = 1 if self.applied(y) > 0 else -1
        return y


def integrate(
    scene: dict[str, Any],
    *,
    sample_rate_hz: float,
    counts_per_rev: int | None,
    angle_rad: float,
    velocity_rad_s: float,
    phase: float = 0.5,
    samples: int,
) -> Run:
    """Run a trial, as the package's `simulate` does."""
    wall, actuator, bias = scene["wall"], scene.get("actuator") or {}, scene.get("bias") or {}
    encoder = scene.get("encoder", {})
    shape = encoder if isinstance(encoder, dict) else {}
    quantum = 2 * pi / counts_per_rev if counts_per_rev and encoder != "none" else None
    period = 1 / sample_rate_hz
    push = wall["stiffness"] * (quantum or 0) / 2 if bias.get("half_quantum") else bias.get("torque", 0.0)
    motion = Motion(scene, push, period / 4)
    step, limit = actuator.get("torque_step", 0.0), actuator.get("torque_limit")
    delay = actuator.get("delay_samples", 0.0)

    y = np.array([angle_rad, velocity_rad_s, angle_rad, velocity_rad_s, 0.0])
    y = motion.hold(y, 0.0, phase * period)
    arrivals: list[tuple[float, float]] = [(-np.inf, 0.0)]  # in samples
    before = None
    rows = []
    for i in range(samples + 1):
        m = measured_angle(y[0], quantum, shape.get("rounding", "floor"), shape.get("offset_counts", 0.0))
        before = m if before is None else before
        command = -wall["stiffness"] * m - wall.get("damping", 0.0) * (m - before) / period if m < 0 else 0.0
        before = m
        command = 0.0 if abs(command) < actuator.get("dead_band", 0.0) else command
        command = step * floor(command / step + 0.5) if step else command
        command = command if limit is None else min(max(command, -limit), limit)
        arrivals.append((i + delay, command))
        now = max(k for k, (t, _) in enumerate(arrivals) if t <= i)
        arrivals = arrivals[now:]
        y[4] = y[4] if motion.lag else arrivals[0][1]
        rows.append(((i + phase) * period, *y[:2], y[4], y[1] == 0 and motion.direction(y) == 0))
        times = [float(i), *(t for t, _ in arrivals[1:] if t < i + 1), i + 1.0]
        for k, (start, end) in enumerate(pairwise(times)):
            y = motion.hold(y, arrivals[k][1], (end - start) * period)
    return Run(*map(np.array, zip(*rows, strict=True)))
