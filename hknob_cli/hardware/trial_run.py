"""One trial on a device: configured, armed, zeroed, started, watched, stopped, and let go whatever happens."""

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from typing import NamedTuple

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.course import Course, Ended
from hknob_cli.hardware.operator import Operator, View, Wish
from hknob_cli.hardware.order import Trial
from hknob_cli.hardware.port import Block, Device, Settings
from hknob_cli.hardware.safety import SILENCE_S, Watch
from hknob_cli.hardware.simulated import Simulated
from hknob_cli.spec.campaign import CoursePlan


class RepeatTrialError(Exception):
    """The operator wants the trial once more."""


class Outcome(NamedTuple):
    """How a trial went: why it ended, the first sample at which the grip counts as held, indices that are missing."""

    ended: Ended
    settled_sample: int | None
    gaps: int


class Task(NamedTuple):
    """A trial to run: what the device is told, how it goes, of how many.

    ``live``: samples come by a clock, so that silence means a dead link; else it means that there are no more.
    """

    trial: Trial
    trials: int
    settings: Settings
    simulated: Simulated | None
    course: CoursePlan
    live: bool


@contextlib.contextmanager
def letting_go(device: Device) -> Iterator[None]:
    """Release the device on every way out; signals wait until that is done."""
    try:
        yield
    finally:
        with _undisturbed():
            device.release()


@contextlib.contextmanager
def _undisturbed() -> Iterator[None]:
    """Hold back what interrupts, where this thread would hear it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def run_trial(device: Device, task: Task, keep: Callable[[Block], None], operator: Operator) -> Outcome:
    """Run a trial; each block is handed to ``keep`` before anything is concluded from it.

    Raises `DeviceError` where the device or the watch over it trips, `RepeatTrialError` and `KeyboardInterrupt` by the
    operator's wish, and what ``keep`` raises. The torque is off in any case.
    """
    with letting_go(device):
        device.configure(task.settings, task.simulated)
        watch = Watch(task.settings, device.identity.native_counts)
        course = Course(task.course, task.settings.interval_s)
        device.arm()
        while not course.zeroed:
            block = _next(device, live=task.live)
            if block is None:  # a recording that begins with the start
                break
            keep(block)
            watch.check(block)
            course.follow(block)
            _heed(operator.look(_view(task, course)))
        device.start()
        ended = _follow(device, task, course, watch, keep, operator)
        device.stop()
        while (rest := device.read(SILENCE_S)) is not None:
            keep(rest)
            watch.check(rest)
    return Outcome(ended, course.settled_sample, watch.gaps)


def _follow(
    device: Device, task: Task, course: Course, watch: Watch, keep: Callable[[Block], None], operator: Operator
) -> Ended:
    """Take blocks until the trial has ended."""
    while True:
        block = _next(device, live=task.live)
        if block is None:
            return Ended.OVER
        keep(block)
        watch.check(block)
        ended = course.follow(block)
        if ended is not None:
            return ended
        if _heed(operator.look(_view(task, course))) is Wish.END:
            return Ended.OPERATOR


def _next(device: Device, *, live: bool) -> Block | None:
    """The next block; None where there are no more. Raises `DeviceError` where there must be one."""
    block = device.read(SILENCE_S)
    if block is None and live:
        raise DeviceError(f"no samples for {SILENCE_S * 1e3:g} ms")
    return block


def _heed(wish: Wish) -> Wish:
    """A wish, where it is not to leave the trial."""
    if wish is Wish.REPEAT:
        raise RepeatTrialError
    if wish is Wish.STOP:
        raise KeyboardInterrupt
    return wish


def _view(task: Task, course: Course) -> View:
    return View(
        trial=task.trial,
        trials=task.trials,
        state=course.phase.value,
        state_s=course.phase_s,
        running_s=course.running_s,
        grip_n=course.grip_n if course.running_s else None,
        torque_nm=course.torque_nm,
    )
