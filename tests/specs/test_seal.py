"""Seals: whatever bit of a file is flipped, and wherever it is cut, it is known to be changed."""

import os
from io import BytesIO
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.results.parted import sealed_file
from hknob_cli.specs import seal as seals
from hknob_cli.specs.parquet import ChangedError, table_of
from hknob_cli.specs.seal import _HEAD, BLANK, KEY, State, is_changed, sealed, state_in, state_of

TEXT = b"<!-- hknob report page 0123456789abcdef " + BLANK + b" -->\n<p>sha256:" + b"1" * 64 + b"</p>\n"
TABLE = pa.table({"p2p_rad": [2.426e-3, 0.0, None], "outcome": ["cycle", "rest", "cycle"]})


def files() -> dict[str, bytes]:
    return {"page.html": sealed(TEXT), "cells.parquet": bytes(sealed_file(TABLE, {b"hknob.provenance": b"{}"}))}


@pytest.mark.parametrize("name", ["page.html", "cells.parquet"])
def test_every_flipped_bit_is_noticed(name: str) -> None:
    whole = files()[name]
    assert state_in(BytesIO(whole)) is State.WHOLE
    for place in range(8 * len(whole)):
        spoilt = bytearray(whole)
        spoilt[place // 8] ^= 1 << place % 8
        found = state_in(BytesIO(spoilt))
        # A text whose word "sha256:" is hit has no seal any more: it is not taken for one as written, either.
        assert found is State.CHANGED or (name == "page.html" and found is State.UNSEALED), place


@pytest.mark.parametrize("name", ["page.html", "cells.parquet"])
def test_every_cut_is_noticed(name: str) -> None:
    whole = files()[name]
    for end in range(len(whole)):
        assert state_in(BytesIO(whole[:end])) is not State.WHOLE, end
    assert state_in(BytesIO(whole + b"\n")) is State.CHANGED


def test_a_changed_table_cannot_be_read_and_a_whole_one_is_what_was_written(tmp_path: Path) -> None:
    path = tmp_path / "cells.parquet"
    path.write_bytes(files()["cells.parquet"])
    assert table_of(path).replace_schema_metadata(None).equals(TABLE)
    data = bytearray(path.read_bytes())
    data[10] ^= 1
    path.write_bytes(data)
    with pytest.raises(ChangedError, match="not as it was written"):
        table_of(path)


def test_files_of_others_have_no_seal(tmp_path: Path) -> None:
    path = tmp_path / "mine.parquet"
    pq.write_table(TABLE, path)
    assert state_of(path) is State.UNSEALED
    assert table_of(path).equals(TABLE)
    path.write_bytes(b"")
    assert state_of(path) is State.UNSEALED
    assert not is_changed(tmp_path / "nothing")


def test_what_has_no_blank_seal_cannot_be_sealed() -> None:
    for text in (b"", b"a page", sealed(TEXT), KEY):
        with pytest.raises(ValueError, match="no blank seal"):
            sealed(text)


def test_a_large_file_is_looked_at_again_once_it_has_changed(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_bytes(sealed(TEXT + bytes(9_000_000)))
    assert [state_of(path), state_of(path)] == [State.WHOLE] * 2
    path.write_bytes(path.read_bytes() + b" ")
    assert state_of(path) is State.CHANGED


def test_a_pipe_is_not_looked_into(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever opens one waits until somebody writes."""
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.setattr(Path, "open", lambda *_: pytest.fail("it is opened"))
    assert not is_changed(tmp_path / "pipe")


def test_a_large_file_is_read_once_and_a_small_one_each_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    monkeypatch.setattr(seals, "_LARGE", 100)
    monkeypatch.setattr(seals, "state_in", lambda stream: asked.append(stream.name) or State.UNSEALED)
    for name, size in (("small", 99), ("large", 100)):
        (tmp_path / name).write_bytes(b"x" * size)
        assert [state_of(tmp_path / name) for _ in range(3)] == [State.UNSEALED] * 3
    assert [Path(one).name for one in asked] == ["small", "small", "small", "large"]


def test_a_table_whose_first_letter_is_damaged_is_known_to_be_changed() -> None:
    table = pa.table({"angle_rad": np.random.default_rng(1).random(4096)})
    data = bytearray(sealed_file(table, {b"hknob.provenance": b"{}"}))
    assert len(data) > 8 * _HEAD  # its seal is not where that of a text is
    assert state_in(BytesIO(data)) is State.WHOLE
    data[0] ^= 1
    assert state_in(BytesIO(data)) is State.CHANGED


def test_a_seal_in_a_long_footer_is_found_by_what_the_file_says_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(seals, "_TAIL", 16)
    assert state_in(BytesIO(files()["cells.parquet"])) is State.WHOLE
