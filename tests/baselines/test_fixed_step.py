"""Fixed steps: orders of convergence, and what the kernels share with their interpreted source."""

from math import log2

import numpy as np
import pytest

from hknob_cli.baselines import fixed_step
from hknob_cli.baselines.fixed_step import METHODS, ORDER, FixedStep, compiled
from hknob_cli.baselines.model import Controller, Deadline, follow
from hknob_cli.specs.plan import Actuator, Bias, Encoder, Finger, Fingerpad, Hand, Knob, Wall
from hknob_cli.stages.bench.timed import Setting
from tests.baselines.trials import INERTIA, by, by_digits60, trial

NONE = np.empty((0, 0, 0))
SECOND = Hand(3e-7, 3.45e-4, 0.04)
FOURTH = Hand(finger=Finger(3e-7, 1e-4, 0.04), fingerpad=Fingerpad(3e-4, 0.5))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "parts", [{"hand": SECOND}, {"hand": FOURTH}, {"hand": FOURTH, "actuator": Actuator(0.5, 1e-3)}]
)
def test_errors_fall_with_the_order(method: str, parts: dict) -> None:
    """Halving the step divides the error by 2^order, while no sample falls on another count.

    The slope is taken from 16 to 64 steps; what the next order adds there is below a tenth of it.
    """
    case = trial(angle=-0.02, velocity=0.3, bias=Bias(0.001), samples=4, **parts)
    exact = [float(angle) for angle in by_digits60(case)]
    errors = [
        max(abs(a - b) for a, b in zip(by(method, case, Setting("", substeps=n)), exact, strict=True)) for n in (16, 64)
    ]
    assert log2(errors[0] / errors[1]) / 2.0 == pytest.approx(ORDER[method], abs=0.15)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("method", METHODS)
def test_friction_holds_and_stops(method: str) -> None:
    knob = Knob(INERTIA, 0.0, 2e-3)
    held = by(method, trial(knob=knob, bias=Bias(1e-3)), Setting("", "stick", substeps=4))
    assert held == [0.01] * 4
    thrown = trial(velocity=2.0, knob=knob, samples=4)
    stopped = by(method, thrown, Setting("", "stick", substeps=1000))
    assert stopped[-1] == pytest.approx(float(by_digits60(thrown)[-1]), abs=2.0 * 2.0 * 1e-6)  # a step at full speed
    assert stopped[-1] == stopped[-2]


def test_compiled_is_interpreted() -> None:
    a = np.array([[0.0, 1.0], [-2e4, -150.0]])
    r, y, z = np.array([0.0, 800.0]), np.array([0.01, -1.0]), np.array([0.01, -1.0])
    fixed_step.rk4(a, r, 5.0, y, 1e-4, 50, NONE)
    compiled("rk4")[0](a, r, 5.0, z, 1e-4, 50, NONE)
    assert z == pytest.approx(y, rel=1e-12)


class OneByOne:
    """The same steps under the controller that the other rivals have; see `run.Integrator`."""

    def __init__(self, fixed: FixedStep) -> None:
        self.fixed, self.steps = fixed, 0

    def hold(self, state, command, duration):
        fixed = self.fixed
        compiled(fixed.method)[0](
            fixed.a, fixed.rest + fixed.b * command, fixed.friction, state, *fixed.steps(duration, fixed.substeps)
        )
        return state

    def free(self, state, duration):
        length, count, _ = self.fixed.steps(duration, self.fixed.substeps)
        control = self.fixed.controller
        for _ in range(count):
            self.hold(state, control.command(control.measured(state[0])), length)
        return state


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rounding", [None, "floor", "nearest", "ceil", "truncate"])
@pytest.mark.parametrize("delay", [0.0, 2.0, 1.25])
def test_the_compiled_controller_is_that_of_the_other_rivals(method: str, rounding: str | None, delay: float) -> None:
    case = trial(
        angle=0.01, samples=120, hand=SECOND, bias=Bias(0.001), wall=Wall(0.3, 2e-5), knob=Knob(INERTIA, 0.0, 1e-4),
        encoder=Encoder(rounding, 0.2) if rounding else None, actuator=Actuator(delay, 1e-4, 0.004, 3e-4),
    )  # fmt: skip
    fixed = FixedStep(case, method=method, substeps=8)
    state = np.zeros(3)
    state[0] = 0.01
    expected = follow(case, Controller(case), OneByOne(fixed), state, Deadline(60.0))
    assert fixed.run(Deadline(60.0)).angles == expected.angles


@pytest.mark.parametrize("rounding", [None, "floor"])
def test_so_it_is_without_a_clock(rounding: str | None) -> None:
    case = trial(
        angle=0.01, samples=50, hand=SECOND, bias=Bias(0.001), encoder=Encoder(rounding) if rounding else None,
        sampled=False,
    )  # fmt: skip
    fixed = FixedStep(case, method="rk4", substeps=8)
    state = np.array([0.01, 0.0])
    expected = follow(case, Controller(case), OneByOne(fixed), state, Deadline(60.0))
    assert fixed.run(Deadline(60.0)).angles == pytest.approx(expected.angles, rel=1e-12)
