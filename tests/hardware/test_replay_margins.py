"""What is replayed, of recordings made by hand: each bound, a hair within it and a hair beyond."""

from collections.abc import Sequence
from math import tau
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.errors import DeviceError, UsageError
from hknob_cli.hardware.port import Identity
from hknob_cli.hardware.replay import (
    FINEST,
    MOST_COUNTS,
    RecordedTrial,
    ReplayDevice,
    _native_counts,
    _Playing,
    _round_rate,
    is_of_wall,
    read_takes,
)
from hknob_cli.recordings.files import table
from hknob_cli.recordings.trial import Key, Trial
from tests.hardware.trials import settings

NATIVE = 1000  # counts of both encoders
TOLD = settings(1000, NATIVE, block_samples=4)
INSIDE = TOLD.wall_stiffness * 10 * tau / NATIVE  # N m of the wall at -10 counts


def recorded(counts: Sequence[int], torques: Sequence[float] = (), **changes: Any) -> RecordedTrial:
    """A trial of 1 kHz, with the wall on from the beginning."""
    n = len(counts)
    plain = RecordedTrial(
        name="by hand",
        sample_rate_hz=1000.0,
        counts_per_rev=NATIVE,
        native_counts=NATIVE,
        number=np.arange(n) + 100,
        time_us=np.arange(n) * 1000 + 7,
        angle_counts=np.array(counts),
        torque_nm=np.array(torques or [0.0] * n, dtype=float),
        grip_n=np.zeros(n),
        running=np.ones(n, dtype=bool),
    )
    return plain._replace(**changes)


def file_of(path: Path, *trials: Sequence[float], rate: float = 1000.0, **columns: Sequence[Any]) -> Path:
    """A file of trials with these angles in counts, and of more columns."""
    rows = table(
        [
            Trial(
                Key("s", "pinch", 0.7, 1, i),
                time_s=np.arange(len(counts)) / rate,
                torque_nm=np.zeros(len(counts)),
                angle_rad=np.array(counts) * (tau / NATIVE),
                grip_n=np.zeros(len(counts)),
            )
            for i, counts in enumerate(trials, 1)
        ]
    )
    for name, values in columns.items():
        rows = rows.append_column(name, pa.array(values))
    pq.write_table(rows, path)
    return path


@pytest.mark.parametrize(
    ("count", "angle", "native"),
    [
        (1, tau / 1000, 1000),
        (-1, -tau / 1000, 1000),
        (1, 1.9999 * tau, 1),
        (MOST_COUNTS, tau, MOST_COUNTS),
        (0, 1.0, FINEST),
    ],
)
def test_the_encoder_is_told_by_the_largest_angle(count: int, angle: float, native: int) -> None:
    assert _native_counts(np.array([0, count]), np.array([0.0, angle]), "one") == native


@pytest.mark.parametrize(("count", "angle"), [(1, 2.0 * tau), (1, -tau), (MOST_COUNTS + 1, tau), (1, 0.0), (3, 1000.0)])
def test_no_encoder_has_less_than_a_count_nor_more_than_most(count: int, angle: float) -> None:
    with pytest.raises(UsageError, match=f"one: {count} angle_counts where angle_rad is .*: no encoder has so many"):
        _native_counts(np.array([0, count]), np.array([0.0, angle]), "one")


@pytest.mark.parametrize(
    ("rate", "found"), [(455.45, 455.0), (455.46, 455.46), (454.56, 455.0), (454.54, 454.54), (1000.0, 1000.0)]
)
def test_a_rate_within_a_thousandth_of_whole_hertz_is_that(rate: float, found: float) -> None:
    assert _round_rate(np.arange(9) / rate) == pytest.approx(found, rel=1e-12)


def test_a_recording_is_of_the_wall_if_98_of_100_torques_are() -> None:
    """Of the samples at which either has one; to single precision, whichever of both is larger."""
    apart, counts = [0] * 900, [-10] * 100
    for wrong, ours in ((2, True), (3, False)):
        odd = recorded([*apart, *counts], [*[0.0] * 900, *[0.5 * INSIDE] * wrong, *[INSIDE] * (100 - wrong)])
        assert is_of_wall(odd, TOLD) is ours
        more = recorded([*apart, *counts], [*[0.0] * (900 - wrong), *[0.01] * wrong, *[INSIDE] * 100])
        assert is_of_wall(more, TOLD) is (wrong / (100 + wrong) < 0.02)
    for sign in (-1.0, 1.0):
        assert is_of_wall(recorded(counts, [INSIDE * (1.0 + sign * 1.9e-7)] * 100), TOLD)
        assert not is_of_wall(recorded(counts, [INSIDE * (1.0 + sign * 2.1e-7)] * 100), TOLD)


def test_a_recording_away_from_the_wall_fits_any() -> None:
    assert is_of_wall(recorded([0, 1, 2]), TOLD)


def test_a_rate_may_be_a_thousandth_off(tmp_path: Path) -> None:
    device = ReplayDevice([file_of(tmp_path / "one.parquet", [0, 5, 6])])
    for rate in (1000.9, 999.1):
        device.configure(settings(rate, NATIVE))
    for rate in (1001.1, 998.9):
        with pytest.raises(DeviceError, match="no recording of"):
            device.configure(settings(rate, NATIVE))


def test_one_sample_has_no_rate(tmp_path: Path) -> None:
    (two,) = read_takes([file_of(tmp_path / "two.parquet", [0, 5])])
    assert two.sample_rate_hz == 1000.0
    with pytest.raises(UsageError, match="trial 2 of block 1: has one sample"):
        read_takes([file_of(tmp_path / "one.parquet", [0, 5], [0])])


def test_the_wall_is_on_from_the_sample_before_the_knob_moves(tmp_path: Path) -> None:
    """From the first on, where it never does."""
    moves, stays = read_takes([file_of(tmp_path / "two.parquet", [3, 3, 3, 5, 6], [4, 4, 4])])
    assert moves.running.tolist() == [False, False, True, True, True]
    assert stays.running.tolist() == [True, True, True]


def test_a_rate_that_is_told_counts(tmp_path: Path) -> None:
    (one,) = read_takes([file_of(tmp_path / "one.parquet", [0, 5, 6], sample_rate_hz=[1003.5] * 3)])
    assert one.sample_rate_hz == 1003.5


def test_the_row_of_an_odd_value_is_said(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"row 3: sample: must be from 0 to 9\.0072e\+15, got -1"):
        read_takes([file_of(tmp_path / "odd.parquet", [0, 5, 6, 7], sample=[0, 1, -1, -2])])


def test_who_answers(tmp_path: Path) -> None:
    device = ReplayDevice([file_of(tmp_path / "one.parquet", [0, 5])])
    assert device.identity == Identity(
        name="replay", native_counts=FINEST, shortest_period_ns=1, simulated=False, boot=1, knows_control=True
    )


def test_three_repeats_take_turns(tmp_path: Path) -> None:
    device = ReplayDevice([file_of(tmp_path / "three.parquet", [0, 5], [0, 6], [0, 7])])
    seen = []
    for _ in range(4):
        device.configure(TOLD)
        device.arm()
        device.start()
        with pytest.raises(DeviceError, match="must be armed"):
            device.start()
        block = device.read(0.0)
        assert block is not None
        assert block.overruns == 0
        seen.append(round(block.angle_counts[-1] * NATIVE / FINEST))
        device.stop()
    assert seen == [5, 6, 7, 5]


def blocks(playing: _Playing, before: int) -> list[tuple[int, int, int]]:
    """First index, size and first time of each block, ``before`` of them before the start."""
    found = [playing.block(started=False) for _ in range(before)]
    playing.start()
    while (block := playing.block(started=True)) is not None:
        found.append(block)
    return [(one.first, one.time_us.size, int(one.time_us[0])) for one in found if one is not None]


@pytest.mark.parametrize("before", [0, 1, 2])
def test_index_and_time_go_on_where_samples_are_skipped(before: int) -> None:
    take = recorded([0] * 20, running=np.arange(20) >= 12)
    at = [(100 + 4 * k, 4, 7 + 4000 * k) for k in range(before + 2)]
    assert blocks(_Playing(take, TOLD), before) == at


def test_a_recorded_gap_ends_a_block_and_stays() -> None:
    number = np.array([*range(100, 106), *range(110, 114)])
    take = recorded([0] * 10, number=number)
    assert blocks(_Playing(take, TOLD), 0) == [(100, 4, 7), (104, 2, 4007), (110, 4, 6007)]


def test_a_wall_that_was_never_on_ends_the_trial_at_the_start() -> None:
    take = recorded([0] * 6, running=np.zeros(6, dtype=bool))
    assert blocks(_Playing(take, TOLD), 1) == [(100, 4, 7)]
