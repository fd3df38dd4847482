"""A campaign: the device that its plan names, and every trial of the grid in its order, none done twice, none lost."""

import contextlib
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hknob_cli.errors import DeviceError, HknobError, RefusedError, SpecError, UsageError
from hknob_cli.hardware.archive import Archive
from hknob_cli.hardware.journal import Journal
from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.order import USUAL_GRIP_N, Trial, faults_of_settings, key_of, period_ns, settings_of, trials_of
from hknob_cli.hardware.port import Block, Device, Simulated, Torque
from hknob_cli.hardware.trial_file import Recorded, about_pulse, joined, sample_table, started_of, zero_of
from hknob_cli.hardware.trial_run import (
    HANDS_OFF,
    Nobody,
    Operator,
    Outcome,
    RepeatTrialError,
    Task,
    View,
    Wish,
    run_trial,
)
from hknob_cli.recordings.trial import Key
from hknob_cli.specs.campaign import REPLAY, VIRTUAL, Course, HwRunPlan, Knob
from hknob_cli.specs.pulses import PulsePlan

Who = Callable[[Trial], Simulated]


def opened(
    plan: HwRunPlan | PulsePlan, stack: ExitStack, *, alarm: Callable[[str], None] = lambda _text: None
) -> Device:
    """The device of a plan, closed with ``stack``. Raises `DeviceError` or `UsageError` if there is none.

    ``alarm`` is told of torque that stays on.
    """
    device = plan.device
    if device.driver == VIRTUAL:
        from hknob_cli.hardware.virtual import VirtualDevice

        nuisances = Nuisances(*plan.nuisances, seed=plan.seed)
        if isinstance(plan, PulsePlan):
            return stack.enter_context(VirtualDevice(nuisances))
        driven = plan.driven
        nuisances = nuisances._replace(amplifier_s=driven.lag_s or nuisances.amplifier_s)
        return stack.enter_context(VirtualDevice(nuisances, coil=driven.coil))
    if device.driver == REPLAY and isinstance(plan, HwRunPlan):
        from hknob_cli.hardware.replay import ReplayDevice

        return stack.enter_context(ReplayDevice(plan.recordings))
    from hknob_cli.hardware.serial_device import BAUD, SerialDevice

    url = device.url
    if url is None:
        from hknob_cli.hardware.reference_target import run_target

        url = stack.enter_context(run_target(device.target or "host", _build_folder(stack)))
    return stack.enter_context(SerialDevice(url, baud=device.baud or BAUD, zero_angle=device.zero_angle, alarm=alarm))


def _build_folder(stack: ExitStack) -> Path:
    """Where built targets are kept between runs; a folder for this run alone where there is no such place."""
    from hknob_cli.engine.jit import cache_directory
    from hknob_cli.engine.kept_code import make_own_folder

    cache = cache_directory()
    if cache is not None:
        folder = cache.parent / "targets"
        if not make_own_folder(folder):  # what is there is run
            return folder
    return Path(stack.enter_context(TemporaryDirectory(prefix="hknob-")))


def who_of(plan: HwRunPlan | PulsePlan) -> Who:
    """Who holds the knob in a trial, and what knob it is, where the device is simulated."""
    if isinstance(plan, PulsePlan):
        from hknob_cli.hardware.person import squeezer

        return partial(squeezer, plan)
    from hknob_cli.hardware.person import Person, hold

    person = Person(
        push_nm=plan.person.push,
        # Somebody holds a simulated knob, whether or not there is a cell that shows how firmly.
        grip_target_n=plan.course.grip_target_n or USUAL_GRIP_N,
        wandering_push=plan.person.wandering_push,
        grip_wander=plan.person.grip_wander,
    )

    knob = Knob(*plan.driven.knob)

    def who(trial: Trial) -> Simulated:
        place = period_ns(trial.sample_rate_hz), trial.counts_per_rev, trial.block
        return hold(person, knob, seed=plan.seed, place=place)

    return who


def check_persons(plan: HwRunPlan | PulsePlan) -> None:
    """Raise `SpecError` at the grip force if nobody can hold a simulated knob as a plan says in one of its trials."""
    if plan.device.driver != VIRTUAL and plan.device.target is None:
        return
    who = who_of(plan)
    for trial in trials_of(plan):
        try:
            who(trial)
        except UsageError as error:
            raise SpecError([plan.grip_place._replace(message=f"{trial}: {error}")]) from None


Opened = Callable[[ExitStack], Device]
Said = Callable[[str], None]
GO_ON = "run the same command again to go on with it"
TORQUE = {
    Torque.OFF: "torque released",
    Torque.UNSEEN: "RELEASE was not answered: see to it that the torque is off, the target's watchdog should do it",
    Torque.ON: "THE TORQUE IS STILL ON: switch the amplifier off by hand",
}
UNSAFE = "find out why before anybody touches the knob"
IN_VAIN = "without a device the same command would end so again: change the spec"


class Campaign:
    """Runs what is not finished."""

    def __init__(
        self,
        plan: HwRunPlan | PulsePlan,
        archive: Archive,
        opened: Opened,
        who: Who,
        *,
        operator: Operator | None = None,
        say: Said = lambda _text: None,
    ) -> None:
        """``opened`` gives the device, when the first trial needs it; ``who`` holds a simulated knob in a trial."""
        self._plan = plan
        self._archive = archive
        self._opened = opened
        self._who = who
        self._operator = operator or Nobody()
        self._say = say
        self.trials = trials_of(plan)
        self.recorded = 0

    def run(self) -> list[Recorded]:
        """All trials, from the disk or from the device.

        Raises `DeviceError` where the device faults, `RefusedError` where it is another than before, `UsageError` where
        it cannot do a trial, `ComputationError` where the disk is full, `KeyboardInterrupt` as asked for; what was
        recorded is on the disk in any case.
        """
        self._archive.enter()
        try:
            return self._all()
        except UsageError:
            self._archive.abandon()
            raise

    def _all(self) -> list[Recorded]:
        done: list[Recorded] = []
        device: Device | None = None
        with ExitStack() as stack:
            for trial in self.trials:
                found = self._archive.finished(trial)
                if found is None:
                    if device is None:
                        device = self._open(stack, trial)
                        self._check_ranges(device)
                    self._check_same(device, done)
                    found = self._run(device, trial)
                done.append(found)
        return done

    def _open(self, stack: ExitStack, trial: Trial) -> Device:
        try:
            return self._opened(stack)
        except DeviceError as error:
            raise DeviceError(f"{self._place(trial)}: {error}") from error

    def _check_ranges(self, device: Device) -> None:
        """Raise `UsageError` if the device cannot do one of the trials: better before the first than hours later."""
        course = self._plan.course
        if device.identity.no_grip_cell and not (isinstance(course, Course) and course.grip is None):
            raise UsageError(f"the device '{device.identity.name}' has no grip cell; write 'grip: none' into the spec")
        for trial in self.trials:
            faults = faults_of_settings(settings_of(self._plan, trial), device.identity)
            if faults:
                raise UsageError(
                    f"{self._place(trial)}: the device '{device.identity.name}' cannot do that: {'; '.join(faults)}"
                )

    def _check_same(self, device: Device, done: list[Recorded]) -> None:
        """Raise `RefusedError` if trials that are finished were recorded with another encoder."""
        native = device.identity.native_counts
        for other in done:
            if other.native_counts != native:
                raise RefusedError(
                    f"the device '{device.identity.name}' has {native} counts per revolution, but {other.trial} was "
                    f"recorded on '{other.device}' with {other.native_counts}; use that, or another --out"
                )

    def _run(self, device: Device, trial: Trial) -> Recorded:
        """Run a trial until it is finished, once more where the operator wants it."""
        while True:
            if self._operator.ready(View(trial, len(self.trials), HANDS_OFF)) is Wish.STOP:
                raise KeyboardInterrupt
            try:
                return self._attempt(device, trial)
            except RepeatTrialError:
                continue

    def _attempt(self, device: Device, trial: Trial) -> Recorded:
        identity = device.identity
        key = key_of(self._plan, trial)
        about: dict[str, Any] = {
            "key": list(key),
            "device": identity.name,
            "native_counts": identity.native_counts,
        }
        journal = self._archive.begin(trial, about)
        blocks: list[Block] = []

        def keep(block: Block) -> None:
            journal.keep(block)
            blocks.append(block)

        try:
            task = Task(
                trial=trial,
                trials=len(self.trials),
                settings=settings_of(self._plan, trial),
                simulated=self._who(trial) if identity.simulated else None,
                course=self._plan.course,
                live=self._plan.is_source,
                pulses=self._plan.pulses if isinstance(self._plan, PulsePlan) else None,
            )
            outcome = run_trial(device, task, keep, self._operator)
        except BaseException as error:
            self._broken_off(journal, trial, error, device.torque)
            raise
        journal.close()
        return self._finish(trial, key, identity.name, identity.native_counts, blocks, outcome)

    def _finish(
        self, trial: Trial, key: Key, name: str, native_counts: int, blocks: list[Block], outcome: Outcome
    ) -> Recorded:
        samples = joined(blocks)
        kept = samples
        if isinstance(self._plan, PulsePlan):
            kept = about_pulse(samples, outcome.settled_sample, self._plan.pulses.window)
        recorded = Recorded(
            trial=trial,
            table=sample_table(kept, key, trial, native_counts, zero_n=zero_of(samples)),
            ended=outcome.ended.value,
            settled_sample=outcome.settled_sample,
            gaps=outcome.gaps,
            overruns=samples.overruns,
            zero_n=zero_of(samples),
            device=name,
            native_counts=native_counts,
            drift=outcome.drift.share if outcome.drift else None,
            drift_uncertainty=outcome.drift.uncertainty if outcome.drift else None,
            started_sample=started_of(samples) if trial.grip_target_n else None,
        )
        self._archive.finish(recorded)
        self.recorded += 1
        return recorded

    def _broken_off(self, journal: Journal, trial: Trial, error: BaseException, torque: Torque) -> None:
        """Keep what there is of a trial, and say where; the error of the device says it itself."""
        with contextlib.suppress(OSError):
            journal.close()
        try:
            found = self._archive.set_aside(trial)
            kept = f"what was recorded of it is in {found}" if found else "nothing was recorded of it"
        except HknobError:
            kept = f"what was recorded of it is in {journal.path}"
        place = self._place(trial)
        if isinstance(error, DeviceError):
            then = UNSAFE if torque is Torque.ON else GO_ON if self._plan.is_source else IN_VAIN
            raise DeviceError(f"{place}: {error}; {TORQUE[torque]}; {kept}; {then}") from error
        if isinstance(error, KeyboardInterrupt):
            self._say(f"{place}: {TORQUE[torque]}; {kept}; {GO_ON}")

    def _place(self, trial: Trial) -> str:
        return f"trial {trial.number} of {len(self.trials)} ({str(trial).partition('(')[2]}"
