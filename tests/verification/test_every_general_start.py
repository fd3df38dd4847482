"""Every start of scenes with delay, limits, virtual damping, lag or a finger, against starts simulated one by one.

The simulation is by SciPy's matrix exponentials, in SI, over many starts at once, and shares nothing with the engine.
Starts are random states of the box; what their readings repeat in the end must be an orbit of the list.
"""

from math import inf, pi
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.sets.search import Box
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.scene import SceneSpec

from .general_scenes import TWO_PARTS, scene

COUNT = 2.0 * pi / 1024
STARTS = 2000
CASES: list[tuple[str, float, int, dict[str, Any]]] = [
    ("whole delay", 1000.0, 1024, {"actuator": {"delay_samples": 1.0}}),
    ("fractional delay", 2000.0, 512, {"actuator": {"delay_samples": 1.6}, "encoder": {"rounding": "ceil"}}),
    ("limit and step", 1000.0, 1024, {"actuator": {"torque_limit": 0.8 * COUNT, "torque_step": 0.15 * COUNT}}),
    ("virtual damping", 464.0, 1024, {"wall": {"damping": 4e-5}, "encoder": {"rounding": "truncate"}}),
    ("nearly all", 700.0, 1024, {"wall": {"damping": 2e-5}, "actuator": {"delay_samples": 0.4, "torque_limit": COUNT}}),
    ("lag", 464.0, 1024, {"actuator": {"time_constant": 2e-4}}),
    ("finger", 464.0, 1024, {"hand": TWO_PARTS}),
]


def matrix(parts: dict[str, Any]) -> NDArray[np.float64]:
    """Rates of (angle, speed, [finger's angle and speed], [torque], command, 1) by themselves, SI."""
    hand, lag = parts["hand"], parts.get("actuator", {}).get("time_constant", 0.0)
    n = 4 if "finger" in hand else 2
    m = n + (1 if lag else 0)
    inertia = parts["knob"]["inertia"] + hand.get("inertia", 0.0)
    a = np.zeros((m + 2, m + 2))
    a[0, 1] = 1.0
    a[1, 0] = -hand.get("stiffness", 0.0) / inertia
    a[1, 1] = -(parts["knob"].get("damping", 0.0) + hand.get("damping", 0.0)) / inertia
    a[1, m + 1] = -parts["bias"]["torque"] / inertia
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
    """Readings inside the wall, 0 outside, of the last samples of each start; shape (kept, starts)."""
    period, quantum = 1.0 / rate_hz, 2.0 * pi / counts
    actuator, wall = parts.get("actuator", {}), parts["wall"]
    delay = actuator.get("delay_samples", 0.0)
    late, split = int(delay), delay - int(delay)
    a = matrix(parts)
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
        return np.ceil(x) if rounding == "ceil" else np.trunc(x)

    under_way = [np.zeros(len(starts)) for _ in range(late + 1)]
    last, seen = count(z[0]), []
    for sample in range(samples + kept):
        level = count(z[0])
        torque = -wall["stiffness"] * quantum * level - wall.get("damping", 0.0) * quantum / period * (level - last)
        if step := actuator.get("torque_step", 0.0):
            torque = step * np.floor(torque / step + 0.5)
        limit = actuator.get("torque_limit", inf)
        under_way = [*under_way, np.where(level < 0, np.clip(torque, -limit, limit), 0.0)][-(late + 2) :]
        last = level
        if sample >= samples:
            seen.append(np.minimum(level, 0.0))
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


def orbit_levels(knob: GeneralKnob, one: Attractor) -> tuple[int, ...]:
    """Readings of one period of an attractor of the list."""
    z, ring, before, head = [one.x, one.v, *one.state], list(one.line), one.before, 0
    seen = []
    for _ in range(one.period):
        seen.append(min(0, int(read(z[0], knob.wall))))
        before, head = advance(z, before, ring, head, knob.body, knob.wall, [0.0] * (2 * knob.body.order))
    return turned(seen)


@pytest.mark.long
@pytest.mark.parametrize(("rate", "counts", "more"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_random_starts_end_in_listed_orbits_only(rate: float, counts: int, more: dict[str, Any]) -> None:
    """Of a box of twenty counts to each side; the list is complete, and no start ends elsewhere."""
    parts = scene(**more)
    knob = sample_general(SceneSpec.model_validate(parts).plain(), sample_rate_hz=rate, counts_per_rev=counts)
    far, fast = 20.0 * knob.quantum_rad, 5.0 * knob.quantum_rad * rate
    box = Box(knob.position(-far), knob.position(far), knob.speed(-fast), knob.speed(fast))
    engine = GeneralSetEngine(compiled("general sets"))
    given = {"rate": knob.rate, "delay_line": knob.delay_line, "max_samples": None}
    found = engine.search_box(knob.body, knob.wall, box, **given)
    assert found.complete
    assert all(one.certified for one in found.attractors)
    listed = {orbit_levels(knob, one) for one in found.attractors}
    assert len(listed) >= 1
    assert {one.outcome for one in found.attractors} <= {Outcome.CYCLE, Outcome.REST}
    chance = np.random.default_rng(int(rate))
    starts = np.column_stack([chance.uniform(-far, far, STARTS), chance.uniform(-fast, fast, STARTS)])
    longest = max(len(levels) for levels in listed)
    seen = readings(parts, rate, counts, starts, int(40.0 / knob.rate), longest)
    for j in range(STARTS):
        last = [int(level) for level in seen[:, j]]
        assert any(turned(last[-len(levels) :]) == levels for levels in listed), (starts[j], last)
