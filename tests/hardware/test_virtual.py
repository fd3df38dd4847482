"""The virtual device: its states and limits, what a target does at a sample, and its motion against proven orbits."""

from math import tau

import numpy as np
import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.port import Sine
from hknob_cli.hardware.virtual import State, VirtualDevice
from tests.hardware.trials import ALIGNED, HAND, settings, virtual_trial


def test_blocks_are_consecutive_and_whole() -> None:
    with VirtualDevice() as device:
        device.configure(settings(block_samples=7), HAND)
        device.arm()
        armed = [device.read(0.0) for _ in range(3)]
        device.start()
        running = [device.read(0.0) for _ in range(3)]
        device.stop()
        assert device.read(0.0) is None
    for i, block in enumerate([*armed, *running]):
        assert block is not None
        assert block.first == 7 * i
        assert block.time_us.tolist() == [1000 * (7 * i + k) for k in range(7)]
        assert block.running.all() == block.running.any() == (i >= 3)
        assert block.overruns == 0
        if i < 3:
            assert not block.torque_nm.any()
            assert set(block.angle_counts.tolist()) == {int(0.02 / tau * 640_000)}
            assert set(block.grip_n.tolist()) == {float(np.float32(0.3))}


def test_states_are_those_of_the_wire() -> None:
    device = VirtualDevice()
    for call in (device.start, device.stop, device.arm, lambda: device.read(0.0)):
        with pytest.raises(DeviceError, match="virtual device"):
            call()
    device.configure(settings(), HAND)
    device.arm()
    with pytest.raises(DeviceError, match="is armed; it must be idle"):
        device.configure(settings(), HAND)
    device.start()
    with pytest.raises(DeviceError, match="is running; it must be armed"):
        device.start()
    device.release()
    assert device.state is State.IDLE
    device.arm()  # settings outlive a release


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"period_ns": 10}, "period_ns must be from 1000 to 1e"),
        ({"counts_per_rev": 700_000}, "counts_per_rev must be from 1 to 640000, got 700000"),
        ({"wall_stiffness": float("nan")}, "wall_stiffness must be from 0 to 1000, got nan"),
        ({"torque_limit_nm": 0.0}, "torque_limit_nm must be above 0, at most 10, got 0"),
        ({"block_samples": 49}, "block_samples must be from 1 to 48, got 49"),
        ({"watchdog_us": 0}, "watchdog_us must be from 1000 to 50000, got 0"),
    ],
)
def test_settings_out_of_range_are_refused(changes: dict[str, float], message: str) -> None:
    device = VirtualDevice()
    with pytest.raises(DeviceError, match=message):
        device.configure(settings(**changes), HAND)
    with pytest.raises(DeviceError, match="given no settings"):
        device.arm()


@pytest.mark.parametrize("changes", [{"inertia": 0.0}, {"damping": -1.0}, {"push_nm": float("inf")}])
def test_an_impossible_knob_is_refused(changes: dict[str, float]) -> None:
    with pytest.raises(DeviceError, match=next(iter(changes))):
        VirtualDevice().configure(settings(), HAND._replace(**changes))


def test_the_wall_is_that_of_the_wire() -> None:
    """Torque from the recorded angle alone, with damping, and the limit, to single precision."""
    told = settings(455, 256, wall_damping=1e-4, torque_limit_nm=7e-3)
    got = virtual_trial(told)
    coarse = np.floor_divide(got.angle_counts * 256, ALIGNED.native_counts)
    step = np.diff(coarse, prepend=coarse[0])
    quantum, interval = tau / 256, told.period_ns * 1e-9
    torque = np.clip(-0.27 * coarse * quantum - 1e-4 * step * quantum / interval, -7e-3, 7e-3)
    torque[(coarse >= 0) | ~got.running] = 0.0
    assert np.abs(got.torque_nm - torque).max() <= 7e-3 * 2.0**-24
    assert (np.abs(torque) == 7e-3).any()
    assert (step[coarse < 0] != 0).any()


def test_person_and_cell() -> None:
    """Grip rises from the start's sample on; the push is never outwards."""
    person = HAND._replace(
        push_nm=0.0, push_sines=(Sine(1e-3, 5.0, 0.0),), grip_sines=(Sine(0.1, 2.0, 0.5),), coulomb_nm=2e-3, angle_rad=0
    )
    got = virtual_trial(settings(), person, duration_s=1.0)
    t = np.cumsum(got.running) * 1e-3 - 1e-3
    grip = 0.3 + got.running * (0.72 * (1 - np.exp(-t / 0.2)) + 0.1 * np.sin(tau * 2.0 * t + 0.5))
    assert np.abs(got.grip_n - grip).max() <= 2.0**-24
    assert not got.angle_counts.any()  # friction above all else: nothing moves
    free = person._replace(coulomb_nm=0.0, stiffness=0.0, damping=1e-2, angle_rad=0.5)
    slid = virtual_trial(settings(), free, duration_s=1.0)
    moved = np.diff(slid.angle_counts[slid.running])
    assert (moved <= 0).all()
    # Damping takes nearly all: way = integral of push / damping over half a period, less what its own inertia keeps.
    way = 1e-3 / 1e-2 / (np.pi * 5.0)
    assert moved[:150].sum() == pytest.approx(-way / tau * ALIGNED.native_counts, rel=2e-3)
    assert not moved[110:200].any()


def test_too_fast_a_knob_trips_within_the_sample() -> None:
    device = VirtualDevice()
    device.configure(settings(speed_limit_rad_s=0.5), HAND._replace(damping=3e-3))
    device.arm()
    device.start()
    blocks = []
    while device.state is State.RUNNING:
        blocks.append(device.read(0.0))
    with pytest.raises(DeviceError, match=r"tripped, its torque is off: the knob moved at 0\.[5-9].*, limit 0\.5"):
        device.read(0.0)
    assert device.state is State.TRIPPED
    assert blocks[-1].torque_nm[-1] == 0.0
    assert not blocks[-1].running[-1]
    counts = np.concatenate([block.angle_counts for block in blocks])
    speed = np.abs(np.diff(counts)) * tau / 640_000 / 1e-3
    assert speed[-1] > 0.5 >= speed[:-1].max()
    for call in (device.arm, device.stop, device.start):
        with pytest.raises(DeviceError, match="tripped"):
            call()
    device.release()
    device.arm()


def test_times_rise_after_every_overrun() -> None:
    """A sample that follows at once on a late one may be in the same microsecond, where a period is no whole number."""
    told = settings(30_000, 512)
    nuisances = Nuisances(late_share=0.5, seed=1)
    found = virtual_trial(told, duration_s=0.3, nuisances=nuisances)
    assert (np.diff(found.time_us) > 0).all()
