"""Controllers that read an angle without counts, against the 60-digit model under the same law.

A trial has the model's angle at every sample. What it is said to come to, which nothing proves, is what the model comes
to: where it rests, or the deepest sample and the period of its cycle.
"""

from typing import Any

import pytest

from tests.controllers.laws import EVERY

from .general_scenes import TWO_PARTS, scene
from .random_scenes import Case, Verdict, compare

COUNTED = ("bounded lag", "impulse", "phase", "timed", "adaptive", "Kalman", "fitted")
CONTROLLERS = [name for name in EVERY if not any(word in name for word in COUNTED)]
STIFF = {"wall": {"stiffness": 2.0}}
SCENES: dict[str, tuple[dict[str, Any], float]] = {
    "alone": ({}, 1000.0),
    "stiff, delay": ({**STIFF, "actuator": {"delay_samples": 1.0}}, 1000.0),
    "stiff, friction, lag": ({**STIFF, "knob": {"coulomb_torque": 1e-4}, "actuator": {"time_constant": 3e-4}}, 464.0),
    "steps, limit": ({"actuator": {"torque_step": 4e-4, "torque_limit": 4e-3}}, 1000.0),
    "dead band, part of a sample": ({"actuator": {"dead_band": 2e-3, "delay_samples": 0.4}}, 464.0),
    "finger, virtual damping": ({"hand": TWO_PARTS, "wall": {"stiffness": 0.27, "damping": 1e-5}}, 1000.0),
}


def follow(controller: str, name: str) -> Verdict:
    """What was compared of a scene under a controller."""
    parts, rate = SCENES[name]
    made = scene(**parts, encoder="none")
    made["controller"] = dict(EVERY[controller])
    return compare(Case(0, (name,), made, rate, None))


def test_controllers_that_read_an_angle() -> None:
    assert len(CONTROLLERS) == 21


@pytest.mark.one_in(20)
@pytest.mark.parametrize("controller", CONTROLLERS)
def test_trials_and_what_they_come_to(controller: str) -> None:
    found = [follow(controller, name) for name in SCENES]
    assert sum(one.samples for one in found) >= 200
    assert sum(one.settled for one in found) >= 2, found
    assert all("not proven" in one.outcome for one in found)


@pytest.mark.long
def test_both_rest_and_cycles_are_compared() -> None:
    found = [follow(controller, name) for controller in CONTROLLERS for name in ("alone", "steps, limit")]
    said = [one.outcome for one in found if one.settled]
    assert min(said.count("rest, not proven"), said.count("cycle, not proven")) >= 5
