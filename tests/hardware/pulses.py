"""Small campaigns of pulses for the tests, and single trials of them on the virtual device."""

from pathlib import Path

import numpy as np

from hknob_cli.hardware.archive import Archive
from hknob_cli.hardware.campaign import Campaign
from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.order import settings_of, trials_of
from hknob_cli.hardware.person import squeezer
from hknob_cli.hardware.port import Block
from hknob_cli.hardware.virtual import VirtualDevice
from hknob_cli.specs.load import validate
from hknob_cli.specs.pulses import PulsePlan
from hknob_cli.specs.source import parse
from tests.hardware.trials import joined

SPEC = """\
kind: hw-run
name: pulses
what: pulses
order: grid
pulses: {grips: [0.71, 4.3], trials: 2, zero: 0.05, timeout: 3, person: {rise: 0.2, relax: 0.05}}
"""
HELD = SPEC.replace("trials: 2", "trials: 1, trigger: held, dwell: 0.1")


def planned(text: str = SPEC) -> PulsePlan:
    """Validated campaign from text."""
    plan = validate(parse(text, "spec.yaml"))
    assert isinstance(plan, PulsePlan)
    return plan


def campaign(out: Path, plan: PulsePlan, device: VirtualDevice | None = None, **options: object) -> Campaign:
    """A campaign in a folder, on a device of its plan where none is given."""
    from functools import partial

    from hknob_cli.hardware.campaign import opened

    archive = Archive(out, identity="one", is_source=False, stamp=b"{}")
    given = (lambda stack: stack.enter_context(device)) if device else partial(opened, plan)
    return Campaign(plan, archive, given, partial(squeezer, plan), **options)


def pulsed(text: str = SPEC, *, nuisances: Nuisances | None = None, number: int = 1) -> Block:
    """All samples of a trial on the virtual device, 3 s of it."""
    plan = planned(text)
    trial = trials_of(plan)[number - 1]
    with VirtualDevice(nuisances) as device:
        device.configure(settings_of(plan, trial), squeezer(plan, trial))
        device.arm()
        blocks = [device.read(1.0) for _ in range(10)]
        device.start()
        blocks += [device.read(1.0) for _ in range(600)]
        device.stop()
    return joined_with_sensors([block for block in blocks if block is not None])


def joined_with_sensors(blocks: list[Block]) -> Block:
    """Blocks as one, with what the sensors told."""
    whole = joined(blocks)
    for name in ("measured_torque_nm", "acceleration_rad_s2"):
        if getattr(blocks[0], name) is not None:
            whole = whole._replace(**{name: np.concatenate([getattr(one, name) for one in blocks])})
    return whole
