"""Drawings of grids, loops and benches on small real results: what they say, and that they say it the same twice."""

import re
from pathlib import Path
from typing import Any

import pytest

from hknob_cli.figures import draw, theme
from hknob_cli.figures.grid import grid, rows_of
from hknob_cli.figures.numbers import log_ticks, number
from hknob_cli.results.result_set import MissingError, Result, ResultSet
from hknob_cli.specs.drawings import MODULES
from tests.conftest import EXPERIMENTS, Command
from tests.forked import Forks

AXES = "grid={sample_rate_hz: [1000, 2000, 4000], counts_per_rev: [256, 512]}"
COARSE_AND_FINE = "grid={sample_rate_hz: [1000, 2000], counts_per_rev: [512, 2048]}"
PLANE = (
    "grid={sample_rate_hz: 1000, counts_per_rev: 1024, wall.stiffness: {log: [0.03, 30, 4]},"
    " wall.damping: [0, 1e-3, 2e-3]}"
)
HAND = "hand.stiffness: [0.04, 0.08], knob.inertia: [1.9e-6, 4.0e-6]"
SMALL = (AXES, "starts={angle: 0.02, phases: 4}")
RUNS: dict[str, tuple[str, ...]] = {
    "small": ("sweep", "chapter8", *SMALL),
    "friction": (
        "sweep",
        "chapter8_friction",
        COARSE_AND_FINE,
        SMALL[1],
    ),
    "noticed": (
        "sweep",
        "chapter8_friction",
        COARSE_AND_FINE,
        SMALL[1],
        "perceive={knob_radius: 8.9 mm, sound_response: [[20, 0.01], [12500, 10]]}",
    ),
    "free": ("sweep", "chapter8", COARSE_AND_FINE, SMALL[1]),
    "hand": (
        "sweep",
        "hand_on_knob",
        f"grid={{sample_rate_hz: 1000, counts_per_rev: 1024, {HAND}}}",
        SMALL[1],
    ),
    "row": ("sweep", "hand_on_knob", "grid={sample_rate_hz: [1000, 2000], counts_per_rev: 1024}", SMALL[1]),
    "one": ("sweep", "hand_on_knob", "grid={sample_rate_hz: 1000, counts_per_rev: 1024}", SMALL[1]),
    "three": (
        "sweep",
        "hand_on_knob",
        "grid={sample_rate_hz: [1000, 2000], counts_per_rev: [512, 1024], hand.stiffness: [0.04, 0.08]}",
        SMALL[1],
    ),
    "growth": (
        "sweep",
        "bouncing_ball_growth",
        "grid={sample_rate_hz: [1000, 10000], counts_per_rev: [128, 1024]}",
        "starts={angle: 0.02, phases: 64}",
    ),
    "bias": (
        "sweep",
        "bias_staircase",
        "grid={sample_rate_hz: 1000, counts_per_rev: 1024, bias.torque: {lin: [2.0e-4, 1.4e-3, 5]}}",
        SMALL[1],
    ),
    "design": (
        "predict",
        "predict_hand_on_knob",
        "grid={design: {sobol: 32}, sample_rate_hz: {log: [500, 5000]}, counts_per_rev: {log: [256, 4096]}, "
        "hand.stiffness: {lin: [0.02, 0.2]}}",
    ),
    "fine": (
        "sweep",
        "hand_on_knob",
        "grid={sample_rate_hz: {log: [100, 10000, 30]}, counts_per_rev: {log: [128, 8192, 20]}}",
        "starts={angle: 0.02, phases: 1}",
    ),
    "dfa": ("dfa", "dfa_hand_on_knob", AXES, "methods=[df1, tsypkin]"),
    "several": ("dfa", "dfa_hand_on_knob", AXES, "methods=[sampled]"),
    "pushed": (
        "sweep",
        "hand_on_knob",
        "grid={sample_rate_hz: [455, 1000], counts_per_rev: [256, 512]}",
        "scene.bias.torque=0.007",
        "starts={angle: 0.02, phases: 16}",
    ),
    "predict": ("predict", "predict_hand_on_knob", AXES),
    "plane": (
        "predict",
        "predict_hand_on_knob",
        PLANE,
        "scene.knob.damping=1e-3",
        "scene.knob.coulomb_torque=3e-3",
    ),
    "bare plane": ("predict", "predict_hand_on_knob", PLANE),
    "bench": (
        "bench",
        "bench_quick",
        "methods=[exact, mujoco_rk4]",  # rk4 would be compiled, which takes longest
        "settings={tolerances: [1.0e-6], substeps: [1, 16]}",
        "scenes={nominal: {}, friction: {scene: {knob: {coulomb_torque: 1.0e-4}}}}",
    ),
}

# Drawing, results, options, and what its text says.
CASES: list[tuple[str, object, dict, tuple[str, ...]]] = [
    ("grid_map", "small", {}, ("sample rate, Hz", "encoder, counts", "peak to peak, mrad", "4000", "512")),
    ("grid_map", "small", {"mesh": True, "log": False}, ("peak to peak, mrad", "rate, Hz")),
    ("grid_map", "small", {"column": "frequency_hz", "across": "counts_per_rev"}, ("frequency, Hz",)),
    ("grid_map", "small", {"column": "rms_rad", "scale": 1e6, "label": "RMS, microrad"}, ("RMS, microrad",)),
    ("grid_map", "small", {"column": "certified_fraction", "log": False}, ("certified fraction", "1.00")),
    ("grid_map", "friction", {}, ("rest", "rest: trials that come to rest")),
    ("grid_map", "friction", {"mesh": True}, ("rest",)),
    ("grid_map", "hand", {}, ("hand stiffness, N·m/rad", "knob inertia, kg·m²", "0.08")),
    ("grid_map", "row", {}, ("2000", "1024")),
    ("grid_map", "row", {"mesh": True}, ("2000",)),
    ("grid_map", "one", {}, ("1000", "1024")),
    ("grid_map", "three", {"at": {"hand.stiffness": 0.08}}, ("hand stiffness, N·m/rad: 0.08", "512")),
    ("grid_map", "fine", {"mesh": True}, ("15 of 30 and 20 of 20 values", "empty: no limit cycle")),
    ("hardware_grid", ["fine", "fine"], {}, ("factor: mean 1.0",)),
    ("grid_map", "growth", {"column": "growth_j_per_s2"}, ("growth of energy, mJ/s²", "\u2212")),
    ("grid_map", "dfa", {"where": {"method": "tsypkin"}}, ("peak to peak, mrad",)),
    ("grid_map", "predict", {"where": {"law": "quantum_period"}}, ("in brackets",)),
    ("grid_pair", ["small", "dfa"], {"wheres": [{}, {"method": "df1"}], "names": ["run", "relay"]}, ("run", "relay")),
    ("grid_pair", "small", {"columns": ["p2p_rad", "frequency_hz"]}, ("peak to peak, mrad", "frequency, Hz")),
    ("grid_pair", ["growth", "row"], {"columns": ["growth_j_per_s2", "p2p_rad"]}, ("mJ/s²", "mrad")),
    (
        "grid_difference",
        ["dfa", "small"],
        {"where": {"method": "df1"}},
        ("difference, %", "standard deviation", "6 cells"),
    ),
    (
        "grid_difference",
        ["dfa", "small"],
        {"amplitude": True, "where": {"method": "df1"}},
        ("amplitude against peak to peak", "\u22125"),
    ),
    ("grid_difference", ["friction", "free"], {}, ("rest", "2 cells")),
    ("grid_lines", "small", {"values": True}, ("256", "512", "peak to peak, mrad")),
    ("grid_lines", "small", {"over": "counts_per_rev", "log": "x"}, ("1000", "2000", "4000")),
    ("grid_lines", "small", {"column": "frequency_hz", "mean_over": True, "log": ""}, ("mean", "single cells")),
    (
        "grid_lines",
        "growth",
        {"column": "growth_j_per_s2", "error": "growth_std_j_per_s2", "trials": "growth_fits"},
        ("growth of energy",),
    ),
    ("grid_lines", "row", {}, ("sample rate, Hz",)),
    ("grid_lines", "friction", {}, ("2048",)),
    ("saturated_map", "small", {}, ("\u22121", "exceeds one count to either side (0 cells)")),
    ("saturated_map", "friction", {}, ("rest", "does not (2 cells)")),
    ("saturated_map", "small", {"column": "frequency_hz", "limit": 100.0}, ("+1", "exceeds 100")),
    ("block_diagram", None, {}, ("G(jω)", "H(jω)")),
    ("nonlinearity", None, {}, ("½KΔθ", "output, N·m")),
    ("nyquist", "small", {}, ("Re G, rad/(N·m)", "rate 1000 Hz", "near the origin")),
    ("nyquist", "small", {"rates": [500.0]}, ("rate 500 Hz",)),
    ("staircase", "bias", {"unit_of_step": True}, ("samples per cycle", "1.657 mN·m", "frequency, Hz")),
    ("staircase", "row", {}, ("sample rate, Hz",)),
    ("staircase", "three", {"over": "sample_rate_hz", "at": {"hand.stiffness": 0.04, "counts_per_rev": 512}}, ("Hz",)),
    ("surface", "small", {}, ("1.00", "worse of the two")),
    ("surface", "friction", {"mesh": True}, ("rest",)),
    ("sensory_surface", "noticed", {"mesh": True}, ("rest", "more noticeable of the two, dB", "t: touch is")),
    ("what_matters", "fine", {}, ("1. sample rate, Hz", "2. encoder, counts", "explains", "at rest, %")),
    ("what_matters", "fine", {"most": 1}, ("left out: 1 that explains less",)),
    ("what_matters", "design", {"where": {"law": "quantum_period"}}, ("3. ", "in domain, %")),
    ("law_lines", ["predict", "small"], {}, ("the law C Δθ T", "points: simulated")),
    ("law_lines", "predict", {"law": "energy_balance", "column": "frequency_hz"}, ("frequency, Hz",)),
    (
        "kb_plane",
        "plane",
        {},
        ("wall stiffness", "virtual damping", "1000 Hz, 1024 counts", "exact", "(Niemeyer)", "any hand"),
    ),
    (
        "kb_plane",
        "bare plane",
        {},
        ("At no stiffness: passive in any hand, with counts (Abbott", "Hulin", "neither"),
    ),
    ("cases", ["one", "row"], {"names": ["slow", "both"]}, ("slow", "2000 Hz, 1024 counts", "frequency, Hz")),
    ("error_time", "bench", {}, ("nominal", "processor time of a run, s", "hknob, exact")),
    ("stability_table", "bench", {}, ("accurate", "friction", "MuJoCo RK4")),
    ("hardware_grid", ["free", "friction"], {}, ("without friction", "rest", "factor: mean", "2 cells")),
]


class Runs(ResultSet):
    """Every result of `RUNS`, through the command line, each when it is first asked for."""

    def __init__(self, folder: Path, hknob: Command) -> None:
        super().__init__({})
        self.folder, self.hknob = folder, hknob

    def __getitem__(self, name: str) -> Result:
        if name in RUNS and name not in self._results:
            stage, spec, *overrides = RUNS[name]
            options = [part for override in overrides for part in ("--set", override)]
            done = self.hknob(stage, EXPERIMENTS / f"{spec}.yaml", *options, "-o", self.folder / name)
            assert done.returncode == 0, done.stderr
            self._results[name] = Result(name, self.folder / name)
        return super().__getitem__(name)


@pytest.fixture(scope="session")
def evidence(tmp_path_factory: pytest.TempPathFactory, forks: Forks) -> ResultSet:
    folder = tmp_path_factory.mktemp("results")
    return Runs(folder, Command(forks, folder))


def text_of(svg: str) -> str:
    return "\n".join(re.findall(r"<text[^>]*>(.*?)</text>", svg, flags=re.DOTALL))


def drawn(evidence: ResultSet, name: str, of: object, options: dict) -> str:
    return theme.svg(draw(name, evidence, of, options), name="f", title="a figure")


@pytest.mark.one_in(20)
@pytest.mark.parametrize(("name", "of", "options", "said"), CASES, ids=[f"{c[0]}-{i}" for i, c in enumerate(CASES)])
def test_a_drawing_says_what_it_shows(
    evidence: ResultSet, name: str, of: object, options: dict, said: tuple[str, ...]
) -> None:
    svg = drawn(evidence, name, of, options)
    text = text_of(svg)
    for word in said:
        assert word in text or word in re.sub(r"\s+", " ", text), f"{word!r} in {text!r}"
    assert "<image" not in svg
    assert "nan" not in text
    assert len(svg) < 150_000


@pytest.mark.one_in(30)
@pytest.mark.parametrize("case", CASES, ids=[f"{c[0]}-{i}" for i, c in enumerate(CASES)])
def test_a_drawing_is_the_same_twice(evidence: ResultSet, case: Any) -> None:
    name, of, options, _ = case
    assert drawn(evidence, name, of, options) == drawn(evidence, name, of, options)


def test_every_drawing_of_grids_is_tried() -> None:
    ours = {"bench", "difference", "lines", "maps", "orbits", "schematic", "senses", "theory", "what_matters"}
    elsewhere = {
        "schematic",
        "torque_reach",
        "what_explains",
        "phase_plane",
        "cycle_spectra",
    }  # of motion, of campaigns
    elsewhere |= {"axis_lines", "equal_loudness", "touch_thresholds"}  # of plots, of remedies
    drawings = {name for name, module in MODULES.items() if module in ours}
    assert drawings - elsewhere == {case[0] for case in CASES}


def test_a_map_writes_every_value_of_its_column(evidence: ResultSet) -> None:
    text = text_of(drawn(evidence, "grid_map", "small", {}))
    for row in evidence["small"].rows("cells"):
        assert number(1e3 * row["p2p_rad"]) in text


@pytest.mark.parametrize(
    ("name", "of", "options", "message"),
    [
        ("grid_map", "small", {"column": "loudness"}, "no column loudness"),
        ("sensory_surface", "small", {}, "the sound of 'small' has no level"),
        ("grid_map", "small", {"across": "hand.stiffness"}, "no axis hand.stiffness"),
        ("grid_map", "nowhere", {}, "no result 'nowhere'"),
        ("grid_map", "bench", {}, "no grid"),
        ("grid_map", "three", {}, "varies over hand.stiffness, too"),
        ("grid_map", "dfa", {"where": {"method": "df9"}}, "no cell where"),
        ("grid_map", "dfa", {"where": {"method": "df1", "sound": 1}}, "no column sound"),
        ("grid_pair", "small", {"columns": ["p2p_rad", "loudness"]}, "no column loudness"),
        ("grid_difference", ["dfa", "bias"], {"where": {"method": "df1"}}, "'bias'"),
        ("grid_difference", ["dfa", "row"], {"where": {"method": "df1"}}, "no cell in common"),
        ("grid_lines", "small", {"error": "loudness"}, "no column loudness"),
        ("saturated_map", "small", {"column": "loudness"}, "no column loudness"),
        ("surface", "small", {"across": "bias.torque"}, "no axis bias.torque"),
        ("surface", "growth", {}, "no limit cycle"),
        ("what_matters", "small", {}, "too few cells"),
        ("what_matters", "growth", {}, "too few cells"),
        ("what_matters", "design", {}, "has several; choose by where: {law"),
        ("staircase", "dfa", {}, "no orbits.parquet"),
        ("staircase", "small", {}, "give 'over' and 'at'"),
        ("staircase", "growth", {}, "no limit cycle"),
        ("law_lines", "small", {}, "no column law"),
        ("law_lines", "predict", {"law": "gut_feeling"}, "no cell where"),
        ("kb_plane", "predict", {}, "is no grid over wall.stiffness and wall.damping alone"),
        ("kb_plane", "small", {}, "no passivity.parquet"),
        ("cases", ["growth"], {}, "no limit cycle"),
        ("error_time", "small", {}, "no bench.parquet"),
        ("error_time", "bench", {"scenes": ["moon"]}, "no run"),
        ("stability_table", "bench", {"methods": []}, "no run"),
        ("nyquist", "bench", {}, "no scene"),
        ("hardware_grid", ["small", "dfa"], {"column": "rms_rad"}, "has several; choose by where: {method"),
    ],
)
def test_what_is_missing_is_said(evidence: ResultSet, name: str, of: object, options: dict, message: str) -> None:
    with pytest.raises(MissingError, match=re.escape(message)):
        draw(name, evidence, of, options)


def test_a_difference_is_that_of_the_analysis(evidence: ResultSet, hknob: Command, tmp_path: Path) -> None:
    folder = tmp_path / "dfa"
    settings = [AXES, "methods=[df1]", f"against={evidence['small'].folder}"]
    options = [part for setting in settings for part in ("--set", setting)]
    done = hknob("dfa", EXPERIMENTS / "dfa_hand_on_knob.yaml", *options, "-o", folder)
    assert done.returncode == 0, done.stderr
    both = ResultSet({"dfa": folder, "small": evidence["small"].folder})
    found = next(
        row
        for row in both["dfa"].rows("differences")
        if row["quantity"] == "amplitude_difference" and not row["in_domain"]
    )
    text = text_of(drawn(both, "grid_difference", ["dfa", "small"], {"amplitude": True, "where": {"method": "df1"}}))
    assert f"mean \u2212{abs(100 * found['mean']):.0f} %" in text
    assert f"standard deviation {100 * found['std']:.0f} %" in text


def test_a_grid_is_laid_out_upward(evidence: ResultSet) -> None:
    found = grid(evidence["small"], columns=("p2p_rad",))
    assert (found.across, found.down) == ("sample_rate_hz", "counts_per_rev")
    assert found.acrosses == [1000, 2000, 4000]
    assert found.downs == [256, 512]
    assert found.values("counts_per_rev")[1] == [512.0, 512.0, 512.0]


def test_numbers_of_cells() -> None:
    given = [
        (220.4, "220"),
        (0.036, "0.0360"),
        (-5.0, "\u22125.00"),
        (0.0, "0"),
        (3.6e-5, "3.60e\u22125"),
        (123456.0, "123456"),
    ]
    assert [number(value) for value, _ in given] == [text for _, text in given]


@pytest.mark.parametrize(("low", "high"), [(60.0, 755.0), (0.04, 220.0), (0.2, 4.9), (1e-9, 1e6), (1.0, 1.01)])
def test_ticks_of_a_log_scale_are_few_and_within_it(low: float, high: float) -> None:
    ticks, texts = log_ticks(low, high)
    assert 1 <= len(ticks) <= 6
    assert len(texts) == len(set(texts)) == len(ticks)
    assert all(0.999 * low <= tick <= 1.001 * high for tick in ticks)


def test_of_several_cycles_in_a_cell_the_largest_is_drawn(evidence: ResultSet) -> None:
    result = evidence["several"]
    rows = result.rows("dfa")
    assert max(row["orbit"] for row in rows) > 0
    for cell in rows_of(result, {"method": "sampled"}):
        sizes = [row["p2p_rad"] for row in rows if all(row[axis] == cell[axis] for axis in result.axes)]
        assert cell["p2p_rad"] == max(sizes)
    text = text_of(drawn(evidence, "grid_map", "several", {}))
    assert number(1e3 * max(row["p2p_rad"] for row in rows)) in text
    first = {"where": {"method": "sampled", "orbit": 0}}
    assert {cell["orbit"] for cell in rows_of(result, first["where"])} == {0}
    assert text_of(drawn(evidence, "grid_map", "several", first)) != text


def test_a_map_of_the_largest_cycles_has_the_mean_beside_them(evidence: ResultSet) -> None:
    """Of 455 Hz and 256 counts, where two cycles coexist with rest, which is in no mean."""
    cell = next(row for row in evidence["pushed"].rows("cells") if row["counts_per_rev"] == 256)
    assert 0.0 < cell["at_rest_fraction"] < 1.0
    text = text_of(drawn(evidence, "grid_map", "pushed", {"column": "p2p_max_rad"}))
    assert f"{1e3 * cell['p2p_max_rad']:.1f} ({1e3 * cell['p2p_rad']:.1f})" in text
    assert "in brackets: the mean of the trials that cycle" in text
    assert "rest: trials that come to rest" in text
