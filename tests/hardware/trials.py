"""Trials on the virtual device for the tests: what it is told, and all its samples in one."""

import numpy as np

from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.port import Block, Device, Identity, Settings, Simulated
from hknob_cli.hardware.virtual import VirtualDevice

RATES, COUNTS = (455, 1000, 2000, 4000), (256, 512, 1024, 2048)
CELLS = [(rate, counts) for rate in RATES for counts in COUNTS]
FRICTION = 0.56e-3
# Table 7 with the stiffness of the lightest grasp, as experiments/chapter8.yaml.
HAND = Simulated(
    inertia=2.2e-6,
    damping=3.45e-4,
    stiffness=0.04,
    coulomb_nm=0.0,
    angle_rad=0.02,
    push_nm=1e-3,
    grip_n=0.72,
    grip_rise_s=0.2,
    grip_offset_n=0.3,
)
# A native encoder that all of Chapter 8's decimated ones divide, so that their edges are exact.
ALIGNED = Identity("virtual", 2**17 * 5, 1000, True, 1)


def settings(rate: float = 1000, counts: int = 1024, **changes: float) -> Settings:
    told = Settings(
        period_ns=round(1e9 / rate),
        counts_per_rev=counts,
        wall_stiffness=0.27,
        wall_damping=0.0,
        torque_limit_nm=0.05,
        speed_limit_rad_s=100.0,
        watchdog_us=50_000,
        block_samples=40,
    )
    return told._replace(**changes)


def joined(blocks: list[Block]) -> Block:
    """Blocks as one."""
    arrays = [np.concatenate([block[i] for block in blocks]) for i in range(1, 6)]
    looks = None if blocks[0].looks is None else np.concatenate([block.looks for block in blocks])
    return Block(blocks[0].first, *arrays, blocks[-1].overruns, looks=looks)


def part_of(block: Block, begin: int, size: int) -> Block:
    """Some samples of a block, as one."""
    part = slice(begin, begin + size)
    looks = None if block.looks is None else block.looks[part]
    return Block(block.first + begin, *(column[part] for column in block[1:6]), block.overruns, looks=looks)


def take(device: Device, told: Settings, simulated: Simulated, *, blocks: int, before: int = 1) -> list[Block]:
    """Blocks of one trial, ``before`` of them while nobody holds the knob."""
    device.configure(told, simulated)
    device.arm()
    found = [device.read(60.0) for _ in range(before)]
    device.start()
    found += [device.read(60.0) for _ in range(blocks)]
    device.stop()
    assert device.read(0.0) is None
    return [block for block in found if block is not None]


def virtual_trial(
    told: Settings,
    simulated: Simulated = HAND,
    *,
    duration_s: float = 2.0,
    nuisances: Nuisances | None = None,
    identity: Identity = ALIGNED,
    before: int = 1,
) -> Block:
    """All samples of a trial on the virtual device."""
    blocks = int(np.ceil(duration_s / told.interval_s / told.block_samples))
    with VirtualDevice(nuisances, identity=identity) as device:
        return joined(take(device, told, simulated, blocks=blocks, before=before))
