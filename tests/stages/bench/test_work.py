"""Tests of `stages.bench.work`: references have an end, and a scene without one says so.

Verdicts, on made-up motions.
"""

from math import inf, pi, sin

import pytest

from hknob_cli.baselines.digits60 import Digits60
from hknob_cli.baselines.model import Deadline, TooSlowError
from hknob_cli.errors import ComputationError
from hknob_cli.report.bench import bench_text, describe_bench
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import BenchPlan, BenchScene
from hknob_cli.stages.bench import timed as bench_run
from hknob_cli.stages.bench.work import BenchStage, judge, measure
from tests.baselines.trials import trial
from tests.conftest import EXPERIMENTS

CASE: BenchScene = trial(samples=29)
Q = 2.0 * pi / 1000
CYCLE = [0.7 * Q * sin(0.9 * i) for i in range(30)]


def verdict(angles: list[float], reference: list[float] = CYCLE) -> str:
    return judge(CASE, angles, reference, accurate=1e-6, same_attractor=0.01).verdict


def test_accurate_up_to_the_threshold() -> None:
    swing = measure(CASE, CYCLE).swing_rad
    assert verdict(CYCLE) == "accurate"
    assert verdict([*CYCLE[:5], CYCLE[5] + 0.9e-6 * swing, *CYCLE[6:]]) == "accurate"
    assert verdict([*CYCLE[:5], CYCLE[5] + 1.1e-6 * swing, *CYCLE[6:]]) == "inaccurate"


def test_another_attractor() -> None:
    assert verdict([1.005 * angle for angle in CYCLE]) == "inaccurate"
    assert verdict([1.02 * angle for angle in CYCLE]) == "wrong attractor"
    assert verdict([angle - Q for angle in CYCLE]) == "wrong attractor"  # the same size, a count deeper
    assert verdict([0.0] * 30) == "wrong attractor"  # rest instead of a cycle
    assert verdict(CYCLE, [0.0] * 30) == "wrong attractor"  # a cycle instead of rest


def test_errors_are_to_the_swing_of_the_last_third() -> None:
    start = [0.02 - 1e-3 * i for i in range(20)]
    judged = judge(CASE, [*start, *CYCLE[:10]], [*start, *[angle + 1e-6 for angle in CYCLE[:10]]],
                   accurate=1e-6, same_attractor=0.01)  # fmt: skip
    p2p = max(CYCLE[:10]) - min(CYCLE[:10])
    assert judged.p2p_rad == pytest.approx(p2p, rel=1e-12)
    assert judged.relative_error == pytest.approx(1e-6 / p2p, rel=1e-6)


def test_at_rest_the_swing_is_that_of_the_whole_trial() -> None:
    rest = [0.02] * 5 + [-0.001] * 25
    found = measure(CASE, rest)
    assert (found.p2p_rad, found.swing_rad) == (0.0, pytest.approx(0.021))
    assert judge(CASE, [0.5] * 30, [0.5] * 30, accurate=1e-6, same_attractor=0.01).relative_error == 0.0
    assert judge(CASE, [0.5] * 30, [0.4] * 30, accurate=1e-6, same_attractor=0.01).relative_error == inf


STIFF = "base.scene.hand.stiffness=1e12"  # turns 2e5 times in a sample interval
RUBS = "scenes={stiff: {scene: {knob: {coulomb_torque: 1.0e-4}}}}"
WITHOUT_CLOCK = "scenes={stiff: {scene: {sampling: continuous}}}"
EXACT = "scenes={stiff: {reference: exact, scene: {knob: {coulomb_torque: 1.0e-4}}}}"
FEW = 1000  # products of a matrix and a state, of 20 us each


def quick(*sets: str) -> BenchPlan:
    plan = load(EXPERIMENTS / "bench_quick.yaml", sets)
    assert isinstance(plan, BenchPlan)
    return plan


@pytest.fixture
def over(monkeypatch: pytest.MonkeyPatch) -> None:
    """The time is over from the beginning; a reference that does not look fails after a few steps, and ends."""
    monkeypatch.setattr(bench_run, "Deadline", lambda _seconds: Deadline(-1.0))
    apply, left = Digits60._apply, iter(range(FEW))

    def counted(self: Digits60, matrix: list[list[object]], state: list[object]) -> list[object]:
        assert next(left, None) is not None, "it works on after its time"
        return apply(self, matrix, state)

    monkeypatch.setattr(Digits60, "_apply", counted)


@pytest.mark.usefixtures("over")
@pytest.mark.parametrize("scene", [RUBS, WITHOUT_CLOCK])
def test_a_reference_in_60_digits_looks_at_the_time_within_an_interval(scene: str) -> None:
    (trial,) = quick(STIFF, scene).scenes
    assert bench_run.reference(trial, limit_s=0.2) == (None, "digits60 takes longer than 4 s")


@pytest.mark.parametrize("scene", [WITHOUT_CLOCK, "scenes={usual: {}}"])
def test_the_engine_looks_at_the_time_too(scene: str) -> None:
    (trial,) = quick("base.scene.hand.stiffness=1e9", scene).scenes
    with pytest.raises(TooSlowError):
        bench_run._exact(trial, Deadline(-1.0), compiled=False)


@pytest.mark.long
@pytest.mark.parametrize(
    ("scene", "why"),
    [(RUBS, "digits60 takes longer than 1 s"), (EXACT, "exact cannot follow it: at 1000 Hz the scene")],
)
def test_a_scene_without_a_reference_does_not_end_the_others(
    scene: str, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Digits60, "_apply", _too_slow)
    usual = "usual: {reference: exact, scene: {hand: {stiffness: 0.04}}}"
    plan = quick(
        STIFF, scene.replace("scenes={", f"scenes={{{usual}, "), "methods=[exact, rk4]", "settings.substeps=[1]"
    )
    table = BenchStage(plan._replace(seconds_per_run=0.01), jobs=1).run()
    verdicts = {(row["scene"], row["method"], row["setting"]): row["verdict"] for row in table.to_pylist()}
    assert verdicts["usual", "exact", "compiled"] == "accurate"
    assert {verdict for (name, _, _), verdict in verdicts.items() if name == "stiff"} <= {"failed", "no reference"}
    text = bench_text({"name": "x", "status": "done", **describe_bench(table.to_pylist())})
    assert f"stiff: no reference, so errors are unknown: {why}" in text
    assert "usual: no reference" not in text


def test_a_good_run_without_a_reference_has_no_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Digits60, "_apply", _too_slow)
    plan = quick("scenes={usual: {}}", "methods=[exact]", "base.duration=0.01")
    rows = BenchStage(plan, jobs=1).run().to_pylist()
    assert {row["verdict"] for row in rows} == {"no reference"}
    assert {row["reference_swing_rad"] for row in rows} == {None}
    assert "N no reference" in bench_text({"name": "x", "status": "done", **describe_bench(rows)})


@pytest.mark.long
def test_the_net_of_events_is_fine_enough_for_the_wall() -> None:
    """Without clock and encoder the wall is a spring; of 1e6 N·m/rad, it throws the knob out within 5 us."""
    (trial,) = quick("scenes={hard: {scene: {sampling: continuous, encoder: none, wall: {stiffness: 1e6}}}}").scenes
    ours = bench_run._exact(trial, Deadline(60.0), compiled=False).angles
    assert bench_run.reference(trial, limit_s=60.0).angles == pytest.approx(ours, abs=1e-9)


def test_an_interval_that_overflows_has_no_motion() -> None:
    parts = "sampling: continuous, hand: {inertia: 0, stiffness: 1e12}, knob: {inertia: 1e-300}"
    (trial,) = quick(f"scenes={{light: {{scene: {{{parts}}}}}}}").scenes
    with pytest.raises(ComputationError, match="numbers overflow"):
        bench_run._exact(trial, Deadline(60.0), compiled=False)


def _too_slow(_self: Digits60, _matrix: object, _state: object) -> None:
    raise TooSlowError
