"""Small campaigns for the tests: a plan of four short trials, a device that can be told to fail, an archive."""

from contextlib import ExitStack
from pathlib import Path

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.archive import Archive
from hknob_cli.hardware.campaign import Campaign
from hknob_cli.hardware.port import Block, Settings, Simulated
from hknob_cli.hardware.virtual import VirtualDevice
from hknob_cli.specs.campaign import HwRunPlan
from hknob_cli.specs.load import validate
from hknob_cli.specs.source import parse
from tests.hardware.trials import HAND

SPEC = """\
kind: hw-run
name: bench
grid: {sample_rate_hz: [1000, 2000], counts_per_rev: [256, 512]}
trial: {zero: 0.05, settle: 0.05, buzz: [0.1, 0.2], longest: 2}
person: {wandering_push: false, grip_wander: false}
"""
REMEDIES = """\
remedies:
  plain wall: {}
  softer wall: {change: {wall: {stiffness: 0.135}}}
  bounded lag: {change: {controller: {kind: bounded_lag, keep: 0.15, time_constant: 0.2}}}
"""


def planned(text: str = SPEC) -> HwRunPlan:
    """Validated campaign from text."""
    plan = validate(parse(text, "spec.yaml"))
    assert isinstance(plan, HwRunPlan)
    return plan


class Faulty(VirtualDevice):
    """A virtual device that writes down what it is asked, and fails at one of its blocks, counted over all trials."""

    def __init__(self, fail_at: int | None = None, error: BaseException | None = None) -> None:
        super().__init__()
        self.calls: list[str] = []
        self.blocks = 0
        self.fail_at = fail_at
        self.error = error or DeviceError("the link is cut")

    def configure(self, settings: Settings, simulated: Simulated | None = None) -> None:
        self.calls.append(f"configure {1e9 / settings.period_ns:.0f} {settings.counts_per_rev}")
        super().configure(settings, simulated)

    def start(self) -> None:
        self.calls.append("start")
        super().start()

    def read(self, timeout_s: float) -> Block | None:
        self.blocks += 1
        if self.blocks == self.fail_at:
            raise self.error
        return super().read(timeout_s)

    def release(self) -> None:
        self.calls.append("release")
        super().release()


def campaign(out: Path, device: VirtualDevice, plan: HwRunPlan | None = None, **options: object) -> Campaign:
    """A campaign in a folder; ``identity`` and ``is_source`` of its archive, and options of `Campaign`."""
    plan = plan or planned()
    archive = Archive(
        out,
        identity=str(options.pop("identity", "one")),
        is_source=bool(options.pop("is_source", False)),
        stamp=b"{}",
    )

    def opened(stack: ExitStack) -> VirtualDevice:
        return stack.enter_context(device)

    return Campaign(plan, archive, opened, lambda _trial: HAND, **options)
