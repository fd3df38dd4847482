"""From a plan to the device that it names, opened, and to who holds a simulated knob."""

from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.order import USUAL_GRIP_N, Trial, period_ns, trials_of
from hknob_cli.hardware.port import Device, Simulated
from hknob_cli.specs.campaign import REPLAY, VIRTUAL, HwRunPlan, Knob
from hknob_cli.specs.pulses import PulsePlan

Who = Callable[[Trial], Simulated]


def opened(
    plan: HwRunPlan | PulsePlan, stack: ExitStack, *, alarm: Callable[[str], None] = lambda _text: None
) -> Device:
    """The device of a plan, closed with ``stack``. Raises `DeviceError` or `UsageError` where there is none.

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
    from hknob_cli.engine.own_folder import make_own_folder

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
