"""``hknob hw-run`` through the installed command, on the virtual device."""

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from hknob_cli.hardware.order import trials_of
from hknob_cli.recordings.columns import KEYS, SAMPLES
from hknob_cli.recordings.read import read
from tests.conftest import EXPERIMENTS, Command
from tests.hardware.campaigns import SPEC, planned

FILES = ("samples.parquet", "trials.parquet", "timing.parquet")


@pytest.fixture(scope="module")
def done(tmp_path_factory, forks):
    """A small campaign, run once: its folder and what was printed."""
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "spec.yaml").write_text(SPEC)
    said = Command(forks, folder)("hw-run", folder / "spec.yaml", "-o", folder / "out", "--plot")
    assert said.returncode == 0, said.stderr
    return folder, said


def test_what_is_printed(done) -> None:
    folder, said = done
    assert said.stderr == ""
    lines = said.stdout.splitlines()
    assert lines[0].startswith("bench: 4 trials, 4 with sustained buzz; grip 0.6")
    assert "peak to peak, mrad (mean peak minus mean trough)" in lines
    assert "frequency, Hz (cycles per second, as a sweep counts them)" in lines
    assert [line for line in lines if line.endswith("samples, 0 missing, 0 late in the loop")]
    for name in (*FILES, "hw_run.png", "timing.png"):
        assert f"wrote {folder / 'out' / name}" in lines
    assert {path.name for path in (folder / "out").iterdir()} == {*FILES, "hw_run.png", "timing.png", ".hknob.lock"}


def test_the_grip_is_laid_out_as_table_8(done) -> None:
    folder, said = done
    lines = said.stdout.splitlines()
    start = lines.index("grip force, N")
    table = [line.split() for line in lines[start + 2 : start + 7]]
    assert table[0] == ["1000", "2000", "mean", "std", "dev"]
    rows = pq.read_table(folder / "out" / "trials.parquet").to_pylist()
    force = {(row["counts_per_rev"], row["sample_rate_hz"]): row["grip_mean_n"] for row in rows}
    for line, counts in zip(table[1:3], (256, 512), strict=True):
        values = [force[counts, 1000], force[counts, 2000]]
        numbers = [*values, np.mean(values), np.std(values, ddof=1)]
        assert line == [str(counts), *(f"{number:.2f}" for number in numbers)]
    assert table[3][0] == "mean"
    assert table[3][-1] == f"{np.mean(list(force.values())):.2f}"
    assert table[4][:2] == ["std", "dev"]
    assert table[4][-1] == f"{np.std(list(force.values()), ddof=1):.2f}"


def test_samples_are_a_recording(done) -> None:
    folder, _ = done
    path = folder / "out" / "samples.parquet"
    schema = pq.read_schema(path)
    more = ("sample_rate_hz", "counts_per_rev", "sample", "device_time_us", "angle_counts", "running")
    assert tuple(schema.names) == (*(column.name for column in (*KEYS, *SAMPLES)), *more)
    assert all(schema.field(name).metadata[b"meaning"] for name in schema.names)
    assert schema.field("device_time_us").metadata[b"unit"] == b"us"
    recorded = read([path])
    assert [(trial.key.block, trial.key.trial) for trial in recorded] == [(1, 1), (1, 2), (1, 3), (1, 4)]
    assert {trial.key.grip_target_n for trial in recorded} == {0.71}
    table = pq.read_table(path)
    count_rad = 2 * np.pi / 640_000
    assert np.array_equal(table["angle_rad"].to_numpy(), table["angle_counts"].to_numpy() * count_rad)
    assert np.abs(np.diff(table["device_time_us"].to_numpy()[:100])).max() <= 1001


def test_trials_are_in_the_order_of_the_campaign(done) -> None:
    folder, _ = done
    table = pq.read_table(folder / "out" / "trials.parquet")
    cells = [(row["order"], row["sample_rate_hz"], row["counts_per_rev"]) for row in table.to_pylist()]
    assert cells == [(one.number, one.sample_rate_hz, one.counts_per_rev) for one in trials_of(planned())]
    for row in table.to_pylist():
        assert row["sustained"]
        assert 0 < row["rms_rad"] < row["p2p_rad"]
        assert row["grip_mean_n"] == pytest.approx(0.71, abs=0.15)  # its band
        assert (row["gaps"], row["overruns"], row["fault"], row["ended"]) == (0, 0, "", "buzz")
        assert row["native_counts"] == 640_000
    record = json.loads(table.schema.metadata[b"hknob.provenance"])
    assert (record["stage"], record["name"]) == ("hw-run", "bench")
    assert {"hknob_hardware", "scipy"} <= set(record["versions"])


def test_again_is_up_to_date_and_json(done, hknob) -> None:
    folder, _ = done
    before = {name: (folder / "out" / name).stat().st_mtime_ns for name in FILES}
    again = hknob("hw-run", folder / "spec.yaml", "-o", folder / "out", "--json")
    summary = json.loads(again.stdout)
    assert (again.returncode, summary["status"], summary["kind"]) == (0, "up to date", "hw-run")
    assert (summary["sustained"], summary["gaps"], summary["overruns"]) == (4, 0, 0)
    assert summary["grip"]["target_n"] == 0.71
    assert len(summary["trials"]) == len(summary["cells"]) == 4
    assert {name: (folder / "out" / name).stat().st_mtime_ns for name in FILES} == before
    dry = hknob("hw-run", folder / "spec.yaml", "-o", folder / "out", "--dry-run", "--set", "seed=1")
    assert dry.stdout.startswith("hw-run would run, because: the spec or the program has changed since")


def test_the_same_seed_gives_the_same_bytes(done, hknob) -> None:
    folder, _ = done
    for seed, same in ((0, True), (1, False)):
        out = folder / f"seed{seed}"
        overrides = ("--set", f"seed={seed}") if seed else ()
        assert hknob("hw-run", folder / "spec.yaml", "-o", out, "-q", *overrides).returncode == 0
        assert ((out / "samples.parquet").read_bytes() == (folder / "out" / "samples.parquet").read_bytes()) is same


def test_force_computes_anew_and_leaves_nothing_of_before(done, hknob) -> None:
    folder, _ = done
    out = folder / "forced"
    first = hknob("hw-run", folder / "spec.yaml", "-o", out)
    forced = hknob("hw-run", folder / "spec.yaml", "-o", out, "--force")
    assert "wrote" in forced.stdout
    assert first.stdout == forced.stdout
    assert {path.name for path in out.iterdir()} == {*FILES, ".hknob.lock"}


def test_replayed_trials_are_those_that_were_recorded(done, hknob) -> None:
    folder, _ = done
    text = SPEC.replace("person: {wandering_push: false, grip_wander: false}\n", "")
    (folder / "again.yaml").write_text(text + "device: {driver: replay, recordings: [out]}\n")
    replayed = hknob("hw-run", folder / "again.yaml", "-o", folder / "replayed")
    assert replayed.returncode == 0, replayed.stderr
    one, other = (pq.read_table(folder / name / "samples.parquet").to_pandas() for name in ("out", "replayed"))
    for column in ("trial", "time_s", "torque_nm", "angle_rad", "grip_n", "sample", "running"):
        # Zeros of the grip cell were subtracted in the recording: what is left of their mean is rounding.
        bound = 1e-15 if column == "grip_n" else 0.0
        assert np.allclose(one[column], other[column], rtol=0.0, atol=bound)
    # It plays what the folder has now: other samples are another input.
    record = pq.read_schema(folder / "replayed" / "trials.parquet").metadata[b"hknob.provenance"]
    assert "recording_0_samples.parquet" in json.loads(record)["inputs"]
    refused = hknob("hw-run", folder / "again.yaml", "-o", folder / "other", "--set", "wall.stiffness=0.5")
    assert refused.returncode == 4
    assert refused.stderr.startswith("trial 1 of 4 (")


LAG = "{kind: bounded_lag, keep: 0.15, time_constant: 0.2}"


def test_a_controller_runs_in_every_trial_and_its_recordings_are_told_apart(done, hknob, tmp_path: Path) -> None:
    folder, _ = done
    (tmp_path / "spec.yaml").write_text(SPEC)
    under = hknob("hw-run", "spec.yaml", "-o", "lag", "--set", f"controller={LAG}")
    assert under.returncode == 0, under.stderr
    assert "controller: bounded_lag, keep 0.15, time_constant 0.2" in under.stdout.splitlines()
    rows = pq.read_table(tmp_path / "lag" / "trials.parquet").to_pylist()
    plain = pq.read_table(folder / "out" / "trials.parquet").to_pylist()
    assert {row["controller"] for row in rows} == {"bounded_lag, keep 0.15, time_constant 0.2"}
    assert "controller" not in plain[0]
    size = {(row["sample_rate_hz"], row["counts_per_rev"]): row["p2p_rad"] for row in plain}
    assert all(row["p2p_rad"] < 0.5 * size[row["sample_rate_hz"], row["counts_per_rev"]] for row in rows)
    text = SPEC.replace("person: {wandering_push: false, grip_wander: false}\n", f"controller: {LAG}\n")
    (tmp_path / "again.yaml").write_text(text + "device: {driver: replay, recordings: [lag]}\n")
    replayed = hknob("hw-run", "again.yaml", "-o", "replayed")
    assert replayed.returncode == 0, replayed.stderr
    one, other = (pq.read_table(tmp_path / name / "samples.parquet") for name in ("lag", "replayed"))
    assert one["torque_nm"].equals(other["torque_nm"])
    refused = hknob("hw-run", "again.yaml", "-o", "plain", "--set", "controller=null")
    assert refused.returncode == 4
    assert "its torque is another" in refused.stderr


def test_nuisances_are_audited(hknob, tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text(SPEC + "nuisances: {overruns: 0.01, jitter: 20 us, grip_noise: 0.01}\n")
    done = hknob("hw-run", "spec.yaml", "-o", "out", "--json")
    summary = json.loads(done.stdout)
    assert summary["overruns"] > 10
    audited = pq.read_table(tmp_path / "out" / "timing.parquet")["missed_ticks"].to_pylist()
    assert summary["missed_ticks"] == sum(audited) > 0
    shown = hknob("hw-run", "spec.yaml", "-o", "out").stdout
    assert f"{summary['overruns']} late in the loop, which left out {sum(audited)} ticks of the clock\n" in shown
    assert [row["fault"] for row in summary["trials"]] == [
        f"the loop was late {row['overruns']} times" if row["overruns"] else "" for row in summary["trials"]
    ]


def test_in_a_pipeline(hknob, tmp_path: Path) -> None:
    (tmp_path / "bench.yaml").write_text(SPEC)
    (tmp_path / "line.yaml").write_text(
        "kind: pipeline\nname: line\nstages:\n  one: {spec: bench.yaml}\n"
        "  other: {spec: bench.yaml, set: {knob.coulomb_torque: 0}}\n"
    )
    done = hknob("run", "line.yaml", "--json")
    assert done.returncode == 0, done.stderr
    assert [stage["status"] for stage in json.loads(done.stdout)["stages"]] == ["computed", "computed"]
    again = hknob("run", "line.yaml")
    assert "2 up to date" in again.stdout
    one, other = (pq.read_table(tmp_path / "results" / "line" / name / "trials.parquet") for name in ("one", "other"))
    assert one["frequency_hz"].to_pylist() != other["frequency_hz"].to_pylist()


@pytest.mark.parametrize(
    "name",
    [
        "ch8_hardware",
        "ch8_hardware_plain",
        "ch8_hardware_bounded_lag",
        "ch8_hardware_remedies",
        "ch8_serial_host",
        "ch8_serial_qemu",
    ],
)
def test_experiments_are_good(hknob, name: str) -> None:
    done = hknob("check", EXPERIMENTS / f"{name}.yaml")
    assert done.returncode == 0
    assert "trials: good" in done.stdout


def test_no_executor(hknob, tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text(SPEC)
    done = hknob("hw-run", "spec.yaml", "--executor", "dask")
    assert (done.returncode, done.stdout) == (2, "")
    assert "one knob" in done.stderr


def test_help_says_where_results_go_and_what_has_no_effect(hknob) -> None:
    said = " ".join(hknob("hw-run", "--help").stdout.replace("│", " ").split())
    assert "[default: results/NAME]" in said
    assert "without effect, for trials follow one another" in said
    assert "recordings of a device are moved to DIR/earlier" in said
    assert "[default: all cores]" in hknob("sweep", "--help").stdout
