"""Tests of `hardware.control`: numbers that a device is told, the device under them, and pulses at a grip."""

import sys
from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.controller import make_control_law
from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.general.laws.law import PIECE
from hknob_cli.errors import DeviceError
from hknob_cli.hardware.control import GripTrigger, Phase, begins_of, control_of, looks_of, senses_speed
from hknob_cli.hardware.port import FIRST_LAWS, Block, PulseOrder
from hknob_cli.hardware.replay import RecordedTrial, is_of_wall
from hknob_cli.hardware.safety import LimitMonitor
from hknob_cli.hardware.virtual import IDENTITY, VirtualDevice
from hknob_cli.hardware.wire.codes import ALL_LAWS, Law
from hknob_cli.specs.controller import KINDS, Controller
from hknob_cli.specs.plan import Encoder, Hand, Knob, Scene, Wall
from tests.hardware.controllers import CONTROLLERS, MODEL, READING, told
from tests.hardware.trials import ALIGNED, HAND, part_of, settings, virtual_trial

KNOWING = ALIGNED._replace(knows_control=True, knows_parts=True, knows_looks=True, laws=ALL_LAWS)
ONCE = ["lag", "passivity", "damping everywhere", "timed", "phase by halves", "half sample", "impulse", "matched wall"]
NAMES = [*ONCE, *READING]
SCENE = Scene(knob=Knob(inertia=1.9e-6), wall=Wall(stiffness=0.27), hand=Hand(3e-7, 3.45e-4, 0.04), encoder=Encoder())


@pytest.mark.parametrize("name", CONTROLLERS)
def test_the_numbers_are_those_of_a_sweep(name: str) -> None:
    law = make_law(SCENE._replace(controller=CONTROLLERS[name]), sample_rate_hz=1000, counts_per_rev=1024).law
    control = told(name).control
    assert control is not None
    assert Law(control.law).name.lower() == law.act.__name__
    assert control.numbers == pytest.approx([min(one, sys.float_info.max) for one in law.fixed], rel=1e-14)
    assert control.rows == tuple(law.first)
    assert (control.places, law.looks) == (law.places, len(looks_of(control)))
    ends = np.cumsum(list(law.sched[::PIECE]))
    pieces = sorted({*begins_of(control), *looks_of(control)})  # a torque or a reading begins each
    assert [0.0, *ends[:-1]] == pytest.approx(pieces, rel=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_that_specs_let_run_on_devices_has_a_law_on_the_wire(kind: str) -> None:
    """One that the wire lacks has ``on_devices=False`` in `specs.controller.KINDS`."""
    controller = Controller(kind, damping=1e-5)
    if KINDS[kind].on_devices:
        assert control_of(controller, settings(), MODEL).law in {*Law}
    else:
        with pytest.raises(ValueError, match="no target runs"):
            control_of(controller, settings(), MODEL)


SENSED = [Controller(kind, velocity="sensor") for kind in ("half_sample", "matched_wall")]
READ = [Controller("first_order_hold", detections=4), Controller("impulse_damping", detections=4)]


TIMED = Controller("velocity_damping", damping=1e-5, velocity="timed", detections=4)
SPEED = Controller("velocity_damping", damping=1e-5, velocity="sensor", window=3)


@pytest.mark.parametrize("controller", [*SENSED, *READ, TIMED, SPEED, *CONTROLLERS.values()])
def test_what_a_controller_reads_is_told_by_its_numbers(controller: Controller) -> None:
    law, control = make_control_law(controller), control_of(controller, settings(), MODEL)
    assert looks_of(control) == pytest.approx(law.looks, rel=1e-15)
    assert senses_speed(control) == law.senses_speed
    assert looks_of(None) == ()
    assert not senses_speed(None)


@pytest.mark.parametrize("controller", [*SENSED, *READ, TIMED, SPEED])
def test_what_reads_more_than_counts_at_samples_is_refused_by_a_target(controller: Controller) -> None:
    """Before it is armed, by what it says it is; the virtual device takes it."""
    asked = settings()._replace(control=control_of(controller, settings(), MODEL))
    said = "has no sensor of the speed" if controller.velocity == "sensor" else "reads its encoder once a sample"
    target = IDENTITY._replace(knows_looks=False, knows_speed=False)
    with VirtualDevice(identity=target) as device, pytest.raises(DeviceError, match=said):
        device.configure(asked, HAND)
    with VirtualDevice() as device:
        device.configure(asked, HAND)


def trial(name: str, **changes: float) -> Block:
    return virtual_trial(told(name, **changes), HAND._replace(push_nm=3e-3), duration_s=0.5, identity=KNOWING)


def watched(name: str, block: Block) -> None:
    watch = LimitMonitor(told(name), KNOWING.native_counts, wired=True)
    size = 40
    for i in range(0, len(block.time_us), size):
        part = part_of(block, i, size)
        if part.running.any():
            watch.start()
        watch.check(part)


@pytest.mark.parametrize("name", NAMES)
def test_the_virtual_device_runs_what_was_agreed(name: str) -> None:
    block = trial(name)
    watched(name, block)
    plain = virtual_trial(settings(), HAND._replace(push_nm=3e-3), duration_s=0.5)
    assert not np.array_equal(plain.torque_nm, block.torque_nm)


@pytest.mark.parametrize("name", NAMES)
def test_the_torque_of_another_wall_is_noticed(name: str) -> None:
    plain = virtual_trial(settings(), HAND._replace(push_nm=3e-3), duration_s=0.5)
    if looks := len(looks_of(told(name).control)):
        plain = plain._replace(looks=np.repeat(plain.angle_counts[:, None], looks, axis=1))
    law = Law(told(name).control.law).name.lower()
    with pytest.raises(DeviceError, match=f"is not that of the wall under {law}"):
        watched(name, plain)


CHANGES: list[Any] = [
    lambda torque: 1.001 * torque * (np.abs(torque) < 4.9e-2),
    lambda torque: np.concatenate([[0.0], torque[:-1]]),
    lambda torque: torque + 1e-5,
]


@pytest.mark.parametrize("change", CHANGES)
def test_a_torque_that_is_not_quite_the_law_is_noticed(change: Any) -> None:
    block = trial("lag")
    with pytest.raises(DeviceError, match=r"is not that of the wall under|where the wall is off"):
        watched("lag", block._replace(torque_nm=change(block.torque_nm)))


@pytest.mark.parametrize("name", READING)
def test_other_readings_are_noticed(name: str) -> None:
    """The torque follows from what was read within the intervals: told otherwise, or not at all, the trial ends."""
    block = trial(name)
    assert block.looks is not None
    assert (np.diff(block.looks[block.running], axis=0) != 0).any()
    for change in (lambda looks: looks + 700, lambda looks: np.roll(looks, 1, axis=0)):
        with pytest.raises(DeviceError, match="is not that of the wall under"):
            watched(name, block._replace(looks=change(block.looks)))
    wanted = block.looks.shape[1]
    for looks, count in ((None, 0), (block.looks[:, :-1], wanted - 1)):
        with pytest.raises(DeviceError, match=f"tells {count} readings .* its wall takes {wanted}"):
            watched(name, block._replace(looks=looks))
    with pytest.raises(DeviceError, match=f"tells {wanted} readings .* its wall takes 0"):
        watched("lag", trial("lag")._replace(looks=block.looks))


def test_a_lag_that_keeps_all_of_a_step_is_the_plain_wall_to_the_last_bit() -> None:
    plain = settings(wall_damping=1e-6)
    whole = plain._replace(control=control_of(Controller("bounded_lag", keep=1.0), plain))
    one, other = virtual_trial(plain), virtual_trial(whole, identity=KNOWING)
    assert np.array_equal(one.torque_nm, other.torque_nm)
    assert np.array_equal(one.angle_counts, other.angle_counts)


def test_a_device_that_does_not_know_controllers_says_so() -> None:
    with (
        VirtualDevice(identity=IDENTITY._replace(knows_control=False)) as device,
        pytest.raises(DeviceError, match="it runs the plain wall alone, no controller"),
    ):
        device.configure(told("lag"), HAND)


def test_older_firmware_is_refused_by_what_it_lacks() -> None:
    older = IDENTITY._replace(laws=FIRST_LAWS, knows_parts=False, knows_converters=False)
    for name, said in (
        ("half sample", "does not have the controller half_sample"),
        ("impulse", "does not change within"),
    ):
        with VirtualDevice(identity=older) as device, pytest.raises(DeviceError, match=said):
            device.configure(told(name), HAND)
    for name in ("lag", "impulse as long as an interval", "hold"):
        with VirtualDevice(identity=older) as device:
            device.configure(told(name), HAND)


@pytest.mark.parametrize("name", ONCE)
def test_a_recording_is_told_from_one_under_another_controller(name: str) -> None:
    block = trial(name)
    take = RecordedTrial(
        "one", 1000.0, 1024, KNOWING.native_counts, np.arange(len(block.time_us)), *block[1:5], block.running
    )
    assert is_of_wall(take, told(name))
    assert not is_of_wall(take, settings())


DT = 1e-3
ORDER = PulseOrder(grip_n=2.0, band_n=0.2, dwell_s=0.0, release_n=0.6, torque_nm=0.01, width_s=0.005)
ZERO = 7


def torques(order: PulseOrder, grip: np.ndarray, zero_n: float = 0.0) -> tuple[np.ndarray, GripTrigger]:
    """Torque at each sample of a grip, after some of an empty cell that shows ``zero_n``."""
    trigger = GripTrigger(order, DT)
    cell = np.concatenate([np.full(ZERO, zero_n), grip + zero_n])
    found = trigger.follow(cell, np.arange(cell.size) >= ZERO)
    assert not found[:ZERO].any()
    return found[ZERO:], trigger


def by_the_rule(order: PulseOrder, grip: np.ndarray) -> np.ndarray:
    """The same from the words: relaxed once, then at the target, or in the band for the dwell; one pulse."""
    n, dwell = grip.size, round(order.dwell_s / DT)
    relaxed = np.maximum.accumulate(grip < order.release_n)
    if dwell:
        inside = (np.abs(grip - order.grip_n) <= order.band_n) & relaxed
        ready = np.array([i >= dwell and inside[i - dwell : i + 1].all() for i in range(n)])
    else:
        ready = (grip >= order.grip_n) & relaxed
    out = np.zeros(n)
    if ready.any():
        first = int(np.argmax(ready))
        out[first : first + round(order.width_s / DT)] = order.torque_nm
    return out


@pytest.mark.parametrize("dwell", [0.0, 0.001, 0.03])
def test_the_pulse_is_that_of_the_rule(dwell: float) -> None:
    rng = np.random.default_rng(5)
    fired = 0
    for _ in range(200):
        steps = rng.normal(0.003, 0.03, 800)
        grip = np.clip(rng.uniform(-0.5, 2.5) + np.cumsum(steps), -0.5, 2.3)
        order = ORDER._replace(dwell_s=dwell)
        expected = by_the_rule(order, grip)
        fired += bool(expected.any())
        assert np.array_equal(torques(order, grip)[0], expected)
    assert 20 < fired < 190


def test_it_fires_once_at_the_first_sample_at_the_target_for_the_width() -> None:
    grip = np.concatenate([np.linspace(0.0, 3.0, 31), np.full(10, 3.0), np.zeros(5), np.linspace(0.0, 3.0, 31)])
    torque, trigger = torques(ORDER, grip)
    assert np.flatnonzero(torque).tolist() == [20, 21, 22, 23, 24]
    assert trigger.phase is Phase.DONE


def test_the_zero_of_the_cell_is_taken_off() -> None:
    grip = np.linspace(0.0, 3.0, 301)
    assert np.array_equal(torques(ORDER, grip, zero_n=-0.25)[0], torques(ORDER, grip)[0])


def test_a_hand_that_was_not_relaxed_fires_nothing() -> None:
    torque, trigger = torques(ORDER, np.full(500, 2.0))
    assert not torque.any()
    assert trigger.phase is Phase.RELAX


def test_a_grip_that_leaves_the_band_begins_its_dwell_anew() -> None:
    order = ORDER._replace(dwell_s=0.01)
    grip = np.concatenate([[0.0], np.full(10, 2.0), [2.3], np.full(30, 2.0)])
    torque, _ = torques(order, grip)
    assert int(np.flatnonzero(torque)[0]) == 12 + 10


def test_phases_in_their_order() -> None:
    trigger = GripTrigger(ORDER._replace(dwell_s=0.003), DT)
    seen = [trigger.phase]
    grip = [0.0, 1.0, 2.0, 2.0, 2.0, 2.0, *[2.0] * 6, 0.1]
    for cell, running in [(0.0, False), *((one, True) for one in grip)]:
        trigger.step(cell, running=running)
        seen += [trigger.phase] if trigger.phase is not seen[-1] else []
    assert seen == [Phase.ZERO, Phase.SQUEEZE, Phase.HOLD, Phase.PULSE, Phase.RELEASE, Phase.DONE]


def test_a_pulse_shorter_than_a_sample_takes_one() -> None:
    torque, _ = torques(ORDER._replace(width_s=1e-5), np.linspace(0.0, 3.0, 301))
    assert np.count_nonzero(torque) == 1
