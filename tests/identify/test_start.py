"""Motors and springs under any torque: steps, sines, chirps, noise; from any state, with fixed parameters."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hknob_cli.identify.least_squares import least_squares
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.output_error import BACKWARDS, output_error
from hknob_cli.identify.prepare import Preparation, conditions
from hknob_cli.identify.second_order import Plant, Start, respond, respond_with_slopes
from hknob_cli.recordings.trial import Key, Trial

DT, COUNT = 1e-3, 3000
TIME = DT * np.arange(COUNT)
MOTOR, SPRUNG = Plant(1.2e-4, 3e-4, 0.0), Plant(1.2e-4, 1e-3, 0.05)
START = Start(0.1, 2.0)
WAVES = {
    "steps": np.sign(np.sin(2.0 * np.pi * 0.7 * TIME)),
    "sine": np.sin(2.0 * np.pi * 3.0 * TIME),
    "chirp": np.sin(2.0 * np.pi * (0.5 * TIME + 2.5 * TIME**2)),
    "noise": np.repeat(np.where(np.random.default_rng(0).random(COUNT // 20) < 0.5, -1.0, 1.0), 20),
}


def running(plant: Plant, torque: np.ndarray, *, noise: float = 1e-3, seed: int = 0, start: Start = START) -> Motion:
    angle = respond(plant, torque, DT, start=start) + noise * np.random.default_rng(seed).normal(size=len(torque))
    return Motion(DT, torque, angle - angle[0], noise_rad=noise, pulsed=False, free_start=True)


def holds(fit, plant: Plant, errors: float = 4.0) -> bool:
    pairs = zip(fit.parameters.values(), plant[: len(fit.parameters)], strict=True)
    return all(abs(one.value - truth) <= errors * one.std + 1e-15 for one, truth in pairs)


@pytest.mark.parametrize("wave", WAVES)
def test_a_motor_is_found_from_any_excitation(wave: str) -> None:
    fit = output_error(running(MOTOR, 0.02 * WAVES[wave]), fixed={"stiffness": 0.0})
    assert holds(fit, MOTOR), fit
    assert fit.parameters["stiffness"] == (0.0, 0.0, True, 0.0)
    assert fit.flags == ()
    assert fit.vaf > 0.9999


@pytest.mark.parametrize("wave", WAVES)
def test_a_spring_is_found_from_any_excitation(wave: str) -> None:
    fit = output_error(running(SPRUNG, 0.02 * WAVES[wave]))
    assert holds(fit, SPRUNG), fit
    assert fit.flags == ()


def test_friction_is_found_from_steps() -> None:
    rubbing = SPRUNG._replace(coulomb=2e-3)
    fit = output_error(running(rubbing, 0.02 * WAVES["steps"]), fit_coulomb=True)
    assert holds(fit, rubbing), fit


@pytest.mark.parametrize("name", ["inertia", "damping", "stiffness"])
def test_a_fixed_parameter_is_held_and_the_others_are_found(name: str) -> None:
    value = getattr(SPRUNG, name)
    motion = running(SPRUNG, 0.02 * WAVES["noise"])
    fit = output_error(motion, fixed={name: value})
    assert fit.parameters[name] == (value, 0.0, True, 0.0)
    assert holds(fit, SPRUNG)
    wrong = output_error(motion, fixed={name: 1.5 * value})
    assert wrong.parameters[name].value == 1.5 * value
    assert any("does not fit" in flag for flag in wrong.flags)


@pytest.mark.long
def test_intervals_of_a_running_motor_hold_the_truth() -> None:
    """Of 200 intervals at 95 % the share has a standard deviation of 1.5 %."""
    rng = np.random.default_rng(1)
    held = []
    for k in range(200):
        plant = Plant(1.2e-4 * rng.uniform(0.5, 2.0), 3e-4 * rng.uniform(0.3, 3.0), 0.0)
        torque = 0.02 * np.repeat(np.where(rng.random(60) < 0.5, -1.0, 1.0), 10)
        fit = output_error(running(plant, torque, seed=k), fixed={"stiffness": 0.0})
        held.append([abs(fit.parameters[n].value - t) <= 1.96 * fit.parameters[n].std for n, t in
                     (("inertia", plant.inertia), ("damping", plant.damping))])  # fmt: skip
    shares = np.mean(held, axis=0)
    assert np.all((shares >= 0.90) & (shares <= 0.995)), shares


def test_repeats_of_one_motor_agree_within_their_errors() -> None:
    """A motor of 1200 g·cm² with friction that the model leaves out, pushed four ways, in g·cm²:

    1207 ± 6.5, 1204 ± 18, 1155 ± 80, 1173 ± 21, where noise alone said ± 1.4, 0.7, 15, 4.2.
    """
    rubbing = MOTOR._replace(coulomb=5e-4)
    fits = [
        output_error(running(rubbing, 0.02 * wave, seed=k), fixed={"stiffness": 0.0})
        for k, wave in enumerate(WAVES.values())
    ]
    found = [fit.parameters["inertia"] for fit in fits]
    noise = [np.sqrt(one.std**2 - one.misfit**2) for one in found]
    off = [abs(one.value - MOTOR.inertia) for one in found]
    assert all(far > 2.5 * own for far, own in zip(off, noise, strict=True))
    assert all(far < 1.96 * one.std for far, one in zip(off, found, strict=True))
    for i, one in enumerate(found):
        assert all(abs(one.value - two.value) < 1.96 * np.hypot(one.std, two.std) for two in found[:i])
    assert all("they allow for the misfit" in " ".join(fit.flags) for fit in fits)


def test_a_sign_that_is_wrong_is_said() -> None:
    motion = running(MOTOR, 0.02 * WAVES["noise"])
    fit = output_error(motion._replace(torque_nm=-motion.torque_nm), fixed={"stiffness": 0.0})
    assert fit.flags == (BACKWARDS,)


def test_torque_that_is_straight_between_samples() -> None:
    """Against SciPy's integrator; held instead, the same torque is a quarter of a sample's motion off."""
    torque = 0.02 * WAVES["sine"][:400]
    angle = solve_ivp(
        lambda s, y: [
            y[1],
            (np.interp(s, TIME[:400], torque) - SPRUNG.damping * y[1] - SPRUNG.stiffness * y[0]) / SPRUNG.inertia,
        ],
        (0.0, TIME[399]),
        list(START),
        t_eval=TIME[:400],
        rtol=1e-10,
        atol=1e-12,
        max_step=DT / 2.0,
    ).y[0]
    straight = respond(SPRUNG, torque, DT, ramps=True, start=START)
    assert np.abs(straight - angle).max() <= 1e-6 * np.ptp(angle)
    assert np.abs(respond(SPRUNG, torque, DT, start=START) - angle).max() > 1e-4 * np.ptp(angle)
    rubbing = respond(SPRUNG, torque, DT, ramps=True, start=START, friction=True)
    assert np.abs(rubbing - angle).max() <= 1e-4 * np.ptp(angle)


@pytest.mark.parametrize("coulomb", [0.0, 2e-3])
def test_slopes_by_the_first_state_are_differences(coulomb: float) -> None:
    plant, torque = SPRUNG._replace(coulomb=coulomb), 0.02 * WAVES["sine"][:300]
    slopes = respond_with_slopes(plant, torque, DT, start=START)[1]
    for column, (angle, velocity) in ((4, (1e-6, 0.0)), (5, (0.0, 1e-5))):
        ends = [
            respond(plant, torque, DT, start=Start(START[0] + way * angle, START[1] + way * velocity))
            for way in (1.0, -1.0)
        ]
        expected = (ends[0] - ends[1]) / (2.0 * (angle + velocity))
        assert slopes[:, column] == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def test_least_squares_of_a_running_motion_has_a_share_of_the_variance() -> None:
    """The spring's rest is not where the record begins: without its torque the stiffness would be far off."""
    trial = Trial(Key("a", "b", 0.0, 1, 1), TIME, 0.02 * WAVES["chirp"],
                  respond(SPRUNG, 0.02 * WAVES["chirp"], DT, start=START), np.full(COUNT, np.nan))  # fmt: skip
    how = Preparation(continuous=True, free_start=True, smooth_torque=True)
    (prepared,) = conditions([trial], how)
    fit = least_squares(prepared.motion)
    for one, truth in zip(fit.parameters.values(), SPRUNG[:3], strict=True):
        assert one.value == pytest.approx(truth, rel=0.03)
    assert fit.vaf > 0.98


def test_measured_torque_is_used_where_it_is_there() -> None:
    acting = 0.02 * WAVES["noise"]
    trial = Trial(
        Key("a", "b", 0.0, 1, 1), TIME, 1.3 * acting, respond(MOTOR, acting, DT), np.full(COUNT, np.nan), acting
    )
    for torque, scale in ((None, 1.0), ("measured", 1.0), ("commanded", 1.3)):
        (prepared,) = conditions([trial], Preparation(continuous=True, decimate=1, free_start=True, torque=torque))
        assert prepared.motion.measured == (torque != "commanded")
        fit = output_error(prepared.motion, fixed={"stiffness": 0.0})
        assert fit.parameters["inertia"].value == pytest.approx(scale * MOTOR.inertia, rel=1e-6)
    (prepared,) = conditions([trial._replace(measured_torque_nm=None)], Preparation(continuous=True, torque="measured"))
    assert "no measured torque: the commanded one is used" in prepared.flags
