"""Pages and pictures that scripts of docs/make make from the program are current."""

import runpy
from pathlib import Path

import pytest

from hknob_cli.cli.explore import explore
from tests.conftest import ROOT

MAKE = ROOT / "docs" / "make"


@pytest.mark.parametrize("name", ["columns", "spec_keys"])  # `test_contents` has another
def test_page_is_current(name: str) -> None:
    made = runpy.run_path(str(MAKE / f"{name}.py"))["page"]()
    assert (ROOT / "docs" / "reference" / f"{name}.md").read_text(encoding="utf-8") == made, "make schemas"


def test_drawing_is_current(tmp_path: Path) -> None:
    script = runpy.run_path(str(MAKE / "signs.py"))
    main, place = script["main"], script["PLACE"]
    main.__globals__["PLACE"] = tmp_path / "signs.svg"
    main()
    assert (tmp_path / "signs.svg").read_bytes() == place.read_bytes(), "make schemas"


def test_page_to_play_with_is_current(tmp_path: Path) -> None:
    explore(out=tmp_path / "knob.html", open_it=False, quiet=True)
    made = (tmp_path / "knob.html").read_bytes()
    assert (ROOT / "docs" / "play" / "knob.html").read_bytes() == made, "make schemas"
