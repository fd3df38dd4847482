"""Sweeps over populations, and hands from files, through the command: columns, summaries, determinism, pipelines."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from hknob_cli.printed import grasps
from hknob_cli.specs.load import load
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import SPEC
from tests.identified import PEOPLE, condition, conditions, write_conditions

HAND = "  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n"


def spec(population: str) -> str:
    text = SPEC.replace(HAND, "").replace("[1024]", "[1024, 4096]")
    return f"{text}population: {{{population}}}\n"


TABLE = spec("table: 1, grip_n: 0.71, people: 5, seed: 7")
SUBJECTS = spec("from: hands, spread: subjects")
DRAWN = spec("from: hands, people: 5")


def rows(folder: Path, file: str = "cells") -> list[dict]:
    return pq.read_table(folder / f"{file}.parquet").to_pylist()


def three(row: dict) -> tuple[float, ...]:
    return row["hand_inertia_kg_m2"], row["hand_damping_nm_s_per_rad"], row["hand_stiffness_nm_per_rad"]


@pytest.fixture
def hands(tmp_path: Path) -> Path:
    return write_conditions(tmp_path / "hands" / "conditions.parquet")


def test_every_cell_is_swept_for_every_person(hknob, spec_file, tmp_path) -> None:
    done = hknob("sweep", spec_file(TABLE), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert "drawn independently" in done.stderr
    assert "1024" in done.stdout
    assert "buzz %" in done.stdout
    cells, orbits = rows(tmp_path / "out"), rows(tmp_path / "out", "orbits")
    assert list(cells[0])[:6] == ["sample_rate_hz", "counts_per_rev", "person", *list(cells[0])[3:6]]
    assert [(row["counts_per_rev"], row["person"]) for row in cells] == [
        (c, p) for c in (1024, 4096) for p in range(1, 6)
    ]
    assert [three(row) for row in cells[:5]] == [three(row) for row in cells[5:]]
    assert len({three(row) for row in cells}) == 5
    assert {three(row) for row in orbits} == {three(row) for row in cells}
    assert (tmp_path / "out" / "grid.png").stat().st_size > 10_000
    field = pq.read_schema(tmp_path / "out" / "cells.parquet").field("hand_damping_nm_s_per_rad")
    assert field.metadata[b"unit"] == b"N*m*s/rad"


def test_a_person_is_that_hand(hknob, spec_file, tmp_path, hands) -> None:
    assert hknob("sweep", spec_file(SUBJECTS), "-o", "people").returncode == 0
    people = rows(tmp_path / "people")
    assert [three(row) for row in people[:4]] == [PEOPLE[name] for name in ("s1", "s2", "s3", "s4")]
    text = SPEC.replace("[1024]", "[1024, 4096]").replace(HAND, "  hand: {from: hands, subject: s3}\n")
    assert hknob("sweep", spec_file(text, "one.yaml"), "-o", "one").returncode == 0
    for one, person in zip(rows(tmp_path / "one"), (people[2], people[6]), strict=True):
        assert one == {name: person[name] for name in one}


def test_the_summary_is_over_people(hknob, spec_file, tmp_path, hands) -> None:
    done = hknob("sweep", spec_file(SUBJECTS), "-o", "out", "--json")
    summary = json.loads(done.stdout)
    assert summary["axes"]["person"] == [1, 2, 3, 4]
    first, _ = summary["population"]
    sizes = sorted(row["p2p_max_rad"] for row in rows(tmp_path / "out")[:4])
    assert first["people"] == 4
    assert first["buzzing_fraction"] == sum(size > 0 for size in sizes) / 4
    assert first["p2p_max_rad_median"] == pytest.approx(0.5 * (sizes[1] + sizes[2]))
    assert first["p2p_max_rad_p95"] == pytest.approx(sizes[2] + 0.85 * (sizes[3] - sizes[2]))
    assert first["counts_per_rev"] == 1024


def test_the_same_seed_is_the_same_bytes_however_it_is_run(hknob, spec_file, tmp_path) -> None:
    path = spec_file(TABLE)
    for jobs in (1, 2):
        assert hknob("sweep", path, "-o", f"out{jobs}", "-j", jobs, "-q").returncode == 0
    for file in ("cells.parquet", "orbits.parquet"):
        assert (tmp_path / "out1" / file).read_bytes() == (tmp_path / "out2" / file).read_bytes()
    again = hknob("sweep", path, "-o", "out1", "--json")
    assert json.loads(again.stdout)["status"] == "up to date"
    other = hknob("sweep", path, "-o", "out3", "-q", "--set", "population.seed=8")
    assert other.returncode == 0
    assert not {three(row) for row in rows(tmp_path / "out3")} & {three(row) for row in rows(tmp_path / "out1")}


def test_threads_change_nothing(spec_file, monkeypatch) -> None:
    monkeypatch.setattr("hknob_cli.stages.sweep.run.THREADS_ABOVE", 0)
    plan = load(spec_file(TABLE))
    one, two = (SweepStage(plan, jobs=jobs).run() for jobs in (1, 2))
    assert one == two


@pytest.mark.parametrize("text", [SUBJECTS, DRAWN])
def test_the_order_of_subjects_in_the_file_does_not_matter(hknob, spec_file, tmp_path, text) -> None:
    path = spec_file(text)
    found = []
    for i, people in enumerate((PEOPLE, dict(reversed(PEOPLE.items())))):
        write_conditions(tmp_path / "hands" / "conditions.parquet", conditions(people))
        assert hknob("sweep", path, "-o", f"out{i}", "-q").returncode == 0
        found.append(rows(tmp_path / f"out{i}"))
    assert found[0] == found[1]


def test_a_changed_file_is_swept_again_and_a_flagged_row_is_said(hknob, spec_file, tmp_path, hands) -> None:
    for text, key in ((DRAWN, "population_sha256"), (SPEC.replace(HAND, "  hand: {from: hands}\n"), "hand_sha256")):
        write_conditions(hands)
        path = spec_file(text)
        assert json.loads(hknob("sweep", path, "-o", key, "--json").stdout)["status"] == "computed"
        quiet = hknob("sweep", path, "-o", key, "--json")
        assert json.loads(quiet.stdout)["status"] == "up to date"
        assert "warning" not in quiet.stderr
        write_conditions(hands, conditions(flags="drift"))
        again = hknob("sweep", path, "-o", key, "--json")
        assert json.loads(again.stdout)["status"] == "computed"
        assert "warning: a hand is used although flagged: " in again.stderr
        record = json.loads(pq.read_schema(tmp_path / key / "cells.parquet").metadata[b"hknob.provenance"])
        assert len(record["inputs"][key]) == 64
        assert "used although flagged" in record["inputs"]["hand_notes"]


def test_means_alone_are_drawn_without_correlations_and_said(hknob, spec_file, tmp_path, hands) -> None:
    write_conditions(hands, conditions()[-1:])
    done = hknob("sweep", spec_file(DRAWN), "-o", "out")
    assert done.returncode == 0
    assert "has no subjects; inertia, damping, stiffness are drawn independently" in done.stderr


def test_a_mean_inertia_below_0_is_drawn_with_the_apparatus(hknob, spec_file, tmp_path) -> None:
    done = hknob("sweep", spec_file(TABLE.replace("0.71", "14.2")), "-o", "out")
    assert done.returncode == 0
    assert "drawn with the apparatus' 1.98e-06" in done.stderr
    mean = next(grasp for grasp in grasps(1) if grasp.grip_n == 14.2).inertia
    assert all(abs(row["hand_inertia_kg_m2"] - mean) < 5 * 6.83e-8 for row in rows(tmp_path / "out"))


@pytest.mark.parametrize(
    ("population", "fault"),
    [
        ("people: 5", "population: must have exactly one of 'from' and 'table'"),
        ("table: 1, from: hands", "population: must have exactly one of 'from' and 'table'"),
        ("table: 1", "population: must have 'grip_n' beside 'table'"),
        ("table: 1, grip_n: 0.72", "population.grip_n: must be a grip force of Tables 1-5, 0.71, 1.3"),
        ("table: 1, grip_n: 0.71, spread: subjects", "population.spread: must be absent where people are of a table"),
        ("from: hands, spread: normal", "population.spread: must be 'lognormal' or 'subjects', got 'normal'"),
        ("from: hands, spread: subjects, people: 3", "population.people: must be absent where the people are the"),
        ("from: hands, people: 0", "population.people: must be >= 1, got 0"),
        ("from: hands, grip_n: 1.0", "population.grip_n: must be 0.71, got 1"),
        ("from: hands, experiment: 2", "population.experiment: must be '1', got '2'"),
        ("from: hands, subject: s1", "population.subject: unknown key"),
        ("from: nowhere", "population.from: "),
        ("from: hands, people: 100000", ""),
    ],
)
def test_faults_have_their_place(hknob, spec_file, hands, population: str, fault: str) -> None:
    text = spec(population)
    if not fault:
        text = text.replace("[1024, 4096]", "{lin: [500, 2000, 20]}")
        fault = "population: must span at most 1000000 cells with the grid, got 2000000"
    done = hknob("check", spec_file(text))
    assert done.returncode == 2
    assert "spec.yaml:11:" in done.stderr
    assert fault in done.stderr


@pytest.mark.parametrize(
    ("people", "fault"),
    [
        (conditions()[:1], "population.from: has one subject, whose spread is unknown"),
        ([condition((1e-7, 1e-4, 0.1), (None, None, None))], "population.from: has no subjects, and no standard"),
        (
            conditions({"a": (-2e-6, 1e-4, 0.1), "b": (-2e-6, 2e-4, 0.1)}),
            "population.from: has a mean inertia of -2e-06",
        ),
        (
            conditions({"a": (-1.9e-6, 1e-4, 0.1), "b": (-1.9e-6, 2e-4, 0.1)}),
            "population: must leave an inertia above 0",
        ),
        (conditions(apparatus_inertia_kg_m2=None), "population.subtract_apparatus: missing, and required"),
        (conditions() * 2, "population.from: has several rows for a subject"),
    ],
)
def test_files_without_a_spread_are_faults(hknob, spec_file, hands, people, fault: str) -> None:
    write_conditions(hands, people)
    done = hknob("sweep", spec_file(DRAWN), "-o", "out")
    assert done.returncode == 2
    assert fault in done.stderr


def test_a_population_is_the_hand(hknob, spec_file) -> None:
    done = hknob("check", spec_file(TABLE.replace("  wall:", f"{HAND}  wall:")))
    assert "scene.hand: must be absent where a population is given" in done.stderr
    done = hknob("check", spec_file(TABLE.replace("grid:\n", "grid:\n  hand.damping: [1e-3]\n")))
    assert "must vary a part of the scene, which has no 'hand'" in done.stderr
    done = hknob("check", spec_file(TABLE + "growth: {duration: 1.0}\n"))
    assert "growth: must be absent where a population is given" in done.stderr


def test_a_pipeline_hands_them_over(hknob, spec_file, tmp_path, hands) -> None:
    spec_file(SPEC.replace(HAND, "  hand: {from: elsewhere, subject: s2}\n"), "one.yaml")
    spec_file(DRAWN.replace("from: hands", "from: elsewhere"), "people.yaml")
    text = (
        "kind: pipeline\nname: both\nstages:\n  sysid: {folder: hands}\n"
        "  one: {spec: one.yaml, set: {scene.hand.from: {from: sysid}}}\n"
        "  people: {spec: people.yaml, set: {population.from: {from: sysid}}}\n"
    )
    path = spec_file(text, "pipeline.yaml")
    assert hknob("run", path).returncode == 0
    assert len(rows(tmp_path / "results" / "both" / "people")) == 10
    record = json.loads(pq.read_schema(tmp_path / "results/both/one/cells.parquet").metadata[b"hknob.provenance"])
    assert record["spec"]["scene"]["hand"] == {"from": {"from": "sysid"}, "subject": "s2"}
    assert json.loads(record["inputs"]["hand"]) == {"inertia": 1.5e-7, "damping": 3.6e-4, "stiffness": 0.045}
    again = json.loads(hknob("run", path, "--json").stdout)
    assert {stage["status"] for stage in again["stages"]} == {"up to date"}
    write_conditions(hands, conditions({**PEOPLE, "s2": (1e-7, 1e-3, 0.1)}))
    changed = json.loads(hknob("run", path, "--json").stdout)
    assert {stage["status"] for stage in changed["stages"]} == {"computed"}


def test_a_page_shows_the_people(hknob, spec_file, tmp_path, hands) -> None:
    assert hknob("sweep", spec_file(SUBJECTS), "-o", "people", "-q").returncode == 0
    page = spec_file("kind: report\nname: page\nresults: {people: people}\n", "page.yaml")
    done = hknob("report", page, "-o", "page")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "page" / "report.html").read_text()
    assert "people who have at most this" in text
    assert "frequency, Hz, where it buzzes" in text
