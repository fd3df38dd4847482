"""Tests of `recordings.trial`: each flag of a suspicious one where it belongs, and none on a sound one."""

import numpy as np
import pytest

from hknob_cli.recordings.trial import flags
from tests.recordings.hands import trial


@pytest.mark.parametrize("torque", [0.01, -0.01])
@pytest.mark.parametrize("rate", [2000.0, 10_000.0])
@pytest.mark.parametrize("counts", [None, 4096, 16_384, 65_536, 640_000])
@pytest.mark.parametrize("rest", [0.0, 1.234, -3.0])
def test_a_sound_trial_has_no_flags(torque: float, rate: float, counts: int | None, rest: float) -> None:
    sound = trial(torque_nm=torque, rate_hz=rate, counts=counts, rest_rad=rest)
    assert flags(sound, counts_per_rev=counts, sample_rate_hz=rate) == ()
    assert flags(sound) == ()


def test_noise_that_averages_out_is_no_motion_before_the_pulse() -> None:
    assert flags(trial(noise_rad=2e-4)) == ()


@pytest.mark.parametrize("number", range(20))
def test_noise_of_some_counts_is_no_lost_sample(number: int) -> None:
    assert flags(trial(number=number, noise_rad=2e-5, counts=640_000, torque_nm=-0.005)) == ()


def flat(sound):
    return sound._replace(torque_nm=np.zeros_like(sound.torque_nm))


def clipped(sound):
    return sound._replace(angle_rad=np.minimum(sound.angle_rad, 0.6 * sound.angle_rad.max()))


def gap(sound):
    keep = np.ones(sound.time_s.size, dtype=bool)
    keep[600:605] = False
    return sound._replace(
        **{name: getattr(sound, name)[keep] for name in ("time_s", "torque_nm", "angle_rad", "grip_n")}
    )


def frozen(sound):
    angle = sound.angle_rad.copy()
    angle[601:605] = angle[600]
    return sound._replace(angle_rad=angle)


def drifting(sound):
    return sound._replace(angle_rad=sound.angle_rad + 1.0 * sound.time_s)


def cut(sound, begin, end):
    names = ("time_s", "torque_nm", "angle_rad", "grip_n")
    return sound._replace(**{name: getattr(sound, name)[begin:end] for name in names})


# What is done to a sound trial at 10 kHz, and the flag it must raise, with the number.
SPOILT = {
    "no pulse": (flat, "no pulse: the commanded torque is zero throughout"),
    "wrong sign": (lambda t: t._replace(angle_rad=-t.angle_rad), "pulse of the wrong sign: the angle moves by -0.1"),
    "held": (clipped, "angle at the end of its range, 0.0"),
    "gap": (gap, "1 gap in time, the longest 0.0006 s, of samples 0.0001 s apart"),
    "frozen": (frozen, "angle repeats itself during motion 1 time, then jumps"),
    "moving": (drifting, "angle not at rest before the pulse: it moves by 0.01"),
    "loose": (lambda t: t._replace(grip_n=0.7 * t.grip_n), "grip of 1.68 N at the pulse, -30% off its target of 2.4 N"),
    "late": (lambda t: cut(t, 495, None), "5 samples before the pulse, fewer than 10"),
    "ends": (lambda t: cut(t, 0, 600), "the recording ends before the pulse does"),
    "still": (lambda t: t._replace(angle_rad=np.zeros_like(t.angle_rad)), "the angle does not move in the pulse"),
    "weak": (lambda t: t._replace(measured_torque_nm=0.6 * t.torque_nm), "measured torque is 60% of the commanded"),
    "milliseconds": (lambda t: t._replace(time_s=1000.0 * t.time_s), "pulse of 20 s, longer than 0.5 s: is time in"),
    "twice": (lambda t: t._replace(torque_nm=t.torque_nm + np.roll(t.torque_nm, 400)), "1 further pulse after the"),
}  # fmt: skip


@pytest.mark.parametrize("name", SPOILT)
def test_spoilt(name: str) -> None:
    spoil, message = SPOILT[name]
    found = flags(spoil(trial(counts=640_000)))
    assert any(flag.startswith(message) for flag in found), found
    assert len(found) == 1, found


def test_few_samples_in_the_pulse() -> None:
    assert "8 samples during the pulse, fewer than 10" in flags(trial(rate_hz=400.0))


def test_coarse_encoder() -> None:
    coarse = trial(counts=512)
    (found,) = flags(coarse, counts_per_rev=512)
    assert found.startswith("encoder too coarse: the motion is 1")
    assert flags(coarse) == (found,)


def test_more_counts_than_stated() -> None:
    """Of 4096 counts said to be 512, changes are eighths of a count; said to be more, nothing shows it."""
    fine = trial(counts=4096)
    assert any("is counts_per_rev right?" in flag for flag in flags(fine, counts_per_rev=512))
    for stated in (4096, 8192, None):
        assert not any("counts_per_rev" in flag for flag in flags(fine, counts_per_rev=stated))


def test_another_rate() -> None:
    assert flags(trial(), sample_rate_hz=4000.0) == ("sampled at 1e+04 Hz, not at 4000 Hz",)
