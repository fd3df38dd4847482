"""What is not ideal about a virtual knob: each by itself, with a stream of its own, however samples are cut."""

from math import tau

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.port import Block, Settings, Simulated
from hknob_cli.hardware.virtual import VirtualDevice
from tests.hardware.trials import ALIGNED, HAND, settings, virtual_trial

ALL = Nuisances(angle_noise_rad=3e-5, grip_noise_n=0.02, amplifier_s=5e-5, jitter_s=2e-6, late_share=0.01, seed=6)
STILL = HAND._replace(coulomb_nm=1.0, angle_rad=0.0101)  # nothing moves it
Q = tau / ALIGNED.native_counts


def same(a: Block, b: Block, *, but: tuple[str, ...] = ()) -> bool:
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in Block._fields if name not in but)


def test_noise_is_as_told() -> None:
    """Four standard errors of a standard deviation; rounding to counts adds a twelfth of a count squared."""
    got = virtual_trial(settings(), STILL, nuisances=ALL, duration_s=4.0)
    n = got.angle_counts.size
    expected = np.sqrt((3e-5 / Q) ** 2 + 1 / 12)
    assert abs(got.angle_counts.std() - expected) < 4 * expected / np.sqrt(2 * n)
    assert abs(got.angle_counts.mean() + 0.5 - 0.0101 / Q) < 4 * expected / np.sqrt(n)
    held = got.grip_n - np.where(got.running, virtual_trial(settings(), STILL, duration_s=4.0).grip_n, 0.3)
    assert abs(held[2000:].std() - 0.02) < 4 * 0.02 / np.sqrt(2 * (n - 2000)) + 1e-4


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("angle_noise_rad", ("angle_counts",)),
        ("grip_noise_n", ("grip_n",)),
        ("jitter_s", ("time_us", "grip_n")),
        ("late_share", ("time_us", "grip_n", "overruns")),
    ],
)
def test_each_is_switched_off_by_itself(name: str, changes: tuple[str, ...]) -> None:
    """On a knob that is held, so that nothing passes from one to another but time."""
    both = virtual_trial(settings(), STILL, nuisances=ALL, duration_s=1.0)
    less = virtual_trial(settings(), STILL, nuisances=ALL._replace(**{name: 0.0}), duration_s=1.0)
    assert same(both, less, but=changes)
    assert not any(np.array_equal(getattr(both, field), getattr(less, field)) for field in changes)


def test_noise_depends_on_seed_and_trial_alone() -> None:
    def run(told: Settings, knob: Simulated, nuisances: Nuisances) -> Block:
        return virtual_trial(told, knob, nuisances=nuisances, duration_s=0.4)

    told = settings()
    first = run(told, HAND, ALL)
    run(settings(2000), HAND, ALL)  # another trial, before the same again
    assert same(run(told, HAND, ALL), first)
    for knob, seed in ((HAND, 7), (HAND._replace(push_nm=1.01e-3), 6)):
        assert not np.array_equal(run(told, knob, ALL._replace(seed=seed)).time_us, first.time_us)


def test_how_samples_are_cut_into_blocks_changes_nothing() -> None:
    whole = virtual_trial(settings(block_samples=40), nuisances=ALL, duration_s=1.4)
    small = virtual_trial(settings(block_samples=8), nuisances=ALL, duration_s=1.4, before=5)
    assert small.angle_counts.size == whole.angle_counts.size
    assert same(whole, small)


def test_a_late_sample_shows_where_the_knob_is_by_then() -> None:
    """A free knob under a constant push falls by a t² / 2, t told in whole microseconds: off by at most a t of one."""
    free = HAND._replace(damping=0.0, stiffness=0.0, angle_rad=60.0, push_nm=2e-4)
    late = Nuisances(jitter_s=3e-5, late_share=0.05, seed=1)
    got = virtual_trial(settings(500), free, nuisances=late, duration_s=0.2)
    on = got.running
    t = (got.time_us[on] - got.time_us[on][0]) * 1e-6
    a = free.push_nm / free.inertia
    expected = free.angle_rad - 0.5 * a * t**2
    assert (np.abs(got.angle_counts[on] * Q - expected) <= a * t * 1.5e-6 + 2 * Q).all()
    assert got.overruns > 0
    assert np.diff(t).max() > 1.3 * 2e-3


def test_a_late_sample_is_no_fast_knob() -> None:
    """Speed is over the time that passed: a limit just above the true speed does not trip after missed ticks."""
    free = HAND._replace(stiffness=0.0, damping=2e-3, angle_rad=2.0, push_nm=2e-3)  # settles at 1 rad/s
    limit = settings(2000, speed_limit_rad_s=1.05)
    got = virtual_trial(limit, free, nuisances=Nuisances(late_share=0.1, seed=1), duration_s=0.5)
    assert got.overruns > 20
    assert np.abs(np.diff(got.angle_counts)).max() * Q / 5e-4 > 1.5


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"jitter_s": -1.0}, "jitter_s must be >= 0, got -1"),
        ({"grip_noise_n": float("nan")}, "grip_noise_n must be >= 0, got nan"),
        ({"late_share": 1.5}, "late_share must be <= 1, got 1.5"),
    ],
)
def test_nuisances_out_of_range_are_refused(changes: dict[str, float], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        VirtualDevice(Nuisances(**changes))
