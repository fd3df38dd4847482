"""Settings of matplotlib in the working folder change no picture, and stop none."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import SPEC

GRID = SPEC.replace("[1000]", "[1000, 2000]").replace("phases: 8", "phases: 2")
HOSTILE = {
    "fonts": b"font.family: monospace\ntext.usetex: True\naxes.facecolor: red\nfigure.dpi: 30\nsavefig.dpi: 30\n",
    "layout": b"savefig.bbox: tight\nlines.linewidth: 9\ntext.hinting: none\npath.sketch: 1, 100, 2\n",
    "no text": b"\xff\xfe\x00font",
    "no settings": b"this is: not: one\nbackend: nothing\n",
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", [*HOSTILE])
def test_no_picture_is_changed(name: str, hknob, spec_file, tmp_path: Path) -> None:
    """The settings are read while the program loads, so that they are there when it starts."""
    page = "kind: report\nname: page\nresults: {grid: grid}\n"

    def drawn(run: Callable[..., Any]) -> dict[str, bytes]:
        done = run("sweep", spec_file(GRID), "-o", "grid", "--plot")
        assert (done.returncode, done.stderr) == (0, "")
        done = run("report", spec_file(page, "r.yaml"), "-o", "page")
        assert (done.returncode, done.stderr) == (0, "")
        kinds = (".png", ".svg", ".html")
        return {path.name: path.read_bytes() for path in tmp_path.rglob("*") if path.suffix in kinds}

    without = drawn(hknob)
    assert len(without) > 2
    for folder in ("grid", "page"):
        shutil.rmtree(tmp_path / folder)
    (tmp_path / "matplotlibrc").write_bytes(HOSTILE[name])
    assert drawn(hknob.anew) == without
