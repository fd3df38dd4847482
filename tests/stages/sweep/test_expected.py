"""Tests of `expected`: what the interpreter is expected to take, against what it took (two cores, 2026)."""

import pytest

from hknob_cli.specs.load import load
from hknob_cli.stages.sweep.run import COMPILE_ABOVE, LOADING_S, SweepStage, work_of
from tests.conftest import EXPERIMENTS

FRICTION = "scene.knob.coulomb_torque=0.56 mN*m"
LAG = "scene.actuator.time_constant=50 us"


@pytest.mark.parametrize(
    ("phases", "scene", "took_s"),
    [
        (64, (FRICTION,), 3.7),
        (64, (FRICTION, "scene.actuator.delay_samples=1"), 4.8),
        (64, ("scene.wall.damping=0.0002",), 2.4),
        (64, (LAG,), 9.4),
        (8, (LAG, FRICTION), 12.7),
        (64, ("scene.cogging={torque: 1 mN*m, per_revolution: 24}",), 17.8),
        (64, ("scene.controller={kind: bounded_lag, keep: 0.15, time_constant: 0.2}",), 71.5),
    ],
)
def test_the_time_of_the_main_grid_is_expected_within_a_factor_of_two(
    phases: int, scene: tuple[str, ...], took_s: float
) -> None:
    plan = load(EXPERIMENTS / "hand_on_knob.yaml", (f"starts={{angle: 0.02, phases: {phases}}}", *scene))
    expected_s = work_of(SweepStage(plan).expected) * LOADING_S / COMPILE_ABOVE
    assert 0.5 < expected_s / took_s < 2.0
