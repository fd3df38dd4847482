"""``hknob hw-run`` with a list of remedies: each tried in every cell, measured, and beside what was computed of it."""

import hashlib
import json
from collections import Counter
from itertools import pairwise
from pathlib import Path
from statistics import median

import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

from hknob_cli.hardware.control import control_of
from hknob_cli.hardware.order import settings_of, trials_of
from hknob_cli.hardware.wire.codes import pack_control
from tests.conftest import EXPERIMENTS, Command
from tests.forked import Forks
from tests.hardware.campaigns import SPEC, planned

LAG = "{kind: bounded_lag, keep: 0.15, time_constant: 0.2}"
DAMPED = "{kind: velocity_damping, damping: 1.0e-4, low_pass: 1 ms}"
REMEDIES = f"""\
remedies:
  plain wall: {{}}
  softer wall: {{change: {{wall: {{stiffness: 0.135}}}}, needs: half the stiffness}}
  bounded lag: {{change: {{controller: {LAG}}}, source: own}}
  damped: {{change: {{controller: {DAMPED}}}}}
"""
TRIED = SPEC + "knob: {coulomb_torque: 0}\n" + REMEDIES
COMPUTED = f"""\
kind: remedies
name: computed
base:
  scene: {{knob: {{inertia: 1.9e-6}}, wall: {{stiffness: 0.27}}, bias: {{torque: 0.001}}}}
  grid: {{sample_rate_hz: [1000, 2000], counts_per_rev: [256, 512]}}
  starts: {{angle: 0.02, phases: 3}}
hands: {{pinch: {{table: 1, grip_n: 0.71}}}}
remedies:
  plain wall: {{}}
  softer wall: {{change: {{scene: {{wall: {{stiffness: 0.135}}}}}}}}
  bounded lag: {{change: {{scene: {{controller: {LAG}}}}}}}
"""
NAMES = ["plain wall", "softer wall", "bounded lag", "damped"]
Cell = tuple[str, float, int]


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory, forks: Forks):
    """Remedies computed in a folder, and tried in another beside it; the folder of both and what was printed."""
    folder = tmp_path_factory.mktemp("tried")
    (folder / "computed.yaml").write_text(COMPUTED)
    (folder / "tried.yaml").write_text(f"{TRIED}against: {folder / 'computed'}\n")
    said = None
    for command in (["remedies", "computed.yaml", "-o", "computed"], ["hw-run", "tried.yaml", "-o", "out", "--plot"]):
        said = Command(forks, folder)(*command)
        assert said.returncode == 0, said.stderr
    return folder, said


def rows_of(path: Path) -> list[dict]:
    return pq.read_table(path).to_pylist()


def by_cell(rows: list[dict]) -> dict[Cell, dict]:
    return {(row["remedy"], row["sample_rate_hz"], row["counts_per_rev"]): row for row in rows}


@pytest.mark.long
def test_every_remedy_is_tried_once_in_every_cell_in_a_mixed_order(done) -> None:
    folder, _ = done
    trials = rows_of(folder / "out" / "trials.parquet")
    assert [row["order"] for row in trials] == list(range(1, 17))
    assert Counter(row["remedy"] for row in trials) == dict.fromkeys(NAMES, 4)
    assert len(by_cell(trials)) == 16
    blocks = sum(one["remedy"] != other["remedy"] for one, other in pairwise(trials))
    assert blocks > 8, "remedies are mixed, so that what changes with time changes for all"
    assert [row["remedy"] for row in trials] == [one.remedy for one in trials_of(planned(TRIED))]


@pytest.mark.long
def test_a_trial_says_what_acted_in_it(done) -> None:
    folder, _ = done
    plan = planned(TRIED)
    found: dict[str, set[str]] = {name: set() for name in NAMES}
    for row, trial in zip(rows_of(folder / "out" / "trials.parquet"), trials_of(plan), strict=True):
        settings = settings_of(plan, trial)
        assert (row["wall_stiffness"], row["wall_damping"]) == (settings.wall_stiffness, 0.0)
        assert row["wall_stiffness"] == (0.135 if trial.remedy == "softer wall" else 0.27)
        controller = plan.tried(trial.remedy).controller
        assert row["controller"] == (controller.words if controller else "")
        packed = pack_control(control_of(controller, settings)) if controller else b""
        assert row["control_digest"] == (hashlib.sha256(packed).hexdigest()[:16] if packed else "")
        found[trial.remedy].add(row["control_digest"])
    assert found["plain wall"] == found["softer wall"] == {""}
    assert not found["bounded lag"] & found["damped"]
    assert len(found["damped"]) > 1, "the numbers of a law are those of the cell"


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("remedy", "change"),
    [("plain wall", ()), ("softer wall", ("wall.stiffness=0.135",)), ("damped", (f"controller={DAMPED}",))],
)
def test_a_trial_is_that_of_a_campaign_of_its_own(done, hknob, tmp_path: Path, remedy: str, change: tuple) -> None:
    """The same knob, hand and push: what differs between remedies is the remedy."""
    folder, _ = done
    (tmp_path / "alone.yaml").write_text(SPEC + "knob: {coulomb_torque: 0}\n")
    sets = [part for one in change for part in ("--set", one)]
    assert hknob("hw-run", "alone.yaml", "-o", "alone", "-q", *sets).returncode == 0
    columns = ["time_s", "torque_nm", "angle_counts", "grip_n", "running"]
    place = {(row["sample_rate_hz"], row["counts_per_rev"]): row["order"] for row in alone_trials(tmp_path)}
    samples, alone = (pq.read_table(path / "samples.parquet") for path in (folder / "out", tmp_path / "alone"))
    for (name, rate, counts), row in by_cell(rows_of(folder / "out" / "trials.parquet")).items():
        if name == remedy:
            one, other = (
                table.filter(pc.equal(table["trial"], number)).select(columns)
                for table, number in ((samples, row["order"]), (alone, place[rate, counts]))
            )
            assert one.equals(other)


def alone_trials(folder: Path) -> list[dict]:
    return rows_of(folder / "alone" / "trials.parquet")


def test_measured_stands_beside_computed(done) -> None:
    folder, _ = done
    rows = rows_of(folder / "out" / "remedies.parquet")
    assert list(dict.fromkeys(row["remedy"] for row in rows)) == NAMES
    trials = by_cell(rows_of(folder / "out" / "trials.parquet"))
    computed = by_cell(rows_of(folder / "computed" / "remedies.parquet"))
    for place, row in by_cell(rows).items():
        mine, plain = trials[place], trials["plain wall", *place[1:]]
        assert (row["trials"], row["sustained"]) == (1, int(mine["sustained"]))
        assert row["p2p_rad"] == mine["p2p_rad"] > 0.0
        assert row["p2p_ratio"] == plain["p2p_rad"] / mine["p2p_rad"]
        there = computed.get(place)
        assert (there is None) == (place[0] == "damped")
        if there is None:
            assert {value for name, value in row.items() if "computed" in name} == {None}
            continue
        assert row["computed_p2p_rad"] == there["p2p_rad"]
        assert row["computed_p2p_max_rad"] == there["p2p_max_rad"]
        assert row["computed_frequency_hz"] == there["frequency_hz"]
        assert row["computed_p2p_ratio"] == pytest.approx(there["p2p_mean_ratio"], rel=1e-12)
        assert row["p2p_over_computed"] == mine["p2p_rad"] / there["p2p_rad"]
        # A trial settles on one of the cycles of the cell, whose mean is computed of three starts.
        assert 0.5 < row["p2p_over_computed"] < 2.0
        assert 0.5 < row["frequency_over_computed"] < 2.0
    lag = [row for row in rows if row["remedy"] == "bounded lag"]
    assert min(row["p2p_ratio"] for row in lag) > 2.0
    assert min(row["computed_p2p_ratio"] for row in lag) > 2.0
    assert {row["needs"] for row in rows if row["remedy"] == "softer wall"} == {"half the stiffness"}


def test_what_is_printed(done, hknob) -> None:
    folder, said = done
    lines = said.stdout.splitlines()
    rows = rows_of(folder / "out" / "remedies.parquet")
    assert lines[0].startswith("bench: 16 trials, 16 with sustained buzz")
    assert said.stderr == f"bench: not computed in {folder / 'computed'}: damped\n"
    times = {name: [row["p2p_ratio"] for row in rows if row["remedy"] == name] for name in NAMES}
    best = (
        f"Smallest buzz: bounded lag, {median(times['bounded lag']):.3g} times smaller (median of the cells; at least"
    )
    assert best in " ".join(said.stdout.split())
    assert [line for line in lines if line.startswith("bounded lag ") and " 4/4 " in line]
    wrote = [line.partition("out/")[2] for line in lines if line.startswith("wrote ")]
    tables = ["samples.parquet", "trials.parquet", "timing.parquet", "remedies.parquet"]
    assert wrote == [*tables, "hw_run.png", "timing.png", "remedies.png"]
    again = hknob("hw-run", folder / "tried.yaml", "-o", folder / "out", "--json")
    summary = json.loads(again.stdout)
    assert (summary["status"], summary["reference"]) == ("up to date", "plain wall")
    assert {row["remedy"] for row in summary["remedies"]} == set(NAMES)
    assert {row["remedy"] for row in summary["cells"]} == set(NAMES)
    lag = next(row for row in summary["remedies"] if row["remedy"] == "bounded lag")
    assert (lag["trials"], lag["times_least"]) == (4, min(times["bounded lag"]))


def test_trials_are_the_same_without_a_comparison(done, hknob, tmp_path: Path) -> None:
    folder, _ = done
    (tmp_path / "tried.yaml").write_text(TRIED)
    alone = hknob("hw-run", "tried.yaml", "-o", "out")
    assert alone.returncode == 0, alone.stderr
    assert "comp." not in alone.stdout
    one, other = (pq.read_table(base / "out" / "samples.parquet") for base in (folder, tmp_path))
    assert one.equals(other)
    assert "computed_p2p_rad" not in pq.read_schema(tmp_path / "out" / "remedies.parquet").names


def test_replayed_trials_are_told_apart_by_their_torque(done, hknob, tmp_path: Path) -> None:
    folder, _ = done
    text = TRIED.replace("person: {wandering_push: false, grip_wander: false}\n", "")
    text = text.replace("knob: {coulomb_torque: 0}\n", "") + "seed: 5\norder: grid\n"
    (tmp_path / "again.yaml").write_text(text + f"device: {{driver: replay, recordings: [{folder / 'out'}]}}\n")
    replayed = hknob("hw-run", "again.yaml", "-o", "replayed")
    assert replayed.returncode == 0, replayed.stderr
    one, other = (by_cell(rows_of(base / "trials.parquet")) for base in (folder / "out", tmp_path / "replayed"))
    assert one.keys() == other.keys()
    for place, row in one.items():
        assert other[place]["p2p_rad"] == row["p2p_rad"]


@pytest.mark.long
def test_both_in_a_pipeline(hknob, tmp_path: Path) -> None:
    (tmp_path / "computed.yaml").write_text(COMPUTED.replace("phases: 3", "phases: 1"))
    (tmp_path / "tried.yaml").write_text(TRIED)
    (tmp_path / "line.yaml").write_text(
        "kind: pipeline\nname: line\nstages:\n  computed: {spec: computed.yaml}\n"
        "  tried: {spec: tried.yaml, set: {against: {from: computed}}}\n"
    )
    assert hknob("check", "line.yaml").returncode == 0, "before there is anything to compare with"
    done = hknob("run", "line.yaml", "--json")
    assert done.returncode == 0, done.stderr
    assert [stage["status"] for stage in json.loads(done.stdout)["stages"]] == ["computed", "computed"]
    rows = rows_of(tmp_path / "results" / "line" / "tried" / "remedies.parquet")
    assert sum(row["computed_p2p_rad"] is not None for row in rows) == 12
    assert "2 up to date" in hknob("run", "line.yaml").stdout


def test_a_page_of_it(done, hknob) -> None:
    folder, _ = done
    (folder / "page.yaml").write_text(
        "kind: report\nname: page\ntitle: Tried\nresults: {tried: FOLDER}\n".replace("FOLDER", str(folder / "out"))
    )
    made = hknob("report", folder / "page.yaml", "-o", folder / "page")
    assert made.returncode == 0, made.stderr
    page = (folder / "page" / "report.html").read_text()
    assert "tried: Smallest buzz: bounded lag" in page
    assert "remedies, as measured and as computed" in page
    assert "motion, plain wall" in page


FAULTS = {
    "what is no part of a device": (
        "softer wall: {change: {wall: {stiffness: 0.135}}", "softer wall: {change: {knob: {inertia: 1}}",
        "remedies.softer wall.change.knob: must not be changed by a remedy on a knob",
    ),
    "an encoder that no device has": (
        DAMPED, f"{DAMPED}, encoder: {{hysteresis_counts: 0.5}}",
        "remedies.damped.change.encoder.hysteresis_counts: must be one that a device can run",
    ),
    "another law's number": (
        DAMPED, "{kind: stiffening, keep: 0.2}",
        "remedies.damped.change.controller.keep: must be absent where kind is stiffening",
    ),
    "a number beyond its range": (
        "stiffness: 0.135", "stiffness: -1",
        "remedies.softer wall.change.wall.stiffness: must be >= 0",
    ),
    "an unknown key": (
        "stiffness: 0.135", "stifness: 0.1",
        "remedies.softer wall.change.wall.stifness: unknown key; did you mean 'stiffness'?",
    ),
    "no wall under a controller": (
        f"controller: {LAG}", f"controller: {LAG}, wall: {{stiffness: 0}}",
        "remedies.bounded lag.change.wall.stiffness: must be > 0 where a controller is given",
    ),
    "no reference": ("  plain wall: {}\n", "", "reference: must be one of remedies (softer wall, bounded lag, damped)"),
    "too many trials": ("buzz: [0.1", "buzz: [0.1", "grid: must be at most 1000 trials with repeats and remedies, got"),
    "a hand of no folder": ("remedies:", "hand: pinch\nremedies:", "hand: must be absent without against"),
}  # fmt: skip


@pytest.mark.parametrize("what", FAULTS)
def test_a_fault_is_where_it_was_written(hknob, tmp_path: Path, what: str) -> None:
    old, new, says = FAULTS[what]
    assert old in TRIED
    text = TRIED.replace(old, new) + ("repeats: 63\n" if what == "too many trials" else "")
    (tmp_path / "tried.yaml").write_text(text)
    done = hknob("check", "tried.yaml")
    assert (done.returncode, done.stdout) == (2, "")
    assert says in done.stderr
    (line,) = done.stderr.splitlines()
    place = int(line.split(":")[1])
    if "change" in says:
        assert text.splitlines()[place - 1].startswith(f"  {says.split('.')[1]}: ")


@pytest.mark.parametrize("key", ["reference: plain wall", "against: computed", "hand: pinch"])
def test_what_goes_with_remedies_alone(hknob, tmp_path: Path, key: str) -> None:
    (tmp_path / "spec.yaml").write_text(f"{SPEC}{key}\n")
    done = hknob("check", "spec.yaml")
    assert done.returncode == 2
    assert f"{key.partition(':')[0]}: must be absent without remedies" in done.stderr


@pytest.mark.long
def test_what_cannot_be_compared_is_said_before_a_trial(done, hknob, tmp_path: Path) -> None:
    folder, _ = done
    two = COMPUTED.replace("hands: {pinch: {table: 1, grip_n: 0.71}}", "hands: {a: {table: 1, grip_n: 0.71}, b: {}}")
    (tmp_path / "two.yaml").write_text(two.replace("phases: 3", "phases: 1"))
    assert hknob("remedies", "two.yaml", "-o", "two", "-q").returncode == 0
    (tmp_path / "tried.yaml").write_text(TRIED)
    there = str(folder / "computed")
    cases = {
        ("against=nowhere",): "against: nowhere/remedies.parquet is not there or cannot be read; run the trial of",
        (f"against={folder / 'out'}",): "remedies.parquet is not the result of a trial of remedies",
        (f"against={there}", "hand=fist"): "has no hand 'fist'; it has pinch",
        ("against=two",): "has several hands; give one of them as 'hand': a, b",
        (f"against={there}", "grid.sample_rate_hz=[3000]"): "has no cell of this grid",
        (
            f"against={there}",
            "reference=x",
            "remedies={x: {}}",
        ): "has none of these remedies; it has plain wall, softer",
    }
    for sets, says in cases.items():
        refused = hknob("hw-run", "tried.yaml", "-o", "out", *(part for one in sets for part in ("--set", one)))
        assert (refused.returncode, refused.stdout) == (2, ""), sets
        assert says in refused.stderr
        assert not (tmp_path / "out" / "recording").exists()
    assert hknob("hw-run", "tried.yaml", "-o", "out", "-q", "--set", "against=two", "--set", "hand=a").returncode == 0


def test_the_experiment_is_good_and_lists_the_same_remedies(hknob) -> None:
    from hknob_cli.specs.load import load

    done = hknob("check", EXPERIMENTS / "remedy_on_knob.yaml")
    assert done.returncode == 0, done.stderr
    tried, computed = (load(EXPERIMENTS / f"{name}.yaml") for name in ("ch8_hardware_remedies", "ch8_remedies"))
    assert [one.name for one in tried.tries] == [one.name for one in computed.remedies]
    for one, other in zip(tried.tries, computed.remedies, strict=True):
        scene = other.grid.scene
        assert (one.controller, *one.wall) == (scene.controller, scene.wall.stiffness, scene.wall.damping)
        assert (one.needs, one.source) == (other.needs, other.source)
    assert {name: list(map(float, values)) for name, values in tried.axes.items()} == {
        name: list(map(float, computed.remedies[0].grid.axes[name])) for name in tried.axes
    }
