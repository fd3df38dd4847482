"""Pictures as files: whole or not at all, and drawn whatever a spec calls its parts."""

from pathlib import Path
from typing import BinaryIO

import pytest
from matplotlib.figure import Figure

from hknob_cli.errors import ComputationError
from hknob_cli.figures import theme
from hknob_cli.figures.sheet import save
from hknob_cli.results.provenance import picture_origin


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
