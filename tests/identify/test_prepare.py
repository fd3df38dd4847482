"""Trials made motions: aligned, averaged, cut, and what cannot be used is left out and said."""

import math

import numpy as np
import pytest

from hknob_cli.identify.prepare import Condition, Preparation, conditions
from tests.recordings.hands import DAMPING, INERTIA, STIFFNESS, trial

PLAIN = Preparation(decimate=1)


def one(*trials, preparation=PLAIN, **options):
    (prepared,) = conditions(trials, preparation, **options)
    return prepared


def test_the_window_is_two_milliseconds_before_and_thirty_after() -> None:
    sound = trial(rest_rad=0.7)
    motion = one(sound).motion
    assert motion.dt_s == pytest.approx(1e-4, rel=1e-9)
    assert motion.angle_rad.size == 20 + 1 + 300
    assert np.flatnonzero(motion.torque_nm)[[0, -1]].tolist() == [20, 219]
    assert motion.angle_rad == pytest.approx(sound.angle_rad[480:801] - 0.7, abs=1e-12)
    assert (motion.averaged, motion.noise_rad) == (1, None)


def test_conditions_and_their_trials() -> None:
    trials = [trial(number=n, block=b) for b in (2, 1) for n in (1, 2, 3)]
    averaged = conditions(trials, PLAIN)
    assert [(p.condition, p.trials) for p in averaged] == [
        (Condition("S1", "pinch", 2.4, 2), (1, 2, 3)), (Condition("S1", "pinch", 2.4, 1), (1, 2, 3)),
    ]  # fmt: skip
    assert averaged[0].motion.averaged == 3
    single = conditions(trials, PLAIN._replace(average=False))
    assert [p.trials for p in single] == [(1,), (2,), (3,)] * 2


def test_averaging_reduces_noise_by_the_root_of_the_number() -> None:
    """The spread of a sample standard deviation of m values is 1/sqrt(2 m): five of them are allowed."""
    noise, count = 1e-4, 64
    clean = one(trial()).motion.angle_rad
    trials = [trial(number=n, noise_rad=noise) for n in range(count)]
    motion = one(*trials).motion
    left = (motion.angle_rad - clean)[25:]
    left -= left.mean()
    assert left.std() == pytest.approx(noise / math.sqrt(count), rel=5.0 / math.sqrt(2.0 * left.size))
    assert motion.noise_rad == pytest.approx(noise / math.sqrt(count), rel=0.05)


def test_how_trials_differ_is_told_from_their_noise() -> None:
    """Angles of 90 and 110 % differ by a standard deviation of 14.1 %, noise and pulses of another size by none."""
    less, more = trial(number=1), trial(number=2)
    scaled = [part._replace(angle_rad=share * part.angle_rad) for part, share in ((less, 0.9), (more, 1.1))]
    motion = one(*scaled).motion
    after = motion.angle_rad[20:]
    assert motion.scatter_rad == pytest.approx(math.sqrt(0.02 * np.mean(after**2)), rel=1e-6)
    assert motion.trials_differ == pytest.approx(motion.scatter_rad / after.max())
    assert one(less).motion.scatter_rad is None
    assert one(trial(number=1, torque_nm=0.008), trial(number=2, torque_nm=0.012)).motion.trials_differ < 1e-6
    noisy = one(*(trial(number=n, noise_rad=1e-4) for n in range(64))).motion
    # Variances of m values are known to a share sqrt(2 / m), in motion and at rest: what is left is within 5 of both.
    assert noisy.scatter_rad < 1e-4 * math.sqrt(5.0 * math.sqrt(2.0 / (300 * 64) + 2.0 / (200 * 64)))


def test_trials_are_aligned_at_the_onset() -> None:
    trials = [trial(number=n, before_s=0.03 + 0.004 * n) for n in range(4)]
    alone = one(trials[0]).motion
    together = one(*trials).motion
    assert together.angle_rad == pytest.approx(alone.angle_rad, abs=1e-12)
    assert together.torque_nm.tolist() == alone.torque_nm.tolist()


def test_pulses_of_different_size_are_averaged_with_their_torque() -> None:
    both = one(trial(number=1, torque_nm=0.008), trial(number=2, torque_nm=0.012)).motion
    assert both.angle_rad == pytest.approx(one(trial()).motion.angle_rad, abs=1e-12)
    assert both.torque_nm.max() == pytest.approx(0.01)


def test_uneven_time_is_put_on_a_grid() -> None:
    """Linear interpolation errs by at most a h^2/8; the torque's impulse is kept; edges are off by one interval."""
    fine = trial(rate_hz=100_000.0)
    random = np.random.default_rng(5)
    keep = np.unique(np.cumsum(random.integers(8, 13, size=fine.time_s.size // 10)))
    keep = np.union1d(keep[keep < fine.time_s.size], [5000])  # the onset
    uneven = fine._replace(
        **{name: getattr(fine, name)[keep] for name in ("time_s", "torque_nm", "angle_rad", "grip_n")}
    )
    motion = one(uneven).motion
    widest = np.diff(uneven.time_s).max()
    onset = int(np.flatnonzero(motion.torque_nm > 1e-9)[0])
    times = 0.05 + motion.dt_s * (np.arange(motion.angle_rad.size) - onset)
    exact = np.interp(times, fine.time_s, fine.angle_rad)
    assert np.abs(motion.angle_rad - exact).max() <= 2.0 * 0.01 / INERTIA * widest**2 / 8.0 + 1e-12
    impulse = float(np.sum(uneven.torque_nm[:-1] * np.diff(uneven.time_s)))
    assert motion.torque_nm.sum() * motion.dt_s == pytest.approx(impulse, rel=1e-9)


def test_noise_is_no_less_than_the_encoder_makes() -> None:
    counts = 65_536
    step = 2.0 * math.pi / counts
    found = [trial(number=n, counts=counts) for n in range(4)]
    assert one(*found, counts_per_rev=counts).motion.noise_rad == pytest.approx(step / math.sqrt(12.0 * 4.0))
    assert one(*found).motion.noise_rad is None
    assert one(trial(noise_rad=1e-3), counts_per_rev=counts).motion.noise_rad == pytest.approx(1e-3, rel=0.2)


@pytest.mark.parametrize("differentiate", [True, False])
def test_derivatives_only_where_asked_for(differentiate: bool) -> None:
    motion = one(trial(), preparation=PLAIN._replace(differentiate=differentiate)).motion
    assert (motion.velocity_rad_s is not None) == (motion.acceleration_rad_s2 is not None) == differentiate


def test_the_equation_of_motion_holds_between_the_edges() -> None:
    """Central differences err by h^2/6 of the third and, twice, h^2/3 of the fourth derivative."""
    motion = one(trial()).motion
    inside = np.r_[25:215, 225:315]
    torque = INERTIA * motion.acceleration_rad_s2 + DAMPING * motion.velocity_rad_s + STIFFNESS * motion.angle_rad
    rate = math.sqrt(STIFFNESS / INERTIA) + DAMPING / INERTIA
    bound = 2.0 * 0.01 * (rate * 1e-4) ** 2
    assert np.abs(torque - motion.torque_nm)[inside].max() <= bound


def test_smoothing_by_ten_at_ten_kilohertz_and_none_at_one() -> None:
    noisy = trial(noise_rad=1e-5)
    smoothed, plain = one(noisy, preparation=Preparation()).motion, one(noisy).motion
    assert smoothed.angle_rad.size == plain.angle_rad.size
    wrong = {
        how: found.acceleration_rad_s2 - one(trial(), preparation=preparation).motion.acceleration_rad_s2
        for how, found, preparation in (("smoothed", smoothed, Preparation()), ("plain", plain, PLAIN))
    }
    # White noise of density n, differentiated twice: n f^2 up to the cutoff, 400 Hz, against 10 kHz/(2 pi) at most.
    assert wrong["smoothed"].std() < 0.1 * wrong["plain"].std()
    slow = trial(rate_hz=1000.0, noise_rad=1e-5)
    assert np.array_equal(one(slow, preparation=Preparation()).motion.angle_rad, one(slow).motion.angle_rad)


def test_decimated_motion_keeps_the_impulse_and_the_onset() -> None:
    full = one(trial(), preparation=Preparation()).motion
    few = one(trial(), preparation=Preparation(interpolate=False)).motion
    assert few.dt_s == pytest.approx(1e-3)
    assert few.angle_rad.size == 2 + 1 + 30
    assert few.torque_nm.size == few.angle_rad.size
    assert few.torque_nm.tolist() == [0.0] * 2 + [pytest.approx(0.01)] * 20 + [0.0] * 11
    assert few.angle_rad == pytest.approx(full.angle_rad[::10], abs=1e-12)


def regression(motion) -> np.ndarray:
    """Relative errors of inertia, damping and stiffness by least squares."""
    terms = np.stack([motion.acceleration_rad_s2, motion.velocity_rad_s, motion.angle_rad], axis=1)
    return np.linalg.lstsq(terms, motion.torque_nm, rcond=None)[0] / [INERTIA, DAMPING, STIFFNESS] - 1.0


def test_torque_smoothed_as_the_angle_leaves_no_bias() -> None:
    """With one filter on all terms the equation of motion still holds; on some of them, the pulse's edges do not."""
    some = regression(one(trial(), preparation=Preparation()).motion)
    every = regression(one(trial(), preparation=Preparation(smooth_torque=True)).motion)
    assert 0.02 < some[0] < 0.05
    assert np.abs(every).max() < 0.001


# What is done to the second of two trials, and why it is left out.
UNUSABLE = {
    "no pulse": (lambda t: t._replace(torque_nm=0.0 * t.torque_nm), "trial 2 left out: no pulse"),
    "late": (lambda t: cut(t, slice(500, None)), "trial 2 left out: the pulse has begun before the recording"),
    "short": (lambda t: cut(t, slice(0, 750)), "trial 2 left out: it ends 0.0249 s after the onset; the window needs"),
    "gap": (lambda t: cut(t, np.r_[0:600, 620:1500]), "trial 2 left out: gap of 0.0021 s in time, over 3 intervals"),
    "few": (lambda t: cut(t, slice(0, 1500, 400)), "trial 2 left out: "),
    "tiny": (lambda t: cut(t, slice(0, 3)), "trial 2 left out: "),
}


def cut(whole, part):
    names = ("time_s", "torque_nm", "angle_rad", "grip_n")
    return whole._replace(**{name: getattr(whole, name)[part] for name in names})


@pytest.mark.parametrize("name", UNUSABLE)
def test_what_cannot_be_used_is_left_out(name: str) -> None:
    spoil, message = UNUSABLE[name]
    prepared = one(trial(number=1), spoil(trial(number=2)))
    assert prepared.trials == (1,)
    assert prepared.motion.angle_rad.tolist() == one(trial(number=1)).motion.angle_rad.tolist()
    assert any(flag.startswith(message) for flag in prepared.flags), prepared.flags


def test_a_condition_without_a_usable_trial_has_no_motion() -> None:
    prepared = one(trial()._replace(torque_nm=np.zeros(1500)))
    assert prepared.motion is None
    assert prepared.trials == ()
    assert prepared.flags[-1] == "trial 1 left out: no pulse"


def test_flags_name_their_trial() -> None:
    loose = trial(number=7, grip_n=1.0)
    assert [flag[:25] for flag in one(trial(number=6), loose).flags] == ["trial 7: grip of 1 N at t"]
