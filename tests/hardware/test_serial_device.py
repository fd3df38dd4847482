"""The serial driver on a pseudo-terminal and on a socket: a trial from end to end, and what it refuses to begin."""

import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

from hknob_cli.errors import DeviceError, ExitCode
from hknob_cli.hardware.port import Block, Device, Settings
from hknob_cli.hardware.serial_device import SerialDevice
from hknob_cli.hardware.wire.codes import Kind
from tests.hardware.fake_target import Manners, PtyTarget, SocketTarget, made_up
from tests.hardware.golden import SETTINGS, WITH_SINES


def trial(device: Device, told: Settings = SETTINGS, *, blocks: int = 20) -> list[Block]:
    """Armed, started half way, stopped: all blocks."""
    device.configure(told, WITH_SINES)
    device.arm()
    got: list[Block] = []
    while len(got) < blocks:
        block = device.read(60.0)
        assert block is not None
        got.append(block)
        if len(got) == blocks // 2:
            device.start()
    device.stop()
    while (block := device.read(60.0)) is not None:
        got.append(block)
    return got


def assert_whole(blocks: list[Block], *, period_ns: int = SETTINGS.period_ns) -> int:
    """Every sample of the made-up signal once, in order; returns how many."""
    count = sum(len(each.time_us) for each in blocks)
    expected = made_up(0, count, period_ns * 1e-3, started=None)
    for name in ("time_us", "angle_counts", "torque_nm", "grip_n"):
        joined = np.concatenate([getattr(each, name) for each in blocks])
        np.testing.assert_array_equal(joined, getattr(expected, name))
    return count


@pytest.mark.parametrize("kind", [PtyTarget, SocketTarget])
def test_two_trials(kind: type[PtyTarget]) -> None:
    with kind() as served:
        with SerialDevice(served.url) as device:
            assert device.identity.name == "made up"
            assert device.identity.boot == served.target.boot
            for _ in range(2):
                blocks = trial(device)
                made = sum(len(each.samples.time_us) for each in served.target.blocks)
                assert assert_whole(blocks) == made
                running = np.concatenate([each.running for each in blocks])
                assert not running[0]
                assert running[-1]
        assert served.target.simulated == WITH_SINES
        assert served.target.settings == SETTINGS
        assert served.target.heard[-1] is Kind.RELEASE
    assert not [thread for thread in threading.enumerate() if thread.name == "hknob wire"]


def test_bytes_of_every_value_pass_a_terminal_that_was_in_line_mode() -> None:
    """A block has bytes that line mode would change, echo or take for Ctrl-C; the driver switches that off."""
    import termios

    with PtyTarget() as served:
        mode = termios.tcgetattr(served._fds[1])
        mode[0] |= termios.ICRNL | termios.IXON
        mode[1] |= termios.OPOST | termios.ONLCR
        mode[3] |= termios.ICANON | termios.ECHO | termios.ISIG
        termios.tcsetattr(served._fds[1], termios.TCSANOW, mode)
        with SerialDevice(served.url) as device:
            assert_whole(trial(device, blocks=30))


def test_what_lay_in_the_port_before_is_not_taken() -> None:
    import os

    with PtyTarget() as served:
        os.write(served._fds[0], bytes(range(256)) * 8)
        with SerialDevice(served.url) as device:
            assert_whole(trial(device))


def test_reading_without_waiting_finds_nothing_and_is_no_fault() -> None:
    with PtyTarget() as served, SerialDevice(served.url) as device:
        assert device.read(0.0) is None
        device.configure(SETTINGS)
        device.arm()
        while device.read(0.0) is None:  # a block may be there at once, or not for a while
            time.sleep(0.001)


def test_any_thread_may_release_while_another_reads() -> None:
    with PtyTarget() as served, SerialDevice(served.url) as device:
        device.configure(SETTINGS)
        device.arm()
        device.start()
        releasing = threading.Thread(target=device.release)
        releasing.start()
        while device.read(0.2) is not None:
            pass
        releasing.join()
        assert served.target.torque_off_at is not None
        trial(device)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"period_ns": 19_999}, "period_ns must be from 20000 to 1e+09, got 19999"),
        ({"counts_per_rev": 10_001}, "counts_per_rev must be from 1 to 10000, got 10001"),
        ({"wall_stiffness": -0.1}, "wall_stiffness must be from 0 to 1000, got -0.1"),
        ({"wall_damping": float("nan")}, "wall_damping must be from 0 to 1000, got nan"),
        ({"torque_limit_nm": 0.0}, "torque_limit_nm must be above 0, at most 10, got 0"),
        ({"speed_limit_rad_s": float("inf")}, "speed_limit_rad_s must be above 0, at most 10000, got inf"),
        ({"watchdog_us": 50_001}, "watchdog_us must be from 1000 to 50000, got 50001"),
        ({"block_samples": 49}, "block_samples must be from 1 to 48, got 49"),
        ({"period_ns": 2_000_000}, "block_samples: a block must take at most 50 ms, these take 80 ms"),
    ],
)
def test_what_is_out_of_range_is_named_and_not_sent(values: dict[str, float], said: str) -> None:
    with PtyTarget() as served, SerialDevice(served.url) as device:
        with pytest.raises(DeviceError) as caught:
            device.configure(SETTINGS._replace(**values))  # type: ignore[arg-type]
        assert str(caught.value) == f"{served.url}: {said}"
        assert caught.value.exit_code is ExitCode.DEVICE
        assert Kind.CONFIGURE not in served.target.heard


def test_nothing_is_armed_without_settings() -> None:
    with PtyTarget() as served, SerialDevice(served.url) as device:
        with pytest.raises(DeviceError, match="not armed"):
            device.arm()
        assert Kind.ARM not in served.target.heard


def test_a_command_out_of_turn_is_refused_with_its_reason() -> None:
    refused = pytest.raises(DeviceError, match=r"refused to start: not in this state \(idle\)")
    with PtyTarget() as served, SerialDevice(served.url) as device, refused:
        device.start()


@pytest.mark.parametrize("use", [lambda d: d.identity, lambda d: d.read(0.1), lambda d: d.stop()])
def test_a_device_that_is_not_open_says_so(use: Callable[[SerialDevice], object]) -> None:
    with pytest.raises(DeviceError, match="the port is not open"):
        use(SerialDevice("/dev/none"))


def test_releasing_what_is_not_open_is_nothing() -> None:
    SerialDevice("/dev/none").release()


def test_answers_that_come_late_are_waited_for() -> None:
    """50 ms is longer than a repeat takes: the command comes twice, and is done once."""
    with PtyTarget(Manners(late_s=0.05)) as served, SerialDevice(served.url) as device:
        device.configure(SETTINGS)
        assert served.target.settings == SETTINGS
        assert served.target.heard.count(Kind.CONFIGURE) >= 2
