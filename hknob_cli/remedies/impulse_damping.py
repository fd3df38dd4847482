"""Impulse damping: a torque pulse that makes good what the hold got wrong when a count was crossed (Section 11.2).

A crossing is seen at the next sample, half an interval late on average: the torque-time integral is wrong by K times
the counts crossed, times T/2. A pulse over the part ``pulse`` of the next interval gives it back, T_I = K dtheta
(T/2) / t_I. With ``detections`` above 1 a fast sub-controller reads the encoder so many times an interval, and the
integral that was wrong is known to 1/detections of it.
"""

import numpy as np

from hknob_cli.remedies.lanes import Array
from hknob_cli.remedies.remedy import Action, Plain, Reading


class ImpulseDamping(Plain):
    """Length of the ``pulse`` (part of an interval), ``gain`` on its integral, ``detections`` of a crossing."""

    rows = 1
    counted: tuple[int, ...] = (0,)

    def __init__(self, pulse: float, gain: float, detections: int) -> None:
        self.pulse = pulse
        self.gain = gain
        self.parts = (pulse, 1.0 - pulse) if pulse < 1.0 else (1.0,)
        self.looks = tuple(k / detections for k in range(1, detections)) if detections > 1 else ()

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """The wall, and before it the pulse."""
        now, before = reading.depth, memory[0]
        if reading.seen is None:
            missed = 0.5 * (now - before)
        else:
            depths = np.where(reading.seen < 0.0, -(reading.seen + fixed[0]), 0.0)
            # A crossing lies half a detection before it is seen, as it does half an interval without any.
            steps = np.diff(np.concatenate([before[None], depths, now[None]]), axis=0)
            count = len(steps)
            late = (count - np.arange(count) - 0.5) / count
            missed = np.einsum("i,ij->j", late, steps)
        pulse = now + self.gain * missed / self.pulse
        return Action((pulse, now) if self.pulse < 1.0 else (pulse,), now[None])
