"""``perceive`` in a sweep through the command: table, picture, files, and what they depend on."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.conftest import EXPERIMENTS, SPEC

GRID = SPEC.replace("[1000]", "[500, 1000]").replace("[1024]", "[128, 1024]")
BLOCK = "perceive: {knob_radius: 8.9 mm}\n"
GAIN = "perceive: {knob_radius: 8.9 mm, sound_gain: 0.02 Pa/(rad/s)}\n"


def test_the_table_says_what_is_felt_and_heard(hknob, spec_file) -> None:
    done = hknob("sweep", spec_file(GRID + GAIN), "-o", "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert "touch, dB above threshold (the harmonic of a cycle that is felt best)" in done.stdout
    assert "sound, dB above threshold (the most audible harmonic)" in done.stdout
    assert "felt in 4 of 4 cells with a level, by " in done.stdout
    assert "heard in 4 of 4 cells with a level, by " in done.stdout
    assert "torque step of a count: 41.5 dB above the least variation detected (2 cells are outside" in done.stdout


def test_a_level_of_touch_says_how_well_it_is_known(hknob, spec_file) -> None:
    done = hknob("sweep", spec_file(SPEC + BLOCK), "-o", "out")
    lines = done.stdout.splitlines()
    (felt,) = (i for i, line in enumerate(lines) if line.startswith("felt in"))
    assert " to " not in lines[felt]  # of one cell there is one level
    assert "known to about 2 dB within one set of thresholds, to about 25 dB between sets" in lines[felt + 1]


def test_without_a_gain_sound_is_relative_and_says_so(hknob, spec_file) -> None:
    done = hknob("sweep", spec_file(GRID + BLOCK), "-o", "out")
    assert "sound, relative dB (no sound gain given: only differences mean something)" in done.stdout
    assert "heard" not in done.stdout


def test_a_list_has_the_levels_too(hknob, spec_file) -> None:
    done = hknob("sweep", spec_file(SPEC + BLOCK), "-o", "out")
    assert "touch dB" in done.stdout
    plain = hknob("sweep", spec_file(SPEC, "plain.yaml"), "-o", "plain")
    assert "touch" not in plain.stdout


@pytest.mark.long
def test_pictures_of_a_grid_and_of_a_line(hknob, spec_file, tmp_path: Path) -> None:
    sizes = {}
    for name, text in (("plain", GRID), ("touch", GRID + BLOCK), ("both", GRID + GAIN), ("line", SPEC + GAIN)):
        done = hknob("sweep", spec_file(text), "-o", name, "--plot", "--force")
        assert (done.returncode, done.stderr) == (0, "")
        data = (tmp_path / name / "grid.png").read_bytes()
        sizes[name] = int.from_bytes(data[16:20]), int.from_bytes(data[20:24])  # of PNG's first chunk
    assert sizes["touch"] == sizes["both"]
    assert sizes["touch"][0] == sizes["plain"][0]
    assert sizes["touch"][1] > 1.3 * sizes["plain"][1]  # a row more; the notes below stay as they are


def test_results_are_the_same_bytes_and_depend_on_the_thresholds(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file(GRID + GAIN)
    for out, jobs in (("a", 1), ("b", 2)):
        assert hknob("sweep", spec, "-o", out, "-j", jobs).returncode == 0
    for name in ("cells.parquet", "orbits.parquet"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    assert "(up to date)" in hknob("sweep", spec, "-o", "a").stdout
    record = json.loads(pq.read_schema(tmp_path / "a" / "cells.parquet").metadata[b"hknob.provenance"])
    assert len(record["inputs"]["perception_sha256"]) == 64
    hknob("sweep", spec_file(GRID, "plain.yaml"), "-o", "plain")
    plain = json.loads(pq.read_schema(tmp_path / "plain" / "cells.parquet").metadata[b"hknob.provenance"])
    assert "perception_sha256" not in plain["inputs"]


def test_settings_reach_the_block(hknob, spec_file) -> None:
    spec = spec_file(SPEC + BLOCK)
    levels = {}
    for name in ("pen_hold", "thenar"):
        done = hknob("sweep", spec, "--set", f"perceive.touch.thresholds={name}", "--json", "-o", name)
        levels[name] = json.loads(done.stdout)["cells"][0]["touch_db"]
    assert levels["pen_hold"] > levels["thenar"]  # a probe into the thumb is felt less
    done = hknob("sweep", spec, "--set", "perceive.knob_radius=-1 mm", "-o", "bad")
    assert done.returncode == 2
    assert "perceive.knob_radius: must be > 0" in done.stderr


def test_the_main_grid_is_felt_everywhere(hknob) -> None:
    """The finding of the experiment: no rate and no resolution of the grid brings a cycle below threshold."""
    done = hknob("sweep", EXPERIMENTS / "hand_on_knob_perceived.yaml", "--json", "-o", "out")
    cells = json.loads(done.stdout)["cells"]
    assert len(cells) == 49
    assert all(row["touch_db"] > 0.0 and row["felt_fraction"] == 1.0 for row in cells)


def test_a_page_shows_the_levels(hknob, spec_file, tmp_path: Path) -> None:
    assert hknob("sweep", spec_file(GRID + GAIN), "-o", "felt").returncode == 0
    page = "kind: report\nname: page\ntitle: Felt\nresults: {small: felt}\n"
    done = hknob("report", spec_file(page, "page.yaml"), "-o", "out")
    assert done.returncode == 0, done.stderr
    figures = {path.name for path in (tmp_path / "out" / "figures").iterdir()}
    assert {"fig-small-touch.svg", "fig-small-sound.svg"} <= figures
    assert "touch, dB above threshold" in (tmp_path / "out" / "figures" / "fig-small-touch.svg").read_text()
