"""Settings of matplotlib in the working folder change no picture, and stop none."""

from pathlib import Path

import pytest

from tests.conftest import SPEC

GRID = SPEC.replace("[1000]", "[1000, 2000]").replace("phases: 8", "phases: 2")
HOSTILE = {
    "fonts": b"font.family: monospace\ntext.usetex: True\naxes.facecolor: red\nfigure.dpi: 30\nsavefig.dpi: 30\n",
    "layout": b"savefig.bbox: tight\nlines.linewidth: 9\ntext.hinting: none\npath.sketch: 1, 100, 2\n",
    "no text": b"\xff\xfe\x00font",
    "no settings": b"this is: not: one\nbackend: nothing\n",
}


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    return {}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["", *HOSTILE])
def test_no_picture_is_changed(name: str, hknob, spec_file, tmp_path: Path, drawn: dict[str, bytes]) -> None:
    """The first, without such a file, is what the others must be."""
    if name:
        (tmp_path / "matplotlibrc").write_bytes(HOSTILE[name])
    done = hknob.anew("sweep", spec_file(GRID), "-o", "grid", "--plot")
    assert (done.returncode, done.stderr) == (0, "")
    done = hknob.anew("report", spec_file("kind: report\nname: page\nresults: {grid: grid}\n", "r.yaml"), "-o", "page")
    assert (done.returncode, done.stderr) == (0, "")
    found = {path.name: path.read_bytes() for path in tmp_path.rglob("*") if path.suffix in (".png", ".svg", ".html")}
    assert len(found) > 2
    if not drawn:
        assert not name
        drawn.update(found)
    assert found == drawn
