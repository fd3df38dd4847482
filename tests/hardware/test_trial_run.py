"""Letting go of a device: on every way out, and before anything else is heard."""

import os
import signal
from pathlib import Path

import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Block, Torque
from hknob_cli.hardware.trial_run import Bound, letting_go
from tests.hardware.campaigns import SPEC, Faulty, campaign, planned


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_second_interruption_waits_until_the_torque_is_off(kind: signal.Signals) -> None:
    class Pressed(Faulty):
        def release(self) -> None:
            os.kill(os.getpid(), kind)
            super().release()

    device = Pressed()
    before = signal.signal(kind, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), letting_go(device):
            raise KeyboardInterrupt
    finally:
        signal.signal(kind, before)
    assert device.calls == ["release"]


class Holding(Faulty):
    """A device that keeps its torque."""

    torque = Torque.ON  # type: ignore[assignment]


@pytest.mark.parametrize("error", [None, DeviceError("it tripped"), KeyboardInterrupt(), ValueError("odd")])
def test_torque_that_stays_is_a_device_fault_whatever_else_was_raised(error: BaseException | None) -> None:
    def go() -> None:
        with letting_go(Holding()):
            if error is not None:
                raise error

    with pytest.raises(DeviceError, match="was told to release, and did not") as caught:
        go()
    assert ("it tripped; " in str(caught.value)) == isinstance(error, DeviceError)


@pytest.mark.parametrize(("own_time", "longest"), [(False, 5.0), (True, 100.0)])
def test_every_phase_ends_by_this_computers_clock(
    monkeypatch: pytest.MonkeyPatch, own_time: bool, longest: float
) -> None:
    """Two seconds by the samples: three more for what is under way, or twenty times and a minute in its own time."""
    device = Faulty()
    device._identity = device.identity._replace(own_time=own_time)
    now = [1000.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    bound = Bound(2.0, "the trial", device, live=True)
    endless = Bound(2.0, "the trial", device, live=False)
    now[0] += longest - 0.01
    bound.check()
    now[0] += 0.02
    endless.check()
    with pytest.raises(DeviceError, match=f"the trial has taken {longest:.1f} s by this computer's clock"):
        bound.check()


def test_a_trial_whose_samples_never_say_that_it_is_over_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The grip cell is never read: samples come, and none of them counts."""

    class Empty(Faulty):
        def read(self, timeout_s: float) -> Block | None:
            now[0] += 0.02
            block = super().read(timeout_s)
            return block and block._replace(**{name: getattr(block, name)[:0] for name in Block._fields[1:6]})

    now = [1000.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    plan = planned(SPEC + "device: {driver: serial, url: /dev/null}\n")
    with pytest.raises(DeviceError, match=r"reading the empty grip cell has taken 3\.\d s by this computer's clock"):
        campaign(tmp_path, Empty(), plan, is_source=True).run()
