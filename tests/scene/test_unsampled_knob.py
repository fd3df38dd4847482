"""The reduction of a scene without a sample clock, against the sensor and the wall as they are defined."""

import math

import pytest

from hknob_cli.engine.unsampled.state_machine import piece_drive, place
from hknob_cli.errors import ComputationError
from hknob_cli.scene.plain_knob import UnsampledKnob, reduce_unsampled
from hknob_cli.specs.scene import SceneSpec

BASE = {
    "knob": {"inertia": 1.9e-6, "coulomb_torque": 2e-4},
    "hand": {"inertia": 3e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
    "sampling": "continuous",
}


def reduced(counts: int | None = 1024, **parts: object) -> UnsampledKnob:
    return reduce_unsampled(SceneSpec.model_validate({**BASE, **parts}).plain(), counts_per_rev=counts)


ROUNDINGS = {
    "floor": math.floor,
    "nearest": lambda value: math.floor(value + 0.5),
    "ceil": math.ceil,
    "truncate": math.trunc,
}


@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("offset", [0.0, 0.3])
def test_torque_is_that_of_the_measured_angle(rounding: str, offset: float) -> None:
    """Away from the edges: measured angle (round(theta/q - o) + o) q, torque -K times it where it is negative."""
    knob = reduced(encoder={"rounding": rounding, "offset_counts": offset})
    q = 2.0 * math.pi / 1024
    for i in range(-49, 30):
        theta = (i + 0.5) * q / 10.0
        measured = (ROUNDINGS[rounding](theta / q - offset) + offset) * q
        wanted = -0.27 * measured if measured < 0.0 else 0.0
        n, _, _ = place(knob.position(theta), 0.0, knob.loop)
        wall = (piece_drive(n, knob.loop) + knob.loop.gamma) * knob.torque_nm
        assert wall == pytest.approx(wanted, abs=1e-16)


@pytest.mark.parametrize("counts", [1024, None])
def test_terms_of_the_equation_of_motion(counts: int | None) -> None:
    knob = reduced(counts, encoder={"rounding": "ceil"} if counts else "none")
    loop = knob.loop
    torque = knob.torque_nm
    assert loop.phi * torque == pytest.approx(2e-4, rel=1e-14, abs=0.0)
    assert loop.alpha * knob.speed(1.0) * torque == pytest.approx(3.45e-4, rel=1e-14, abs=0.0)
    assert loop.beta * torque / knob.unit_rad == pytest.approx(0.04, rel=1e-14, abs=0.0)
    assert loop.kappa * torque / knob.unit_rad == pytest.approx(0.27, rel=1e-14, abs=0.0)
    # Bias and hand at theta = 0.
    x = knob.position(0.0)
    assert (loop.gamma + loop.beta * x) * torque == pytest.approx(0.001, rel=1e-13)
    assert knob.angle_rad(knob.position(0.0123)) == pytest.approx(0.0123, rel=1e-15)


def test_half_quantum_bias_is_half_a_count_of_wall_torque() -> None:
    for encoder in ({"rounding": "floor"}, "none"):
        knob = reduced(512, bias={"half_quantum": True}, encoder=encoder)
        assert knob.loop.gamma * knob.torque_nm == pytest.approx(0.27 * math.pi / 512, rel=1e-14, abs=0.0)


def test_missing_counts_and_overflow_are_refused() -> None:
    with pytest.raises(ComputationError, match="counts_per_rev"):
        reduced(None)
    with pytest.raises(ComputationError, match="overflow"):
        reduced(1024, knob={"inertia": 1e-300}, hand={"damping": 1e9})
