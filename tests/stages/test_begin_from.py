"""Tests of `begin_from`: the next question is asked of the same knob."""

from collections.abc import Callable
from pathlib import Path

import pytest

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.specs.load import load
from hknob_cli.stages.begin_from import KINDS, begin_from
from hknob_cli.theory.staircase import best_keep, slowness

SWEEP = """\
kind: sweep
name: my-wall
scene:
  knob: {inertia: 40 g*cm^2, coulomb_torque: 0.3 mN*m}
  hand: {inertia: 1.0e-7, damping: 4.0e-4, stiffness: 0.04}
  wall: {stiffness: 0.5 N*m/rad}
  bias: {torque: 10 mN*m}
  actuator: {delay_samples: 1}
grid: {sample_rate_hz: 2 kHz, counts_per_rev: 1200}
starts: {angle: -20 mrad, phases: 8}
perceive: {knob_radius: 12 mm}
"""


@pytest.fixture
def begun(tmp_path: Path) -> Callable[..., Path]:
    """Writes a spec, and beside it one that begins from it; the path of the latter."""

    def begin(kind: str, text: str = SWEEP) -> Path:
        (tmp_path / "own.yaml").write_text(text)
        path = tmp_path / f"{kind}.yaml"
        path.write_text(begin_from(kind, tmp_path / "own.yaml", f"my-{kind}", tmp_path))
        return path

    return begin


def without_friction(text: str = SWEEP) -> str:
    return text.replace(", coulomb_torque: 0.3 mN*m", "")


@pytest.mark.parametrize("kind", ["remedies", "design"])
def test_few_phases_where_all_would_take_long(begun, kind: str) -> None:
    """Friction or an actuator; phases and ranges that the author gave stay, and a plain knob is quick."""
    every = SWEEP.replace(", phases: 8", "").replace("12 mm", "8.9 mm")
    plain = without_friction(every).replace("  actuator: {delay_samples: 1}\n", "")
    ranged = every.replace("{angle: -20 mrad}", "{angle: [-20 mrad, 0], velocity: [-1, 1]}")
    delayed = without_friction(every)
    starts = {}
    for name, text in (("own", SWEEP), ("friction", every), ("delay", delayed), ("plain", plain), ("ranged", ranged)):
        path = begun(kind, text)
        starts[name] = load(path).values["base"]["starts"]
        assert ("16 phases of the sample clock answer soon" in path.read_text()) == (name in ("friction", "delay"))
    assert starts["own"]["phases"] == 8
    assert starts["friction"]["phases"] == starts["delay"]["phases"] == 16
    assert "phases" not in starts["plain"]
    assert starts["ranged"] == {"angle": ["-20 mrad", 0], "velocity": [-1, 1]}


@pytest.mark.parametrize("kind", ["predict", "dfa"])
def test_an_analysis_has_the_scene_and_grid_of_the_sweep(begun, tmp_path: Path, kind: str) -> None:
    plan = load(begun(kind, without_friction()))
    own = load(tmp_path / "own.yaml")
    assert (plan.name, plan.scene, plan.axes) == (f"my-{kind}", own.scene, own.axes)


def test_remedies_are_in_proportion_to_the_knob(begun, tmp_path: Path) -> None:
    plan = load(begun("remedies"))
    own = load(tmp_path / "own.yaml")
    sweeps = {one.name: one.grid for one in plan.remedies}
    plain = sweeps["plain wall"]
    assert plain.scene._replace(hand=own.scene.hand) == own.scene
    assert (plain.starts, plan.hands) == (own.starts, ("this hand",))
    assert plan.cases == (("this knob", 2000.0, 1200),)
    assert sweeps["softer wall"].scene.wall.stiffness == 0.25
    assert sweeps["friction x 2"].scene.knob.coulomb_torque == pytest.approx(6e-4)
    assert sweeps["damping x 4"].scene.knob.damping == pytest.approx(1.2e-3)
    assert sweeps["rate x 2"].axes["sample_rate_hz"] == [4000.0]
    assert sweeps["counts x 4"].axes["counts_per_rev"] == [4800]
    r = slowness(inertia_kg_m2=4.1e-6, damping_nm_s_per_rad=4e-4, time_constant_s=0.2)
    assert sweeps["bounded lag"].scene.controller.keep == pytest.approx(best_keep(r), rel=5e-3)
    assert "knob_radius: 12 mm" in (tmp_path / "remedies.yaml").read_text()


def test_the_command_line_may_have_changed_it(begun, tmp_path: Path) -> None:
    begun("remedies")
    text = begin_from("predict", tmp_path / "own.yaml", "p", tmp_path, ("scene.wall.stiffness=0.7",))
    (tmp_path / "changed.yaml").write_text(text)
    assert load(tmp_path / "changed.yaml").scene.wall.stiffness == 0.7


def test_only_what_the_knob_has_is_changed(begun) -> None:
    text = without_friction().replace("inertia: 40 g*cm^2", "inertia: 1").replace("2 kHz", "[1000, 2000]")
    plan = load(begun("remedies", text))
    assert [one.name for one in plan.remedies] == ["plain wall", "softer wall", "damping x 4", "counts x 4"]
    assert plan.cases == ()


def test_a_design_begins_from_a_sweep_or_from_its_remedies(begun, tmp_path: Path) -> None:
    first = begun("design").read_text()
    plan = load(tmp_path / "design.yaml")
    assert plan.present == {"sample_rate_hz": 2000.0, "counts_per_rev": 1200}
    assert plan.stiffness == pytest.approx(0.375)
    again = begin_from("design", begun("remedies"), "my-design", tmp_path)
    assert again.splitlines()[1:] == first.splitlines()[1:]


def test_a_sweep_takes_a_remedy_along(begun, tmp_path: Path) -> None:
    """The base by its first hand with the change of the remedy; without one, the base."""
    trial = begun("remedies")
    (tmp_path / "plain.yaml").write_text(begin_from("sweep", trial, "plain", tmp_path))
    assert load(tmp_path / "plain.yaml").scene == load(tmp_path / "own.yaml").scene
    for name in ("softer wall", "counts x 4"):
        (tmp_path / "one.yaml").write_text(begin_from("sweep", trial, "one", tmp_path, remedy=name))
        plan = load(tmp_path / "one.yaml")
        tried = next(one.grid for one in load(trial).remedies if one.name == name)
        assert plan.scene._replace(hand=None) == tried.scene._replace(hand=None)
        assert plan.scene.hand == load(tmp_path / "own.yaml").scene.hand
        assert plan.axes["counts_per_rev"] == tried.axes["counts_per_rev"]
    with pytest.raises(UsageError, match="--remedy: unknown remedy 'softer wal'; did you mean 'softer wall'"):
        begin_from("sweep", trial, "one", tmp_path, remedy="softer wal")
    tuned = trial.read_text().replace(
        "  plain wall: {}", "  tuned: {tune: {knob.damping: [0.1, 0.2]}}\n  plain wall: {}"
    )
    trial.write_text(tuned)
    with pytest.raises(UsageError, match="'tuned' is tuned cell by cell"):
        begin_from("sweep", trial, "one", tmp_path, remedy="tuned")


def test_a_preset_is_named_and_not_copied(begun, tmp_path: Path) -> None:
    text = "kind: sweep\nname: s\nscene: {from: smartknob, hand: {table: 1, grip_n: 0.71}}\n"
    plan = load(begun("remedies", text))
    assert "from: smartknob" in (tmp_path / "remedies.yaml").read_text()
    assert plan.remedies[0].grid.scene.knob == load(tmp_path / "own.yaml").scene.knob


@pytest.mark.parametrize(
    ("kind", "old", "new", "said"),
    [
        (
            "bench",
            "",
            "",
            "a spec of kind bench cannot begin from another spec; sweep, remedies, design, predict, dfa can",
        ),
        ("dfa", "", "", r"cannot begin from .*own.yaml: scene.knob.coulomb_torque: must be absent: Coulomb friction"),
        ("design", "2 kHz", "[1000, 2000]", "a design begins from a knob of one sample rate"),
        ("remedies", "kind: sweep", "kind: dfa", "is a spec of kind dfa; sweep and remedies can be begun from"),
    ],
)
def test_what_cannot_be_begun_from_says_why(begun, kind: str, old: str, new: str, said: str) -> None:
    with pytest.raises(UsageError, match=said):
        begun(kind, SWEEP.replace(old, new, 1) if old else SWEEP)


def test_faults_of_the_spec_are_its_own(begun) -> None:
    with pytest.raises(SpecError, match=r"own.yaml:2:1: nme: unknown key"):
        begun(KINDS[0], SWEEP.replace("name:", "nme:"))
