"""Every start of scenes with more than the plain loop has, without friction, against starts simulated one by one.

The simulation (`general_starts`) shares nothing with the engine.
Starts are random states of the box; what their readings repeat in the end must be an orbit of the list.
"""

from math import pi
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hknob_cli.engine.attractors import Attractor, Search
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.sets.search import Box
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.scene import SceneSpec

from .general_scenes import TWO_PARTS, scene
from .general_starts import readings, turned

COUNT = 2.0 * pi / 1024
STARTS = 2000
FREE = {"wall": {"stiffness": 0.0}}
CASES: list[tuple[str, float, int, dict[str, Any]]] = [
    ("whole delay", 1000.0, 1024, {"actuator": {"delay_samples": 1.0}}),
    ("fractional delay", 2000.0, 512, {"actuator": {"delay_samples": 1.6}, "encoder": {"rounding": "ceil"}}),
    ("limit and step", 1000.0, 1024, {"actuator": {"torque_limit": 0.8 * COUNT, "torque_step": 0.15 * COUNT}}),
    ("virtual damping", 464.0, 1024, {"wall": {"damping": 4e-5}, "encoder": {"rounding": "truncate"}}),
    ("nearly all", 700.0, 1024, {"wall": {"damping": 2e-5}, "actuator": {"delay_samples": 0.4, "torque_limit": COUNT}}),
    ("lag", 464.0, 1024, {"actuator": {"time_constant": 2e-4}}),
    ("finger", 464.0, 1024, {"hand": TWO_PARTS}),
    ("dead band", 1000.0, 1024, {"actuator": {"dead_band": 0.7 * COUNT}}),
    ("detents", 1000.0, 1024, {**FREE, "detents": {"per_revolution": 60, "torque": 4e-3}}),
    (
        "detents that jump, late",
        1000.0,
        512,
        {
            **FREE,
            "detents": {"per_revolution": 40, "torque": 4e-3, "shape": "spring"},
            "actuator": {"delay_samples": 1.0},
        },
    ),
    (
        "end stops and a limit",
        700.0,
        1024,
        {**FREE, "end_stops": {"low": -0.02, "high": 0.03, "stiffness": 0.3}, "actuator": {"torque_limit": 3e-3}},
    ),
    (
        "dead zone and lag",
        1000.0,
        512,
        {**FREE, "dead_zone": {"width": 0.06, "stiffness": 0.2}, "actuator": {"time_constant": 1e-4}},
    ),
    (
        "profile",
        464.0,
        1024,
        {
            **FREE,
            "profile": {"points": [[-0.05, 4e-3], [0.0, 1e-3], [0.04, -2e-3]], "interpolation": "stepped"},
            "encoder": {"rounding": "nearest"},
        },
    ),
]


def orbit_levels(knob: GeneralKnob, one: Attractor) -> tuple[int, ...]:
    """Readings of one period of an attractor of the list."""
    z, ring, before, head = [one.x, one.v, *one.state], list(one.line), one.before, 0
    seen = []
    for _ in range(one.period):
        shown = int(read(z[0], knob.wall))
        seen.append(min(0, shown) if knob.wall.table is None else shown)
        before, head = advance(z, before, ring, head, knob.body, knob.wall, [0.0] * (2 * knob.body.order))
    return turned(seen)


IDS = [case[0] for case in CASES]
FROM_AFAR = [
    case for case in CASES if case[0] in ("limit and step", "dead band", "detents", "end stops and a limit", "profile")
]
FROM_AFAR += [
    ("limit", 1000.0, 512, {"actuator": {"torque_limit": 4e-3}, "encoder": {"rounding": "truncate"}}),
    ("step", 1000.0, 1024, {"actuator": {"torque_step": 0.3 * COUNT}, "encoder": {"rounding": "nearest"}}),
    (
        "end stops and the wall",
        1000.0,
        1024,
        {"end_stops": {"low": -0.02, "high": 0.03, "stiffness": 0.1}},
    ),
    ("dead zone", 1000.0, 512, {**FREE, "dead_zone": {"width": 0.06, "stiffness": 0.2}}),
    ("detents and the wall", 1000.0, 512, {"detents": {"per_revolution": 60, "torque": 1e-3}}),
]


def every_start_ends_in_a_listed_orbit(
    parts: dict[str, Any], rate: float, counts: int, found: Search, starts: NDArray[np.float64]
) -> None:
    """``found``: the list, all of whose orbits are proven; ``starts``: (n, 2), rad and rad/s, each simulated."""
    knob = sample_general(SceneSpec.model_validate(parts).plain(), sample_rate_hz=rate, counts_per_rev=counts)
    assert found.complete
    assert all(one.certified for one in found.attractors)
    listed = {orbit_levels(knob, one) for one in found.attractors}
    assert len(listed) >= 1
    assert {one.outcome for one in found.attractors} <= {Outcome.CYCLE, Outcome.REST}
    longest = max(len(levels) for levels in listed)
    seen = readings(parts, rate, counts, starts, int(40.0 / knob.rate), longest)
    for j in range(len(starts)):
        last = [int(level) for level in seen[:, j]]
        assert any(turned(last[-len(levels) :]) == levels for levels in listed), (starts[j], last)


@pytest.mark.long
@pytest.mark.parametrize(("rate", "counts", "more"), [case[1:] for case in CASES], ids=IDS)
def test_random_starts_end_in_listed_orbits_only(rate: float, counts: int, more: dict[str, Any]) -> None:
    """Of a box of twenty counts to each side; the list is complete, and no start ends elsewhere."""
    parts = scene(**more)
    knob = sample_general(SceneSpec.model_validate(parts).plain(), sample_rate_hz=rate, counts_per_rev=counts)
    far, fast = 20.0 * knob.quantum_rad, 5.0 * knob.quantum_rad * rate
    box = Box(knob.position(-far), knob.position(far), knob.speed(-fast), knob.speed(fast))
    engine = GeneralSetEngine(compiled("general sets"))
    given = {"rate": knob.rate, "delay_line": knob.delay_line, "max_samples": None}
    found = engine.search_box(knob.body, knob.wall, box, **given)
    assert found
    chance = np.random.default_rng(int(rate))
    starts = np.column_stack([chance.uniform(-far, far, STARTS), chance.uniform(-fast, fast, STARTS)])
    every_start_ends_in_a_listed_orbit(parts, rate, counts, found, starts)


@pytest.mark.long
@pytest.mark.parametrize(
    ("rate", "counts", "more"), [case[1:] for case in FROM_AFAR], ids=[case[0] for case in FROM_AFAR]
)
def test_starts_from_afar_end_in_listed_orbits_only(rate: float, counts: int, more: dict[str, Any]) -> None:
    """From within the region that all come into, and from up to a thousand times as far."""
    parts = scene(**more)
    knob = sample_general(SceneSpec.model_validate(parts).plain(), sample_rate_hz=rate, counts_per_rev=counts)
    engine = GeneralSetEngine(compiled("general sets"))
    found = engine.search_anywhere(knob.body, knob.wall, rate=knob.rate, delay_line=knob.delay_line, max_samples=None)
    assert found.region
    chance = np.random.default_rng(int(rate))
    sizes = 10.0 ** chance.uniform(-1.0, 3.0, (STARTS, 1))
    x = chance.uniform(*found.region[:2], STARTS)
    v = chance.uniform(*found.region[2:], STARTS)
    unit = np.array([knob.quantum_rad, knob.quantum_rad * rate])
    every_start_ends_in_a_listed_orbit(parts, rate, counts, found, np.column_stack([x, v]) * unit * sizes)
