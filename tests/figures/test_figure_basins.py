"""The figure of basins on the page: a map a cell, with the shares of the attractors."""

import re

import pytest

from hknob_cli.figures import draw, theme
from hknob_cli.page.compose import chapters_of
from hknob_cli.results.result_set import MissingError, ResultSet
from tests.conftest import SPEC, Command
from tests.forked import Forks

RANGES = SPEC.replace("{angle: 0.02, phases: 8}", "{angle: [-20 mrad, 20 mrad], velocity: [-2, 2]}")


@pytest.fixture(scope="module")
def evidence(forks: Forks, tmp_path_factory: pytest.TempPathFactory) -> ResultSet:
    root = tmp_path_factory.mktemp("basins")
    hknob, spec = Command(forks, root), root / "spec.yaml"
    for name, text in {
        "mapped": RANGES.replace("[1024]", "[512, 1024]") + "basins: {points: 12}\n",
        "unmapped": RANGES,
    }.items():
        spec.write_text(text)
        assert hknob("sweep", spec, "-o", name).returncode == 0
    return ResultSet({name: root / name for name in ("mapped", "unmapped")})


def test_a_map_a_cell_with_sizes_and_shares(evidence: ResultSet) -> None:
    svg = theme.svg(draw("basins", evidence, "mapped", {}), name="f", title="a figure")
    words = re.sub(r"<[^>]+>", " ", svg)
    assert "1000 Hz" in words
    assert "512 counts" in words
    assert "1024 counts" in words
    for row in evidence["mapped"].rows("orbits"):
        assert f"{1e3 * row['p2p_rad']:.3g} mrad" in words
    assert svg.count("<image") == 2  # a picture of the starts each; the page's policy lets pictures in
    one = theme.svg(draw("basins", evidence, "mapped", {"where": {"counts_per_rev": 512}}), name="f", title="a figure")
    assert "512 counts" in one
    assert "1024 counts" not in one
    with pytest.raises(MissingError, match="no such cell"):
        draw("basins", evidence, "mapped", {"where": {"counts_per_rev": 77}})
    with pytest.raises(MissingError):
        draw("basins", evidence, "unmapped", {})


def test_a_page_shows_maps_where_there_are_some(evidence: ResultSet) -> None:
    drawn = {
        name: [figure.draw for chapter in chapters_of(evidence) for figure in chapter.figures if name in figure.of]
        for name in ("mapped", "unmapped")
    }
    assert "basins" in drawn["mapped"]
    assert "basins" not in drawn["unmapped"]
