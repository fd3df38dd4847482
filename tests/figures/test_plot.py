"""Tests of `plot`: the pictures of --plot are the figures of the page."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.image import imread

from hknob_cli.figures import DRAWINGS, drawing_of
from hknob_cli.figures.plot import draw_hidden, draw_scene, draw_trial
from hknob_cli.results.provenance import picture_origin


def hidden(ratio: float, inertia: float) -> dict[str, Any]:
    given = {"knob_inertia_kg_m2": 2e-6, "finger_inertia_kg_m2": 3e-7}
    return {"ratio": ratio, "estimator": "output_error", "inertia_kg_m2": inertia, **given}


def test_a_picture_is_the_figure_of_that_name(tmp_path: Path, monkeypatch: Any) -> None:
    path, drawn = tmp_path / "a.png", []
    figure = drawing_of("hidden_inertia")
    monkeypatch.setitem(DRAWINGS, "hidden_inertia", lambda *given: drawn.append(given) or figure(*given))
    before = dict(mpl.rcParams)
    assert draw_hidden([hidden(1.0, 2.07e-6), hidden(10.0, 2.003e-6)], title="pads", path=path)
    assert len(drawn) == 1
    assert picture_origin(path) == ("sysid", "pads")
    assert dict(mpl.rcParams) == before  # the next picture has its own style
    assert imread(path)[..., :3].min() < 0.2  # something is drawn
    assert imread(path)[0, 0, :3].tolist() == [1.0, 1.0, 1.0]  # on white, as an SVG is on the page's colour


def test_without_a_figure_nothing_is_written(tmp_path: Path) -> None:
    assert not draw_trial([], title="none", path=tmp_path / "a.png")
    assert not list(tmp_path.iterdir())


def test_one_scene_of_a_bench(tmp_path: Path) -> None:
    run = {"scene": "still", "method": "rk45", "friction": "none", "setting": "1e-6"}
    rows = [{**run, "seconds": 1e-3 * i, "relative_error": 1e-3 / i} for i in (1, 2)]
    draw_scene("still", rows, accurate=1e-6, name="b", path=tmp_path / "a.png")
    assert picture_origin(tmp_path / "a.png") == ("bench", "b")
