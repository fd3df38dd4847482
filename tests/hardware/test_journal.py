"""The journal of a trial: what was written is read again, bit by bit, however the file ends."""

from pathlib import Path

import numpy as np
import pytest

from hknob_cli.errors import ComputationError
from hknob_cli.hardware.journal import Journal, packed, read_journal, unpacked
from hknob_cli.hardware.port import Block

ABOUT = {"trial": {"number": 3}, "native_counts": 640_000}


def block(first: int, count: int, seed: int = 1) -> Block:
    rng = np.random.default_rng(seed + first)
    return Block(
        first,
        np.arange(first, first + count) * 1000,
        rng.integers(-(2**40), 2**40, count),
        rng.standard_normal(count) * 1e-3,
        rng.standard_normal(count),
        rng.random(count) < 0.5,
        7,
    )


def same(one: Block, other: Block) -> bool:
    scalars = (one.first, one.overruns) == (other.first, other.overruns)
    return scalars and all(np.array_equal(a, b) for a, b in zip(one[1:6], other[1:6], strict=True))


def written(path: Path, sizes: tuple[int, ...] = (10, 1, 48)) -> list[Block]:
    journal = Journal(path, ABOUT)
    blocks, first = [], 0
    for size in sizes:
        blocks.append(block(first, size))
        journal.keep(blocks[-1])
        first += size
    journal.close()
    return blocks


def test_what_was_written_is_read(tmp_path: Path) -> None:
    blocks = written(tmp_path / "a.part")
    found = read_journal(tmp_path / "a.part")
    assert found is not None
    assert (found.about, found.whole) == (ABOUT, True)
    assert all(same(*pair) for pair in zip(found.blocks, blocks, strict=True))


def test_a_block_is_on_the_disk_before_the_next(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "a.part", ABOUT)
    for i in range(3):
        journal.keep(block(10 * i, 10))
        found = read_journal(tmp_path / "a.part")
        assert found is not None
        assert len(found.blocks) == i + 1
    journal.close()


def test_cut_anywhere_only_the_last_block_is_lost(tmp_path: Path) -> None:
    path = tmp_path / "a.part"
    blocks = written(path)
    content = path.read_bytes()
    ends = [len(content)]
    for one in reversed(blocks):
        ends.insert(0, ends[0] - len(packed(one)) - 8)
    for cut in range(len(content)):
        path.write_bytes(content[:cut])
        found = read_journal(path)
        if cut < ends[0]:
            assert found is None
            continue
        assert found is not None
        assert len(found.blocks) == sum(end <= cut for end in ends[1:])
        assert found.whole == (cut in ends)


def test_a_changed_byte_is_noticed(tmp_path: Path) -> None:
    """Every byte of the file, one at a time: what is read is what was written, or less."""
    path = tmp_path / "a.part"
    blocks = written(path, (3, 2))
    content = path.read_bytes()
    for place in range(len(content)):
        path.write_bytes(content[:place] + bytes([content[place] ^ 0x10]) + content[place + 1 :])
        found = read_journal(path)
        if found is not None:
            assert not found.whole
            assert found.about == ABOUT
            assert all(same(*pair) for pair in zip(found.blocks, blocks, strict=False))


def test_other_bytes_are_no_block() -> None:
    good = packed(block(0, 5))
    for bad in (b"", good[:-1], good + b"x", b"x" * 30):
        with pytest.raises(ValueError, match=r"too short|length"):
            unpacked(bad)


def test_no_room(tmp_path: Path) -> None:
    with pytest.raises(ComputationError, match="cannot be written"):
        Journal(tmp_path / "not there" / "a.part", ABOUT)
    (tmp_path / "a.part").write_text("mine")
    with pytest.raises(ComputationError, match="File exists"):
        Journal(tmp_path / "a.part", ABOUT)
    assert (tmp_path / "a.part").read_text() == "mine"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "a.part", ABOUT)
    journal.keep(block(0, 4))
    with Path("/dev/full").open("wb", buffering=0) as full:
        plain, journal._file = journal._file, full
        with pytest.raises(ComputationError, match="No space left"):
            journal.keep(block(4, 4))
        journal._file = plain
    journal.close()
    found = read_journal(tmp_path / "a.part")
    assert found is not None
    assert len(found.blocks) == 1
