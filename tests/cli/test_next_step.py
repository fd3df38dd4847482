"""The last line of a stage: a command that the program takes, for people only."""

import json
import shlex
from pathlib import Path

ONE = ("--set", "grid={sample_rate_hz: 1000, counts_per_rev: 1024}", "--set", "starts.phases=4")


def test_the_picture_then_the_next_question(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file()
    for out in ([], ["-o", "with a space"]):
        first = hknob("sweep", spec, *out, *ONE).stdout.splitlines()[-1]
        assert first.startswith("next: hknob sweep ")
        words = shlex.split(first.removeprefix("next: "))
        then = hknob(*words[1:])
        assert (then.returncode, "grid.png" in then.stdout) == (0, True)
        second = then.stdout.splitlines()[-1]
        assert second.startswith("next: hknob new remedies --out ")
    assert hknob(*shlex.split(second)[2:]).returncode == 0
    assert not hknob(*words[1:]).stdout.splitlines()[-1].startswith("next:")  # that file is there now


def test_a_knob_at_rest_needs_no_remedies(hknob, spec_file) -> None:
    rests = ("--set", "scene.wall.stiffness=0.001", "--set", "scene.bias.torque=0", "--set", "scene.knob.damping=0.01")
    done = hknob("sweep", spec_file(), "--plot", *ONE, *rests)
    assert done.returncode == 0, done.stderr
    assert "comes to rest" in done.stdout
    assert "next:" not in done.stdout


def test_neither_quiet_nor_machines_are_told(hknob, spec_file) -> None:
    spec = spec_file()
    assert "next:" not in hknob("sweep", spec, *ONE, "-q").stdout
    done = hknob("sweep", spec, *ONE, "--json")
    assert json.loads(done.stdout)["status"] == "up to date"
    assert "next:" not in done.stderr
