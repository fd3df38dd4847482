"""What a device at a wire says of its wall must be what was agreed: flag after START, torque by the law."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Block
from hknob_cli.hardware.safety import LimitMonitor
from tests.hardware.trials import ALIGNED, HAND, settings, virtual_trial

TOLD = settings(1000, 1024, wall_damping=1e-6, torque_limit_nm=4e-3)


def trial() -> Block:
    """A trial of the virtual device, which has the same wall: half a second, in it and out of it, at the limit too."""
    return virtual_trial(TOLD, HAND._replace(push_nm=3e-3), duration_s=0.5)


def parts(block: Block, size: int = 40) -> list[Block]:
    whole = len(block.time_us)
    return [
        Block(block.first + i, *(column[i : i + size] for column in block[1:6]), block.overruns)
        for i in range(0, whole, size)
    ]


def watched(blocks: list[Block]) -> None:
    """The watch over blocks, told to start at the first that has the wall on."""
    watch = LimitMonitor(TOLD, ALIGNED.native_counts, wired=True)
    for block in blocks:
        if block.running.any():
            watch.start()
        watch.check(block)


def altered(**changes: Any) -> list[Block]:
    block = trial()
    return parts(block._replace(**{name: change(getattr(block, name).copy()) for name, change in changes.items()}))


def test_the_virtual_wall_is_the_one_agreed() -> None:
    block = trial()
    assert (np.abs(block.torque_nm) == float(np.float32(4e-3))).any()
    assert (block.torque_nm[block.running] == 0.0).any()
    watched(parts(block))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda torque: 0.5 * torque, "0.5 times as much"),
        (lambda torque: -torque, "-1 times as much"),
        (lambda torque: 1.001 * torque * (np.abs(torque) < 3.9e-3), " times as much"),
        (lambda torque: np.concatenate([[0.0], torque[:-1]]), "is not that of the wall"),
        (lambda torque: torque + 1e-5, "1e-05 mN m|0.01 mN m where the wall is off"),
    ],
)
def test_another_torque_is_noticed(change: Any, said: str) -> None:
    with pytest.raises(DeviceError, match=said):
        watched(altered(torque_nm=change))


def test_single_precision_is_the_same_torque() -> None:
    """A target that computes with floats of 24 bits is off by some 1e-7."""
    watched(altered(torque_nm=lambda torque: torque * (1.0 + 5e-7)))


def test_a_flag_before_start_is_noticed() -> None:
    watch = LimitMonitor(TOLD, ALIGNED.native_counts, wired=True)
    block = next(each for each in parts(trial()) if each.running.any())
    with pytest.raises(DeviceError, match="was not told to switch it on, at sample 40"):
        watch.check(block)


def without(block: Block, off: np.ndarray) -> Block:
    """A block whose wall is off at some samples, with no torque there."""
    return block._replace(running=block.running & ~off, torque_nm=np.where(off, 0.0, block.torque_nm))


def test_a_flag_that_is_lost_within_a_block_is_noticed() -> None:
    whole = trial()
    off = np.arange(len(whole.time_us)) >= 250
    with pytest.raises(DeviceError, match="says that the wall is off, and goes on sampling, at sample 250"):
        watched(parts(without(whole, off)))


def test_a_flag_that_is_lost_with_the_last_sample_of_a_block_is_noticed_by_the_next() -> None:
    whole = trial()
    blocks = parts(without(whole, np.arange(len(whole.time_us)) >= 239))
    watched(blocks[:6])  # it may have tripped there
    with pytest.raises(DeviceError, match="said at sample 239 that the wall is off, and went on sampling"):
        watched(blocks[:7])


def test_a_recording_is_not_held_to_the_wire() -> None:
    watch = LimitMonitor(TOLD, ALIGNED.native_counts)
    for block in altered(torque_nm=lambda torque: 0.5 * torque):
        watch.check(block)
