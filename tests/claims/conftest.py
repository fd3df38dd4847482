"""A ledger from text, and a copy of the printed tables that a test may change."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from hknob_cli.claims.ledger import Ledger, load_ledger
from hknob_cli.printed import tables

HEAD = "text: a text\nclaims:\n"


@pytest.fixture
def ledger(tmp_path: Path) -> Callable[[str], Ledger]:
    """Reads the claims of a ledger, given as YAML."""

    def read(claims: str) -> Ledger:
        path = tmp_path / "claims.yaml"
        path.write_text(HEAD + claims)
        return load_ledger(path)

    return read


@pytest.fixture
def copied_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a copy of the tables, which the program reads instead of its own."""
    folder = tmp_path / "tables"
    shutil.copytree(tables.folder(), folder)
    monkeypatch.setattr(tables, "FOLDERS", (folder,))
    return folder
