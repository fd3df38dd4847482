"""Stated intervals with a noisy torque sensor hold the truth as often as they say; a reaction cell reads the hand.

The knobs are ideal but for the sensor. Of 108 intervals of 95 % at least 89 % hold the truth: three standard errors of
a share, sqrt(0.95 * 0.05 / 108) = 2.1 %, below 95 %.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from hknob_cli.apparatus.experiment import Schedule, record_experiments
from hknob_cli.apparatus.hand import SecondOrder, follow, mechanism, split
from hknob_cli.apparatus.hand_recording import Rig, taken_by_friction
from hknob_cli.identify.output_error import output_error
from hknob_cli.identify.prepare import Preparation, conditions
from tests.apparatus.truths import truths

CHOSEN = Schedule(experiments=[1], subjects=12, blocks=1, trials=3, grips=[0.71, 4.3, 14.2])
LEAST = 0.89
DT = 1e-4


@pytest.mark.parametrize("noise", [1e-4, 5e-4])
def test_intervals_allow_for_the_noise_of_the_sensor(noise: float) -> None:
    rig = replace(Rig.ideal(), torque_noise_nm=noise, angle_noise_rad=2e-6)
    how = Preparation(decimate=1, differentiate=False, average=False, torque="measured")
    true = truths(CHOSEN, seed=3)
    inside = []
    for one in conditions(record_experiments(rig, CHOSEN, seed=3), how, counts_per_rev=rig.counts_per_rev):
        (hand,) = (hand for key, hand in true.items() if key[:4] == tuple(one.condition) and key.trial == one.trials[0])
        assert one.motion is not None
        assert one.motion.measured
        found = output_error(one.motion).parameters
        inside.append(
            [abs(found[name].value - value) <= 1.96 * found[name].std for name, value in hand._asdict().items()]
        )
    assert len(inside) == 108
    assert np.all(np.mean(inside, axis=0) >= LEAST)


def test_the_noise_and_the_onset_are_those_of_the_record() -> None:
    """Noise of the mean of three trials is the sensor's over the root of 3, from 50 samples each: good to 6 %."""
    rig = replace(Rig.ideal(), torque_noise_nm=1e-4)
    trials = record_experiments(rig, CHOSEN._replace(subjects=1, grips=[4.3]), seed=3)
    (one,) = conditions(trials, Preparation(decimate=1, differentiate=False, torque="measured"))
    assert one.motion is not None
    assert one.motion.torque_noise_nm == pytest.approx(1e-4 / math.sqrt(3.0), rel=0.25)
    (commanded,) = conditions(trials, Preparation(decimate=1, differentiate=False, torque="commanded"))
    assert commanded.motion is not None
    assert one.motion.onset == commanded.motion.onset
    assert commanded.motion.torque_noise_nm is None


@pytest.mark.parametrize("order", ["second", "fourth"])
@pytest.mark.parametrize("lag", [0.0, 5e-5])
def test_a_reaction_cell_reads_what_moves_knob_and_hand(order: str, lag: float) -> None:
    """Torque less friction is J a + the hand's torque, a from exact velocities by central differences.

    These are off by |jerk'| dt^2 / 6, jerk' about (torque / J)(b / J)^2, below 1e-3 of the torque at 10 us; across a
    step of the torque, and where the knob turns or stops, there is no such difference.
    """
    second = SecondOrder(2.2e-6, 3.45e-4, 0.04)
    hand = second if order == "second" else split(second, knob_kg_m2=1.9e-6)
    body = mechanism(hand, coulomb=5.6e-4, lag_s=lag)
    states = follow(body, body.rest(0.0), [(7e-3, 2000), (0.0, 4000)], 0.1 * DT)
    acting = states[:, -1] if lag else np.where(np.arange(len(states)) < 2000, 7e-3, 0.0)
    reads = acting - taken_by_friction(body, states, acting)
    size = len(states[0]) // 2 * 2
    moved = hand.inertia * (np.gradient(states[:, 1], 0.1 * DT) - states[:, :size] @ body.rates[0, 1, :size])
    sure = np.ones(len(states), dtype=bool)
    turns = np.flatnonzero(np.diff(np.sign(states[:, 1])) != 0)
    for at in (0, 2000, len(states) - 1, *turns):
        sure[max(at - 60, 0) : at + 61] = False
    assert sure.sum() > 4000
    assert np.abs(reads - moved)[sure].max() < 1e-3 * 7e-3
