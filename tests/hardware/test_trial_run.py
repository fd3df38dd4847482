"""Letting go of a device: on every way out, and before anything else is heard."""

import os
import signal

import pytest

from hknob_cli.hardware.trial_run import letting_go
from tests.hardware.campaigns import Faulty


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
