"""The replay device: plays recorded trials back through the device port, each for the settings it was made with."""

from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from hknob_cli.errors import DeviceError, UsageError
from hknob_cli.hardware.port import Block, Drift, Identity, Settings, Torque
from hknob_cli.hardware.recorded_trials import RecordedTrial, is_of_wall, read_takes
from hknob_cli.hardware.simulated import Simulated

_SAME_RATE = 1e-3  # by how much a recorded sample rate may be off


class ReplayDevice:
    """A device that gives what was recorded, as fast as it is read.

    A trial is found by its sample rate and counts per revolution; where there are several, they take turns, in the
    order of the files. Overruns are not in a recording's samples: none are told.
    """

    def __init__(self, paths: Iterable[Path]) -> None:
        """Read recordings, or folders of campaigns. Raises `UsageError` where that cannot be done."""
        self._takes = read_takes(paths)
        if not self._takes:
            raise UsageError("there is nothing to replay")
        self._identity = Identity("replay", self._takes[0].native_counts, 1, False, 1)
        self._turns: dict[tuple[int, int], int] = {}
        self._chosen: tuple[RecordedTrial, Settings] | None = None
        self._playing: _Playing | None = None
        self._started = False

    @property
    def identity(self) -> Identity:
        """Who answers: nobody any more; ``native_counts`` are those of the recording's encoder."""
        return self._identity

    @property
    def torque(self) -> Torque:
        """Off: there is no motor."""
        return Torque.OFF

    @property
    def drift(self) -> Drift | None:
        """None: it has no clock."""
        return None

    def configure(self, settings: Settings, simulated: Simulated | None = None) -> None:  # noqa: ARG002 - was somebody
        """Find the recording for a trial's settings. Raises `DeviceError`, with what is there, if there is none."""
        self._must(self._playing is None, "be idle")
        rate = 1e9 / settings.period_ns
        near = [take for take in self._takes if abs(take.sample_rate_hz / rate - 1.0) <= _SAME_RATE]
        near = [take for take in near if take.counts_per_rev in (settings.counts_per_rev, None)]
        fitting = [take for take in near if is_of_wall(take, settings)]
        if not fitting:
            raise DeviceError(_not_there(settings, near, self._takes))
        cell = settings.period_ns, settings.counts_per_rev
        turn = self._turns.get(cell, 0)
        self._turns[cell] = turn + 1
        self._chosen = fitting[turn % len(fitting)], settings

    def arm(self) -> None:
        """Go to the first sample of the recording. Raises `DeviceError` if it is not idle, or has no settings."""
        self._must(self._playing is None, "be idle")
        if self._chosen is None:
            raise DeviceError("the replay device cannot be armed: it was given no settings")
        self._playing, self._started = _Playing(*self._chosen), False

    def start(self) -> None:
        """Go on to the first sample with the wall on. Raises `DeviceError` if the device is not armed."""
        if self._playing is None or self._started:
            raise DeviceError("the replay device must be armed for that")
        self._playing.start()
        self._started = True

    def read(self, timeout_s: float) -> Block | None:  # noqa: ARG002 - nothing takes time here
        """The next recorded samples, at once; None where there are no more, none before `start`, or after `stop`."""
        return self._playing.block(started=self._started) if self._playing else None

    def stop(self) -> None:
        """End it; what was not read is left. Raises `DeviceError` if the device is not armed."""
        self._must(self._playing is not None, "be armed")
        self._playing = None

    def release(self) -> None:
        """End it, whatever state it is in."""
        self._playing = None

    def __enter__(self) -> Self:
        """Open the device."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release it."""
        self.release()

    def _must(self, is_so: bool, what: str) -> None:
        if not is_so:
            raise DeviceError(f"the replay device must {what} for that")


class _Playing:
    """A recording as it is played: how far, and what was skipped.

    What is left before the start is skipped, and index and time go on without a gap. Gaps that were recorded are gaps.
    """

    def __init__(self, take: RecordedTrial, settings: Settings) -> None:
        self._take, self._settings = take, settings
        on = np.flatnonzero(take.running)
        self._first_on = int(on[0]) if on.size else take.number.size
        self._at = self._skipped = self._skipped_us = 0

    def start(self) -> None:
        take, at, first = self._take, self._at, self._first_on
        if at < first < take.number.size:
            number, time_us = int(take.number[at]), int(take.time_us[at])
            self._skipped, self._skipped_us = int(take.number[first]) - number, int(take.time_us[first]) - time_us
        self._at = max(at, first)

    def block(self, *, started: bool) -> Block | None:
        take = self._take
        end = min(self._at + self._settings.block_samples, take.number.size if started else self._first_on)
        if end <= self._at:
            return None
        holes = np.flatnonzero(np.diff(take.number[self._at : end]) != 1)
        end = self._at + int(holes[0]) + 1 if holes.size else end
        part = slice(self._at, end)
        self._at = end
        return Block(
            first=int(take.number[part.start]) - self._skipped,
            time_us=take.time_us[part] - self._skipped_us,
            angle_counts=take.angle_counts[part],
            torque_nm=take.torque_nm[part],
            grip_n=take.grip_n[part],
            running=take.running[part],
            overruns=0,
        )


def _not_there(settings: Settings, near: list[RecordedTrial], takes: list[RecordedTrial]) -> str:
    """Why no recording is of these settings, and what there is."""
    asked = f"{1e9 / settings.period_ns:g} Hz with {settings.counts_per_rev} counts"
    if near:
        wall = f"{settings.wall_stiffness:g} N·m/rad and {settings.wall_damping:g} N·m·s/rad"
        return f"the recording of {asked} is not of a wall of {wall}: its torque is another ({near[0].name})"
    there = dict.fromkeys(str(take) for take in takes)
    return f"no recording of {asked}; there are: {', '.join(there)}"
