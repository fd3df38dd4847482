"""Reduction of a scene to numbers: scales, shifts, and what a measured angle is."""

from math import ceil, floor, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.engine.loop import drive_of, level_of
from hknob_cli.errors import ComputationError
from hknob_cli.scene.plain_knob import SampledKnob, sample_knob
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
