"""``hknob remedies`` over a further axis of the scene: for every remedy where it helps and where it harms."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from hknob_cli.specs.load import load
from tests.cli.test_remedies import SMALL

OVER = SMALL[: SMALL.index("cases:")].replace("sample_rate_hz: [1000, 2000]", "sample_rate_hz: 1000").replace(
    "counts_per_rev: [360, 1024]", "counts_per_rev: 2650\n    knob.inertia: [20 g*cm^2, 200 g*cm^2]"
).replace("phases: 4", "phases: 2") + SMALL[SMALL.index("remedies:\n  plain") :].replace(
    "time_constant: 0.05", "time_constant: 0.2"
)


def test_a_remedy_that_helps_a_light_knob_and_harms_a_heavy_one_is_seen_to(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("remedies", spec_file(OVER), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert "over knob.inertia: times smaller, for the hand and cell that gain least" in done.stdout
    table = done.stdout[done.stdout.index("over knob.inertia: times smaller") :].splitlines()
    line = next(line for line in table if line.startswith("bounded lag  "))
    light, heavy = line.split()[-2:]
    assert float(light) > 2.0
    assert heavy.endswith("*")
    assert float(heavy[:-1]) < 1.0
    assert "bounded lag: outside its domain in 1 row," in done.stdout
    assert "bounded lag: bounded_lag with keep 0.15 is outside its domain for 1 of 4 hands and knobs" in done.stderr
    assert "max mrad" not in done.stdout  # no cases, and no footnotes to a table that is not there
    assert (tmp_path / "out" / "remedies_knob_inertia.png").read_bytes()[:4] == b"\x89PNG"
    assert not (tmp_path / "out" / "remedies.png").exists()
    table = pq.read_table(tmp_path / "out" / "remedies.parquet")
    assert table.schema.field("knob.inertia").metadata[b"unit"] == b"kg*m^2"
    assert len(table) == 2 * 2 * 2
    said = json.loads(hknob("remedies", spec_file(OVER), "-o", "out", "--json").stdout)
    assert [row["knob.inertia"] for row in said["over"]["knob.inertia"]["bounded lag"]] == pytest.approx([2e-6, 2e-5])


def test_cases_have_the_scene_of_the_base_beside_an_axis(hknob, spec_file, tmp_path: Path) -> None:
    text = OVER.replace("remedies:\n  plain", "cases:\n  fine: {sample_rate_hz: 1000, counts_per_rev: 2650}\n"
                        "remedies:\n  plain")  # fmt: skip
    done = hknob("remedies", spec_file(text), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    for name in ("remedies.png", "remedies_knob_inertia.png"):
        assert (tmp_path / "out" / name).exists()
    assert "knob.inertia" not in pq.read_table(tmp_path / "out" / "cases.parquet").column_names


@pytest.mark.parametrize(
    ("axis", "change", "message"),
    [
        (
            "knob.inertia: [2.0e-6, 8.0e-6]",
            "{scene: {knob: {inertia: 8.0e-6}}}",
            "must not set scene.knob.inertia, which the grid of the base varies",
        ),
        ("knob.inertias: [1]", "{}", "did you mean 'knob.inertia'?"),
    ],
)
def test_an_axis_that_a_remedy_overrules_or_has_not_is_refused(hknob, spec_file, axis, change, message) -> None:
    text = OVER.replace("knob.inertia: [20 g*cm^2, 200 g*cm^2]", axis)
    start = text.index("    change:")
    text = text[:start] + f"    change: {change}\n" + text[text.index("    needs:") :]
    done = hknob("remedies", spec_file(text), "-o", "out")
    assert done.returncode == 2
    assert message in done.stderr


@pytest.mark.parametrize("axis", ["knob.coulomb_torque: [0, 1.0e-4]", "actuator.delay_samples: [0, 1]"])
def test_a_controller_goes_with_friction_and_delay_as_axes(spec_file, axis) -> None:
    text = OVER.replace("knob.inertia: [20 g*cm^2, 200 g*cm^2]", axis)
    text = text.replace("    bias:", "    actuator: {delay_samples: 0}\n    bias:")
    start = text.index("    change:")
    changed = "    change: {scene: {controller: {kind: stiffening}}}\n"
    load(spec_file(text[:start] + changed + text[text.index("    needs:") :]))


@pytest.mark.parametrize("axis", ["bias.torque: [5.0e-4, 2.0e-3]", "wall.stiffness: [0.1, 0.5]"])
def test_push_and_stiffness_are_axes_too(hknob, spec_file, axis: str) -> None:
    done = hknob("remedies", spec_file(OVER.replace("knob.inertia: [20 g*cm^2, 200 g*cm^2]", axis)), "-o", "out")
    assert done.returncode == 0, done.stderr
    assert f"over {axis.partition(':')[0]}: times smaller" in done.stdout


def test_an_axis_of_one_value_has_neither_table_nor_picture(hknob, spec_file, tmp_path: Path) -> None:
    text = OVER.replace("knob.inertia: [20 g*cm^2, 200 g*cm^2]", "knob.inertia: 20 g*cm^2")
    done = hknob("remedies", spec_file(text), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert "over knob.inertia" not in done.stdout
    assert "no picture: no cases are given, and no further axis" in done.stderr
    assert not list((tmp_path / "out").glob("*.png"))
