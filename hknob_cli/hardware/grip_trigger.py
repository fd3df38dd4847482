"""The state machine that fires a pulse when a grip is as told (Hasser, section 3.2), sample by sample.

RELAX until the grip is below the release level; SQUEEZE until it reaches the target, or is in its band, where it has
to stay (HOLD); PULSE; RELEASE until the grip is below the release level again; DONE. Times are whole samples. The force
is that of the cell less its mean before the start, as the device told it, so that host and device go by one number.
"""

from enum import Enum

import numpy as np

from hknob_cli.hardware.port import Array, Flags, Pulse, PulseOrder


class Phase(str, Enum):
    """What a trial is at; ``ZERO``: before the start."""

    ZERO = "zero"
    RELAX = "relax"
    SQUEEZE = "squeeze"
    HOLD = "hold"
    PULSE = "pulse"
    RELEASE = "release"
    DONE = "done"


def pulse_of(order: PulseOrder, interval_s: float) -> Pulse:
    """A pulse in samples, as devices count them; ``interval_s`` from sample to sample."""
    return Pulse(
        grip_n=order.grip_n,
        band_n=order.band_n,
        release_n=order.release_n,
        torque_nm=order.torque_nm,
        width=max(1, round(order.width_s / interval_s)),
        dwell=round(order.dwell_s / interval_s),
    )


class GripTrigger:
    """Follows the grip of one trial; ``phase`` is that of the last sample."""

    def __init__(self, order: PulseOrder, interval_s: float) -> None:
        """``interval_s`` from sample to sample."""
        self._pulse = pulse_of(order, interval_s)
        self._stayed = 0
        self._sum, self._count = 0.0, 0
        self.phase = Phase.ZERO

    @property
    def zero_n(self) -> float:
        """Mean of the cell before the start."""
        return self._sum / self._count if self._count else 0.0

    def step(self, cell_n: float, *, running: bool) -> float:
        """Torque (N·m) from this sample to the next, at which the grip cell shows ``cell_n``."""
        if not running:
            self._sum, self._count = self._sum + cell_n, self._count + 1
            return 0.0
        grip = cell_n - self.zero_n
        if self.phase in (Phase.ZERO, Phase.RELAX):
            self.phase = Phase.SQUEEZE if grip < self._pulse.release_n else Phase.RELAX
        if self.phase in (Phase.SQUEEZE, Phase.HOLD):
            self._wait(grip)
        elif self.phase is Phase.PULSE:
            self._stayed += 1
            self.phase = Phase.PULSE if self._stayed < self._pulse.width else Phase.RELEASE
        if self.phase is Phase.RELEASE and grip < self._pulse.release_n:
            self.phase = Phase.DONE
        return self._pulse.torque_nm if self.phase is Phase.PULSE else 0.0

    def _wait(self, grip: float) -> None:
        """Fire, or go on waiting."""
        pulse = self._pulse
        if not pulse.dwell:
            fires = grip >= pulse.grip_n
        else:
            held = abs(grip - pulse.grip_n) <= pulse.band_n
            self._stayed = self._stayed + 1 if held else 0
            self.phase = Phase.HOLD if held else Phase.SQUEEZE
            fires = self._stayed > pulse.dwell
        if fires:
            self.phase, self._stayed = Phase.PULSE, 0

    def follow(self, cell_n: Array, running: Flags) -> Array:
        """Torques (n,) at samples."""
        return np.array([self.step(one, running=on) for one, on in zip(cell_n.tolist(), running.tolist(), strict=True)])
