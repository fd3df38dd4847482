"""The person who squeezes: the course of the force, and the hand at it."""

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.hardware.order import settings_of, trials_of
from hknob_cli.hardware.person import AIM_CV, grip_of, order_of, squeezer, squeezing_hand
from hknob_cli.hardware.port import Squeeze
from hknob_cli.printed import table
from tests.hardware.pulses import HELD, SPEC, planned

PLAIN = Squeeze(
    aim_n=2.0,
    rise_s=0.5,
    overshoot=0.15,
    climbs=False,
    reaction_s=0.2,
    relax_s=0.1,
    strength_n=30.0,
    hands=((1.0, 2e-6, 1e-4, 0.1), (3.0, 1e-6, 5e-4, 0.2)),
)
T = np.arange(0.0, 5.0, 1e-4)


def test_a_held_grip_overshoots_at_the_rise_and_settles() -> None:
    force = grip_of(PLAIN, T, None)
    assert not force[T < 0.2].any()
    top = int(np.argmax(force))
    assert T[top] == pytest.approx(0.2 + 0.5, abs=1e-4)
    assert force[top] == pytest.approx(2.0 * 1.15, rel=1e-6)
    # Each half turn the distance from the aim is the overshoot's share of the one before.
    low = force[np.searchsorted(T, 0.2 + 1.0)]
    assert low == pytest.approx(2.0 * (1.0 - 0.15**2), rel=1e-6)
    assert force[-1] == pytest.approx(2.0, rel=1e-6)


def test_a_climbing_grip_is_a_ramp_up_to_the_strength() -> None:
    force = grip_of(PLAIN._replace(climbs=True, strength_n=7.0), T, None)
    assert force[np.searchsorted(T, 0.7)] == pytest.approx(2.0, rel=1e-3)
    ramp = (T > 0.2) & (force < 7.0)
    assert np.allclose(np.diff(force[ramp]), 2.0 / 0.5 * 1e-4)
    assert force.max() == 7.0


@pytest.mark.parametrize("climbs", [True, False])
def test_after_the_pulse_the_hand_lets_go(climbs: bool) -> None:
    squeeze = PLAIN._replace(climbs=climbs)
    before, after = grip_of(squeeze, T, None), grip_of(squeeze, T, 0.9)
    lets_go = 0.9 + 0.2
    assert np.array_equal(before[lets_go >= T], after[lets_go >= T])
    later = after[lets_go < T]
    assert np.allclose(later[1:] / later[:-1], np.exp(-1e-4 / 0.1))


def test_a_hand_between_two_rows_lies_between_them() -> None:
    assert squeezing_hand(PLAIN, 2.5) == pytest.approx((1.25e-6, 4e-4, 0.175))
    assert squeezing_hand(PLAIN, 0.2) == pytest.approx((2e-6, 1e-4, 0.1))
    assert squeezing_hand(PLAIN, 9.0) == pytest.approx((1e-6, 5e-4, 0.2))


def test_the_mean_person_is_the_printed_one_in_every_trial() -> None:
    plan = planned(SPEC.replace("person: {", "person: {person: 0, "))
    for trial in trials_of(plan):
        person = squeezer(plan, trial)
        row = next(row for row in table(1) if row["grip_n"] == trial.grip_target_n)
        assert (person.inertia, person.damping, person.stiffness) == (
            row["inertia_kg_m2"],
            row["damping_nm_s_per_rad"],
            row["stiffness_nm_per_rad"],
        )
        assert person.squeeze
        assert person.squeeze.aim_n == trial.grip_target_n
        assert person.coulomb_nm == 0.56e-3


def test_another_knob_replaces_that_of_the_apparatus() -> None:
    """Table 1 includes 19.8 g·cm² of apparatus (Table 10): a knob of 50 adds 30.2 to its hands."""
    mean = SPEC.replace("person: {", "person: {person: 0, ")
    plain, heavy = planned(mean), planned(mean + "knob: {inertia: 50 g*cm^2, damping: 1.0e-4}\n")
    one, other = (squeezer(plan, trials_of(plan)[0]) for plan in (plain, heavy))
    assert other.inertia - one.inertia == pytest.approx(30.2e-7)
    assert other.damping - one.damping == pytest.approx(1e-4)
    assert other.stiffness == one.stiffness
    # The pulse is as high as turns that hand by 0.09 rad: more inertia, more torque.
    assert order_of(heavy, 0.71).torque_nm > order_of(plain, 0.71).torque_nm


def test_a_knob_lighter_than_what_the_hand_takes_off_is_refused() -> None:
    plan = planned(SPEC.replace("4.3", "14.2") + "knob: {inertia: 1 g*cm^2}\n")
    with pytest.raises(UsageError, match=r"no inertia together at 14\.2 N"):
        squeezer(plan, trials_of(plan)[0])


def test_people_and_trials_differ_and_a_seed_repeats() -> None:
    plan = planned(SPEC.replace("trials: 2", "trials: 40"))
    people = [squeezer(plan, trial) for trial in trials_of(plan) if trial.grip_target_n == 0.71]
    assert people == [squeezer(plan, trial) for trial in trials_of(plan) if trial.grip_target_n == 0.71]
    aims = np.array([one.squeeze.aim_n for one in people if one.squeeze]) / 0.71
    assert abs(aims.mean() - 1.0) < 4.0 * AIM_CV / np.sqrt(40)
    assert 0.6 * AIM_CV < aims.std(ddof=1) < 1.4 * AIM_CV
    assert len({one.stiffness for one in people}) == 40
    # One block, so a trial's own spread: 5 % of the stiffness (`Variation`).
    cv = np.std([one.stiffness for one in people], ddof=1) / np.mean([one.stiffness for one in people])
    assert 0.03 < cv < 0.07
    assert squeezer(plan._replace(seed=1), trials_of(plan)[0]) != people[0]


def test_what_the_device_is_told() -> None:
    plan = planned(HELD.replace("trigger", "torques: [3 mN*m, 8 mN*m], width: 10 ms, band: 0.2, release: 0.5, trigger"))
    trials = trials_of(plan)
    assert settings_of(plan, trials[1]).pulse == (4.3, pytest.approx(0.86), 0.1, 2.15, 0.008, 0.01)
    assert settings_of(plan, trials[0]).wall_stiffness == 0.0
