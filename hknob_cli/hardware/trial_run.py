"""One trial on a device, from configuring to letting go whatever happens, and who watches it.

Who watches a campaign: what is shown of a trial, and what may be wished for while it runs.
"""

import contextlib
import time
from collections.abc import Callable, Iterator
from enum import Enum
from typing import NamedTuple, Protocol

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.order import Trial
from hknob_cli.hardware.port import Block, Device, Drift, Settings, Simulated, Torque
from hknob_cli.hardware.safety import LimitMonitor, undisturbed
from hknob_cli.hardware.sample_clock import SampleClock, drift_fault
from hknob_cli.hardware.trial_phases import Ended, PulsePhases, TrialPhases
from hknob_cli.specs.campaign import Course
from hknob_cli.specs.pulses import PulseCourse, Pulses

HANDS_OFF = "hands off"  # the state of a trial that has not begun

# A driver with a link knows when that is dead, and says why: this is for one that hangs, and longer than any of theirs.
# Shorter, it would take a pause of this computer's own for silence.
PATIENCE_S = 3.0
# By how much a phase may last longer than its samples say, by this computer's clock: blocks may be on their way.
LATE_S = 3.0
# A clock that is simulated may be slower than any real one: under an emulator, on a busy computer, several times.
OWN_TIME_SLOWER, OWN_TIME_LATE_S = 20.0, 60.0


class Wish(str, Enum):
    """What the operator wants of the trial at hand."""

    GO_ON = "go on"
    END = "end"
    REPEAT = "repeat"
    STOP = "stop"


class View(NamedTuple):
    """What is seen of a trial at an instant: ``state`` in a word; time (s) in it and since the start; forces."""

    trial: Trial
    trials: int
    state: str
    state_s: float = 0.0
    running_s: float = 0.0
    grip_n: float | None = None
    torque_nm: float = 0.0


class Operator(Protocol):
    """Sees a campaign and decides."""

    def ready(self, view: View) -> Wish:
        """Wait until the trial may begin, hands off the knob; `Wish.STOP` ends the campaign."""

    def look(self, view: View) -> Wish:
        """See the trial at hand, and say what to do with it."""


class Nobody:
    """An operator who is not there."""

    def ready(self, _view: View) -> Wish:
        """Begin at once."""
        return Wish.GO_ON

    def look(self, _view: View) -> Wish:
        """Go on."""
        return Wish.GO_ON


class RepeatTrialError(Exception):
    """The operator wants the trial once more."""


class Outcome(NamedTuple):
    """How a trial went: why it ended, the first sample at which the grip counts as held, indices that are missing.

    ``drift`` of the device's clock by this computer's, None where the device is in its own time.
    """

    ended: Ended
    settled_sample: int | None
    gaps: int
    drift: Drift | None = None


class Task(NamedTuple):
    """A trial to run: what the device is told, how it goes, of how many.

    ``live``: samples come by a clock, so that silence means a dead link; else it means that there are no more.
    ``pulses``: of a trial whose settings have a pulse.
    """

    trial: Trial
    trials: int
    settings: Settings
    simulated: Simulated | None
    course: Course | PulseCourse
    live: bool
    pulses: Pulses | None = None

    @property
    def phases(self) -> "TrialPhases | PulsePhases":
        """What follows it."""
        if self.pulses is not None and self.settings.pulse is not None:
            return PulsePhases(self.pulses, self.settings.pulse, self.settings.interval_s)
        assert isinstance(self.course, Course)
        return TrialPhases(self.course, self.settings.interval_s)


@contextlib.contextmanager
def letting_go(device: Device) -> Iterator[None]:
    """Release the device on every way out; signals wait until that is done.

    Raises `DeviceError` where the device still has torque, whatever else was raised.
    """
    before = ""
    try:
        yield
    except DeviceError as error:
        before = f"{error}; "
        raise
    finally:
        try:
            with undisturbed():
                device.release()
        finally:
            if device.torque is Torque.ON:
                raise DeviceError(f"{before}the device was told to release, and did not")


def run_trial(device: Device, task: Task, keep: Callable[[Block], None], operator: Operator) -> Outcome:
    """Run a trial; each block is handed to ``keep`` before anything is concluded from it.

    Raises `DeviceError` where the device or the watch over it trips, `RepeatTrialError` and `KeyboardInterrupt` by the
    operator's wish, and what ``keep`` raises. The torque is off in any case.
    """
    with letting_go(device):
        device.configure(task.settings, task.simulated)
        watch = LimitMonitor(task.settings, device.identity.native_counts, wired=task.live)
        clock = SampleClock(task.settings, simulated=device.identity.simulated)
        course = task.phases

        def take(block: Block) -> None:
            keep(block)
            watch.check(block)
            if task.live:
                clock.take(block)

        device.arm()
        bound = Bound(task.course.zero, "reading the empty grip cell", device, live=task.live)
        while not course.zeroed:
            block = _next(device, live=task.live)
            if block is None:  # a recording that begins with the start
                break
            take(block)
            course.follow(block)
            bound.check()
            _heed(operator.look(_view(task, course)))
        device.start()
        watch.start()
        bound = Bound(task.course.longest, "the trial", device, live=task.live)
        ended = _follow(device, task, course, take, bound, operator)
        device.stop()
        bound = Bound(0.0, "reading what is left", device, live=task.live)
        while (rest := device.read(PATIENCE_S)) is not None:
            take(rest)
            bound.check()
        clock.judge()
        drift = device.drift if task.live else None
        if wrong := drift_fault(drift):
            raise DeviceError(wrong)
    return Outcome(ended, course.settled_sample, watch.gaps, drift)


class Bound:
    """A bound on a phase of a trial by this computer's clock, whatever the device's samples say."""

    def __init__(self, seconds: float, what: str, device: Device, *, live: bool) -> None:
        """``live``: samples come by a clock; others have no bound but their own."""
        self._what = what
        self._began = time.monotonic()
        own = device.identity.own_time
        longest = OWN_TIME_SLOWER * seconds + OWN_TIME_LATE_S if own else seconds + LATE_S
        self._longest = longest if live else float("inf")

    def check(self) -> None:
        """Raise `DeviceError` where the phase has lasted too long."""
        lasted = time.monotonic() - self._began
        if lasted > self._longest:
            raise DeviceError(
                f"{self._what} has taken {lasted:.1f} s by this computer's clock, and the samples do not say that "
                f"it is over (at most {self._longest:.1f} s)"
            )


def _follow(
    device: Device,
    task: Task,
    course: TrialPhases | PulsePhases,
    take: Callable[[Block], None],
    bound: Bound,
    operator: Operator,
) -> Ended:
    """Take blocks until the trial has ended."""
    while True:
        block = _next(device, live=task.live)
        if block is None:
            return Ended.OVER
        take(block)
        ended = course.follow(block)
        if ended is not None:
            return ended
        bound.check()
        if _heed(operator.look(_view(task, course))) is Wish.END:
            return Ended.OPERATOR


def _next(device: Device, *, live: bool) -> Block | None:
    """The next block; None where there are no more. Raises `DeviceError` where there must be one."""
    block = device.read(PATIENCE_S)
    if block is None and live:
        raise DeviceError(f"no samples for {PATIENCE_S:g} s")
    return block


def _heed(wish: Wish) -> Wish:
    """A wish, where it is not to leave the trial."""
    if wish is Wish.REPEAT:
        raise RepeatTrialError
    if wish is Wish.STOP:
        raise KeyboardInterrupt
    return wish


def _view(task: Task, course: TrialPhases | PulsePhases) -> View:
    return View(
        trial=task.trial,
        trials=task.trials,
        state=course.phase.value,
        state_s=course.phase_s,
        running_s=course.running_s,
        grip_n=course.grip_n if course.running_s else None,
        torque_nm=course.torque_nm,
    )
