"""From a plan to the device that it names, opened."""

from contextlib import ExitStack
from pathlib import Path
from tempfile import gettempdir

from hknob_cli.hardware.nuisances import Nuisances
from hknob_cli.hardware.port import Device
from hknob_cli.spec.campaign import REPLAY, VIRTUAL, HwRunPlan


def opened(plan: HwRunPlan, stack: ExitStack) -> Device:
    """The device of a plan, closed with ``stack``. Raises `DeviceError` or `UsageError` where there is none."""
    device = plan.device
    if device.driver == VIRTUAL:
        from hknob_cli.hardware.virtual import VirtualDevice

        return stack.enter_context(VirtualDevice(Nuisances(*plan.nuisances, seed=plan.seed)))
    raise NotImplementedError
