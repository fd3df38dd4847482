"""MuJoCo's hinges against 60 digits: the same scene, expressed another way."""

import pytest

from hknob_cli.specs.plan import Bias, Finger, Fingerpad, Hand, Knob
from hknob_cli.stages.bench.timed import Setting
from tests.baselines.trials import INERTIA, by, by_digits60, trial

FOURTH = Hand(finger=Finger(3e-7, 1e-4, 0.04), fingerpad=Fingerpad(3e-4, 0.5))


def difference(case, method: str, setting: Setting) -> float:
    exact = by_digits60(case)
    return max(abs(a - float(b)) for a, b in zip(by(method, case, setting), exact, strict=True))


@pytest.mark.parametrize("hand", [Hand(3e-7, 3.45e-4, 0.04), FOURTH])
def test_runge_kutta_is_of_fourth_order(hand: Hand) -> None:
    case = trial(angle=-0.02, velocity=0.3, bias=Bias(0.001), hand=hand, samples=4)
    coarse, fine = (difference(case, "mujoco_rk4", Setting("", substeps=n)) for n in (8, 32))
    assert coarse / fine == pytest.approx(256.0, rel=0.3)


def test_stiff_friction_comes_near_to_coulomb() -> None:
    case = trial(velocity=2.0, knob=Knob(INERTIA, 0.0, 2e-3), samples=4)
    soft = difference(case, "mujoco_euler", Setting("", "soft", substeps=64))
    stiff = difference(case, "mujoco_euler", Setting("", "stiff", substeps=64))
    assert stiff < 1e-4
    assert stiff < soft
