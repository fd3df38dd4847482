"""Files of a campaign under way that are not as it left them: the trial is done again, and nothing recorded is lost."""

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.errors import ComputationError
from hknob_cli.hardware.journal import MAGIC, Journal, read_journal
from hknob_cli.hardware.order import trials_of
from hknob_cli.hardware.port import Block
from hknob_cli.hardware.trial_file import ABOUT, read_trial
from tests.hardware.campaigns import Faulty, campaign, planned
from tests.spoilt_parquet import odd_text


def _column(table: pa.Table, name: str, values: Any) -> pa.Table:
    return table.set_column(table.column_names.index(name), name, values)


def _first_nan(table: pa.Table) -> pa.Table:
    values = table["torque_nm"].to_numpy().copy()
    values[0] = np.nan
    return _column(table, "torque_nm", pa.array(values))


TABLES = {
    "a column less": lambda table: table.drop_columns("running"),
    "a column more": lambda table: table.append_column("more", table["trial"]),
    "another type": lambda table: _column(table, "grip_n", table["grip_n"].cast(pa.string())),
    "time going back": lambda table: table.take(list(range(table.num_rows))[::-1]),
    "no samples": lambda table: table.slice(0, 0),
    "no number": _first_nan,
    "nothing": lambda table: _column(table, "angle_counts", pa.nulls(table.num_rows, pa.int64())),
    "text that is none": lambda table: _column(table, "subject", odd_text(table.num_rows)),
}
ABOUTS: dict[str, Any] = {
    "gaps": "x",
    "overruns": 2**70,
    "device": ["a"],
    "ended": None,
    "native_counts": 0,
    "zero_n": float("nan"),
    "settled_sample": {},
    "trial": 3,
}


@pytest.fixture(scope="module")
def one(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished trial."""
    folder = tmp_path_factory.mktemp("campaign")
    done = campaign(folder, Faulty()).run()
    return folder / "recording" / f"{done[0].trial.label}.parquet"


@pytest.mark.parametrize("spoil", TABLES)
def test_samples_that_are_none(one: Path, tmp_path: Path, spoil: str) -> None:
    assert read_trial(one) is not None
    table = pq.read_table(one)
    pq.write_table(TABLES[spoil](table).replace_schema_metadata(table.schema.metadata), tmp_path / "a.parquet")
    assert read_trial(tmp_path / "a.parquet") is None


@pytest.mark.parametrize("key", ABOUTS)
def test_what_is_said_of_them_that_is_none(one: Path, tmp_path: Path, key: str) -> None:
    table = pq.read_table(one)
    about = json.loads(table.schema.metadata[ABOUT])
    assert key in about
    for said in ({**about, key: ABOUTS[key]}, [about], None):
        pq.write_table(table.replace_schema_metadata({ABOUT: json.dumps(said)}), tmp_path / "a.parquet")
        assert read_trial(tmp_path / "a.parquet") is None


@pytest.mark.parametrize("is_source", [False, True])
def test_a_trial_of_a_device_that_cannot_be_read_is_not_made_again_unasked(tmp_path: Path, is_source: bool) -> None:
    done = campaign(tmp_path, Faulty(), is_source=is_source).run()
    folder, label = tmp_path / "recording", done[0].trial.label
    path = folder / f"{label}.parquet"
    path.write_bytes(spoilt := path.read_bytes()[:-100])
    device = Faulty()
    if is_source:  # it cannot be made again: that is for its owner to decide
        with pytest.raises(ComputationError, match=f"{label}.parquet: is not as it was recorded"):
            campaign(tmp_path, device, is_source=True).run()
        assert "start" not in device.calls
        assert path.read_bytes() == spoilt
        path.rename(tmp_path / "mine")
    again = campaign(tmp_path, device, is_source=is_source).run()
    assert device.calls.count("start") == 1
    assert again[0].table.equals(done[0].table)
    assert not (folder / "aborted").exists()


def test_what_a_device_recorded_of_another_trial_is_kept(tmp_path: Path) -> None:
    done = campaign(tmp_path, Faulty(), is_source=True).run()
    first, second = (tmp_path / "recording" / f"{one.trial.label}.parquet" for one in done[:2])
    first.write_bytes(other := second.read_bytes())
    assert campaign(tmp_path, Faulty(), is_source=True).run()[0].table.equals(done[0].table)
    kept = tmp_path / "recording" / "aborted" / f"{done[0].trial.label}_1.parquet"
    assert kept.read_bytes() == other


@pytest.mark.parametrize(
    "about",
    [
        [],
        None,
        {},
        {"key": 1, "native_counts": 256, "device": "a"},
        {"key": ["s", "e", 1.0, 1, 1], "native_counts": 0, "device": "a"},
        {"key": ["s", "e", 1.0, 1, 1], "native_counts": "x", "device": "a"},
        {"key": ["s", "e", 1.0, 2**70, 1], "native_counts": 256, "device": "a"},
        {"key": ["s", "e", 1.0, 1, 1], "native_counts": 256, "device": []},
    ],
)
def test_a_journal_that_does_not_say_what_it_is_of_is_kept(tmp_path: Path, about: Any) -> None:
    campaign(tmp_path, Faulty()).run()
    folder, label = tmp_path / "recording", trials_of(planned())[0].label
    (folder / f"{label}.parquet").unlink()
    part = folder / f"{label}.part"
    journal = Journal(part, about)
    journal.keep(Block(0, np.arange(3), np.arange(3), np.zeros(3), np.zeros(3), np.ones(3, dtype=bool), 0))
    journal.close()
    content = part.read_bytes()
    assert len(campaign(tmp_path, Faulty()).run()) == 4
    assert (folder / "aborted" / f"{label}_1.part").read_bytes() == content


@pytest.mark.parametrize("first", [2**63 - 1, 2**63, 2**64 - 3])
def test_a_journal_of_samples_with_numbers_that_cannot_be_is_kept(tmp_path: Path, first: int) -> None:
    campaign(tmp_path, Faulty()).run()
    folder, label = tmp_path / "recording", trials_of(planned())[0].label
    (folder / f"{label}.parquet").unlink()
    part = folder / f"{label}.part"
    journal = Journal(part, {"key": ["s", "e", 1.0, 1, 1], "native_counts": 256, "device": "a"})
    journal.keep(Block(first, np.arange(3), np.arange(3), np.zeros(3), np.zeros(3), np.ones(3, dtype=bool), 0))
    journal.close()
    content = part.read_bytes()
    assert len(campaign(tmp_path, Faulty()).run()) == 4
    assert (folder / "aborted" / f"{label}_1.part").read_bytes() == content


def test_a_journal_that_is_nested_too_deeply_says_nothing(tmp_path: Path) -> None:
    deep = b"[" * 200_000
    (tmp_path / "x.part").write_bytes(MAGIC + struct.pack("<II", len(deep), zlib.crc32(deep)) + deep)
    assert read_journal(tmp_path / "x.part") is None
