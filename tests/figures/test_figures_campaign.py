"""Drawings of campaigns on a knob, on a small one: what they say, and that they say it the same twice."""

from pathlib import Path
from typing import Any

import pytest

from hknob_cli.figures import draw, theme
from hknob_cli.figures.campaign import one_trial
from hknob_cli.page.answers import answers_of
from hknob_cli.page.compose import chapters_of
from hknob_cli.results.result_set import MissingError, ResultSet
from tests.conftest import EXPERIMENTS, Command
from tests.drawn import first_of_each
from tests.forked import Forks

GRID = "grid={sample_rate_hz: [1000, 4000], counts_per_rev: [256, 2048]}"
SHORT = "trial={zero: 0.1, settle: 0.1, buzz: [1, 1], longest: 3}"
STARTS = "starts={angle: 0.02, phases: 4}"
SOFT = "{wall: {stiffness: 0.135}}"
TWO = "remedies={plain wall: {}, softer wall: {change: CHANGE}}"
RUNS = {
    "plain": ("hw-run", "ch8_hardware_plain", GRID, SHORT),
    "friction": ("hw-run", "ch8_hardware", GRID, SHORT),
    "row": ("hw-run", "ch8_hardware_plain", "grid={sample_rate_hz: [1000], counts_per_rev: [256]}", SHORT),
    "computed": (
        "remedies",
        "ch8_remedies",
        f"base.{GRID}",
        TWO.replace("CHANGE", f"{{scene: {SOFT}}}"),
        "base.starts={angle: 0.02, phases: 2}",
    ),
    "tried": ("hw-run", "ch8_hardware_remedies", GRID, SHORT, TWO.replace("CHANGE", SOFT), "against=BASE/computed"),
    "sweep": ("sweep", "chapter8", GRID, STARTS, "scene.bias={torque: 0.001}"),
    "predict": ("predict", "predict_chapter8", GRID),
    "whine": ("sweep", "whine", "starts={angle: 1.0e-4, phases: 4}", "record={duration: 0.01, interval: 2.0e-5}"),
}
ONE: dict[str, Any] = {"sample_rate_hz": 1000, "counts_per_rev": 256}
PRINTED = {"frequency_hz": {"mean": 2.0}, "p2p_rad": {"mean": 1.2, "least": 0.26, "largest": 2.5}}
CASES: list[tuple[str, object, dict[str, Any], tuple[str, ...]]] = [
    ("grid_map", "friction", {"column": "frequency_hz"}, ("frequency, Hz", "rest: trials that come to rest")),
    ("grid_map", "plain", {"column": "wall_torque_nm", "log": False}, ("wall torque nm, N·m",)),
    ("hardware_grid", ["sweep", "friction"], {"names": ("swept", "tried")}, ("swept", "tried", "2 cells")),
    ("grid_difference", ["friction", "sweep"], {}, ("rest", "2 cells")),
    ("grip_forces", None, {}, ("0.64", "mean 0.72 ± 0.05 N")),
    ("grip_forces", "friction", {}, ("printed, Table 8", "a virtual person", "mean 0.72 ± 0.05 N", "2048")),
    ("campaign_thumbnails", "friction", {}, ("1000 Hz", "4000 Hz", "256", "2048", "8 cycles")),
    ("campaign_thumbnails", "row", {"cycles": 4}, ("1000 Hz", "4 cycles")),
    ("campaign_trial", "friction", ONE, ("angle, mrad", "torque, mN·m", "angle seen, mrad", "grip, N")),
    ("campaign_trial", "plain", {**ONE, "grip": False, "from_s": 0, "to_s": 0.1}, ("angle, mrad", "time, ms")),
    ("campaign_trial", "friction", {**ONE, "counts_per_rev": 2048}, ("grip, N",)),
    ("campaign_lines", ["sweep", "plain"], {"names": ["swept", "tried"]}, ("swept", "tried", "2048 counts")),
    (
        "campaign_lines",
        ["predict", "sweep", "friction"],
        {"law": "quantum_period"},
        ("predict", "friction", "256 counts", "peak to peak, mrad"),
    ),
    (
        "what_explains",
        ["plain", "friction"],
        {"over": "sweep", "names": ["nothing", "all"], "printed": PRINTED},
        ("nothing", "all", "4 of 4", "2 of 4", "printed", "pitch over the simulated", "2048"),
    ),
    (
        "torque_reach",
        ["whine", "row"],
        {"printed_hz": 2200, "printed_rad": 0.0014},
        ("101-fold", "whine", "row", "printed", "peak to peak, mrad"),
    ),
    ("torque_reach", ["whine"], {}, ("no losses",)),
    ("remedies_tried", "tried", {}, ("softer wall", "measured", "computed", "times smaller than", "buzzes, %")),
    ("campaign_thumbnails", "tried", {"remedy": "softer wall"}, ("1000 Hz", "2048", "8 cycles")),
    ("campaign_trial", "tried", {**ONE, "remedy": "softer wall"}, ("angle, mrad", "grip, N")),
    ("grid_map", "tried", {"where": {"remedy": "softer wall"}}, ("2048",)),
]  # fmt: skip


@pytest.fixture(scope="module")
def evidence(tmp_path_factory: pytest.TempPathFactory, forks: Forks) -> ResultSet:
    base = tmp_path_factory.mktemp("campaigns")
    hknob = Command(forks, base)
    folders: dict[str, Path] = {}
    for name, (stage, spec, *sets) in RUNS.items():
        folders[name] = base / name
        more = [part for value in sets for part in ("--set", value.replace("BASE", str(base)))]
        done = hknob(stage, EXPERIMENTS / f"{spec}.yaml", "-o", folders[name], "-q", *more)
        assert done.returncode == 0, done.stderr
    return ResultSet(folders)


@pytest.mark.parametrize(
    ("name", "of", "options", "says"), first_of_each(CASES), ids=[f"{c[0]}-{i}" for i, c in enumerate(CASES)]
)
def test_what_a_figure_says(
    evidence: ResultSet, name: str, of: object, options: dict[str, Any], says: tuple[str, ...]
) -> None:
    text = theme.svg(draw(name, evidence, of, dict(options)), name="f", title="t")
    for words in says:
        assert words in text, words


@pytest.mark.one_in(30)
@pytest.mark.parametrize("case", CASES, ids=[f"{c[0]}-{i}" for i, c in enumerate(CASES)])
def test_a_figure_is_the_same_twice(evidence: ResultSet, case: Any) -> None:
    name, of, options, _ = case
    text, again = (theme.svg(draw(name, evidence, of, dict(options)), name="f", title="t") for _ in range(2))
    assert text == again


@pytest.mark.parametrize(
    ("name", "of", "options", "says"),
    [
        ("campaign_thumbnails", "sweep", {}, r"no trials\.parquet of 'sweep'"),
        ("campaign_trial", "plain", {**ONE, "counts_per_rev": 300}, "no trial at 1000 Hz and 300 counts"),
        ("campaign_trial", "plain", {**ONE, "from_s": 90}, "no samples there, at 1000 Hz, 256 counts"),
        ("campaign_lines", ["sweep", "row"], {}, "1 resolutions at 1 rates"),
        ("what_explains", ["row"], {"over": "whine"}, "no cell in common"),
        ("torque_reach", ["plain"], {}, "of several cells"),
        ("remedies_tried", "plain", {}, r"no remedies\.parquet of 'plain'"),
        ("campaign_thumbnails", "tried", {}, "tried several remedies; give one of them as 'remedy': "),
        ("campaign_thumbnails", "plain", {"remedy": "x"}, "tried no remedy 'x'; it has none"),
        ("grid_map", "tried", {}, "has several; choose by where"),
    ],
)
def test_what_is_not_there_is_said(
    evidence: ResultSet, name: str, of: object, options: dict[str, Any], says: str
) -> None:
    with pytest.raises(MissingError, match=says):
        draw(name, evidence, of, options)


def test_pitch_is_that_of_cycles(evidence: ResultSet) -> None:
    """A cycle across the wall's edge switches its torque on once; a part of one may be missed at either end."""
    trial = one_trial(evidence, "friction", **ONE)
    (cell,) = (row for row in evidence["friction"].rows("cells") if all(row[name] == ONE[name] for name in ONE))
    torque = trial.torque[trial.steady]
    switched = int(((torque[1:] > 0.0) & (torque[:-1] == 0.0)).sum())
    assert switched > 20
    assert cell["frequency_hz"] == pytest.approx(switched / trial.row["steady_s"], abs=2.0 / trial.row["steady_s"])


def test_a_page_of_its_own(evidence: ResultSet) -> None:
    """A campaign has pictures and a sentence where a report's spec lists neither."""
    one = ResultSet({"friction": evidence["friction"].folder})
    (chapter,) = chapters_of(one)
    assert [figure.draw for figure in chapter.figures] == ["grid_map", "grid_map", "campaign_thumbnails"]
    (answer,) = answers_of(one)
    assert answer.startswith("friction: It buzzes in 2 of 4 cells, in the trials recorded. The most: ")


def test_a_page_of_remedies_that_were_tried(evidence: ResultSet) -> None:
    one = ResultSet({"tried": evidence["tried"].folder})
    (chapter,) = chapters_of(one)
    assert [figure.draw for figure in chapter.figures] == ["remedies_tried", "campaign_thumbnails"]
    assert [table.file for table in chapter.tables] == ["remedies", "trials"]
    (answer,) = answers_of(one)
    assert answer.startswith(("tried: Smallest buzz: softer wall, ", "tried: No remedy made the buzz smaller"))
