"""The host's watch stands exactly where it says: a hair within each bound passes, a hair beyond is refused.

Blocks are made by hand, and torques by hand from the wall's law.
"""

import signal
from concurrent.futures import ThreadPoolExecutor
from math import tau
from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.control import ControlledWall
from hknob_cli.hardware.port import Block, Converters, OverAngle, PulseOrder
from hknob_cli.hardware.safety import LimitMonitor, undisturbed
from tests.hardware.controllers import told
from tests.hardware.trials import settings

NATIVE = 1000  # counts of both encoders
LIMIT = 0.5  # N m
K, B = 0.25, 1e-4  # N m/rad, N m s/rad
TOLD = settings(1000, NATIVE, wall_stiffness=K, wall_damping=B, torque_limit_nm=LIMIT, speed_limit_rad_s=1e3)
QUANTUM, INTERVAL = tau / NATIVE, 1e-3  # rad, s


def block(angles: list[int], torques: list[float], first: int = 0, on: Any = True) -> Block:
    count = len(angles)
    return Block(
        first,
        (np.arange(first, first + count) + 10) * 1000,
        np.array(angles),
        np.array(torques, dtype=float),
        np.full(count, 0.3),
        np.full(count, on) if isinstance(on, bool) else np.array(on),
        0,
    )


def watch(*blocks: Block, told: Any = TOLD) -> LimitMonitor:
    """A watch that has looked at these, told to start."""
    found = LimitMonitor(told, NATIVE, wired=True)
    found.start()
    for one in blocks:
        found.check(one)
    return found


def parts(angle: int, before: int) -> tuple[float, float]:
    """Spring and damper at an angle inside the wall, N m."""
    return -K * angle * QUANTUM, -B * (angle - before) * QUANTUM / INTERVAL


@pytest.mark.parametrize(("angle", "before"), [(-10, -10), (-20, -15), (-3, -11)])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_torque_may_differ_by_a_ten_thousandth_of_its_parts(angle: int, before: int, sign: float) -> None:
    """Added in size, also where spring and damper pull against each other."""
    spring, damper = parts(angle, before)
    most = 1e-4 * (abs(spring) + abs(damper)) + 1e-6 * LIMIT
    at_first = parts(before, before)[0]
    watch(block([before, angle], [at_first, spring + damper + sign * 0.99 * most]))
    with pytest.raises(DeviceError, match="is not that of the wall"):
        watch(block([before, angle], [at_first, spring + damper + sign * 1.01 * most]))


def test_where_there_is_no_torque_it_may_differ_by_a_millionth_of_the_limit() -> None:
    watch(block([5, 5], [0.0, 0.99e-6 * LIMIT]))
    with pytest.raises(DeviceError) as caught:
        watch(block([5, 5], [0.0, 1.01e-6 * LIMIT], first=7))
    assert str(caught.value) == (
        "the torque is not that of the wall: 0.000505 mN m, where 0.25 N m/rad with 0.0001 N m s/rad at 1000 counts, "
        "at most 0.5 N m, give 0, at sample 8, 5 counts of 1000"
    )


def test_what_is_said_of_a_wrong_torque() -> None:
    spring = parts(-10, -10)[0]
    with pytest.raises(DeviceError) as caught:
        watch(block([-10, -10, -10], [spring, spring, 2.0 * spring], first=40))
    assert str(caught.value) == (
        f"the torque is not that of the wall: {2e3 * spring:.4g} mN m, where 0.25 N m/rad with 0.0001 N m s/rad at "
        f"1000 counts, at most 0.5 N m, give {1e3 * spring:.4g}, 2 times as much, at sample 42, -10 counts of 1000"
    )


def test_a_torque_at_the_very_limit_passes() -> None:
    """With the hundredth that is granted, and not a digit more."""
    plain = LimitMonitor(TOLD, NATIVE)
    plain.check(block([0], [LIMIT * 1.01]))
    with pytest.raises(DeviceError, match=r"beyond the limit of 0\.5 N m"):
        plain.check(block([0], [np.nextafter(LIMIT * 1.01, 1.0)], first=1))


def test_the_damper_goes_on_from_block_to_block() -> None:
    first, (spring, damper) = parts(-10, -10)[0], parts(-14, -10)
    watch(block([-10], [first]), block([-14], [spring + damper], first=1))
    with pytest.raises(DeviceError, match="is not that of the wall"):
        watch(block([-10], [first]), block([-14], [spring], first=1))


def controlled(name: str, angles: list[int]) -> tuple[Any, list[float]]:
    """Settings under a controller, and its torques from angle to angle, by the law alone, sample by sample."""
    asked = told(name, 1000, NATIVE, wall_stiffness=K, wall_damping=B, torque_limit_nm=LIMIT, speed_limit_rad_s=1e4)
    assert asked.control is not None
    law = ControlledWall(asked, asked.control)
    befores = [angles[0], *angles[:-1]]
    return asked, [law.torque(count, before) for count, before in zip(angles, befores, strict=True)]


@pytest.mark.parametrize("name", ["lag", "damping over a window", "hold"])
def test_a_controller_goes_on_from_block_to_block(name: str) -> None:
    angles = [-10, -12, -15, -15, -11, -6]
    asked, torques = controlled(name, angles)
    watch(block(angles, torques), told=asked)
    watch(block(angles[:3], torques[:3]), block(angles[3:], torques[3:], first=3), told=asked)
    watch(*(block([a], [t], first=i) for i, (a, t) in enumerate(zip(angles, torques, strict=True))), told=asked)
    torques[4] *= 1.001
    with pytest.raises(DeviceError, match=f"is not that of the wall under [a-z_]+: {1e3 * torques[4]:.4g} mN m"):
        watch(block(angles[:3], torques[:3]), block(angles[3:], torques[3:], first=3), told=asked)


def test_the_plain_wall_is_not_what_a_controller_gives() -> None:
    angles = [-10, -12, -15]
    asked, torques = controlled("lag", angles)
    plain = [sum(parts(a, b)) for a, b in zip(angles, [-10, -10, -12], strict=True)]
    assert max(abs(one - other) for one, other in zip(torques, plain, strict=True)) > 1e-3 * LIMIT
    with pytest.raises(DeviceError, match="under"):
        watch(block(angles, plain), told=asked)


def test_a_controllers_torque_stops_at_the_limit() -> None:
    """On both sides: what it would give beyond is refused, the limit itself is not."""
    angles = [-10, -400, -400, -400]
    asked, torques = controlled("damping over a window", angles)
    asked = asked._replace(torque_limit_nm=0.1)
    assert max(torques) > 0.2
    held = [min(max(one, -0.1), 0.1) for one in torques]
    watch(block(angles, held), told=asked)
    with pytest.raises(DeviceError, match="is not that of the wall"):
        watch(block(angles, [min(one, 0.099) for one in held]), told=asked)


def test_nothing_follows_a_last_sample_without_the_flag() -> None:
    """Also where that sample is a block of its own: the wall was on before."""
    spring = parts(-10, -10)[0]
    on, off = block([-10, -10], [spring, spring]), block([-10], [0.0], first=2, on=False)
    found = watch(on, off)
    with pytest.raises(DeviceError, match="said at sample 2 that the wall is off, and went on sampling"):
        found.check(block([-10], [0.0], first=3, on=False))
    found = watch(on, off)
    with pytest.raises(DeviceError, match="went on sampling"):
        found.check(block([-10], [spring], first=3))


def test_samples_before_the_wall_is_on_have_no_flag() -> None:
    spring = parts(-10, -10)[0]
    watch(block([-10], [0.0], on=False), block([-10, -10], [0.0, spring], first=1, on=[False, True]))


def test_an_index_that_comes_again_is_no_gap_of_less_than_none() -> None:
    plain = LimitMonitor(TOLD, NATIVE)
    plain.check(block([0, 0, 0, 0], [0.0] * 4, first=2))
    late = block([0, 0], [0.0] * 2, first=4)
    plain.check(late._replace(time_us=late.time_us + 10_000))
    assert plain.gaps == 0


PULSE = TOLD._replace(pulse=PulseOrder(grip_n=2.0, band_n=0.1, dwell_s=0.0, torque_nm=0.2, width_s=2e-3, release_n=0.5))
GRIPS = [0.3, 0.3, 1.3, 2.5, 2.5, 2.5, 0.3]  # N of the cell, which shows 0.3 where nobody holds the knob
TORQUES = [0.0, 0.0, 0.0, 0.2, 0.2, 0.0, 0.0]  # N m: two samples from the one on at which the grip is 2 N
ON = [False, True, True, True, True, True, True]


def pulsed(torques: list[float], first: int = 0, on: Any = None) -> Block:
    return block([0] * len(torques), torques, first, ON if on is None else on)._replace(grip_n=np.array(GRIPS))


def test_the_pulse_that_the_grip_fires_passes() -> None:
    watch(pulsed(TORQUES), told=PULSE)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_pulse_may_differ_by_a_millionth_of_the_limit(sign: float) -> None:
    for i, plain in enumerate(TORQUES):
        torques = list(TORQUES)
        torques[i] = plain + sign * 0.99e-6 * LIMIT
        watch(pulsed(torques), told=PULSE)
        torques[i] = plain + sign * 1.01e-6 * LIMIT
        with pytest.raises(DeviceError, match=f"is not that of the pulse: .*, at sample {7 + i}$"):
            watch(pulsed(torques, first=7), told=PULSE)


def test_what_is_said_of_a_wrong_pulse() -> None:
    with pytest.raises(DeviceError) as caught:
        watch(pulsed([0.0, 0.0, 0.0, 0.2, 0.1, 0.0, 0.0], first=40), told=PULSE)
    assert str(caught.value) == (
        "the torque is not that of the pulse: 100 mN m, where the grip that the device told calls for 200, at sample 44"
    )


@pytest.mark.parametrize("edge", [1.0 - 1e-5, 1.0 + 1e-5])
def test_a_torque_in_steps_may_be_either_of_two_where_roundings_decide(edge: float) -> None:
    """The wall's torque is 2.5 steps, to a tenth of the share by which a target's may differ."""
    step = parts(-10, -10)[0] / 2.5 * edge
    asked = TOLD._replace(converters=Converters(step_nm=step))
    for steps in (2, 3):
        watch(block([-10, -10], [steps * step] * 2), told=asked)
    for steps in (0.9, 4.1):
        with pytest.raises(DeviceError, match="is not that of the wall behind its converters: "):
            watch(block([-10, -10], [steps * step] * 2), told=asked)


def test_a_torque_in_steps_is_the_nearest_elsewhere() -> None:
    step = parts(-10, -10)[0] / 2.501
    asked = TOLD._replace(converters=Converters(step_nm=step))
    watch(block([-10, -10], [3 * step] * 2), told=asked)
    with pytest.raises(DeviceError, match="behind its converters"):
        watch(block([-10, -10], [2 * step] * 2), told=asked)


def test_a_torque_over_the_angle_is_said_to_be_one() -> None:
    over = OverAngle(first=-4, turn=NATIVE, below=0.0, above=0.0, torques=(0.0, 0.1, 0.2, 0.0))
    asked = TOLD._replace(over_angle=over, wall_damping=0.0)
    watch(block([-3, -2], [0.1, 0.2]), told=asked)
    with pytest.raises(DeviceError, match="is not that of the wall and the torque over the angle: 100 mN m"):
        watch(block([-3, -2], [0.1, 0.1]), told=asked)


def test_an_interruption_waits_until_the_torque_is_off() -> None:
    """It is heard once, by whoever heard it before."""
    heard: list[int] = []

    def hear(number: int, _frame: object) -> None:
        heard.append(number)

    kinds = [signal.SIGTERM, signal.SIGHUP]
    before = [signal.signal(kind, hear) for kind in kinds]
    try:
        with undisturbed():
            for kind in (*kinds, *kinds):
                signal.raise_signal(kind)
            assert heard == []
        assert heard == kinds
        assert [signal.getsignal(kind) for kind in kinds] == [hear, hear]
    finally:
        for kind, handler in zip(kinds, before, strict=True):
            signal.signal(kind, handler)


def test_another_thread_which_hears_no_interruption_puts_none_off() -> None:
    handler = signal.getsignal(signal.SIGTERM)

    def same() -> bool:
        with undisturbed():
            return signal.getsignal(signal.SIGTERM) is handler

    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(same).result()
