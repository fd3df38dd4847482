"""Tests of `results.versions`."""

from hknob_cli.results.versions import COMPUTING, ROOT, SHOWING, _files, source_digest


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
