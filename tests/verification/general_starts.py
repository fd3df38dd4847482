"""Starts of scenes without friction, simulated side by side by SciPy's matrix exponentials, in SI.

Nothing of the package is used. A scene is a spec's plain dictionary, with a torque or half a count's torque as bias,
without an offset of the encoder. Torques over the angle are rounded from 60 digits (`over_angle_reference`).
"""

from math import inf, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from .over_angle_reference import torques


def matrix(parts: dict[str, Any], push: float) -> NDArray[np.float64]:
    """Rates of (angle, speed, [finger's angle and speed], [torque], command, 1) by themselves, SI."""
    hand, lag = parts["hand"], parts.get("actuator", {}).get("time_constant", 0.0)
    n = 4 if "finger" in hand else 2
    m = n + (1 if lag else 0)
    inertia = parts["knob"]["inertia"] + hand.get("inertia", 0.0)
    a = np.zeros((m + 2, m + 2))
    a[0, 1] = 1.0
    a[1, 0] = -hand.get("stiffness", 0.0) / inertia
    a[1, 1] = -(parts["knob"].get("damping", 0.0) + hand.get("damping", 0.0)) / inertia
    a[1, m + 1] = -push / inertia
    if n == 4:
        pad, tip = hand["fingerpad"], hand["finger"]
        between = np.array([pad["stiffness"], pad["damping"]])
        a[1, :4] += np.concatenate([-between, between]) / inertia
        a[2, 3] = 1.0
        own = np.array([tip["stiffness"], tip["damping"]])
        a[3, :4] = np.concatenate([between, -between - own]) / tip["inertia"]
    a[1, m - 1 if lag else m] += 1.0 / inertia
    if lag:
        a[m - 1, m - 1], a[m - 1, m] = -1.0 / lag, 1.0 / lag
    return a


def readings(
    parts: dict[str, Any], rate_hz: float, counts: int, starts: NDArray[np.float64], samples: int, kept: int
) -> NDArray[np.float64]:
    """Readings inside the wall, 0 outside, of the last samples of each start; shape (kept, starts).

    With a torque over the angle all readings, outside of the wall, too.
    """
    period, quantum = 1.0 / rate_hz, 2.0 * pi / counts
    actuator, wall = parts.get("actuator", {}), parts["wall"]
    delay = actuator.get("delay_samples", 0.0)
    late, split = int(delay), delay - int(delay)
    bias = parts["bias"]
    push = 0.5 * wall["stiffness"] * quantum if bias.get("half_quantum") else bias["torque"]
    a = matrix(parts, push)
    first, rest = expm(a * split * period), expm(a * (1.0 - split) * period)
    command_at = len(a) - 2
    z = np.zeros((len(a), len(starts)))
    z[0], z[1], z[-1] = starts[:, 0], starts[:, 1], 1.0
    if "finger" in parts["hand"]:
        z[2:4] = z[:2]
    rounding = parts.get("encoder", {}).get("rounding", "floor")

    def count(angle: NDArray[np.float64]) -> NDArray[np.float64]:
        x = angle / quantum
        if rounding == "floor":
            return np.floor(x)
        if rounding == "nearest":
            return np.floor(x + 0.5)
        return np.ceil(x) if rounding == "ceil" else np.trunc(x)

    over = torques(parts, counts)
    under_way = [np.zeros(len(starts)) for _ in range(late + 1)]
    last, seen = count(z[0]), []
    for sample in range(samples + kept):
        level = count(z[0])
        torque = -wall["stiffness"] * quantum * level - wall.get("damping", 0.0) * quantum / period * (level - last)
        torque = np.where(level < 0, torque, 0.0) + (over(level) if over else 0.0)
        torque = np.where(np.abs(torque) < actuator.get("dead_band", 0.0), 0.0, torque)
        if step := actuator.get("torque_step", 0.0):
            torque = step * np.floor(torque / step + 0.5)
        limit = actuator.get("torque_limit", inf)
        under_way = [*under_way, np.clip(torque, -limit, limit)][-(late + 2) :]
        last = level
        if sample >= samples:
            seen.append(level if over else np.minimum(level, 0.0))
        if split > 0.0:
            z[command_at] = under_way[-2 - late]
            z = first @ z
        z[command_at] = under_way[-1 - late]
        z = rest @ z
    return np.array(seen)


def turned(levels: list[int]) -> tuple[int, ...]:
    """The shortest period of levels, turned so that every way to write it is the same."""
    n = len(levels)
    shortest = next(p for p in range(1, n + 1) if n % p == 0 and levels == levels[:p] * (n // p))
    one = levels[:shortest]
    return min(tuple(one[i:] + one[:i]) for i in range(shortest))
