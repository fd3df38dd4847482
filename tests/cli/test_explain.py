"""``hknob explain``: every shipped spec is explained; derived numbers are those of formulas written out here."""

import json
from math import exp, pi, sqrt
from pathlib import Path

import pytest

from hknob_cli.cli.check import _explained
from hknob_cli.report.scene_words import as_data, explained_text
from hknob_cli.specs.load import load
from hknob_cli.specs.starter import starter
from hknob_cli.stage_table import KINDS, STAGES
from hknob_cli.stages.explain import EXPLANATIONS
from tests.conftest import EXPERIMENTS, ROOT

SPEC = """\
kind: sweep
name: small
scene:
  knob: {inertia: 2.0e-6, damping: 1.0e-4, coulomb_torque: 2.0e-4}
  hand: {inertia: 3.0e-7, damping: 3.0e-4, stiffness: 0.04}
  wall: {stiffness: 0.3}
  bias: {torque: 0.001}
  actuator: {delay_samples: 1, time_constant: 1.0e-4}
grid:
  sample_rate_hz: [500, 1000, 4000]
  counts_per_rev: [512, 2048]
  wall.stiffness: [0.2, 0.5]
starts: {angle: 0.02, phases: 8}
"""


def numbers(text: str, tmp_path: Path, *sets: str) -> dict[str, tuple[float, float]]:
    """Least and largest of each derived number, in SI units."""
    (tmp_path / "spec.yaml").write_text(text)
    data = as_data(_explained(tmp_path / "spec.yaml", sets))
    return {one["name"]: (one["least"], one["largest"]) for one in data["numbers"]}


@pytest.mark.parametrize("path", sorted(EXPERIMENTS.glob("*.yaml")), ids=lambda path: path.stem)
def test_every_experiment_is_explained(path: Path, monkeypatch) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("COLUMNS", "80")
    found = _explained(path, ())
    text = explained_text(found)
    assert text.startswith(found.answer[:40])
    assert found.answer[-1] in ".?"
    assert all(len(line) <= 80 or " " not in line.strip() for line in text.splitlines())
    assert "nan" not in text.split()
    json.dumps(as_data(found), allow_nan=False)


def test_a_kind_without_an_explanation_of_its_own_is_told_by_its_row(monkeypatch) -> None:
    assert set(EXPLANATIONS) <= set(KINDS)
    monkeypatch.delitem(EXPLANATIONS, "bench")
    monkeypatch.chdir(ROOT)
    found = _explained(EXPERIMENTS / "bench_quick.yaml", ())
    assert found.answer == STAGES["bench"].summary
    assert found.sections["work"] == [f"{len(load(EXPERIMENTS / 'bench_quick.yaml').scenes)} scenes."]


@pytest.mark.parametrize("kind", KINDS)
def test_every_starter_is_explained(kind: str, tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text(starter(kind))
    found = _explained(tmp_path / "spec.yaml", ())
    assert (found.kind, found.next.split()[:2]) == (kind, ["hknob", kind])


def test_numbers_by_hand(tmp_path: Path) -> None:
    found = numbers(SPEC, tmp_path)
    inertia, damping = 2.0e-6 + 3.0e-7, 1.0e-4 + 3.0e-4
    small, large = 0.2 * 2.0 * pi / 2048, 0.5 * 2.0 * pi / 512
    expected = {
        "one count": (2.0 * pi / 2048, 2.0 * pi / 512),
        "sample period T": (1.0 / 4000, 1.0 / 500),
        "torque step": (small, large),
        "half quantum": (small / 2.0, large / 2.0),
        "push": (0.001 / large, 0.001 / small),
        "friction": (2.0e-4 / large, 2.0e-4 / small),
        "inertia of knob and hand": (inertia, inertia),
        "damping of knob and hand": (damping, damping),
        "time constant": (inertia / damping,) * 2,
        "pitch off the wall": (sqrt(0.04 / inertia) / (2.0 * pi),) * 2,
        "pitch on the wall": tuple(sqrt((k + 0.04) / inertia) / (2.0 * pi) for k in (0.2, 0.5)),
        "damping ratio on the wall": tuple(damping / 2.0 / sqrt((k + 0.04) * inertia) for k in (0.5, 0.2)),
        "delay": (1.5 / 4000 + 1.0e-4, 1.5 / 500 + 1.0e-4),
        # K (T / 2 + t_d), which the formula is at a whole number of samples without virtual damping
        "damping for passivity": (0.2 * 1.5 / 4000, 0.5 * 1.5 / 500),
    }
    assert found.keys() == expected.keys()
    for name, ends in expected.items():
        assert found[name] == pytest.approx(ends, rel=1e-12), name


def test_numbers_of_a_bounded_lag(tmp_path: Path) -> None:
    """Of r = J/(b tau): the least part of a step that it may keep, the best by the rule, and the gain of its mean."""
    lag = "scene.controller={kind: bounded_lag, keep: 0.15, time_constant: 0.2}"
    found = numbers(SPEC, tmp_path, lag, "grid={sample_rate_hz: 1000, counts_per_rev: 512}")
    r = 2.3e-6 / (4.0e-4 * 0.2)
    for name, value in (("least keep", r), ("best keep", 2.0 * r / (1.0 + r)), ("gain of the lag", 1.0 - exp(-0.005))):
        assert found[name] == pytest.approx((value, value), rel=1e-12), name
    other = numbers(SPEC, tmp_path, "scene.controller={kind: half_sample}")
    assert not {"least keep", "best keep", "gain of the lag"} & other.keys()


def test_numbers_of_a_detent(tmp_path: Path) -> None:
    """Its slope at rest, and no damping ratio on a wall that is not there."""
    spec = SPEC.replace("grid:", "  detents: {torque: 0.005, per_revolution: 24}\ngrid:")
    grid = "grid={sample_rate_hz: 1000, counts_per_rev: 512}"
    found = numbers(spec, tmp_path, "scene.wall.stiffness=0", "scene.wall.damping=0", grid)
    slope = 24.0 * 0.005
    assert found["stiffness of a detent"] == pytest.approx((slope, slope))
    assert found["pitch in a detent"] == pytest.approx((sqrt((slope + 0.04) / 2.3e-6) / (2.0 * pi),) * 2)
    assert found["a late detent drives"] == pytest.approx((slope * found["delay"][0],) * 2)
    assert "damping ratio on the wall" not in found


def test_a_half_quantum_is_half_a_step(tmp_path: Path) -> None:
    found = numbers(SPEC, tmp_path, "scene.bias={half_quantum: true}")
    assert found["push"] == (0.5, 0.5)


def test_ranges_of_a_large_grid_are_those_of_all_its_cells(tmp_path: Path) -> None:
    """Of more than 4096 combinations only the ends are taken: the same as all of them."""
    grid = "grid={sample_rate_hz: {log: [100, 9000, 90]}, counts_per_rev: 512, wall.stiffness: {lin: [0.1, 1, 91]}}"
    found = numbers(SPEC, tmp_path, grid, "scene.actuator=null")
    every = [0.5 * stiffness / rate for rate in (100.0, 9000.0) for stiffness in (0.1, 1.0)]
    assert found["damping for passivity"] == pytest.approx((min(every), max(every)), rel=1e-12)


def test_passivity_is_judged_by_the_damping(tmp_path: Path) -> None:
    """K T / 2 is 1.5e-4 for 0.3 N*m/rad at 1 kHz; the knob has 1e-4 N*m*s/rad, knob and hand 4e-4."""
    (tmp_path / "spec.yaml").write_text(SPEC)
    sets = ("grid={sample_rate_hz: 1000, counts_per_rev: 512}", "scene.actuator=null")
    one, other, _ = as_data(_explained(tmp_path / "spec.yaml", sets))["passivity"]
    assert one.endswith("? No.")
    assert "Yes: b is 2.667 times" in other
    stiff = as_data(_explained(tmp_path / "spec.yaml", (*sets, "scene.wall.stiffness=0.9")))["passivity"]
    assert "No: b is 0.8889 times" in stiff[1]
    both = (*sets[1:], "grid={sample_rate_hz: [1000, 200], counts_per_rev: 512}")
    assert "In a part of the grid only" in as_data(_explained(tmp_path / "spec.yaml", both))["passivity"][1]


def test_passivity_is_asked_of_the_longest_interval_of_a_clock(tmp_path: Path) -> None:
    """A clock that may jitter by 90 % may always be late: b is to be above K T (1 + 0.9) / 2."""
    (tmp_path / "spec.yaml").write_text(starter("sweep"))
    scene = (
        "{knob: {inertia: 1.9e-6}, hand: {inertia: 3e-7, damping: %g}, wall: {stiffness: 0.27}, clock: {jitter: 0.9}}"
    )
    needed = 0.27 * 1e-3 * 1.9 / 2
    for factor, word in ((0.999, "No"), (1.001, "Yes")):
        sets = (f"scene={scene % (factor * needed)}", "grid={sample_rate_hz: 1000, counts_per_rev: 1024}")
        lines = as_data(_explained(tmp_path / "spec.yaml", sets))["passivity"]
        assert lines[1].startswith(f"Is that of knob and hand? {word}: b is")
        assert lines[2] == "It is asked of the longest interval that the clock may have."


def test_what_is_not_proven_and_ignored_is_said(tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text(SPEC)
    bare = as_data(_explained(tmp_path / "spec.yaml", ("scene.encoder=none", "grid={sample_rate_hz: 1000}")))
    assert "may stay unproven" in bare["not_proven"][0]
    assert as_data(_explained(tmp_path / "spec.yaml", ()))["not_proven"] == []
    still = as_data(_explained(tmp_path / "spec.yaml", ("scene.bias=null",)))
    assert any("nothing pushes" in line.lower() for line in still["ignored"])
    (tmp_path / "preset.yaml").write_text(starter("sweep", "smartknob"))
    preset = as_data(_explained(tmp_path / "preset.yaml", ()))
    assert any(line.startswith("left out by the preset: detents, cogging") for line in preset["ignored"])


def test_as_a_user_runs_it(hknob, tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text(SPEC)
    done = hknob("explain", "spec.yaml")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert done.stdout.startswith(
        "A 3 x 2 x 2 grid of sample rates, encoder resolutions and values of wall.stiffness asks"
    )
    assert "  Wall: a spring below the angle 0, 0.2 to 0.5 N*m/rad (2 values)." in done.stdout
    assert done.stdout.endswith("next: hknob sweep spec.yaml\n")
    data = json.loads(hknob("explain", "spec.yaml", "--json", "--set", "grid.counts_per_rev=1024").stdout)
    step = next(one for one in data["numbers"] if one["name"] == "one count")
    assert step["least"] == step["largest"] == pytest.approx(2.0 * pi / 1024)
    wrong = hknob("explain", "spec.yaml", "--set", "scene.wall.stiffness=-1")
    assert wrong.returncode == 2
    assert "must be >= 0" in wrong.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["spec.yaml"]


def test_settings_are_repeated_in_what_is_next(tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text(SPEC)
    found = _explained(tmp_path / "spec.yaml", ("scene.wall.stiffness=0.3", "grid.counts_per_rev=[512, 1024]"))
    assert found.next.endswith("spec.yaml --set scene.wall.stiffness=0.3 --set 'grid.counts_per_rev=[512, 1024]'")
    assert _explained(tmp_path / "spec.yaml", ()).next.endswith("spec.yaml")


@pytest.mark.parametrize(
    ("starts", "every", "some"),
    [
        ("{angle: 0.02}", "every phase of the sample clock. Results say in which cells", "64 phases of the sample"),
        ("{angle: [-0.05, 0.05], velocity: [-5, 5]}", "Every state from -50 to 50 mrad", "Some states from -50 to 50"),
    ],
)
def test_starts_that_are_not_all_followed_are_said_to_be_some(
    starts: str, every: str, some: str, tmp_path: Path
) -> None:
    text = SPEC[: SPEC.index("starts:")] + f"starts: {starts}\n"
    (tmp_path / "spec.yaml").write_text(text)
    whole = " ".join(explained_text(_explained(tmp_path / "spec.yaml", ())).split())
    assert every in whole
    assert some not in whole
    jitters = " ".join(explained_text(_explained(tmp_path / "spec.yaml", ("scene.clock={jitter: 0.1}",))).split())
    assert some in jitters
    assert "Results say" not in jitters
