"""Clips: the waveform that the harmonics say, within full scale, always the same bytes."""

import io
import wave

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.perception.sound import clip, wav_bytes

FADE = 882  # samples, 20 ms


def test_speed_and_acceleration_of_a_sinusoid() -> None:
    """θ = a cos(2πft): speed -2πfa sin, acceleration -(2πf)²a cos; between the fades as they are."""
    a, f = 1e-3, 100.0
    t = np.arange(44100)[FADE:-FADE] / 44100
    speed = clip([f], [a], duration_s=1.0)
    assert speed.samples[FADE:-FADE] == pytest.approx(
        -speed.factor * 2 * np.pi * f * a * np.sin(2 * np.pi * f * t), abs=1e-9
    )
    push = clip([f], [a], quantity="acceleration", duration_s=1.0)
    wanted = -push.factor * (2 * np.pi * f) ** 2 * a * np.cos(2 * np.pi * f * t)
    assert push.samples[FADE:-FADE] == pytest.approx(wanted, abs=1e-9)
    assert (speed.unit, push.unit) == ("rad/s", "rad/s^2")
    # Half of full scale is reached; a sample lies within 2 degrees of each peak.
    assert np.abs(speed.samples).max() == pytest.approx(0.5)
    assert speed.factor == pytest.approx(0.5 / (2 * np.pi * f * a), rel=1e-3)


def test_parts_from_half_the_sample_rate_on_are_left_out() -> None:
    alone = clip([100.0], [1e-3], duration_s=0.1)
    more = clip([0.0, 100.0, 22050.0, 30000.0], [5.0, 1e-3, 1.0, 1.0], duration_s=0.1)
    assert (alone.samples == more.samples).all()
    for hertz in ([22050.0], [0.0], []):
        with pytest.raises(UsageError, match="nothing to hear"):
            clip(hertz, np.ones(len(hertz)))


def test_ends_are_faded_to_silence() -> None:
    sound = clip([1000.0], [1e-3 + 1e-3j], duration_s=0.2)
    assert sound.samples[0] == 0.0
    assert sound.samples[-1] == 0.0
    assert np.abs(sound.samples[:20]).max() < 0.01
    assert len(clip([1000.0], [1e-3], duration_s=1e-4).samples) == 4  # shorter than its fades


def test_a_fixed_factor_keeps_clips_comparable_and_never_clips() -> None:
    quiet, loud = (clip([100.0], [a], duration_s=0.1, factor=0.1) for a in (1e-3, 2e-3))
    assert loud.samples == pytest.approx(2.0 * quiet.samples)
    with pytest.raises(UsageError, match="factor of 10 clips"):
        clip([100.0], [1e-3], factor=10.0)


def test_the_file_is_a_wav_of_16_bits_and_the_same_every_time() -> None:
    sound = clip(100.0 * np.arange(1, 8), 1e-3 / np.arange(1, 8) ** 3, duration_s=0.5)
    data = wav_bytes(sound)
    assert data == wav_bytes(clip(100.0 * np.arange(1, 8), 1e-3 / np.arange(1, 8) ** 3, duration_s=0.5))
    with wave.open(io.BytesIO(data)) as file:
        assert (file.getnchannels(), file.getsampwidth(), file.getframerate(), file.getnframes()) == (
            1,
            2,
            44100,
            22050,
        )
        samples = np.frombuffer(file.readframes(22050), "<i2") / 32767
    assert samples == pytest.approx(sound.samples, abs=0.5 / 32767 + 1e-12)  # rounded to the nearest step


@pytest.mark.parametrize(
    "bad", [{"quantity": "angle"}, {"duration_s": 0.0}, {"duration_s": 601.0}, {"duration_s": float("nan")}]
)
def test_bad_requests_are_refused(bad: dict) -> None:
    with pytest.raises(UsageError):
        clip([100.0], [1e-3], **bad)
