"""The host's own watch: what is within the limits passes, what is beyond names its sample, gaps are counted."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Block
from hknob_cli.hardware.safety import LimitMonitor
from tests.hardware.trials import settings

NATIVE = 10_000
TOLD = settings(1000, 256, speed_limit_rad_s=50.0, torque_limit_nm=0.05)
# 50 rad/s for 1 ms are 79.6 counts of 10 000: with a hundredth, and one for the encoder, 81.4.
MOST_COUNTS = 81


def block(first: int = 0, count: int = 4, **changes: Any) -> Block:
    plain = Block(
        first,
        np.arange(first, first + count) * 1000,
        np.zeros(count, dtype=np.int64),
        np.zeros(count),
        np.full(count, 0.3),
        np.ones(count, dtype=bool),
        0,
    )
    return plain._replace(**{name: np.array(values) for name, values in changes.items()})


def test_a_trial_within_its_limits_passes() -> None:
    watch = LimitMonitor(TOLD, NATIVE)
    watch.check(block(torque_nm=[0.05, -0.05, 0.05, 0.0], angle_counts=[5, 5 + MOST_COUNTS, 5, -MOST_COUNTS + 5]))
    watch.check(block(4))
    watch.check(block(8, 0))
    assert watch.gaps == 0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"torque_nm": [0.0, 0.0, -0.051, 0.0]}, "the torque is beyond the limit of 0.05 N m, at sample 12"),
        ({"torque_nm": [0.0, np.nan, 0.0, 0.0]}, "the torque is not a number, at sample 11"),
        ({"grip_n": [np.inf, 0.0, 0.0, 0.0]}, "the grip force is not a number, at sample 10"),
        ({"angle_counts": [0, 0, 0, 82]}, "the knob is faster than the limit of 50 rad/s, at sample 13"),
        ({"angle_counts": [-82, -82, -82, -82]}, "the knob is faster than the limit of 50 rad/s, at sample 10"),
        ({"time_us": [10_000, 11_000, 10_999, 13_000]}, "the device's clock runs backwards, at sample 12"),
        ({"time_us": [4_000, 11_000, 12_000, 13_000]}, "the device's clock runs backwards, at sample 10"),
        (
            {"time_us": [10_000, 10_000, 12_000, 13_000]},
            "the device's clock gives two samples the same time: it must be told to 1 us, and a period is 1000 us "
            "(a clock of 1 ms is too coarse), at sample 11",
        ),
    ],
)
def test_what_is_beyond_is_named(changes: dict[str, Any], said: str) -> None:
    watch = LimitMonitor(TOLD, NATIVE)
    watch.check(block(6))
    with pytest.raises(DeviceError) as error:
        watch.check(block(10, **changes))
    assert str(error.value) == said


def test_a_late_sample_is_no_fast_knob() -> None:
    """Five periods late, it may have come five times as far; a sample that is early by a hair no further."""
    watch = LimitMonitor(TOLD, NATIVE)
    watch.check(block())
    late = block(4, time_us=[8000, 8001, 9000, 10_000], angle_counts=[5 * 79, 5 * 79 + MOST_COUNTS, 400, 400])
    watch.check(late)


def test_missing_samples_are_counted() -> None:
    watch = LimitMonitor(TOLD, NATIVE)
    watch.check(block(2))
    watch.check(block(9, angle_counts=[4 * 79] * 4))
    watch.check(block(20))
    assert watch.gaps == 3 + 7
