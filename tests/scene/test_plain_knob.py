"""Tests of `scene.plain_knob`: scales, shifts, and what a measured angle is; without a clock, against the wall."""

import math
from math import ceil, floor, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.engine.loop import drive_of, level_of
from hknob_cli.engine.unsampled.state_machine import piece_drive, place
from hknob_cli.errors import ComputationError
from hknob_cli.scene.plain_knob import SampledKnob, UnsampledKnob, reduce_unsampled, sample_knob
from hknob_cli.specs.scene import SceneSpec

N = 1024
QUANTUM = 2 * pi / N
READ = {"floor": floor, "ceil": ceil, "nearest": lambda x: floor(x + 0.5), "truncate": int}


def knob(rounding: str = "floor", offset: float = 0.0, **scene: object) -> SampledKnob:
    parts: dict[str, object] = {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
        "encoder": {"rounding": rounding, "offset_counts": offset},
    }
    return sample_knob(SceneSpec.model_validate({**parts, **scene}).plain(), sample_rate_hz=1000.0, counts_per_rev=N)


def test_numbers_of_table_7() -> None:
    loop = knob().loop
    assert loop.alpha == pytest.approx(3.45e-4 * 1e-3 / 2.2e-6, rel=1e-14)
    assert loop.beta == pytest.approx(0.04 * 1e-6 / 2.2e-6, rel=1e-14)
    assert loop.kappa == pytest.approx(0.27 * 1e-6 / 2.2e-6, rel=1e-14)
    assert loop.gamma == pytest.approx(0.001 * 1e-6 / (2.2e-6 * QUANTUM), rel=1e-14)


@given(
    counts=st.floats(-20, 20, allow_nan=False),
    rounding=st.sampled_from(sorted(READ)),
    offset=st.sampled_from([0.0, 0.25, 0.5, 0.875]),
)
def test_wall_torque_is_that_of_the_measured_angle(counts: float, rounding: str, offset: float) -> None:
    """Torque is -K * measured where that is an angle below 0; measured is (rounding(theta/q - offset) + offset) q."""
    one = knob(rounding, offset)
    measured = READ[rounding](counts - offset) + offset
    wanted = -0.27 * measured * QUANTUM if measured < 0 else 0.0
    x = counts - one.shift
    if abs(x - round(x)) < 1e-9:
        return  # the shift itself may round across the edge
    drive = drive_of(level_of(x, one.loop.sense), one.loop) + one.loop.gamma
    torque = drive * one.inertia_kg_m2 * QUANTUM / one.period_s**2
    assert torque == pytest.approx(wanted, abs=1e-15 + 1e-12 * abs(wanted))


@pytest.mark.parametrize("rounding", sorted(READ))
@pytest.mark.parametrize("count", [-3, -2, -1, 0, 1])
def test_on_an_edge_the_rounding_decides(rounding: str, count: int) -> None:
    edge = count - 0.5 if rounding == "nearest" else float(count)
    one = knob(rounding)
    level = level_of(edge - one.shift, one.loop.sense)
    assert level == min(READ[rounding](edge), 0)


def test_hand_is_neutral_at_angle_zero_whatever_the_encoder() -> None:
    for rounding in READ:
        for offset in (0.0, 0.5):
            one = knob(rounding, offset, bias={"torque": 0.0})
            assert one.loop.gamma + one.loop.beta * one.position(0.0) == pytest.approx(0.0, abs=1e-18)


def test_round_trip_of_angles() -> None:
    one = knob("nearest", 0.25)
    assert one.angle_rad(one.position(0.0123)) == pytest.approx(0.0123, rel=1e-14)


def test_half_quantum_is_half_of_the_torque_step() -> None:
    loop = knob(bias={"half_quantum": True}).loop
    assert loop.gamma == 0.5 * loop.kappa


def test_delay_line_holds_the_commands_under_way() -> None:
    for delay, line, split in ((0.0, 0, 0.0), (0.25, 1, 0.25), (1.0, 2, 0.0), (2.5, 3, 0.5)):
        one = knob(actuator={"delay_samples": delay})
        assert (one.delay_line, one.loop.split) == (line, split)


def test_overflow_is_said() -> None:
    scene = SceneSpec.model_validate({"knob": {"inertia": 1e-300}, "wall": {"stiffness": 1e12}}).plain()
    with pytest.raises(ComputationError, match="overflow"):
        sample_knob(scene, sample_rate_hz=1e-3, counts_per_rev=1)


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
