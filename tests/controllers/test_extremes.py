"""Controllers where a scene is extreme: labelled ends, finite numbers, no warning."""

from math import isfinite
from typing import Any

import pytest

from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import loaded
from tests.controllers.laws import CONTROLLERS

SPEC = """\
kind: sweep
name: extreme
scene:
  knob: {inertia: 1.9e-6}
  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}
  wall: {stiffness: 0.27}
  bias: {torque: 0.001}
  controller: CONTROLLER
grid:
  sample_rate_hz: [1000]
  counts_per_rev: [1024]
starts: {angle: 0.02, phases: 2}
"""
SCENES = {
    "no hand stiffness": (", stiffness: 0.04", ""),
    "slow": ("[1000]", "[0.5, 20]"),
    "fast": ("[1000]", "[30000]"),
    "one count": ("[1024]", "[1, 3]"),
    "fine": ("[1024]", "[4000000]"),
    "hard": ("0.27", "1.0e+6"),
    "soft": ("0.27", "1.0e-9"),
    "no push": ("{torque: 0.001}", "{torque: 0}"),
    "weak": ("bias: {torque: 0.001}", "bias: {torque: 0.001}\n  actuator: {torque_limit: 1.0e-5}"),
}
QUICK = ["bounded lag", "half sample, sensor", "impulse, timed", "matched wall", "passivity", "phase, both"]


def ends(controller: dict[str, Any], *change: str) -> list[dict[str, Any]]:
    settings = ", ".join(f"{key}: {str(value).lower()}" for key, value in controller.items())
    text = SPEC.replace("CONTROLLER", f"{{{settings}}}").replace(*change)
    return SweepStage(loaded(text), jobs=1).run().orbits.to_pylist()


@pytest.mark.one_in(3)
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", QUICK)
def test_ends_are_labelled(name: str, scene: str) -> None:
    rows = ends(CONTROLLERS[name], *SCENES[scene])
    assert rows
    for row in rows:
        assert row["outcome"] in ("cycle", "rest", "diverged", "undecided")
        assert row["certified"] == (not row["reason"])
        if row["outcome"] in ("cycle", "rest") and row["certified"]:
            assert all(isfinite(row[key]) for key in ("p2p_rad", "rms_rad", "frequency_hz", "margin_counts"))
            assert row["margin_counts"] > 0.0


def test_without_hand_stiffness_cycles_are_a_continuum() -> None:
    rows = ends(CONTROLLERS["stiffening"], ", stiffness: 0.04", "")
    assert rows
    assert not any(row["certified"] for row in rows if row["outcome"] == "cycle")


def test_a_torque_limit_bounds_the_torque() -> None:
    """Below the push no wall holds the knob: it rests against the hand's spring, at (limit - push)/stiffness."""
    rows = ends(
        CONTROLLERS["bounded lag"], "bias: {torque: 0.001}", "bias: {torque: 0.01}\n  actuator: {torque_limit: 0.002}"
    )
    assert [row["outcome"] for row in rows] == ["rest"]
    assert rows[0]["min_rad"] == pytest.approx((0.002 - 0.01) / 0.04, rel=1e-9)
