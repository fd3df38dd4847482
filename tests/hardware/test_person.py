"""The virtual person: the printed spread of grips, hands between the table's rows, and what can be switched off."""

from math import tau

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.hardware.person import (
    PRINTED_TARGET_N,
    STEADY_S,
    TREMOR_HZ,
    Knob,
    Person,
    hand_at,
    hold,
    printed_grips,
)
from hknob_cli.hardware.port import MOST_SINES
from hknob_cli.printed import grasps

KNOB = Knob(1.9e-6)
DRAWN = [hold(Person(), KNOB, seed=3, place=(1000, 256, i)) for i in range(1500)]


def means(offset_s: float = 0.5) -> np.ndarray:
    """Mean grip over a steady part, by the integral of the sines."""
    found = []
    for one in DRAWN:
        total = one.grip_n
        for sine in one.grip_sines:
            begin, end = (tau * sine.frequency_hz * t + sine.phase for t in (offset_s, offset_s + STEADY_S))
            total += sine.amplitude * (np.cos(begin) - np.cos(end)) / (end - begin)
        found.append(total)
    return np.array(found)


def test_trial_means_scatter_as_in_table_8() -> None:
    """Within four standard errors of 1500 draws: std / sqrt(n) of a mean, std / sqrt(2 n) of a standard deviation."""
    mean, std = printed_grips()
    assert round(mean, 2) == 0.72
    assert round(std, 2) == 0.05
    drawn = means()
    assert abs(drawn.mean() - mean) < 4 * std / np.sqrt(drawn.size)
    assert abs(drawn.std() - std) < 4 * std / np.sqrt(2 * drawn.size)


def test_another_target_scatters_in_proportion() -> None:
    """The same draws, so exactly; for trial means only where the wander is proportional, too, as it is."""
    firm = hold(Person(grip_target_n=2 * PRINTED_TARGET_N), KNOB, seed=3, place=(1000, 256, 0))
    assert firm.grip_n == pytest.approx(2 * DRAWN[0].grip_n, rel=1e-12)


def test_push_differs_as_it_is_told() -> None:
    """Mean and coefficient of variation within four standard errors; a lognormal's are 1.2 times a normal's."""
    smooth = Knob(1.9e-6, coulomb_torque=0.0)
    pushes = np.array([hold(Person(), smooth, seed=3, place=(1000, 256, i)).push_nm for i in range(1500)])
    assert abs(pushes.mean() - 1e-3) < 4 * 0.2e-3 / np.sqrt(pushes.size)
    assert abs(pushes.std() / pushes.mean() - 0.2) < 4 * 1.2 * 0.2 / np.sqrt(2 * pushes.size)
    assert (pushes > 0.0).all()


def test_a_push_keeps_contact_against_friction() -> None:
    """Only those are drawn again that friction would stop, and the others are the same without it."""
    smooth = Knob(1.9e-6, coulomb_torque=0.0)
    again = 0
    for i, one in enumerate(DRAWN[:500]):
        free = hold(Person(), smooth, seed=3, place=(1000, 256, i))
        weakest = [each.push_nm - sum(sine.amplitude for sine in each.push_sines) for each in (one, free)]
        assert weakest[0] > KNOB.coulomb_torque
        if weakest[1] > KNOB.coulomb_torque:
            assert (one.push_nm, one.push_sines) == (free.push_nm, free.push_sines)
        else:
            again += 1
    assert 0 < again < 250
    weak = hold(Person(push_nm=3e-4), KNOB, seed=3, place=(1,))
    assert weak.push_nm < KNOB.coulomb_torque


def test_wander_is_slow_and_tremor_in_its_band() -> None:
    for one in DRAWN[:200]:
        for mean, sines, wander in ((one.push_nm, one.push_sines, 0.1), (PRINTED_TARGET_N, one.grip_sines, 0.02)):
            assert len(sines) <= MOST_SINES
            slow = [sine for sine in sines if sine.frequency_hz <= 1.0]
            fast = [sine for sine in sines if TREMOR_HZ[0] <= sine.frequency_hz <= TREMOR_HZ[1]]
            assert len(slow) == len(fast) == 2
            assert np.sqrt(sum(sine.amplitude**2 / 2 for sine in slow)) == pytest.approx(wander * mean)


def test_each_is_switched_off_by_itself() -> None:
    place = (1000, 256, 7)
    both = hold(Person(), KNOB, seed=3, place=place)
    calm = hold(Person(wandering_push=False), KNOB, seed=3, place=place)
    assert (calm.push_nm, calm.push_sines) == (1e-3, ())
    assert calm == both._replace(push_nm=1e-3, push_sines=())
    firm = hold(Person(grip_wander=False), Knob(1.9e-6, coulomb_torque=0.0), seed=3, place=place)
    assert (firm.grip_n, firm.grip_sines, firm.coulomb_nm) == (0.71, (), 0.0)
    assert (firm.push_nm, firm.push_sines, firm.grip_offset_n) == (both.push_nm, both.push_sines, both.grip_offset_n)
    row = grasps(1)[0]
    assert (firm.damping, firm.stiffness) == (row.damping, row.stiffness)
    assert firm.inertia == 1.9e-6 + row.inertia
    assert both.coulomb_nm == 0.56e-3


def test_a_trial_is_drawn_from_its_place_and_seed_alone() -> None:
    assert hold(Person(), KNOB, seed=3, place=(1000, 256, 7)) == DRAWN[7]
    assert hold(Person(), KNOB, seed=4, place=(1000, 256, 7)) != DRAWN[7]
    assert len({one.push_nm for one in DRAWN}) == len(DRAWN)


def test_hands_lie_on_lines_between_the_rows() -> None:
    rows = grasps(1)
    for row in rows:
        assert hand_at(row.grip_n) == pytest.approx(row, rel=1e-12)
    assert hand_at(1.005).damping == pytest.approx(0.5 * (rows[0].damping + rows[1].damping))
    assert hand_at(0.12).stiffness == pytest.approx(2 * rows[0].stiffness - rows[1].stiffness)
    assert min(hand_at(0.0)[1:]) > 0.0


@pytest.mark.parametrize(
    ("person", "knob", "message"),
    [
        (Person(push_nm=-1.0), KNOB, "push_nm must be >= 0, got -1"),
        (Person(grip_target_n=float("nan")), KNOB, "grip_target_n must be >= 0, got nan"),
        (Person(grip_target_n=20.0, grip_wander=False), KNOB, r"up to a grip of 14\.2 N, got 20 N"),
        (Person(grip_target_n=14.2, grip_wander=False), Knob(1e-7), "no inertia together at a grip of 14.2 N"),
    ],
)
def test_what_cannot_be_is_refused(person: Person, knob: Knob, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        hold(person, knob, seed=0, place=(1,))
