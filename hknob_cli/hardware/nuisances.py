"""What a virtual knob can have that the ideal one has not: noise, an amplifier that lags, a clock that is late."""

from math import isfinite
from typing import NamedTuple
from zlib import crc32

import numpy as np

from hknob_cli.apparatus.streams import Purpose, stream
from hknob_cli.errors import UsageError
from hknob_cli.hardware.port import Array, Settings, Simulated

_ANGLE, _GRIP, _JITTER, _LATE, _TORQUE, _ACCELERATION = range(6)  # last number of each nuisance's stream


class Nuisances(NamedTuple):
    """Each is off at 0, and draws from a stream of its own, so that switching one on changes no other.

    ``angle_noise_rad``: rms of the encoder before it rounds; ``grip_noise_n``: rms of the grip cell; ``amplifier_s``:
    time constant of a first-order lag from command to torque; ``jitter_s``: rms by which a sample begins after its
    time, never before it; ``late_share``: share of samples that begin half a period to ``LATEST`` periods after it.

    The noise of a trial follows from ``seed``, its settings and its simulated person, whatever was run before.
    """

    angle_noise_rad: float = 0.0
    grip_noise_n: float = 0.0
    amplifier_s: float = 0.0
    jitter_s: float = 0.0
    late_share: float = 0.0
    seed: int = 0

    def checked(self) -> "Nuisances":
        """These. Raises `UsageError` for a number out of range."""
        for name, value in self._asdict().items():
            if not isfinite(value) or value < 0.0:
                raise UsageError(f"virtual device: {name} must be >= 0, got {value:g}")
        if self.late_share > 1.0:
            raise UsageError(f"virtual device: late_share must be <= 1, got {self.late_share:g}")
        return self


LATEST = 3.0  # periods that an overrun takes at most: an assumption, some ticks of the clock are missed


class Disturbances:
    """The nuisances of one trial, block after block; how they are cut into blocks changes nothing."""

    def __init__(self, nuisances: Nuisances, settings: Settings, simulated: Simulated) -> None:
        plain = simulated._replace(push_sines=(), grip_sines=())
        numbers = [value for value in plain if not isinstance(value, tuple)]
        numbers += [value for sine in (*simulated.push_sines, *simulated.grip_sines) for value in sine]
        numbers += [one.amplitude for one in simulated.squeeze.sines] if simulated.squeeze else []
        person = crc32(np.array(numbers, dtype="<f8").tobytes())
        place = settings.period_ns, settings.counts_per_rev, person

        def own(which: int) -> np.random.Generator:
            return stream(nuisances.seed, Purpose.DEVICE, *place, which)

        self._nuisances = nuisances
        self._angle, self._grip, self._jitter, self._late = own(_ANGLE), own(_GRIP), own(_JITTER), own(_LATE)
        self._torque, self._acceleration = own(_TORQUE), own(_ACCELERATION)
        self._jitter_periods = nuisances.jitter_s / settings.interval_s
        self._tick = 0

    def angle_rad(self, count: int) -> Array:
        """Noise of the encoder at the next samples."""
        return _noise(self._angle, self._nuisances.angle_noise_rad, count)

    def grip_n(self, count: int) -> Array:
        """Noise of the grip cell at the next samples."""
        return _noise(self._grip, self._nuisances.grip_noise_n, count)

    def torque_nm(self, rms: float, count: int) -> Array:
        """Noise of a torque sensor at the next samples."""
        return _noise(self._torque, rms, count)

    def acceleration_rad_s2(self, rms: float, count: int) -> Array:
        """Noise of an accelerometer at the next samples."""
        return _noise(self._acceleration, rms, count)

    def begins(self, count: int) -> tuple[Array, Array]:
        """When the next samples begin, and how late that is, both in periods: arrays (count,).

        A sample begins at the first tick of the clock after the last one began, or later. Ticks that pass meanwhile are
        not made up for.
        """
        late = np.abs(_noise(self._jitter, self._jitter_periods, count))
        if self._nuisances.late_share > 0.0:
            chance = self._late.random((count, 2))
            over = chance[:, 0] < self._nuisances.late_share
            late = np.where(over, 0.5 + (LATEST - 0.5) * chance[:, 1], late)
        ticks = np.zeros(count)
        if late.max() < 1.0:
            ticks[:] = self._tick + np.arange(count)
            self._tick += count
        else:
            for i in range(count):
                ticks[i] = self._tick
                self._tick += 1 + int(late[i])
        return ticks + late, late


def _noise(rng: np.random.Generator, rms: float, count: int) -> Array:
    return rms * rng.standard_normal(count) if rms > 0.0 else np.zeros(count)
