"""Faults of a target in another language, through the command: each is named as what it is, with exit code 4."""

import re
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.hardware.foreign import arranged, foreign_target

pytestmark = pytest.mark.long  # programs that talk in real time

STAYS = "THE TORQUE IS STILL ON: switch the amplifier off by hand"

# What the target does wrong, and what the user reads.
FAULTS = {
    "stop-keeps-running": "the target acknowledged STOP, but says that it is running, and not idle; torque released",
    "arms-at-once": "the target acknowledged ARM, but says that it is running, and not armed; torque released",
    "no-wall-flag": r"does not say that the wall is on, at sample \d+|mN m where the wall is off, at sample \d+",
    "loses-wall-flag": r"the device sa(id at sample \d+|ys) that the wall is off, and (went|goes) on sampling",
    "wall-flag-too-early": "the device says that the wall is on, and was not told to switch it on, at sample 0",
    "torque-while-armed": "the torque is 1 mN m where the wall is off, at sample 0",
    "half-stamps": "its times rise by 500 us from sample to sample, where a period is 1000 us: 50.0% too little",
    "stamps-2-percent-fast": "its times rise by 1020 us from sample to sample, .* is 1000 us: 2.0% too much",
    "loop-at-half-rate": r"the loop did not run at 1000 Hz: .*, which is 500 Hz, and does not say so",
    "loop-at-half-rate-unsaid": r"the target's clock is [45]\d\.\d% slow by this computer's \(sure to ",
    "half-torque": r"the torque is not that of the wall: .* 0\.27 N m/rad .*256 counts.*, 0\.5 times as much",
    "other-counts": r"the torque is not that of the wall: .*256 counts",
    "wrong-sign": r"the torque is not that of the wall: .*, -1 times as much",
    "stale-torque": r"the torque is not that of the wall: ",
    "nan-torque": r"the target sent a torque that is not a number, at sample \d+",
    "nan-grip": r"the target sent a grip force that is not a number, at sample \d+",
    "block-crcs-wrong": r"no samples came for \d+ ms: but \d+ frames came with a wrong checksum: does the target make",
    "nan-echo": "took other values, and was not armed: wall_stiffness sent 0.27, taken nan",
    "other-echo": "took other values, and was not armed: counts_per_rev sent 256, taken 77",
    "restarts": "the target has restarted",
    "falls-silent": r"no samples came for \d+ ms: it answers, but is not sampling",
    "trips-by-speed": r"the target took its torque off at sample \d+, .*: the knob turned faster than the speed limit",
}


def run(hknob, folder: Path, fault: str, more: str = "", **changes: str) -> str:
    """What the command says to a target with a fault; it must be a device fault, without a traceback or a result."""
    with foreign_target("--fault", fault) as url:
        done = hknob(*arranged(folder, url, more, **changes))
    assert (done.returncode, done.stdout) == (4, ""), done.stderr
    assert "Traceback" not in done.stderr
    assert not (folder / "out" / "trials.parquet").exists()
    return done.stderr


@pytest.mark.one_in(6)
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_and_the_torque_released(hknob, tmp_path: Path, fault: str) -> None:
    """Of three trials one names it: where a busy computer stands still, another fault may be met first."""
    for number in range(3):
        folder = tmp_path / str(number)
        folder.mkdir()
        said = run(hknob, folder, fault)
        assert "torque released; " in said
        assert said.startswith("trial 1 of 1 (1000 Hz, 256 counts): ")
        assert said.count("\n") == 1
        if re.search(FAULTS[fault], said):
            return
    pytest.fail(said)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("fault", "why"),
    [
        ("keeps-torque", "the target acknowledged RELEASE, but says that it is running, and not idle"),
        ("keeps-torque-in-secret", "the target acknowledged RELEASE, but goes on sending samples with the wall on"),
        ("refuses-release", "the target refused RELEASE, and says that it is running"),
    ],
)
def test_torque_that_stays_is_said_again_and_again_until_the_port_closes(
    hknob, tmp_path: Path, fault: str, why: str
) -> None:
    said = run(hknob, tmp_path, fault).splitlines()
    assert len(said) >= 3
    assert f"{STAYS}. {why}" in said[0]
    assert all(line.endswith(f"{STAYS}. {why}; RELEASE is sent again") for line in said[1:-1])
    assert said[-1].startswith("trial 1 of 1 (1000 Hz, 256 counts): the device was told to release, and did not; ")
    assert STAYS in said[-1]
    assert "torque released" not in said[-1]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("how", ["fast", "slow"])
def test_a_clock_that_is_wrong_by_2_percent_is_noticed_by_the_computers_own(hknob, tmp_path: Path, how: str) -> None:
    """Loop and times are of the same wrong clock, so that only another can tell."""
    long = "trial: {zero: 0.5, settle: 0.1, buzz: [9, 9], longest: 12}\n"
    with foreign_target("--fault", f"clock-2-percent-{how}") as url:
        arguments = arranged(tmp_path, url)
        spec = tmp_path / "spec.yaml"
        spec.write_text(re.sub("trial: .*\n", long, spec.read_text()))
        done = hknob(*arguments)
    assert (done.returncode, done.stdout) == (4, ""), done.stderr
    assert re.search(
        rf"the target's clock is [\d.]+% {how} by this computer's \(sure to [\d.]+%, at most 1%", done.stderr
    )


def test_a_millisecond_clock_at_2_khz_is_refused_when_it_arrives(hknob, tmp_path: Path) -> None:
    said = run(hknob, tmp_path, "ms-clock", rates="[2000]")
    assert "two samples have the same time near sample 0: the target must tell times to 1 us" in said


def test_torque_beyond_the_limit_that_was_agreed_is_noticed(hknob, tmp_path: Path) -> None:
    with foreign_target("--fault", "no-torque-limit") as url:
        arguments = arranged(tmp_path, url)
        spec = tmp_path / "spec.yaml"
        spec.write_text(spec.read_text().replace("{watchdog", "{torque: 5e-3, watchdog"))
        done = hknob(*arguments)
    assert done.returncode == 4
    assert "the torque is beyond the limit of 0.005 N m, at sample " in done.stderr


def test_checksums_that_are_all_wrong_are_called_so(hknob, tmp_path: Path) -> None:
    said = run(hknob, tmp_path, "all-crcs-wrong")
    assert re.search(
        r"a target answers, but \d+ frames came with a wrong checksum: does the target make its CRC-32", said
    )


def test_blocks_sent_twice_cost_nothing(hknob, tmp_path: Path) -> None:
    with foreign_target("--fault", "repeats-samples") as url:
        done = hknob(*arranged(tmp_path, url))
    assert done.returncode == 0, done.stderr
    numbers = pq.read_table(tmp_path / "out" / "samples.parquet")["sample"].to_pylist()
    assert numbers == list(range(len(numbers)))
