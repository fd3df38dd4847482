"""Trials of any scene against the 60-digit model: angle, velocity and torque at every sample.

The bound. With the same commands, two motions of knob and finger do not part in the norm of their energy: springs keep
it, dampers and Coulomb friction (a monotone force) only take from it. So the error after n samples is at most the sum
of n local errors, each ``LOCAL`` roundings of the largest angle, speed and torque that the step computes with; an error
of the lagging torque, which decays by itself, is added to each. A sensor without counts has commands that follow the
error: there the amplification is measured, on the model, by nudging it at every sample.

A run is comparable only where rounding cannot flip a count or a torque step: the least distance to either is asserted
to be beyond the bound by a factor of a thousand. Whether a knob that stops sticks is decided by physics only where the
sum of torques is not within rounding of the friction: asserted likewise.
"""

from functools import cache
from itertools import pairwise
from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest

from hknob_cli.scene.general_knob import Trial, simulate
from hknob_cli.specs.scene import SceneSpec

from . import general_reference as reference
from .general_scenes import CASES, Case

EPS = 2.0**-53
LOCAL = 32  # roundings of a step: 7 products of a row, their sum, the matrix's own, an event's time
AWAY = 1e3  # how far beyond the bound a jump has to lie


class Bounds(NamedTuple):
    """Of the error of each column, and of the command before it is rounded."""

    angle: float
    velocity: float
    torque: float
    command: float


def bounds(trial: reference.Trial, case: Case) -> Bounds:
    """Error bounds of an engine that rounds as the module says."""
    bodies, control = trial.friction.bodies, trial.control
    j, b, k = float(bodies.inertia), float(bodies.damping), float(bodies.stiffness)
    lag, period = float(bodies.lag), float(control.period)
    if bodies.driven:
        lag = float(bodies.inductance / bodies.resistance)
    local, n = LOCAL * EPS, case.samples + 2
    angle = max(trial.largest_angle, abs(case.angle))
    # Terms of a sum may exceed it: velocity by torque / inertia * time, angle by that times the period, and by a count,
    # from whose edge a position may be reckoned.
    load = trial.largest_command + float(bodies.bias) + float(bodies.friction) + k * angle
    gain = min(period / j, 1 / b if b else inf)
    speed = max(trial.largest_speed, abs(case.velocity)) + gain * load
    angle += period * speed + (float(control.quantum) if control.quantum is not None else 0.0)
    springs = [k]
    inertias = [j]
    if bodies.finger:
        springs = [float(bodies.finger_stiffness), float(bodies.pad_stiffness)]
        inertias.append(float(bodies.finger_inertia))
    wound = float(bodies.torque_constant**2 / bodies.inductance)
    torque = local * load
    if lag:  # an error of a hold's end by a rounding of the sample period, and the sum of what has not decayed yet
        torque = (torque + 4 * EPS * period / lag * load) / -np.expm1(-period / lag)
    step = sqrt((sum(springs) + wound) * (local * angle) ** 2 + sum(inertias) * (local * speed) ** 2)
    step += torque * period / sqrt(j)
    root = n * step
    velocity = root / sqrt(j)
    held = root * sum(1 / sqrt(s) if s else inf for s in springs)
    drift = n * (local * angle + period * velocity)
    angle = min(held, drift)
    command = float(control.stiffness + 2 * control.damping / control.period) * angle
    return Bounds(angle, velocity, torque + (command if control.quantum is None else 0.0), command + local * load)


@cache
def modelled(name: str) -> reference.Trial:
    """The model's run of a case."""
    case = next(case for case in CASES if case.name == name)
    return reference.simulate(case.scene, **case.arguments)


def compare(case: Case) -> tuple[reference.Trial, Trial]:
    """Run both, and hold the engine to the bounds."""
    expected = modelled(case.name)
    within = bounds(expected, case)
    if expected.control.quantum is None:
        nudge = reference.mp.mpf(10) ** -25
        other = reference.simulate(case.scene, **case.arguments, nudge=nudge)
        local = float(nudge) * expected.largest_angle
        apart = max(abs(a.angle - b.angle) for a, b in zip(expected.samples, other.samples, strict=True))
        factor = max(1.0, float(apart) / (local * (case.samples + 1)))
        within = Bounds(*(factor * bound for bound in within))
    assert expected.edge > AWAY * within.angle, "a sample too near an edge of the encoder: choose another scene"
    assert expected.step > AWAY * within.command, "a command too near a jump of its rounding: choose another scene"

    got = simulate(SceneSpec.model_validate(case.scene).plain(), **case.arguments)
    for name, bound in zip(("angle_rad", "velocity_rad_s", "torque_nm"), within, strict=False):
        column = getattr(got, name)
        exact = [getattr(sample, name.split("_")[0]) for sample in expected.samples]
        errors = [float(abs(reference.mp.mpf(x) - y)) for x, y in zip(column, exact, strict=True)]
        worst = int(np.argmax(errors))
        assert errors[worst] <= bound, f"{name} off by {errors[worst]:.3g} at sample {worst}, bound {bound:.3g}"
    clock = [float(sample.time) for sample in expected.samples]
    assert got.time_s == pytest.approx(clock, rel=4 * EPS)
    return expected, got


@pytest.mark.one_in(9)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_sample(case: Case) -> None:
    """The bound holds; while the knob is stuck its velocity is exactly 0 and its angle does not change a bit."""
    expected, got = compare(case)
    friction = expected.friction
    if friction.bodies.friction == 0:
        return
    assert friction.closest > AWAY * 2 * LOCAL * EPS * (case.samples + 2), "sticking was not decided by the physics"
    rest = np.array([bool(sample.velocity == 0) for sample in expected.samples])
    assert np.array_equal(got.velocity_rad_s == 0, rest)
    same = np.array([bool(a.angle == b.angle) for a, b in pairwise(expected.samples)])
    assert np.array_equal(np.diff(got.angle_rad)[same], np.zeros(same.sum()))


@pytest.mark.one_in(5)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_compiled_to_the_last_bit(case: Case) -> None:
    """Compiled and interpreted, the engine is the same arithmetic."""
    plain = SceneSpec.model_validate(case.scene).plain()
    interpreted = simulate(plain, **case.arguments)
    compiled = simulate(plain, **case.arguments, compiled=True)
    for name, one, other in zip(Trial._fields, interpreted, compiled, strict=True):
        assert np.array_equal(one, other), name


@pytest.mark.long
def test_the_scenes_stick_slip_and_let_go() -> None:
    """The scenes reach what they are there for: reversals, sticks, and releases inside a hold."""
    seen: dict[str, Any] = {"stops": 0, "sticks": 0, "releases": 0}
    for case in CASES:
        if case.scene["knob"].get("coulomb_torque") and case.samples <= 300:
            friction = modelled(case.name).friction
            for name in seen:
                seen[name] += getattr(friction, name)
    assert seen["stops"] > 500
    assert seen["sticks"] > 40
    assert seen["releases"] > 30
