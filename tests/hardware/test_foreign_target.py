"""A target in another language, written from the page of the wire alone: it passes a campaign."""

import json
import re
import socket
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from hknob_cli.hardware.wire.answers import About, Ack, Samples
from hknob_cli.hardware.wire.codes import Kind, State, Status
from hknob_cli.hardware.wire.commands import Configure, Plain, SetAct, Simulate, Zero
from hknob_cli.hardware.wire.messages import Decoder, Message, decode, encode, frame
from tests.hardware.foreign import arranged, foreign_target
from tests.hardware.golden import LAG, SETTINGS, WITH_SINES


def ask(link: socket.socket, decoder: Decoder, command: Message) -> Ack:
    """The answer to a command, whatever else comes before."""
    link.sendall(frame(encode(command)))
    while True:
        for body in decoder.feed(link.recv(65536)):
            found = decode(body)
            if isinstance(found, Ack) and found.nonce == command.nonce:  # type: ignore[union-attr]
                return found
            assert found is None or isinstance(found, Samples)


def linked(url: str) -> socket.socket:
    host, port = url.removeprefix("socket://").split(":")
    link = socket.create_connection((host, int(port)), timeout=120)
    link.sendall(b"\0")
    return link


@pytest.mark.long
def test_a_campaign(hknob, tmp_path: Path) -> None:
    """Four cells; the knob is stepped by other code, and buzzes as the virtual one does."""
    with foreign_target() as url:
        arguments = arranged(tmp_path, url, rates="[1000, 2000]", counts="[256, 512]")
        done = hknob(*arguments, "--json", "--set", "knob.coulomb_torque=0")
        assert done.returncode == 0, done.stderr
        summary = json.loads(done.stdout)
        again = hknob(*arguments, "--set", "knob.coulomb_torque=0")
        assert (again.returncode, "(up to date)" in again.stdout) == (0, True)
    assert [row["device"] for row in summary["trials"]] == ["perl"] * 4
    assert all(row["sustained"] and row["fault"] == "" for row in summary["trials"])
    assert summary["gaps"] == summary["overruns"] == summary["missed_ticks"] == 0
    assert abs(summary["host_drift"]) <= summary["host_drift_uncertainty"]
    assert re.search(
        r"the device's clock is \d+\.\d\d% (fast|slow) by this computer's, sure to \d+\.\d\d%", again.stdout
    )
    # The same campaign on the virtual knob: cells alike to a tenth, as far as one start of a trial is like another.
    text = (tmp_path / "spec.yaml").read_text()
    (tmp_path / "virtual.yaml").write_text(re.sub("device: .*\n", "", text))
    other = hknob("hw-run", tmp_path / "virtual.yaml", "--json", "--set", "knob.coulomb_torque=0")
    for here, there in zip(summary["trials"], json.loads(other.stdout)["trials"], strict=True):
        assert here["p2p_rad"] == pytest.approx(there["p2p_rad"], rel=0.1)
        assert here["frequency_hz"] == pytest.approx(there["frequency_hz"], rel=0.1)


@pytest.mark.long
def test_a_campaign_without_a_grip_cell(hknob, tmp_path: Path) -> None:
    with foreign_target("--no-grip-cell") as url:
        refused = hknob(*arranged(tmp_path, url))
        assert refused.returncode == 2
        assert "the device 'perl' has no grip cell; write 'grip: none' into the spec" in refused.stderr
        done = hknob(*arranged(tmp_path, url, "grip: none\n"), "--plot")
        assert done.returncode == 0, done.stderr
        assert "no grip cell" in done.stdout
        assert "grip force" not in done.stdout
    rows = pq.read_table(tmp_path / "out" / "trials.parquet").to_pylist()
    assert [(row["ended"], row["fault"], row["grip_mean_n"]) for row in rows] == [("buzz", "", None)]
    assert 0.1 <= rows[0]["settled_s"] < 0.2


@pytest.mark.long
def test_the_angle_is_zero_where_the_knob_is_when_the_port_is_opened(hknob, tmp_path: Path) -> None:
    """The simulated knob rests at 0.02 rad, which is 52 counts of 16384, and 0 once it was made the zero."""
    angles = []
    with foreign_target() as url:
        for zero in ("false", "true"):
            (tmp_path / zero).mkdir()
            arguments = arranged(tmp_path / zero, url)
            done = hknob(*arguments, "--set", f"device.zero_angle={zero}")
            assert done.returncode == 0, done.stderr
            table = pq.read_table(tmp_path / zero / "out" / "samples.parquet")
            angles.append(table["angle_counts"][0].as_py())
    assert angles == [52, 0]


@pytest.mark.parametrize(
    ("command", "said"),
    [(Configure(2, SETTINGS), SETTINGS), (Simulate(3, WITH_SINES), WITH_SINES), (Zero(4, -77), -77)],
)
def test_it_says_what_it_took(command: Message, said: object) -> None:
    with foreign_target() as url, linked(url) as link:
        answer = ask(link, Decoder(), command)
        assert (answer.status, answer.state, answer.said) == (Status.DONE, State.IDLE, said)


def test_it_greets_and_answers_again_what_it_has_done() -> None:
    with foreign_target() as url, linked(url) as link:
        decoder = Decoder()
        about = ask(link, decoder, Plain(Kind.HELLO, 1)).said
        assert about == About(16384, 50_000, simulated=True, name="perl", knows_zero=True)
        assert ask(link, decoder, Plain(Kind.START, 2)).status is Status.NOT_NOW
        assert ask(link, decoder, Plain(Kind.ARM, 3)).status is Status.NOT_NOW
        assert ask(link, decoder, Configure(4, SETTINGS._replace(watchdog_us=50))).status is Status.OUT_OF_RANGE
        assert ask(link, decoder, Configure(5, SETTINGS)).status is Status.DONE
        first = ask(link, decoder, Plain(Kind.ARM, 6))
        assert ask(link, decoder, Plain(Kind.ARM, 6)) == first


def test_it_knows_no_controller_and_says_so() -> None:
    with foreign_target() as url, linked(url) as link:
        decoder = Decoder()
        assert ask(link, decoder, Configure(1, SETTINGS)).status is Status.DONE
        answer = ask(link, decoder, SetAct(2, LAG))
        assert (answer.status, answer.state, answer.said) == (Status.NOT_KNOWN, State.IDLE, None)


def test_a_campaign_under_a_controller_is_refused_before_anything_is_armed(hknob, tmp_path: Path) -> None:
    with foreign_target() as url:
        refused = hknob(*arranged(tmp_path, url, "controller: {kind: bounded_lag}\n"))
    assert refused.returncode == 2
    assert (
        "trial 1 of 1 (1000 Hz, 256 counts): the device 'perl' cannot do that: it runs the plain wall" in refused.stderr
    )
    assert "no controller: it does not know CONTROL (docs/reference/wire.md)" in refused.stderr
    assert not (tmp_path / "out" / "trials.parquet").exists()


@pytest.mark.long
def test_its_knob_moves_as_the_virtual_one(hknob, tmp_path: Path) -> None:
    """Sample by sample over the first swings: from the same rest, on an encoder of as many counts."""
    with foreign_target() as url:
        arguments = arranged(tmp_path, url)
        done = hknob(*arguments, "--set", "knob.coulomb_torque=0", "--set", "knob.damping=2e-5")
        assert done.returncode == 0, done.stderr
    table = pq.read_table(tmp_path / "out" / "samples.parquet")
    angle, on = table["angle_counts"].to_numpy(), table["running"].to_numpy(zero_copy_only=False)
    text = re.sub("device: .*\n", "", (tmp_path / "spec.yaml").read_text())
    (tmp_path / "virtual.yaml").write_text(text)
    done = hknob(
        "hw-run", tmp_path / "virtual.yaml", "-o", tmp_path / "virtual",
        "--set", "knob.coulomb_torque=0", "--set", "knob.damping=2e-5",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    other = pq.read_table(tmp_path / "virtual" / "samples.parquet")
    theirs, began = other["angle_rad"].to_numpy(), other["running"].to_numpy(zero_copy_only=False)
    mine = angle[on][:60] / 16384 * 2 * np.pi
    assert np.abs(mine - theirs[began][:60]).max() < 2 * np.pi / 16384 * 1.5
