"""Pictures as files: whole or not at all, and drawn whatever a spec calls its parts."""

from pathlib import Path
from typing import BinaryIO

import pyarrow as pa
import pytest
from matplotlib.figure import Figure

from hknob_cli.errors import ComputationError
from hknob_cli.figures import theme
from hknob_cli.figures.defaults import figures_of
from hknob_cli.figures.sheet import save, sheet_of
from hknob_cli.results.provenance import picture_origin
from hknob_cli.results.result_set import Held


def crowded() -> Figure:
    """A figure whose labels leave its panels no room, in letters that no font here has."""
    figure = Figure(figsize=(2, 1), layout="constrained")
    for axes in figure.subplots(1, 4):
        axes.set_ylabel("\u65e5\u672c " * 20)
        axes.set_yticks([0.0], ["a label much too wide for so small a figure"])
    return figure


def test_what_is_too_crowded_is_drawn_without_a_warning(tmp_path: Path) -> None:
    """A warning is an error in these tests."""
    save(crowded(), tmp_path / "a.png", stage="bench", name="x")
    assert picture_origin(tmp_path / "a.png") == ("bench", "x")
    assert theme.svg(crowded(), name="a", title="a").startswith("<svg ")


def test_half_a_picture_is_not_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for error, told in (
        (OSError(28, "No space left on device"), ComputationError),
        (KeyboardInterrupt(), KeyboardInterrupt),
    ):

        def fail(half: BinaryIO, raised: BaseException = error, **_: object) -> None:
            half.write(b"half")
            raise raised

        figure = Figure()
        monkeypatch.setattr(figure, "savefig", fail)
        with pytest.raises(told):
            save(figure, tmp_path / "a.png", stage="bench", name="x")
        assert not list(tmp_path.iterdir())


def grid(side: int) -> Held:
    """A sweep of so many rates and resolutions, in whose cells the mean differs from the largest cycle."""
    cells = [
        {
            "sample_rate_hz": 100.0 * (i + 1),
            "counts_per_rev": 64 * (j + 1),
            "p2p_max_rad": 2e-3 / (i + 1),
            "p2p_rad": 1e-3 / (i + 1),
            "frequency_at_max_hz": 50.0,
            "frequency_hz": 60.0,
            **dict.fromkeys(("at_rest_fraction", "diverged_fraction", "undecided_fraction"), 0.0),
        }
        for i in range(side)
        for j in range(side)
    ]
    return Held("tried", "sweep", {"cells": pa.Table.from_pylist(cells)}, ["sample_rate_hz", "counts_per_rev"])


def test_a_picture_begins_with_its_answer() -> None:
    result = grid(2)
    planned = figures_of(result)
    assert [one.options["column"] for one in planned] == ["p2p_max_rad", "frequency_at_max_hz"]  # means are in brackets
    without, with_ = sheet_of(result, planned), sheet_of(result, planned, "It buzzes. " * 20)
    assert without is not None
    assert with_ is not None
    assert [text.get_text() for text in without.texts] == [one.title for one in planned]
    said = [text.get_text() for text in with_.texts][: -len(planned)]
    assert " ".join(said) == ("It buzzes. " * 20).strip()
    assert with_.get_figheight() > without.get_figheight()


def test_maps_too_fine_to_be_written_in_have_the_mean_beside_them() -> None:
    assert [one.options["column"] for one in figures_of(grid(17))][2:] == ["p2p_rad"]
