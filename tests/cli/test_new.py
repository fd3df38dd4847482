"""``hknob new``: every kind has a starter that is valid, from each preset that the kind takes; small ones run."""

import json
import subprocess
from pathlib import Path

import pytest

from hknob_cli.specs.load import load
from hknob_cli.specs.preset import names, read_preset
from hknob_cli.specs.starter import WITH_SCENE, starter
from hknob_cli.stage_table import KINDS, PIPELINE, SPECS

REFUSED = {("dfa", "href"), ("dfa", "odrive_v3")}  # these knobs have friction, which is not in dfa

# Those whose work takes longer, or needs results of others: their own tests run such a spec.
RUN_ELSEWHERE = ("bench", "design", "hw-run", "remedies", "report", "sysid")


@pytest.mark.parametrize("kind", SPECS)
def test_every_kind_has_a_valid_starter(hknob, tmp_path: Path, kind: str) -> None:
    if kind == PIPELINE:  # it names two specs
        assert hknob("new", "sweep", "--out", "my-knob.yaml").returncode == 0
        assert hknob("new", "report", "--out", "my-page.yaml").returncode == 0
    done = hknob("new", kind, "--out", "spec.yaml")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "wrote spec.yaml\n")
    assert hknob("new", kind).stdout == (tmp_path / "spec.yaml").read_text()
    checked = hknob("check", "spec.yaml")
    assert checked.returncode == 0, checked.stderr
    assert checked.stdout.startswith(f"spec.yaml: {kind} 'my-")


@pytest.mark.parametrize("kind", SPECS)
def test_starters_are_commented_and_fit(kind: str) -> None:
    lines = starter(kind).splitlines()
    assert sum("#" in line for line in lines) >= len(lines) / 3
    assert max(map(len, lines)) <= 130
    assert not [line for line in lines if line.startswith(("#{", "#}"))]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("preset", names())
@pytest.mark.parametrize("kind", WITH_SCENE)
def test_starters_from_presets(kind: str, preset: str, tmp_path: Path) -> None:
    if (kind, preset) in REFUSED:
        with pytest.raises(Exception, match=r"cannot begin from .* Coulomb friction is not in dfa"):
            starter(kind, preset)
        return
    path = tmp_path / "spec.yaml"
    path.write_text(starter(kind, preset))
    plan = load(path)
    assert plan.name == f"my-{preset}"
    scene = plan.remedies[0].grid.scene if kind == "remedies" else plan.scene
    read = read_preset(preset, tmp_path)
    assert scene.knob.inertia == read.scene["knob"]["inertia"]
    if kind == "remedies":
        softer = next(one for one in plan.remedies if one.name == "softer wall")
        assert softer.grid.scene.wall.stiffness == pytest.approx(0.5 * scene.wall.stiffness, rel=1e-11)
    if kind == "design":
        assert plan.present == read.grid
        assert plan.stiffness == pytest.approx(0.75 * scene.wall.stiffness, rel=1e-11)


@pytest.mark.parametrize(
    ("kind", "key", "value"),
    [
        ("sweep", "scene.knob.damping", "1.0e-4"),
        ("sweep", "scene.knob.coulomb_torque", "0.1 mN*m"),
        ("sweep", "scene.wall.damping", "1.0e-5"),
        ("sweep", "scene.actuator", "{delay_samples: 1, torque_limit: 50 mN*m}"),
        ("sweep", "scene.encoder", "{rounding: nearest}"),
        ("sweep", "scene.hand", "{inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}"),
        ("sweep", "scene.bias", "{half_quantum: true}"),
        ("sweep", "scene.controller", "{kind: bounded_lag, keep: 0.15, time_constant: 0.2}"),
        ("sweep", "starts", "{angle: [-50 mrad, 50 mrad], velocity: [-5, 5]}"),
        ("sweep", "perceive", "{knob_radius: 8.9 mm}"),
        ("dfa", "scene.actuator", "{delay_samples: 1}"),
        ("dfa", "scene.bias", "{torque: 1 mN*m}"),
        ("predict", "scene.knob.coulomb_torque", "0.1 mN*m"),
        ("predict", "scene.wall.damping", "1.0e-5"),
        ("predict", "laws", "[quantum_period]"),
        ("remedies", "perceive", "{knob_radius: 8.9 mm}"),
        ("design", "constraints.hearing", "{above_present: 0, people: 0.34}"),
        ("sysid", "knob_radius", "8.9 mm"),
        ("sysid", "excitation", "continuous"),
        ("hw-run", "device", "{driver: serial, url: /dev/ttyACM0}"),
        ("hw-run", "limits", "{torque: 20 mN*m}"),
        ("hw-run", "remedies", "{plain wall: {}, softer wall: {change: {wall: {stiffness: 0.135}}}}"),
    ],
)
def test_alternatives_in_comments_are_valid(kind: str, key: str, value: str, tmp_path: Path) -> None:
    text = starter(kind)
    assert value in text
    assert key.split(".")[-1] in text
    (tmp_path / "spec.yaml").write_text(text)
    load(tmp_path / "spec.yaml", (f"{key}={value}",))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in RUN_ELSEWHERE])
def test_starters_run(hknob, kind: str) -> None:
    assert hknob("new", kind, "--out", "spec.yaml").returncode == 0
    done = hknob(kind, "spec.yaml", "--out", "out", "--json", "-q")
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["status"] == "computed"
    if kind == "sweep":
        assert summary["cells"][0]["p2p_rad"] > 0.0


def test_a_file_that_is_there_stays(hknob, tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text("mine")
    done = hknob("new", "sweep", "--out", "spec.yaml")
    assert done.returncode == 3
    assert done.stderr == "spec.yaml: is there already, and stays as it is; name another file\n"
    (tmp_path / "link.yaml").symlink_to(tmp_path / "elsewhere.yaml")
    assert hknob("new", "sweep", "--out", "link.yaml").returncode == 3
    assert hknob("new", "sweep", "--out", "nowhere/spec.yaml").returncode == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link.yaml", "spec.yaml"]
    assert (tmp_path / "spec.yaml").read_text() == "mine"


def test_what_cannot_be_begun_is_said(hknob, tmp_path: Path) -> None:
    assert "did you mean 'sweep'" in (wrong := hknob("new", "swep")).stderr
    assert wrong.returncode == 2
    assert "did you mean 'idrive'" in (wrong := hknob("new", "sweep", "--from", "idrve", "--out", "a.yaml")).stderr
    assert wrong.returncode == 2
    assert hknob("new", "sysid", "--from", "idrive").returncode == 2
    assert not list(tmp_path.iterdir())


def test_without_a_kind_all_are_listed(hknob) -> None:
    """Beside a terminal that is an error, so that no list lands in a file; nothing is asked."""
    done = hknob("new")
    assert done.returncode == 2
    assert done.stdout == ""
    for kind in SPECS:
        assert f"\n{kind} " in done.stderr
    script = subprocess.run(
        ["script", "-qec", f"{hknob('--version').args[0]} new", "/dev/null"],
        capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert script.returncode == 0, script.stdout
    for kind in SPECS:
        assert f"{kind} " in script.stdout


def test_a_preset_of_a_users_own(hknob, tmp_path: Path) -> None:
    own = {"title": "mine", "scene": {"knob": {"inertia": 2e-6}, "wall": {"stiffness": 0.2}}}
    (tmp_path / "own.yaml").write_text(json.dumps(own))
    assert hknob("new", "sweep", "--from", "own.yaml", "--out", "mine.yaml").returncode == 0
    plan = load(tmp_path / "mine.yaml")
    assert plan.scene.wall.stiffness == 0.2
    assert plan.axes == {"sample_rate_hz": [1000.0], "counts_per_rev": [1024]}  # the starter's, where it has none
