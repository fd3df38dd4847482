"""The target's pulse: the same torques as the state machine of the host, to the last bit, and what PULSE takes."""

import ctypes as c
import math
from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.control import GripTrigger, Phase, pulse_of
from hknob_cli.hardware.order import faults_of_settings, settings_of, trials_of
from hknob_cli.hardware.person import squeezer
from hknob_cli.hardware.port import Block, PulseOrder, Simulated
from hknob_cli.hardware.safety import LimitMonitor
from hknob_cli.hardware.virtual import IDENTITY, VirtualDevice
from hknob_cli.hardware.wire.answers import About
from hknob_cli.hardware.wire.codes import Kind, State, Status, Trip
from hknob_cli.hardware.wire.commands import Alive, Configure, SetAct
from tests.hardware.firmware import (
    CPulse,
    CPulseState,
    CSettings,
    CSimulated,
    CSqueeze,
    ScriptedTarget,
    events_of,
    library,
    samples_of,
)
from tests.hardware.golden import LAG, PULSE, SETTINGS, SQUEEZE
from tests.hardware.pulses import HELD, SPEC, planned
from tests.hardware.trials import joined

INTERVAL = SETTINGS.interval_s
PHASES = list(Phase)
ORDERS = {
    "threshold": PulseOrder(0.7, 0.07, 0.0, 0.2, 0.005, 0.005),
    "held": PulseOrder(0.7, 0.07, 0.003, 0.2, 0.005, 0.005),
    "of one sample": PulseOrder(0.7, 0.07, 0.0, 0.2, 0.005, 1e-6),
    "held for a sample": PulseOrder(0.7, 0.3, INTERVAL, 0.65, 0.005, 0.002),
}


def wandering_grips(seed: int, count: int) -> np.ndarray:
    """Cell readings in single precision that rise, wander about the target, fall, and touch the levels exactly."""
    rng = np.random.default_rng(seed)
    grip = np.abs(rng.uniform(0.0, 1.2) + np.cumsum(rng.normal(scale=0.02, size=count))) % 1.2
    levels = rng.choice([0.7, 0.2, 0.63, 0.77, 0.65], size=count)
    return np.where(rng.random(count) < 0.02, levels, grip).astype(np.float32).astype(np.float64)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ORDERS)
def test_torques_are_those_of_the_host_to_the_last_bit(name: str) -> None:
    seen: set[str] = set()
    pulse = CPulse(*pulse_of(ORDERS[name], INTERVAL))
    for seed in range(60):
        trigger, state = GripTrigger(ORDERS[name], INTERVAL), CPulseState()
        rest = np.random.default_rng(seed).normal(scale=0.01, size=seed % 7).astype(np.float32).astype(np.float64)
        for cell, on in [*((one, False) for one in rest), *((one, True) for one in wandering_grips(seed, 2000))]:
            torque = library().pulse_step(pulse, state, cell, on)
            assert torque == trigger.step(cell, running=on)
            assert PHASES[state.phase] is trigger.phase
            seen.add(trigger.phase)
        assert trigger.zero_n == (state.sum / state.count if state.count else 0.0)
    assert seen >= set(PHASES) - ({Phase.HOLD} if not ORDERS[name].dwell_s else set())


@pytest.mark.parametrize("text", [SPEC, HELD])
@pytest.mark.parametrize("number", [1, 2])
def test_a_simulated_trial_is_that_of_the_virtual_device(text: str, number: int) -> None:
    """Person, pulse and knob of the firmware, without a clock: the same counts and torques, grips as they travel."""
    plan = planned(text)
    trial = trials_of(plan)[number - 1]
    settings, who = settings_of(plan, trial), squeezer(plan, trial)
    with VirtualDevice() as device:
        device.configure(settings, who)
        device.arm()
        blocks = [device.read(1.0)]
        device.start()
        blocks += [device.read(1.0) for _ in range(450)]
    told = joined([block for block in blocks if block is not None])
    before, count = int((~told.running).sum()), int(told.running.sum())
    angle, torque, grip = (np.zeros(before + count) for _ in range(3))
    assert settings.pulse is not None
    assert who.squeeze
    assert library().scripted_squeezed(
        CSimulated.of(who),
        CSqueeze.of(who.squeeze),
        CPulse(*pulse_of(settings.pulse, settings.interval_s)),
        settings.interval_s,
        before,
        count,
        *(one.ctypes.data for one in (angle, torque, grip)),
    )
    counts = np.floor(angle / math.tau * IDENTITY.native_counts)
    assert np.array_equal(counts, told.angle_counts)
    assert np.ptp(counts) > 1000
    assert np.array_equal(torque.astype(np.float32), told.torque_nm.astype(np.float32))
    assert np.count_nonzero(torque) == 200
    assert np.abs(grip - told.grip_n).max() <= np.spacing(np.float32(told.grip_n.max()))


def begun(**differing: Any) -> ScriptedTarget:
    target = ScriptedTarget()
    assert target.command(Configure(1, SETTINGS._replace(**differing))).status == Status.DONE
    return target


def test_a_trial_zeroes_waits_fires_once_and_is_recorded() -> None:
    target = begun(block_samples=5)
    pulse = pulse_of(ORDERS["held"], INTERVAL)
    assert target.command(SetAct(2, pulse)).said == pulse
    trigger = GripTrigger(ORDERS["held"], INTERVAL)
    target.plain(Kind.ARM)
    expected, sent = [], []
    grips = np.concatenate([np.full(40, 0.125), 0.125 + np.r_[np.linspace(0, 0.7, 60), np.full(60, 0.71)]])
    grips = np.r_[grips, np.linspace(0.8, 0.0, 60), np.full(40, 0.71 + 0.125)].astype(np.float32).astype(np.float64)
    for i, grip in enumerate(grips):
        if i == 40:
            target.plain(Kind.START)
        target.grip = grip
        target.angle = -3000  # deep in the wall that the settings have: a pulse takes its place
        target.sample()
        expected.append(trigger.step(grip, running=i >= 40))
        assert target.torque == expected[-1]
        target.nonce += 1
        sent += samples_of(target.tell(Alive(target.nonce, 0)))
    assert trigger.phase is Phase.DONE
    assert np.count_nonzero(expected) == pulse.width == 20
    told = np.concatenate([one.samples.torque_nm for one in sent])
    assert np.array_equal(told, np.array(expected[: told.size]).astype(np.float32))


def fired(target: ScriptedTarget) -> None:
    """Arm, start, relax and squeeze: the pulse is on."""
    target.plain(Kind.ARM)
    target.grip = 0.0
    target.sample()
    target.plain(Kind.START)
    target.sample()
    target.grip = 1.0
    target.sample()


@pytest.mark.parametrize("end", ["emergency", "speed", "silence", "release", "stop"])
def test_what_ends_a_trial_ends_its_pulse(end: str) -> None:
    target = begun()
    target.command(SetAct(2, PULSE._replace(dwell=0)))
    fired(target)
    assert target.torque == PULSE.torque_nm
    faults = {"emergency": Trip.EMERGENCY_STOP, "speed": Trip.SPEED, "silence": Trip.WATCHDOG}
    if end == "emergency":
        target.emergency = 1
    elif end == "speed":
        target.angle = 100_000
    if end in ("release", "stop"):
        assert target.plain(Kind.RELEASE if end == "release" else Kind.STOP).status == Status.DONE
    else:
        target.run(2_000 * SETTINGS.watchdog_us)
        assert events_of(target.said())[0].fault == faults[end]
    assert target.torque == 0.0
    assert target.call_at == 2**64 - 1


def test_another_trial_waits_for_its_own_grip() -> None:
    target = begun()
    target.command(SetAct(2, PULSE._replace(dwell=0)))
    for _ in range(2):  # the pulse stays, its state does not
        fired(target)
        assert target.torque == PULSE.torque_nm
        target.plain(Kind.RELEASE)


def test_settings_make_it_forget_the_pulse() -> None:
    target = begun()
    target.command(SetAct(2, PULSE._replace(dwell=0)))
    target.command(Configure(3, SETTINGS))
    fired(target)
    assert target.torque == 0.0


def test_a_pulse_takes_the_place_of_a_controller() -> None:
    target = begun()
    target.command(SetAct(2, LAG))
    target.command(SetAct(3, PULSE._replace(dwell=0)))
    target.angle = -5000
    fired(target)
    assert target.torque == PULSE.torque_nm


def test_a_grip_that_is_no_number_fires_nothing() -> None:
    target = begun()
    target.command(SetAct(2, PULSE._replace(dwell=0)))
    target.plain(Kind.ARM)
    target.sample()
    target.plain(Kind.START)
    for grip in (0.0, math.nan, math.nan):
        target.grip = grip
        target.sample()
        assert target.torque == 0.0


@pytest.mark.parametrize("state", list(State))
@pytest.mark.parametrize("message", [SetAct(50, PULSE), SetAct(50, SQUEEZE)])
def test_it_is_taken_when_idle_only(state: State, message: SetAct) -> None:
    target = begun()
    target.bring_to(state)
    answer = target.command(message)
    assert answer.status == (Status.DONE if state is State.IDLE else Status.NOT_NOW)
    assert answer.said == (message.act if state is State.IDLE else None)


def test_it_needs_settings() -> None:
    assert ScriptedTarget().command(SetAct(1, PULSE)).status == Status.NOT_NOW


WRONG: list[dict[str, Any]] = [
    *({"grip_n": value} for value in (0.0, -1.0, 1001.0)),
    *({"band_n": value} for value in (-0.1, 0.72)),
    *({"release_n": value} for value in (0.0, -0.1, 0.71, 0.8)),
    *({"torque_nm": value} for value in (0.0, -0.005, 0.0501)),
    *({"width": value} for value in (0, 2001)),
    {"dwell": 2**31},
]


@pytest.mark.parametrize("changes", WRONG)
def test_what_is_out_of_range_changes_nothing(changes: dict[str, Any]) -> None:
    target = begun()
    answer = target.command(SetAct(2, PULSE._replace(**changes)))
    assert (answer.status, answer.said) == (Status.OUT_OF_RANGE, None)
    fired(target)
    assert target.torque == 0.0


def test_the_ends_of_the_ranges_are_in() -> None:
    limits = CSettings(*SETTINGS.numbers)
    for changes in ({"torque_nm": 0.05}, {"width": 2000}, {"width": 1}, {"band_n": 0.0}, {"dwell": 2**31 - 1}):
        assert library().pulse_in_range(CPulse(*PULSE._replace(**changes)), limits)
    for name in PULSE._fields[:4]:
        assert not library().pulse_in_range(CPulse(*PULSE._replace(**{name: math.nan})), limits)


WRONG_SQUEEZES: list[dict[str, Any]] = [
    *({name: 0.0} for name in ("aim_n", "rise_s", "overshoot", "reaction_s", "relax_s", "strength_n")),
    {"overshoot": 1.0},
    {"hands": ()},
    {"hands": ((0.7, 0.0, 1e-4, 0.04),)},
    {"hands": ((0.7, 1e-6, -1e-4, 0.04),)},
    {"hands": ((0.7, 1e-6, 1e-4, 0.04), (0.7, 1e-6, 1e-4, 0.04))},
]


@pytest.mark.parametrize("changes", WRONG_SQUEEZES)
def test_nobody_squeezes_like_that(changes: dict[str, Any]) -> None:
    assert begun().command(SetAct(2, SQUEEZE._replace(**changes))).status == Status.OUT_OF_RANGE


def test_too_fast_a_hand_is_refused() -> None:
    fast = SQUEEZE._replace(hands=((0.7, 1e-12, 0.0, 1.0),))
    nothing = np.zeros(2).ctypes.data
    person = Simulated(2.2e-6, 3.45e-4, 0.04, 0.0, 0.0, 0.0, 0.7, 0.2, 0.0)
    given = CSimulated.of(person), CSqueeze.of(fast), CPulse(*PULSE), 1e-3, 1, 1, nothing, nothing, nothing
    assert not library().scripted_squeezed(*given)


def test_it_says_that_it_knows_pulses() -> None:
    said = ScriptedTarget().plain(Kind.HELLO).said
    assert isinstance(said, About)
    assert said.knows_pulses


def test_a_target_without_a_grip_cell_knows_none() -> None:
    class Identity(c.Structure):
        _fields_ = (
            ("native_counts", c.c_uint32),
            ("shortest_period_ns", c.c_uint32),
            ("flags", c.c_uint8),
            ("name", c.c_char * 16),
        )

    body = (c.c_uint8 * 64)()
    library().identity_write(body, c.c_size_t(0), c.byref(Identity(4096, 250_000, 2, b"knob")))
    assert body[8] == 2 + 8 + 16 + 64 + 128  # without 32


def test_pulses_that_are_too_long_are_refused_by_the_host_too() -> None:
    def found(width_s: float, period_ns: int = 250_000) -> list[str]:
        order = PulseOrder(0.71, 0.071, 0.0, 0.213, 0.005, width_s)
        settings = SETTINGS._replace(period_ns=period_ns, pulse=order)
        fits = library().pulse_in_range(CPulse(*pulse_of(order, settings.interval_s)), CSettings(*settings.numbers))
        faults = faults_of_settings(settings, IDENTITY)
        assert fits == (not faults)
        return faults

    assert found(0.5) == found(0.5, 300_000) == []  # 1667 samples of 0.3 ms: the nearest to half a second
    assert "at most 0.5 s" in found(0.501)[0]


def test_the_host_holds_a_device_to_its_pulse() -> None:
    """By the grip that it told, sample by sample, those after the stop included."""
    order = ORDERS["threshold"]
    settings = SETTINGS._replace(pulse=order)
    trigger = GripTrigger(order, INTERVAL)
    grips = np.r_[np.zeros(10), np.linspace(0, 1, 40), np.full(30, 0.9)].astype(np.float32).astype(np.float64)
    running = np.arange(80) >= 10
    told = trigger.follow(grips, running).astype(np.float32).astype(np.float64)
    block = Block(0, 250 * np.arange(80), np.full(80, -3000), told, grips, running, 0)

    def check(torque_nm: np.ndarray) -> None:
        watch = LimitMonitor(settings, 640_000, wired=True)
        watch.start()
        watch.check(block._replace(torque_nm=torque_nm))

    check(block.torque_nm)
    at = int(np.flatnonzero(block.torque_nm)[0])
    for place, value in ((at, 0.0), (at - 1, 0.005), (at + 20, 0.005), (79, 1e-4), (at, 0.00501)):
        wrong = block.torque_nm.copy()
        wrong[place] = value
        with pytest.raises(DeviceError, match=f"not that of the pulse.*at sample {place}$"):
            check(wrong)
