"""``hknob hw-run`` with a serial device: recordings are sources, and an operator at a terminal steers the campaign."""

import json
import os
import pty
import select
import signal
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from hknob_cli.hardware.journal import read_journal
from hknob_cli.hardware.order import trials_of
from hknob_cli.hardware.trial_file import joined
from hknob_cli.hardware.wire.codes import Kind
from tests.conftest import HKNOB
from tests.hardware.campaigns import SPEC as VIRTUAL
from tests.hardware.campaigns import planned
from tests.hardware.fake_target import Manners, PtyTarget, made_up

# A busy machine stops the target's thread now and then: its clock against the computer's is tested elsewhere.
MANNERS = Manners(outside=True, own_time=True)
# The made-up signal is no knob's: leaps of the angle outside the wall, and a grip that is never in the band.
SPEC = """\
kind: hw-run
name: bench
device: {{driver: serial, url: {url}}}
grid: {{sample_rate_hz: [1000], counts_per_rev: [256, 512]}}
limits: {{torque: 0.2, speed: 10000 rad/s, watchdog: 50 ms}}
trial: {{zero: 0.03, settle: 0.02, buzz: [0.1, 0.1], longest: 0.3}}
"""


def arranged(folder: Path, url: str, **changes: str) -> tuple[object, ...]:
    """Arguments of the command, its spec written."""
    text = SPEC.format(url=url)
    for old, new in changes.items():
        text = text.replace(f"{old}: 0.3", f"{old}: {new}")
    (folder / "spec.yaml").write_text(text)
    return "hw-run", folder / "spec.yaml", "-o", folder / "out"


@pytest.mark.long
def test_a_device_is_recorded_once(hknob, tmp_path: Path) -> None:
    with PtyTarget(MANNERS) as pretended:
        arguments = arranged(tmp_path, pretended.url)
        done = hknob(*arguments, "--json", "--plot")
        assert done.returncode == 0, done.stderr
        summary = json.loads(done.stdout)
        assert [row["ended"] for row in summary["trials"]] == ["longest", "longest"]
        assert summary["gaps"] == 0
        assert all(row["fault"].startswith("the grip was never held") for row in summary["trials"])
        assert pretended.target.heard.count(Kind.START) == 2
        assert pretended.target.simulated is not None  # it says that it simulates, so it was told whom
        again = hknob(*arguments)
        assert (again.returncode, "(up to date)" in again.stdout) == (0, True)
        assert pretended.target.heard.count(Kind.START) == 2
    samples = pq.read_table(tmp_path / "out" / "samples.parquet").to_pandas()
    for _, trial in samples.groupby("trial"):
        started = int(np.argmax(trial["running"]))
        known = made_up(0, len(trial), 1000.0, started=started)
        assert not trial["torque_nm"].any()
        assert np.array_equal(trial["angle_counts"], known.angle_counts)
        assert np.array_equal(trial["running"], known.running)
        assert np.array_equal(trial["device_time_us"], known.time_us)
    folder = tmp_path / "out" / "recording"
    labels = [trial.label for trial in trials_of(planned((tmp_path / "spec.yaml").read_text()))]
    assert sorted(path.name for path in folder.glob("*.parquet")) == sorted(f"{label}.parquet" for label in labels)
    kept = {path.name: path.read_bytes() for path in folder.glob("*.parquet")}
    # Another spec is refused, without the device; begun anew, the earlier recordings stay.
    refused = hknob(*arguments, "--set", "wall.stiffness=0.3")
    assert (refused.returncode, refused.stdout) == (3, "")
    assert "made with another spec; they are kept" in refused.stderr
    with PtyTarget(MANNERS) as other:
        forced = hknob(*arranged(tmp_path, other.url), "--force")
        assert forced.returncode == 0, forced.stderr
        assert f"the earlier recordings are in {tmp_path / 'out' / 'earlier' / '1'}" in forced.stderr
    earlier = tmp_path / "out" / "earlier" / "1"
    assert {path.name: path.read_bytes() for path in (earlier / "recording").glob("*.parquet")} == kept
    assert (earlier / "hw_run.png").exists()
    assert (tmp_path / "out" / "samples.parquet").exists()


@pytest.mark.long
def test_results_can_be_made_again_without_the_device(hknob, tmp_path: Path) -> None:
    with PtyTarget(MANNERS) as pretended:
        arguments = arranged(tmp_path, pretended.url)
        assert hknob(*arguments).returncode == 0
    out = tmp_path / "out"
    before = {name: (out / name).read_bytes() for name in ("samples.parquet", "trials.parquet")}
    (out / "trials.parquet").unlink()
    again = hknob(*arguments)
    assert again.returncode == 0, again.stderr
    assert {name: (out / name).read_bytes() for name in before} == before


def test_a_link_that_is_cut(hknob, tmp_path: Path) -> None:
    with PtyTarget(replace(MANNERS, cut_at=20)) as pretended:
        arguments = arranged(tmp_path, pretended.url)
        done = hknob(*arguments)
    assert (done.returncode, done.stdout) == (4, "")
    assert done.stderr.startswith("trial 1 of 2 (1000 Hz, ")
    assert "RELEASE was not answered: see to it that the torque is off" in done.stderr
    assert "; what was recorded of it is in " in done.stderr
    assert done.stderr.count("\n") == 1
    kept = pq.read_table(next((tmp_path / "out" / "recording" / "aborted").iterdir()))
    assert 0 < kept.num_rows <= 200
    assert np.array_equal(kept["angle_counts"], made_up(0, kept.num_rows, 1000.0, started=None).angle_counts)


def test_nobody_answers(hknob, tmp_path: Path) -> None:
    done = hknob(*arranged(tmp_path, "/dev/hknob-that-is-not-there"))
    assert (done.returncode, done.stdout) == (4, "")
    assert "/dev/hknob-that-is-not-there" in done.stderr
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr


@pytest.mark.long
def test_a_campaign_that_found_no_device_stands_in_nobodys_way(hknob, tmp_path: Path) -> None:
    assert hknob(*arranged(tmp_path, "/dev/hknob-that-is-not-there")).returncode == 4
    with PtyTarget(MANNERS) as pretended:
        done = hknob(*arranged(tmp_path, pretended.url), "--set", "wall.stiffness=0.3")
    assert done.returncode == 0, done.stderr


@pytest.mark.long
def test_killed_what_was_received_is_there(hknob, tmp_path: Path) -> None:
    with PtyTarget(MANNERS) as pretended:
        target = pretended.target
        arguments = arranged(tmp_path, pretended.url, longest="1.5")
        label = trials_of(planned((tmp_path / "spec.yaml").read_text()))[0].label
        part = tmp_path / "out" / "recording" / f"{label}.part"
        process = subprocess.Popen([HKNOB, *arguments], stderr=subprocess.DEVNULL)
        wait_for(lambda: Kind.START in target.heard and part.stat().st_size > 10_000)
        before = part.read_bytes()
        process.kill()
        process.wait()
        assert part.read_bytes().startswith(before)
        wait_for(lambda: target.torque_off_at is not None)  # its watchdog, here at ten times its time
        done = hknob(*arguments, "--json", "-v")
        assert done.returncode == 0, done.stderr
        assert "2 of 2 trials recorded now" in done.stderr
    kept = pq.read_table(tmp_path / "out" / "recording" / "aborted" / f"{label}_1.parquet").to_pandas()
    known = made_up(0, len(kept), 1000.0, started=int(np.argmax(kept["running"])))
    (tmp_path / "before.part").write_bytes(before)
    earlier = read_journal(tmp_path / "before.part")
    assert earlier is not None
    assert len(kept) >= joined(earlier.blocks).number.size > 200
    assert np.array_equal(kept["sample"], np.arange(len(kept)))
    assert np.array_equal(kept["angle_counts"], known.angle_counts)
    assert np.array_equal(kept["running"], known.running)


@pytest.mark.long
@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupted_the_torque_is_off_at_once(tmp_path: Path, kind: signal.Signals) -> None:
    with PtyTarget(MANNERS) as pretended:
        arguments = arranged(tmp_path, pretended.url, longest="60")
        heeded = signal.signal(kind, signal.SIG_DFL)  # the tests may themselves run under nohup
        process = subprocess.Popen([HKNOB, *arguments], stderr=subprocess.PIPE, text=True)
        signal.signal(kind, heeded)
        wait_for(lambda: Kind.START in pretended.target.heard)
        time.sleep(0.1)
        process.send_signal(kind)
        _, errors = process.communicate(timeout=120)
        assert process.returncode == 130
        assert Kind.RELEASE in pretended.target.heard[pretended.target.heard.index(Kind.START) :]
        assert "torque released" in errors
        assert errors.splitlines()[-1].startswith("interrupted")


def wait_for(so) -> None:
    deadline = time.monotonic() + 120
    while not so() and time.monotonic() < deadline:
        time.sleep(0.01)
    assert so()


class Terminal:
    """The command at a terminal: what it shows, and keys pressed."""

    def __init__(self, *arguments: object) -> None:
        self.end, theirs = pty.openpty()
        self.process = subprocess.Popen(
            [HKNOB, *map(str, arguments)],
            stdin=theirs,
            stderr=theirs,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
            env={**os.environ, "TERM": "xterm", "COLUMNS": "120", "LINES": "40"},
        )
        os.close(theirs)
        self.shown = ""

    def wait_for(self, text: str) -> None:
        """Read what is shown until a text is in it; what was shown before is forgotten."""
        deadline = time.monotonic() + 120
        while text not in self.shown and time.monotonic() < deadline:
            if select.select([self.end], [], [], 0.1)[0]:
                try:
                    self.shown += os.read(self.end, 65536).decode(errors="replace")
                except OSError:  # the other side is gone
                    break
        assert text in self.shown, self.shown[-2000:]
        self.shown = self.shown[self.shown.index(text) + len(text) :]

    def press(self, key: str) -> None:
        os.write(self.end, key.encode())

    def finish(self) -> tuple[int, str]:
        """Exit code, and what was printed."""
        while True:
            try:
                if not os.read(self.end, 65536):
                    break
            except OSError:
                break
        printed = self.process.communicate(timeout=120)[0]
        os.close(self.end)
        return self.process.returncode, printed


@pytest.mark.long
def test_an_operator_steers(tmp_path: Path) -> None:
    with PtyTarget(MANNERS) as pretended:
        heard = pretended.target.heard
        terminal = Terminal(*arranged(tmp_path, pretended.url, longest="60"))
        terminal.wait_for("hands off the knob, then press space")
        assert Kind.ARM not in heard
        terminal.press(" ")
        terminal.wait_for("grip the knob, into the band")
        terminal.wait_for("target 0.71 N")
        terminal.press("r")
        terminal.wait_for("hands off the knob, then press space")
        assert heard.count(Kind.START) == 1
        terminal.press(" ")
        terminal.wait_for("grip the knob, into the band")
        terminal.press(" ")
        terminal.wait_for("trial 2/2")
        terminal.wait_for("hands off the knob, then press space")
        terminal.press(" ")
        terminal.wait_for("grip the knob, into the band")
        terminal.press("q")
        code, printed = terminal.finish()
        assert (code, printed) == (130, "")
        assert heard[-1] is Kind.RELEASE
        folder = tmp_path / "out" / "recording"
        assert len(list(folder.glob("*.parquet"))) == 1
        assert len(list((folder / "aborted").iterdir())) == 2
        # The same command goes on with the second trial, nobody being there.
        starts = heard.count(Kind.START)
        terminal = Terminal("hw-run", tmp_path / "spec.yaml", "-o", tmp_path / "out", "--unattended", "--json")
        wait_for(lambda: heard.count(Kind.START) == starts + 1)
        time.sleep(0.1)
        terminal.process.send_signal(signal.SIGTERM)
        assert terminal.finish()[0] == 130
        assert heard.count(Kind.START) == starts + 1


def test_a_simulation_is_shown_and_asks_nothing(tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text(VIRTUAL)
    terminal = Terminal("hw-run", tmp_path / "spec.yaml", "-o", tmp_path / "out")
    terminal.wait_for("trial 4/4")
    assert "hands off the knob" in terminal.shown
    assert "space" not in terminal.shown
    code, printed = terminal.finish()
    assert (code, printed.splitlines()[0][:8]) == (0, "bench: 4")


def test_quiet_shows_nothing(tmp_path: Path) -> None:
    with PtyTarget(MANNERS) as pretended:
        terminal = Terminal(*arranged(tmp_path, pretended.url), "-q")
        code, printed = terminal.finish()
        assert code == 0
        assert "2 trials" in printed
        assert terminal.shown == ""


def test_the_terminal_is_as_it_was(tmp_path: Path) -> None:
    import termios

    with PtyTarget(MANNERS) as pretended:
        end, theirs = pty.openpty()
        before = termios.tcgetattr(theirs)
        process = subprocess.Popen(
            [HKNOB, *arranged(tmp_path, pretended.url)], stdin=theirs, stderr=theirs, stdout=subprocess.DEVNULL
        )
        wait_for(lambda: not termios.tcgetattr(theirs)[3] & termios.ICANON)
        process.send_signal(signal.SIGINT)
        assert process.wait(120) == 130
        assert termios.tcgetattr(theirs) == before
        os.close(end)
        os.close(theirs)
