"""Tests of `results.versions`."""

from hknob_cli.results.versions import COMPUTING, ROOT, SHOWING, source_digest


def test_every_folder_that_results_depend_on_is_there() -> None:
    missing = [folder for folder in (*COMPUTING, *SHOWING) if not (ROOT / folder).exists()]
    assert not missing
    digests = [source_digest((folder,)) for folder in COMPUTING]
    assert len(set(digests)) == len(COMPUTING)  # a folder without source has the digest of nothing
