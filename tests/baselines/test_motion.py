"""Motions with a closed form, followed by rivals and by 60 digits."""

from math import exp, log, pi, sin, sqrt

import pytest

from hknob_cli.specs.plan import Actuator, Bias, Encoder, Hand, Knob, Wall
from hknob_cli.stages.bench.timed import Setting
from tests.baselines.trials import COUNTS, INERTIA, PERIOD, STIFFNESS, by, by_digits60, trial

Q = 2.0 * pi / COUNTS
SCIPY = ("rk23", "rk45", "dop853", "lsoda", "radau", "bdf")
LOOSE = Setting("loose", tolerance=1e-8)


@pytest.mark.parametrize("method", SCIPY)
def test_friction_stops_the_knob_and_holds_it(method: str) -> None:
    """A knob thrown upwards stops after J w / (T_c + g) at J w^2 / 2 (T_c + g), and stays, for T_c > g."""
    friction, bias, speed = 2e-3, 5e-4, 2.0
    case = trial(angle=0.01, velocity=speed, knob=Knob(INERTIA, 0.0, friction), bias=Bias(bias), samples=4)
    assert INERTIA * speed / (friction + bias) < 2.5 * PERIOD
    end = 0.01 + INERTIA * speed**2 / (2.0 * (friction + bias))
    assert by(method, case, LOOSE)[-1] == pytest.approx(end, abs=1e-9)
    assert abs(float(by_digits60(case)[-1]) - end) < 1e-17


@pytest.mark.parametrize("method", SCIPY)
def test_a_lagging_torque_breaks_the_knob_loose(method: str) -> None:
    """It sticks until u (1 - exp(-t / t_c)) = T_c; from there the torque beyond friction grows to u - T_c."""
    friction, lag, angle = 1e-3, 4e-4, -0.5 * Q
    case = trial(angle=angle, knob=Knob(INERTIA, 0.0, friction), actuator=Actuator(time_constant=lag), samples=3)
    command = STIFFNESS * Q
    left = PERIOD + lag * log(1.0 - friction / command)  # of the first interval
    beyond = (command - friction) / INERTIA
    moved = beyond * (left**2 / 2.0 - lag * left + lag**2 * (1.0 - exp(-left / lag)))
    assert abs(float(by_digits60(case)[1]) - (angle + moved)) < 1e-17
    assert by(method, case, LOOSE)[1] == pytest.approx(angle + moved, abs=1e-9)


def test_delay_shifts_the_push() -> None:
    """One and a quarter samples late, a constant push moves the free knob by a t^2 / 2."""
    case = trial(angle=-0.5 * Q, actuator=Actuator(1.25), samples=3)
    acceleration = STIFFNESS * Q / INERTIA
    for angles in (by_digits60(case), by("rk45", case), by("rk4", case, Setting("", substeps=4))):
        assert float(angles[1]) == pytest.approx(-0.5 * Q, abs=1e-16)
        assert float(angles[2]) == pytest.approx(-0.5 * Q + acceleration * (0.75 * PERIOD) ** 2 / 2.0, abs=1e-16)


@pytest.mark.parametrize("method", SCIPY)
def test_without_clock_and_encoder_the_wall_is_a_spring(method: str) -> None:
    speed, omega = -3.0, sqrt(STIFFNESS / INERTIA)
    case = trial(angle=1e-4, velocity=speed, encoder=None, sampled=False, samples=10)
    enters = 1e-4 / -speed
    for angles, error in ((by_digits60(case), 1e-16), (by(method, case, LOOSE), 1e-7)):
        for number, angle in enumerate(angles):
            t = (number + 0.5) * PERIOD - enters
            inside = speed / omega * sin(omega * t)
            expected = speed * t if t < 0.0 else inside if t < pi / omega else -speed * (t - pi / omega)
            assert abs(float(angle) - expected) < error


@pytest.mark.parametrize("method", SCIPY)
def test_without_clock_a_count_acts_at_its_edge(method: str) -> None:
    """Thrown into the wall by less than a count, the knob is thrown out by the push of that count."""
    speed = -0.8 * sqrt(2.0 * STIFFNESS * Q**2 / INERTIA)
    case = trial(angle=1e-5, velocity=speed, sampled=False, samples=12)
    push, enters = STIFFNESS * Q / INERTIA, 1e-5 / -speed
    inside = 2.0 * -speed / push
    assert 2.0 * PERIOD < inside < 11.0 * PERIOD
    for angles, error in ((by_digits60(case), 1e-16), (by(method, case, LOOSE), 1e-7)):
        for number, angle in enumerate(angles):
            t = (number + 0.5) * PERIOD - enters
            within = speed * t + push * t * t / 2.0
            expected = speed * t if t < 0.0 else within if t < inside else -speed * (t - inside)
            assert abs(float(angle) - expected) < error


@pytest.mark.parametrize("rounding", ["floor", "nearest", "ceil"])
def test_digits60_is_the_recursion_of_the_other_60_digit_model(rounding: str) -> None:
    from itertools import islice

    from tests.verification.reference import build_cell

    parts = {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
        "encoder": {"rounding": rounding, "offset_counts": 0.3},
        "actuator": {"delay_samples": 1.75},
    }
    cell = build_cell(parts, sample_rate_hz=1000.0, counts_per_rev=1024)
    start = cell.start((cell.plant.inertia * 0 + 0.02, cell.plant.inertia * 0), 0, 1)
    expected = [state[0] for state, _ in islice(cell.run(start, 101), 101)]
    case = trial(
        angle=0.02, samples=100, knob=Knob(1.9e-6), hand=Hand(3e-7, 3.45e-4, 0.04), wall=Wall(0.27),
        bias=Bias(0.001), encoder=Encoder(rounding, 0.3), actuator=Actuator(1.75),
    )._replace(counts_per_rev=1024)  # fmt: skip
    assert max(abs(a - b) for a, b in zip(by_digits60(case), expected, strict=True)) < 1e-50
