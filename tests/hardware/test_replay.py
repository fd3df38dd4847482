"""Trials that were recorded, played back: the same samples, found by their settings, from every kind of file."""

from math import tau
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc
import pyarrow.parquet as pq
import pytest

from hknob_cli.errors import DeviceError, UsageError
from hknob_cli.hardware.port import Block, Settings
from hknob_cli.hardware.replay import FINEST, ReplayDevice, read_takes
from hknob_cli.recordings.columns import KEYS, SAMPLES
from hknob_cli.recordings.files import table
from hknob_cli.recordings.trial import Key, Trial
from tests.hardware.trials import ALIGNED, HAND, joined, settings, take, virtual_trial

CELLS = [(1000, 512), (1000, 1024), (2000, 512)]
ZERO_BLOCKS = 5


def campaign(got: Block, told: Settings, number: int, counts: int | None = None) -> pa.Table:
    """Rows of a campaign's ``samples.parquet``."""
    n = got.time_us.size
    recorded = Trial(
        key=Key("s", "pinch", 0.71, 1, number),
        time_s=got.time_us * 1e-6,
        torque_nm=got.torque_nm,
        angle_rad=got.angle_counts * (tau / ALIGNED.native_counts),
        grip_n=got.grip_n,
    )
    found = table([recorded])
    extra = {
        "sample_rate_hz": pa.array(np.full(n, round(1e9 / told.period_ns, 0))),
        "counts_per_rev": pa.array(np.full(n, counts or told.counts_per_rev)),
        "sample": pa.array(np.arange(n) + got.first),
        "device_time_us": pa.array(got.time_us),
        "angle_counts": pa.array(got.angle_counts),
        "running": pa.array(got.running),
    }
    for name, values in extra.items():
        found = found.append_column(name, values)
    return found


@pytest.fixture(scope="module")
def trials() -> list[tuple[Settings, Block]]:
    told = [settings(rate, counts) for rate, counts in CELLS]
    return [(one, virtual_trial(one, duration_s=0.5, before=ZERO_BLOCKS)) for one in told]


@pytest.fixture(scope="module")
def folder(trials: list[tuple[Settings, Block]], tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("campaign")
    rows = [campaign(got, told, i) for i, (told, got) in enumerate(trials, 1)]
    pq.write_table(pa.concat_tables(rows), found / "samples.parquet")
    return found


def played(device: ReplayDevice, told: Settings, *, before: int = ZERO_BLOCKS) -> list[Block]:
    device.configure(told, HAND)
    device.arm()
    found = [device.read(0.0) for _ in range(before)]
    device.start()
    while (block := device.read(0.0)) is not None:
        found.append(block)
    device.stop()
    assert device.read(0.0) is None
    return [block for block in found if block is not None]


def same(a: Block, b: Block) -> bool:
    return a.first == b.first and all(np.array_equal(a[i], b[i]) for i in range(1, 6))


def test_a_campaign_plays_back_the_same_samples(folder: Path, trials: list[tuple[Settings, Block]]) -> None:
    with ReplayDevice([folder]) as device:
        assert device.identity.native_counts == ALIGNED.native_counts
        assert not device.identity.simulated
        for told, got in reversed(trials):
            assert same(joined(played(device, told)), got)
            small = told._replace(block_samples=7)  # however they are cut
            before = -(-ZERO_BLOCKS * told.block_samples // 7)
            assert same(joined(played(device, small, before=before)), got)


def test_it_is_read_like_any_device(folder: Path, trials: list[tuple[Settings, Block]]) -> None:
    told, got = trials[1]
    with ReplayDevice([folder]) as device:
        blocks = got.time_us.size // told.block_samples - ZERO_BLOCKS
        again = take(device, told, HAND, blocks=blocks, before=ZERO_BLOCKS)
        assert same(joined(again), got)
        assert [block.first for block in again] == [told.block_samples * i for i in range(len(again))]


def test_what_is_left_before_the_start_is_skipped_without_a_gap(
    folder: Path, trials: list[tuple[Settings, Block]]
) -> None:
    told, got = trials[0]
    with ReplayDevice([folder]) as device:
        for before in (0, 2):
            again = joined(played(device, told, before=before))
            left = (ZERO_BLOCKS - before) * told.block_samples
            assert again.first == 0
            assert np.array_equal(again.angle_counts[again.running], got.angle_counts[got.running])
            assert np.array_equal(again.time_us, got.time_us[: got.time_us.size - left])
        device.configure(told)
        device.arm()
        while device.read(0.0) is not None:  # no more than was recorded before the start
            pass
        device.start()
        block = device.read(0.0)
        assert block is not None
        assert block.first == ZERO_BLOCKS * told.block_samples


def test_recorded_gaps_stay(trials: list[tuple[Settings, Block]], tmp_path: Path) -> None:
    told, got = trials[0]
    rows = campaign(got, told, 1)
    keep = np.ones(rows.num_rows, dtype=bool)
    keep[300:304] = False
    pq.write_table(rows.filter(pa.array(keep)), tmp_path / "holes.parquet")
    with ReplayDevice([tmp_path / "holes.parquet"]) as device:
        numbers = [block.first + i for block in played(device, told) for i in range(block.time_us.size)]
    assert numbers == [*range(300), *range(304, rows.num_rows)]


def test_settings_that_were_not_recorded_are_refused(folder: Path) -> None:
    device = ReplayDevice([folder])
    there = "1000 Hz with 512 counts, 1000 Hz with 1024 counts, 2000 Hz with 512 counts"
    with pytest.raises(DeviceError, match=f"no recording of 2000 Hz with 1024 counts; there are: {there}"):
        device.configure(settings(2000, 1024))
    with pytest.raises(DeviceError, match=r"not of a wall of 0\.3 N·m/rad"):
        device.configure(settings(2000, 512, wall_stiffness=0.3))
    with pytest.raises(DeviceError, match=r"and 0\.0001 N·m·s/rad: its torque is another"):
        device.configure(settings(2000, 512, wall_damping=1e-4))
    with pytest.raises(DeviceError, match="given no settings"):
        device.arm()


def test_repeats_take_turns(tmp_path: Path) -> None:
    told = settings()
    pushes = (1.0e-3, 1.2e-3)
    trials = [virtual_trial(told, HAND._replace(push_nm=push), duration_s=0.3) for push in pushes]
    rows = pa.concat_tables([campaign(got, told, i) for i, got in enumerate(trials)])
    pq.write_table(rows, tmp_path / "two.parquet")
    with ReplayDevice([tmp_path / "two.parquet"]) as device:
        again = [joined(played(device, told, before=1)) for _ in range(3)]
    assert [same(a, b) for a, b in zip(again, [*trials, trials[0]], strict=True)] == [True] * 3
    assert not same(again[0], again[1])


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_plain_recording_is_found_by_its_torque(
    ending: str, trials: list[tuple[Settings, Block]], tmp_path: Path
) -> None:
    """Nothing but the columns of the contract: rate from the times, counts from the torque, start from the motion."""
    path = tmp_path / f"plain.{ending}"
    rows = pa.concat_tables([campaign(got, told, i) for i, (told, got) in enumerate(trials)])
    rows = rows.select([column.name for column in (*KEYS, *SAMPLES)])
    pc.write_csv(rows, path) if ending == "csv" else pq.write_table(rows, path)
    with ReplayDevice([path]) as device:
        assert device.identity.native_counts == FINEST
        for told, got in trials:
            again = joined(played(device, told, before=0))
            angle = again.angle_counts * (tau / FINEST)
            n = again.angle_counts.size
            # Rounding down to the finer counts.
            off = got.angle_counts[-n:] * (tau / ALIGNED.native_counts) - angle
            assert (np.abs(off - 0.5 * tau / FINEST) <= 0.5001 * tau / FINEST).all()
            assert np.array_equal(again.torque_nm, got.torque_nm[-n:])
            assert n >= got.running.sum() - 1
        with pytest.raises(DeviceError, match="2000 Hz with counts not said"):
            device.configure(settings(4000, 512))
        with pytest.raises(DeviceError, match="its torque is another"):
            device.configure(settings(1000, 256))


def test_states(folder: Path) -> None:
    with ReplayDevice([folder]) as device:
        assert device.read(0.0) is None
        for call in (device.start, device.stop):
            with pytest.raises(DeviceError, match="must be armed"):
                call()
        device.configure(settings(1000, 512))
        device.arm()
        for call in (device.arm, lambda: device.configure(settings(1000, 512))):
            with pytest.raises(DeviceError, match="must be idle"):
                call()
        device.release()
        device.arm()


def test_files_that_cannot_be_replayed(trials: list[tuple[Settings, Block]], tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot be read"):
        ReplayDevice([tmp_path])
    with pytest.raises(UsageError, match="nothing to replay"):
        ReplayDevice([])
    rows = campaign(trials[0][1], trials[0][0], 1)
    at = rows.column_names.index("angle_counts")
    text = rows.set_column(at, "angle_counts", pa.array(["x"] * rows.num_rows))
    pq.write_table(text, tmp_path / "text.parquet")
    with pytest.raises(UsageError, match="angle_counts: must be of type int64, is string"):
        ReplayDevice([tmp_path / "text.parquet"])
    holes = rows.set_column(at, "angle_counts", pa.array([None] + [1] * (rows.num_rows - 1)))
    pq.write_table(holes, tmp_path / "holes.parquet")
    with pytest.raises(UsageError, match="angle_counts: nothing in 1 rows"):
        ReplayDevice([tmp_path / "holes.parquet"])
    for name, value in (("sample", -1), ("device_time_us", 2**62), ("counts_per_rev", 0), ("angle_counts", -(2**60))):
        column = pa.array(np.full(rows.num_rows, value, dtype=np.int64))
        pq.write_table(rows.set_column(rows.column_names.index(name), name, column), tmp_path / "odd.parquet")
        with pytest.raises(UsageError, match=f"row 1: {name}: must be from .* to .*, got"):
            ReplayDevice([tmp_path / "odd.parquet"])
    column = pa.array(np.full(rows.num_rows, 0.0))
    pq.write_table(rows.set_column(rows.column_names.index("angle_rad"), "angle_rad", column), tmp_path / "odd.parquet")
    with pytest.raises(UsageError, match="angle_counts where angle_rad is 0: no encoder has so many"):
        ReplayDevice([tmp_path / "odd.parquet"])
    pq.write_table(rows.append_column(" sample", rows.column("sample")), tmp_path / "twice.parquet")
    with pytest.raises(UsageError, match="sample: column is there 2 times"):
        ReplayDevice([tmp_path / "twice.parquet"])
    pq.write_table(rows, tmp_path / "campaign.parquet")
    plain = rows.drop_columns(["angle_counts"])
    other = plain.set_column(plain.column_names.index("trial"), "trial", pa.array(np.full(rows.num_rows, 9)))
    pq.write_table(other, tmp_path / "plain.parquet")
    with pytest.raises(UsageError, match="of different encoders, of 655360, 16777216 counts"):
        read_takes([tmp_path / "campaign.parquet", tmp_path / "plain.parquet"])
