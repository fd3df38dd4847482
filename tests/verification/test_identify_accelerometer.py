"""What an accelerometer on the virtual apparatus reads, and J, B, K of it, against the exact motion."""

from dataclasses import replace

import numpy as np
import pytest

from hknob_cli.apparatus.experiment import Schedule, record_experiments
from hknob_cli.apparatus.hand_recording import Rig
from hknob_cli.identify.least_squares import least_squares, least_squares_acceleration
from hknob_cli.identify.prepare import Preparation, conditions
from tests.apparatus.truths import truths
from tests.identify.pulses import propagate, second

CHOSEN = Schedule(experiments=[1], subjects=2, blocks=1, trials=1, grips=[0.71, 14.2])
SHARP = replace(Rig.ideal(), acceleration_noise=0.0, counts_per_rev=0)
DT = 1e-4


def test_it_reads_the_acceleration_just_before_the_torque() -> None:
    """Of SciPy's exact motion of the same hand: (T - B v - K x) / J, T that of the interval before the sample."""
    true = truths(CHOSEN, seed=5)
    for trial in record_experiments(SHARP, CHOSEN, seed=5):
        hand = true[trial.key]
        states = propagate(*second(*hand), trial.torque_nm, DT)
        before = np.append(0.0, trial.torque_nm[:-1])
        expected = (before - hand.damping * states[:, 1] - hand.stiffness * states[:, 0]) / hand.inertia
        assert trial.acceleration_rad_s2 is not None
        assert np.max(np.abs(trial.acceleration_rad_s2 - expected)) < 1e-8 * np.max(np.abs(expected))


def test_it_spares_the_inertia_what_smoothing_adds() -> None:
    """Without noise only the velocity, differenced and smoothed, is off: below 1 % of the inertia.

    The angle's second derivative, smoothed beside a square pulse, is 2.6 to 7.4 % high.
    """
    true = truths(CHOSEN, seed=5)
    for one in conditions(record_experiments(SHARP, CHOSEN, seed=5), Preparation(average=False)):
        (hand,) = (hand for key, hand in true.items() if key[:4] == tuple(one.condition))
        assert one.motion is not None
        felt, differenced = (
            fit(one.motion).parameters["inertia"].value for fit in (least_squares_acceleration, least_squares)
        )
        assert abs(felt / hand.inertia - 1.0) < 0.01 < abs(differenced / hand.inertia - 1.0)


def test_without_an_accelerometer_nothing_is_told() -> None:
    trials = record_experiments(Rig.ideal(), CHOSEN._replace(subjects=1, grips=[0.71]), seed=5)
    (one,) = conditions(trials, Preparation())
    assert one.motion is not None
    fit = least_squares_acceleration(one.motion)
    assert not any(value.identifiable for value in fit.parameters.values())
    assert fit.flags == ("no accelerometer: nothing can be identified",)


def test_noise_pulls_the_inertia_towards_zero() -> None:
    """By the noise's power over the acceleration's, about: noise as large as the acceleration's rms halves it."""
    (trial,) = record_experiments(SHARP, CHOSEN._replace(subjects=1, grips=[0.71]), seed=5)
    how = Preparation(average=False, window_s=(0.0, 0.03))
    (one,) = conditions([trial], how)
    assert one.motion is not None
    assert one.motion.felt_rad_s2 is not None
    rms = float(np.sqrt(np.mean(one.motion.felt_rad_s2**2)))
    noise = rms * np.random.default_rng(1).standard_normal(trial.time_s.size)
    (loud,) = conditions([trial._replace(acceleration_rad_s2=trial.acceleration_rad_s2 + noise)], how)
    assert loud.motion is not None
    quiet, pulled = (
        least_squares_acceleration(motion).parameters["inertia"].value for motion in (one.motion, loud.motion)
    )
    assert pulled == pytest.approx(0.5 * quiet, rel=0.35)
