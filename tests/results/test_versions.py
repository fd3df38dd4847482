"""Tests of `results.versions`."""

import sys
from importlib import metadata
from pathlib import Path

import pytest

from hknob_cli.results.versions import COMPUTING, ROOT, SHOWING, _files, source_digest, version


def test_every_folder_that_results_depend_on_is_there() -> None:
    missing = [folder for folder in (*COMPUTING, *SHOWING) if not (ROOT / folder).exists()]
    assert not missing
    digests = [source_digest((folder,)) for folder in COMPUTING]
    assert len(set(digests)) == len(COMPUTING)  # a folder without source has the digest of nothing


def test_words_on_the_terminal_do_not_make_results_old() -> None:
    stages = ROOT / "stages"
    words = list(stages.rglob("*text.py"))
    assert words
    assert not set(words) & set(_files(stages))
    assert stages / "sweep" / "run.py" in _files(stages)


@pytest.mark.parametrize("library", ["numpy", "pyarrow", "scipy", "matplotlib", "jinja2", "numba", "hypothesis"])
def test_versions_are_those_of_the_metadata(library: str) -> None:
    assert version(library) == metadata.version(library)


def test_a_version_that_no_folder_tells_is_asked_of_the_metadata(tmp_path: Path, monkeypatch) -> None:
    """Of a library as older tools install it; the first on the path counts; what is on the path may not be there."""
    (tmp_path / "old_library.egg-info").write_text("Metadata-Version: 1.0\nName: old_library\nVersion: 1.2\n")
    monkeypatch.setattr("sys.path", [str(tmp_path / "nowhere"), str(tmp_path / "first"), str(tmp_path), *sys.path])
    assert version("old_library") == "1.2"
    (tmp_path / "first" / "old_library-3.0rc1.dist-info").mkdir(parents=True)
    (tmp_path / "first" / "old_library_more-4.0.dist-info").mkdir()
    assert version("old_library") == "3.0rc1"
    with pytest.raises(metadata.PackageNotFoundError):
        version("no_library")
