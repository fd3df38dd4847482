"""Tests of `apparatus.experiment`: the same every time, whatever else is recorded; what was put in comes out."""

from dataclasses import replace

import numpy as np
import pytest

from hknob_cli.apparatus.experiment import (
    POSITIONS_M,
    Schedule,
    cell_sensitivity,
    record_apparatus,
    record_experiments,
    record_grip_cell,
    record_motor_calibration,
    setups,
)
from hknob_cli.apparatus.hand_recording import Pulse, Rig, peak_per_torque, record_trial, scaled_pulse, squeeze
from hknob_cli.apparatus.people import EXPERIMENTS, Variation, grips, mean_hand
from hknob_cli.errors import UsageError
from hknob_cli.printed import apparatus_inertia
from hknob_cli.recordings.trial import Key, Purpose, Trial, stream
from tests.apparatus.reference import pulse_response
from tests.apparatus.truths import truths

STEP = 2.0 * np.pi / 640_000


def same(one: Trial, other: Trial) -> bool:
    return one.key == other.key and all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("time_s", "torque_nm", "angle_rad", "grip_n")
    )


def test_the_numbers_of_the_experiments() -> None:
    keys = [trial.key for trial in record_experiments(Rig.ideal())]
    assert len(keys) == len(set(keys)) == 54 * (9 + 4 * 5)
    assert list(truths()) == keys
    assert len(truths(Schedule(subjects=9))) == 2430
    first = record_experiments(Rig(), Schedule([1], subjects=1))
    assert [trial.key.grip_target_n for trial in first[:18:3]] == [0.71, 1.3, 2.4, 4.3, 7.8, 14.2]
    for trial in first:
        assert len(trial.time_s) == len(trial.torque_nm) == len(trial.angle_rad) == len(trial.grip_n) == 651
        pushed = np.flatnonzero(trial.torque_nm)
        assert (pushed[0], len(pushed)) == (50, 200)
        assert np.diff(trial.time_s) == pytest.approx(1e-4, rel=1e-9)


def test_every_time_the_same_and_another_seed_another() -> None:
    chosen = Schedule([2], subjects=2, grips=[0.71, 7.8])
    one, again, other = (record_experiments(Rig(), chosen, seed=seed) for seed in (3, 3, 4))
    assert all(map(same, one, again))
    assert not any(np.array_equal(a.angle_rad, b.angle_rad) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize(
    "left",
    [
        {"subjects": [2]},
        {"experiments": [3]},
        {"grips": [2.4]},
        {"blocks": 1},
        {"trials": 1},
        {"experiments": [3], "subjects": [2], "grips": [2.4], "blocks": 1, "trials": 1},
    ],
)
def test_leaving_out_changes_nothing_of_the_rest(left: dict) -> None:
    chosen = Schedule([1, 3], subjects=[1, 2], blocks=2, trials=2, grips=[0.71, 2.4])
    whole = {trial.key: trial for trial in record_experiments(Rig(), chosen)}
    part = record_experiments(Rig(), chosen._replace(**left))
    assert 0 < len(part) < len(whole)
    assert all(same(trial, whole[trial.key]) for trial in part)


def test_no_two_trials_share_their_noise() -> None:
    flat = Rig(angle_noise_rad=1e-3, counts_per_rev=0)
    recorded = record_experiments(flat, Schedule([1, 2], subjects=2), variation=Variation.none())
    noise = np.array([trial.angle_rad[:50] - trial.angle_rad[:50].mean() for trial in recorded])
    shared = np.corrcoef(noise) - np.eye(len(noise))
    # 50 samples: correlations of standard deviation 1 / sqrt(49); six of them, over 23 thousand pairs.
    assert np.abs(shared).max() < 6.0 / 7.0


@pytest.mark.parametrize("number", EXPERIMENTS)
def test_the_ideal_rig_is_the_closed_form_in_counts(number: int) -> None:
    """The encoder rounds down: the angle is at most a count above what is recorded, and never below."""
    chosen = Schedule([number], subjects=[1], blocks=1, trials=1)
    known = truths(chosen)
    for trial in record_experiments(Rig.ideal(), chosen):
        pulse = scaled_pulse(number, trial.key.grip_target_n)
        exact = pulse_response(known[trial.key], trial.time_s - 5e-3, pulse.torque_nm, 0.02)
        counts = trial.angle_rad / STEP
        assert np.abs(counts - np.round(counts)).max() < 1e-9
        rest = exact - trial.angle_rad
        assert rest.min() > -1e-12
        assert rest.max() < STEP + 1e-12


@pytest.mark.parametrize("rig", [Rig.ideal(), Rig()], ids=["ideal", "real"])
def test_mean_hands_move_by_what_is_printed(rig: Rig) -> None:
    for trial in record_experiments(rig, Schedule(subjects=1, blocks=1, trials=1), variation=Variation.none()):
        peak = trial.angle_rad.max() - trial.angle_rad[:50].mean()
        assert 0.07 < peak < 0.11, trial.key


@pytest.mark.parametrize("number", EXPERIMENTS)
def test_peaks_in_closed_form(number: int) -> None:
    """Against the largest of fine samples: a maximum between two of them is above by at most |θ''| dt² / 8."""
    times = np.linspace(0.0, 0.08, 80_001)
    for grip in grips(number):
        hand = mean_hand(number, grip)
        sampled = pulse_response(hand, times, 1.0, 0.02).max()
        assert 0.0 <= peak_per_torque(hand) - sampled + 1e-12 < 2.0 / hand.inertia * 1e-12 / 8 + 2e-12
        assert scaled_pulse(number, grip).torque_nm * sampled == pytest.approx(0.09, rel=1e-6)


def test_the_squeeze_fires_at_the_threshold() -> None:
    for trial in record_experiments(Rig(), Schedule([1], subjects=1)):
        target = trial.key.grip_target_n
        assert trial.grip_n[:50].max() < target <= trial.grip_n[50]
        # Ramp: a second to the target; noise of 0.01 N, five of it over 651 samples.
        assert trial.grip_n[50:].max() < target * 1.06 + 0.07
    early = record_experiments(Rig(trigger_share=0.5), Schedule([1], subjects=1, grips=[14.2]))
    assert all(7.1 <= trial.grip_n[50] < 7.2 for trial in early)
    exact = squeeze(Rig.ideal(), 2.0, 50, 651, stream(0, Purpose.BENCH))
    assert exact[50] == 2.0
    assert np.diff(exact) == pytest.approx(2e-4, rel=1e-9)


def test_every_nuisance_does_what_it_says() -> None:
    hand, pulse, key = mean_hand(1, 2.4), Pulse(7e-3), Key("S1", "1", 2.4, 1, 1)

    def angle(**changes: float) -> np.ndarray:
        return record_trial(replace(Rig.ideal(), **changes), hand, pulse, key, stream(0, Purpose.BENCH)).angle_rad

    plain = angle()
    assert angle(counts_per_rev=0) == pytest.approx(plain, abs=STEP)
    assert angle(counts_per_rev=0, torque_error=0.1) == pytest.approx(1.1 * angle(counts_per_rev=0), rel=1e-12)
    # A lag is late by its time constant, once it has settled: 50 µs at most 4 rad/s or so.
    late = plain - angle(amplifier_s=50e-6)
    assert 0.0 < late[150] < 50e-6 * np.abs(np.diff(plain)).max() * 1e4 + STEP
    assert angle(coulomb_nm=0.56e-3).max() < plain.max() - 0.005
    noise = angle(angle_noise_rad=1e-3, counts_per_rev=0) - angle(counts_per_rev=0)
    assert noise.std() == pytest.approx(1e-3, rel=5 / np.sqrt(2 * 651))
    assert 0.0 < abs(angle(posture_rad=0.05)[0]) <= 0.05 + STEP
    assert 0.0 < abs(angle(coulomb_nm=0.56e-3, preload=1.0)[0]) <= 0.56e-3 / hand.stiffness + STEP
    sensed = record_trial(Rig(torque_noise_nm=0.0), hand, pulse, key, stream(0, Purpose.BENCH)).measured_torque_nm
    assert sensed is not None
    assert sensed[51] == pytest.approx(7e-3 * (1 - np.exp(-2.0)), rel=1e-12)


def test_a_fourth_order_hand_hides_its_finger() -> None:
    """Firm grips of fourth order move nearly as the second order with the knob's inertia alone (section 4.4.1)."""
    chosen = Schedule([1], subjects=1, grips=[14.2])
    four = record_experiments(Rig.ideal(), chosen, variation=Variation.none(), model="fourth")[0]
    bare = mean_hand(1, 14.2)._replace(inertia=19.8e-7)
    two = pulse_response(bare, four.time_s - 5e-3, scaled_pulse(1, 14.2).torque_nm, 0.02)
    assert 0.0 < np.abs(four.angle_rad - two).max() < 0.005


def test_the_rigs_knobs_are_those_of_the_printed_apparatus() -> None:
    assert Rig().small_knob_kg_m2 == pytest.approx(apparatus_inertia(1), rel=1e-15)
    assert Rig().medium_knob_kg_m2 == pytest.approx(apparatus_inertia(3), rel=1e-15)


def test_bad_numbers_are_said() -> None:
    with pytest.raises(UsageError, match="rig: coulomb_nm must be >= 0, got -1"):
        Rig(coulomb_nm=-1.0)
    with pytest.raises(UsageError, match="rig: sample_rate_hz must be > 0, got 0"):
        Rig(sample_rate_hz=0.0)
    with pytest.raises(UsageError, match="rig: preload must be <= 1"):
        Rig(preload=2.0)
    with pytest.raises(UsageError, match="subjects must be numbers from 1"):
        record_experiments(Rig(), Schedule(subjects=[0]))
    with pytest.raises(UsageError, match="blocks and trials must be >= 1"):
        truths(Schedule(blocks=0))
    with pytest.raises(UsageError, match="has no grip of 5 N"):
        truths(Schedule(grips=[5.0]))


def test_torque_constants_and_friction_of_both_ranges() -> None:
    """Slopes of the mean of both directions, within five standard errors of a least-squares slope."""
    rows = record_motor_calibration(Rig(), seed=1)
    for index, constant in ((0, 26.4e-3), (1, 28.4e-3)):
        chosen = rows.range_index == index
        current, torque, way = rows.current_a[chosen], rows.torque_nm[chosen], rows.direction[chosen]
        error = 2e-5 / (np.sqrt(chosen.sum()) * current.std())
        assert np.polyfit(current, torque - way * 0.56e-3, 1)[0] == pytest.approx(constant, abs=5 * error)
        friction = 0.5 * (torque[way > 0].mean() - torque[way < 0].mean())
        assert friction == pytest.approx(0.56e-3, abs=5 * 2e-5 / np.sqrt(chosen.sum()))
        assert (constant * current).max() == pytest.approx(2e-3 if index == 0 else 30e-3)
    assert np.diff(rows.time_s[:10]) == pytest.approx(0.1)
    assert rows.angle_rad.max() < 3 * 2 * np.pi + 1e-9


def test_a_ripple_averages_out_over_whole_turns() -> None:
    still = record_motor_calibration(Rig(), noise_nm=0.0)
    rippled = record_motor_calibration(Rig(), noise_nm=0.0, ripple_nm=1e-3)
    assert np.abs(rippled.torque_nm - still.torque_nm).max() > 0.9e-3
    assert rippled.torque_nm.mean() == pytest.approx(still.torque_nm.mean(), abs=1e-9)


def test_the_grip_cells_coefficient_depends_on_where_it_is_pressed() -> None:
    rows = record_grip_cell(seed=2)
    slopes = {}
    for position in POSITIONS_M:
        chosen = rows.position_m == position
        force, voltage = rows.force_n[chosen], rows.voltage_v[chosen]
        error = 1e-3 / (np.sqrt(chosen.sum()) * force.std())
        slopes[position] = np.polyfit(force, voltage, 1)[0]
        assert slopes[position] == pytest.approx(cell_sensitivity(position), abs=5 * error)
    assert slopes[3.18e-3] / slopes[9.53e-3] == pytest.approx(1.9, rel=0.02)
    assert slopes[3.18e-3] > slopes[6.35e-3] > slopes[9.53e-3]
    with pytest.raises(UsageError, match="not on the grip cell's shell"):
        record_grip_cell(positions_m=[0.02])


def test_setups_are_those_of_table_10() -> None:
    found = setups()
    assert found["shaft"] == pytest.approx(12.0e-7)
    assert found["small_experimental"] == pytest.approx(19.8e-7)
    assert found["medium_experimental"] == pytest.approx(32.7e-7)
    assert len(found) == 7


def test_inertia_of_knobs_that_nobody_holds() -> None:
    """Speed after a pulse on an ideal rig without bearings: torque times duration over inertia."""
    recorded = record_apparatus(Rig.ideal(), damping=0.0, stiffness=0.0)
    assert len(recorded) == 3 * 6 * 3
    for trial in recorded:
        speed = (trial.angle_rad[-1] - trial.angle_rad[250]) / (trial.time_s[-1] - trial.time_s[250])
        impulse = trial.torque_nm.sum() * 1e-4
        step = 2 * np.pi / 640_000 / (trial.time_s[-1] - trial.time_s[250])
        assert speed == pytest.approx(impulse / setups()[trial.key.subject], abs=2 * step)
        assert not trial.grip_n.any()
    with pytest.raises(UsageError, match="no setup 'tiny'; there are: shaft, small_proof"):
        record_apparatus(Rig(), chosen=["tiny"])


def test_benches_are_the_same_every_time_and_part_by_part() -> None:
    rig = Rig()
    whole = {trial.key: trial for trial in record_apparatus(rig)}
    for trial in record_apparatus(rig, chosen=["medium_experimental"], trials=1):
        assert np.array_equal(trial.angle_rad, whole[trial.key].angle_rad)
    assert np.array_equal(record_grip_cell().voltage_v, record_grip_cell().voltage_v)
    assert np.array_equal(record_motor_calibration(rig).torque_nm, record_motor_calibration(rig).torque_nm)
