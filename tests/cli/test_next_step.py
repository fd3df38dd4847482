"""The last line of a stage: a command that the program takes, for people only."""

import json
import shlex
import subprocess
from pathlib import Path

TWO = ("--set", "grid={sample_rate_hz: 1000, counts_per_rev: [512, 1024]}", "--set", "starts.phases=4")
ONE = ("--set", "grid={sample_rate_hz: 1000, counts_per_rev: 1024}", "--set", "starts.phases=4")


def step(done: subprocess.CompletedProcess[str]) -> str:
    """The command of the last line; empty where there is none."""
    assert done.returncode == 0, done.stderr
    last = done.stdout.splitlines()[-1]
    return last.removeprefix("next: ") if last.startswith("next: ") else ""


def test_the_picture_then_the_next_question(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file()
    for out in ([], ["-o", "with a space"]):
        first = hknob("sweep", spec, *out, *TWO).stdout.splitlines()[-1]
        assert first.startswith("next: hknob sweep ")
        words = shlex.split(first.removeprefix("next: "))
        then = hknob(*words[1:])
        assert (then.returncode, "grid.png" in then.stdout) == (0, True)
        second = then.stdout.splitlines()[-1]
        assert second.startswith(f"next: hknob new remedies --from {shlex.quote(str(spec))} --set ")
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


def test_one_knob_is_played_with_first(hknob, spec_file, tmp_path: Path) -> None:
    """The page begins with what was swept, overrides included; once it is there, the picture comes next."""
    spec = spec_file()
    first = step(hknob("sweep", spec, *ONE))
    assert first.startswith("hknob explore ")
    explored = hknob(*shlex.split(first)[1:], "--no-open", "--json")
    assert json.loads(explored.stdout)["cells"] == 1
    assert "--plot" in step(hknob("sweep", spec, *ONE))


def test_a_knob_that_the_page_does_not_follow_is_drawn(hknob, spec_file) -> None:
    lag = ("--set", "scene.actuator={time_constant: 1.0e-4}", "--set", "limits.max_samples=400")
    assert "--plot" in step(hknob("sweep", spec_file(), *ONE, *lag))


def test_a_trial_of_remedies_takes_the_best_along(hknob, spec_file, tmp_path: Path) -> None:
    """A sweep of the knob with it, which runs; then the picture."""
    trial = ("new", "remedies", "--from", spec_file(), *ONE, "--out", "trial.yaml")
    assert hknob(*trial).returncode == 0
    assert hknob("new", "remedies", "--from", "trial.yaml", "--remedy", "softer wall").returncode == 0
    done = hknob("remedies", "trial.yaml", "-j", "1", "--set", "cases={}")
    first = step(done)
    assert first.startswith("hknob new sweep --from trial.yaml --set ")
    best = shlex.split(first)[shlex.split(first).index("--remedy") + 1]
    assert f"{best} costs " in " ".join(done.stdout.split())
    assert hknob(*shlex.split(first)[1:]).returncode == 0
    assert hknob("sweep", shlex.split(first)[-1], "-o", "with", "-q").returncode == 0
    assert "--plot" in step(hknob("remedies", "trial.yaml", "--set", "cases={}"))


def test_a_design_that_cannot_begin_from_a_grid_begins_anew(hknob, spec_file, tmp_path: Path) -> None:
    """A design is of one rate and resolution; what is suggested after remedies over several is a command that runs."""
    grid = ("--set", "grid={sample_rate_hz: [1000, 2000], counts_per_rev: 1024}", "--set", "starts.phases=2")
    assert hknob("new", "remedies", "--from", spec_file(), *grid, "--out", "trial.yaml").returncode == 0
    trial = ("remedies", "trial.yaml", "-j", "1", "--plot")
    along = step(hknob(*trial))
    assert hknob(*shlex.split(along)[1:]).returncode == 0  # the sweep with the best; its file is there from now on
    design = step(hknob(*trial))
    assert design.startswith("hknob new design --out ")
    assert hknob(*shlex.split(design)[1:]).returncode == 0


PIPELINE = """\
kind: pipeline
name: two
stages:
  first: {{spec: {spec}}}
  page: {{spec: {page}, set: {{results: {{from: all}}}}}}
"""
PAGE = "kind: report\nname: page\ntitle: One knob\nresults: []\n"


def test_a_pipeline_ends_with_its_page(hknob, spec_file, tmp_path: Path) -> None:
    """Computed, up to date, and stopped on the way: then with the whole of it."""
    page = tmp_path / "page.yaml"
    page.write_text(PAGE)
    pipeline = tmp_path / "two.yaml"
    pipeline.write_text(PIPELINE.format(spec=spec_file(), page=page))
    out = ("-o", "some where", "--set", "stages.first.set.starts.phases=2")
    rest = step(hknob("run", str(pipeline), *out, "--until", "first"))
    assert shlex.split(rest) == ["hknob", "run", str(pipeline), "--out", *out[1:]]
    for _ in range(2):
        shown = step(hknob(*shlex.split(rest)[1:]))
        assert shlex.split(shown)[:3] == ["python3", "-m", "webbrowser"]
        assert Path(tmp_path, shlex.split(shown)[3]).name == "report.html"
    assert "next:" not in hknob(*shlex.split(rest)[1:], "-q").stdout
    assert "next:" not in hknob(*shlex.split(rest)[1:], "--json").stdout


def test_a_pipeline_without_a_page_gets_one(hknob, spec_file, tmp_path: Path) -> None:
    new = step(hknob("run", spec_file(), *ONE))
    assert new.startswith("hknob new report --out ")
    assert hknob(*shlex.split(new)[1:]).returncode == 0
    assert step(hknob("run", spec_file(), *ONE)) == ""  # that file is there now
