"""The bias of estimators by cause, and the finger that hides behind its pad."""

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.identify.studies import bias_study, hidden_inertia

MOTOR_INERTIA = 19.8e-7  # Appendix C


@pytest.fixture(scope="module")
def biases():
    told: list[tuple[int, int]] = []
    rows = bias_study(
        12,
        nuisances={"noise_rad": (0.0, 1e-3), "coulomb_nm": (5.6e-4,), "decimation": (1.0, 10.0, 40.0)},
        progress=lambda *done: told.append(done),
    )
    assert {total for _, total in told} == {144}  # 12 conditions at 6 levels and 2 grips
    assert [done for done, _ in told if done % 12] == [done for done in range(144) if done % 12]
    return {(row.grip_n, row.nuisance, row.level, row.estimator, row.parameter): row for row in rows}


def test_noise_pulls_the_inertia_of_least_squares_down(biases) -> None:
    """Implicit regularization, Section 4.4: at the lightest grip 20 % at 1 mrad; output error is not pulled."""
    quiet, loud = (biases[0.71, "noise_rad", level, "least_squares", "inertia"].bias_percent for level in (0.0, 1e-3))
    assert loud < quiet - 10.0
    assert abs(biases[0.71, "noise_rad", 1e-3, "output_error", "inertia"].bias_percent) < 1.0


def test_smoothing_pushes_it_up(biases) -> None:
    for grip in (0.71, 14.2):
        found = [biases[grip, "decimation", level, "least_squares", "inertia"].bias_percent for level in (10.0, 40.0)]
        assert 2.0 < found[0] < found[1]


def test_friction_left_out_is_taken_for_damping(biases) -> None:
    for estimator in ("least_squares", "output_error"):
        assert biases[0.71, "coulomb_nm", 5.6e-4, estimator, "damping"].bias_percent > 20.0
    fitted = biases[0.71, "coulomb_nm", 5.6e-4, "output_error_friction", "damping"]
    assert abs(fitted.bias_percent) < 0.1


def test_output_error_has_no_bias_beyond_chance(biases) -> None:
    """Means of 12 within 4 of their standard deviations, over 3 parameters and 2 grips."""
    for grip in (0.71, 14.2):
        for name in ("inertia", "damping", "stiffness"):
            row = biases[grip, "noise_rad", 1e-3, "output_error", name]
            assert abs(row.bias_percent) < 4.0 * row.std_percent / np.sqrt(12)


def test_a_stiff_finger_hides_its_inertia() -> None:
    """A finger that moves 1/(1 + r) of the knob adds J1/(1 + r)^2 to its kinetic energy: Section 4.4.1's curve."""
    for row in hidden_inertia(1.15e-3, 0.23, inertia=MOTOR_INERTIA, ratios=(1.0, 3.0, 10.0, 100.0, 1000.0)):
        expected = MOTOR_INERTIA + 3e-7 / (1.0 + row.ratio) ** 2
        # Equal ratios of dampers and springs keep that share apart from the own inertia of the finger: second order.
        assert row.inertia == pytest.approx(expected, rel=0.006 / row.ratio)
        assert row.vaf > 0.99999


@pytest.mark.parametrize("ratio", [1e-6, 1e6])
def test_a_finger_too_light_to_follow_is_refused(ratio: float) -> None:
    """The hold is squared from one so short that the finger hardly moves in it, where rounding is of the size of what
    the knob does: all damping was lost, at a VAF of 1. Within the limit damping is told to some 1e-6."""
    hand = {"damping": 1.15e-3, "stiffness": 0.23, "inertia": MOTOR_INERTIA, "ratios": [ratio]}
    with pytest.raises(UsageError, match="too fast to be followed"):
        hidden_inertia(**hand, finger_inertia=1e-16)
    found = hidden_inertia(**hand, finger_inertia=1.3e-10)[-1]
    assert found.damping == pytest.approx(1.15e-3, rel=1e-5)
