"""Measures of orbits of the general loop: those of the plain loop where both follow the knob, and what neither has."""

from math import isnan
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.measure.orbit import Measurer, OrbitMeasures
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.scene import SceneSpec
from tests.verification.general_scenes import LIGHT, TWO_PARTS, scene
from tests.verification.law_scenes import FOR_EVER


@pytest.fixture(scope="module")
def engine() -> GeneralEngine:
    return GeneralEngine(compiled("general"))


def general(parts: dict[str, Any], engine: GeneralEngine, counts: int = 1024) -> list[OrbitMeasures]:
    """Measures of the cycles of a scene, by the general loop, from the smallest."""
    knob = sample_general(SceneSpec.model_validate(parts).plain(), sample_rate_hz=1000.0, counts_per_rev=counts)
    start = knob.start(0.02, 0.0)
    found = engine.search(
        knob.body, knob.wall, start, rate=knob.rate, phases=8, delay_line=knob.delay_line, max_samples=None
    )
    measurer = GeneralMeasurer(knob, engine)
    said = [measurer.measure(one) for one in found.attractors if one.outcome is Outcome.CYCLE]
    assert said
    return sorted(said, key=lambda one: one.p2p_rad)


def plain(parts: dict[str, Any], counts: int = 1024) -> list[OrbitMeasures]:
    """The same, by the plain loop."""
    knob = sample_knob(SceneSpec.model_validate(parts).plain(), sample_rate_hz=1000.0, counts_per_rev=counts)
    engine = Engine()
    found = engine.search(
        knob.loop, x=knob.position(0.02), v=0.0, phases=8, delay_line=knob.delay_line, max_samples=None
    )
    measurer = Measurer(knob, engine)
    said = [measurer.measure(one) for one in found.attractors if one.outcome is Outcome.CYCLE]
    return sorted(said, key=lambda one: one.p2p_rad)


@pytest.mark.parametrize("late", [0.0, 0.4, 2.0])
def test_measures_are_those_of_the_plain_loop(late: float, engine: GeneralEngine) -> None:
    """What neither has is no number in both."""
    parts = scene(actuator={"delay_samples": late})
    for one, other in zip(general(parts, engine), plain(parts), strict=True):
        for name in OrbitMeasures._fields:
            wanted, said = getattr(other, name), getattr(one, name)
            assert said == pytest.approx(wanted, rel=1e-8, abs=1e-18, nan_ok=True), name
        assert isnan(one.friction_loss_j)
        assert one.late_exit_j != 0.0


PARTS = {
    "lag": scene(actuator={"time_constant": 2e-4}),
    "table": scene(profile={"points": [[-0.5, 0.1], [0.0, 0.0], [0.5, 0.0]]}),
    "hysteresis": scene(encoder={"hysteresis_counts": 0.5}),
}


@pytest.mark.parametrize("name", PARTS)
def test_a_late_edge_is_of_the_plain_wall_alone(name: str) -> None:
    """Interpreted: eight trials do not repay a compiler."""
    for one in general(PARTS[name], GeneralEngine(patience=FOR_EVER)):
        assert all(isnan(value) for value in (one.late_entry_j, one.late_exit_j, one.staircase_j))
        assert not isnan(one.wall_work_j)


@pytest.mark.parametrize("hand", [None, TWO_PARTS], ids=["one body", "two bodies"])
def test_friction_takes_its_torque_times_the_way(hand: Any, engine: GeneralEngine) -> None:
    """A period's work is lost to dampers and to friction."""
    parts = scene(knob=LIGHT, **({"hand": hand} if hand else {}))
    for one in general(parts, engine):
        assert one.friction_loss_j > 0.0
        assert one.wall_work_j == pytest.approx(one.damping_loss_j + one.friction_loss_j, rel=1e-6)
        assert np.isfinite(one.rms_rad)
