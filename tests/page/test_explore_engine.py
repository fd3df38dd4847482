"""The engine of the explore page against the program: the same trial, the same cycle, to nine digits."""

import json
import random
from collections import Counter
from collections.abc import Iterator
from math import isnan
from typing import Any

import pytest

from hknob_cli.engine.outcome import Outcome
from hknob_cli.page.explore import KINDS, knobs_of
from hknob_cli.page.explore import engine as engine_text
from hknob_cli.perception.touch import thresholds
from hknob_cli.scene.general_knob import simulate
from hknob_cli.specs.plan import scene_at
from tests.conftest import ROOT
from tests.page.explore_scenes import (
    CONTROLLERS,
    OTHERS,
    RADIUS_M,
    Scene,
    is_quick,
    plan_of,
    random_scene,
    trial_of,
)

Engine = pytest.importorskip("py_mini_racer", reason="mini-racer is not installed").MiniRacer

DIGITS = 1e-9
FIND = """\
function found(scene, touch) {
  const one = Knob.solve(scene, {motion: false});
  const {outcome, p2p, frequency, min, max, period, cycles} = one;
  return JSON.stringify({outcome, p2p, frequency, min, max, period, cycles, touch: Knob.touchLevel(one, touch)});
}
function motion(scene, samples) {
  const one = Knob.solve(scene);
  return JSON.stringify(Array.from({length: samples}, (_, i) => Knob.at(one, i + 1e-12)));
}"""


@pytest.fixture(scope="module")
def engine() -> Iterator[Any]:
    with Engine() as engine:
        engine.eval(engine_text())
        engine.eval(FIND)
        yield engine


def found(engine: Any, scene: Scene) -> dict[str, Any]:
    felt = thresholds()
    touch = {"points": felt.points.tolist(), "low": felt.low_hz, "high": felt.high_hz, "radius": RADIUS_M}
    answer: dict[str, Any] = json.loads(engine.eval(f"found({json.dumps(scene)}, {json.dumps(touch)})"))
    return answer


def compare(engine: Any, scene: Scene) -> str:
    """The outcome, which is the same in both; sizes, pitches, levels are, too."""
    result, ours = trial_of(plan_of(scene)), found(engine, scene)
    assert len(result.attractors) == 1
    attractor, measures, felt = result.attractors[0], result.measures[0], result.perceived[0]
    assert ours["outcome"] == attractor.outcome.name.lower()
    if attractor.outcome is not Outcome.CYCLE:
        return str(ours["outcome"])
    assert ours["frequency"] == pytest.approx(measures.frequency_hz, rel=DIGITS)
    if not attractor.certified:
        # Nothing holds the knob: what the program has is the trial's last period, which comes back by its closure only.
        near = 10.0 * attractor.closure * result.quantum_rad
        assert ours["p2p"] == pytest.approx(measures.p2p_rad, rel=DIGITS, abs=near)
        return "cycle"
    assert ours["p2p"] == pytest.approx(measures.p2p_rad, rel=DIGITS)
    assert ours["min"] == pytest.approx(measures.min_rad, rel=DIGITS, abs=DIGITS * measures.p2p_rad)
    assert ours["max"] == pytest.approx(measures.max_rad, rel=DIGITS, abs=DIGITS * measures.p2p_rad)
    if isnan(felt.touch_db):
        assert ours["touch"] is None
    else:
        assert ours["touch"]["level"] == pytest.approx(felt.touch_db, abs=1e-6)
        assert ours["touch"]["hertz"] == pytest.approx(felt.touch_hz, rel=DIGITS)
    return "proven"


def scenes(remedy: str, count: int) -> list[Scene]:
    """Scenes under a remedy whose trial is soon at its end; the same ones at every call."""
    chance, some = random.Random(remedy), []
    while len(some) < count:
        scene = random_scene(chance, remedy)
        if is_quick(plan_of(scene)):
            some.append(scene)
    return some


def _compare_all(engine: Any, remedy: str, count: int) -> None:
    outcomes = Counter(compare(engine, scene) for scene in scenes(remedy, count))
    assert outcomes["proven"] > 0


@pytest.mark.one_in(3)
@pytest.mark.parametrize("remedy", [*OTHERS, *CONTROLLERS])
def test_its_cycles_are_those_of_the_program(engine: Any, remedy: str) -> None:
    _compare_all(engine, remedy, 4)


@pytest.mark.long
@pytest.mark.parametrize("remedy", [*OTHERS, *CONTROLLERS])
def test_two_hundred_cycles_are_those_of_the_program(engine: Any, remedy: str) -> None:
    _compare_all(engine, remedy, 20)


def test_every_controller_of_the_page_is_compared() -> None:
    assert set(CONTROLLERS) == set(KINDS)


@pytest.mark.parametrize("remedy", ["plain", "virtual damping", "delay", "amplifier"])
def test_its_motion_is_that_of_the_program(engine: Any, remedy: str) -> None:
    """Sample by sample, from the first; a difference of roundings grows at no count edge."""
    for scene in scenes(remedy, 4):
        plan, start = plan_of(scene), scene["start"]
        cell = {"sample_rate_hz": scene["rate"], "counts_per_rev": scene["counts"]}
        trial = simulate(
            scene_at(plan.scene, cell),
            sample_rate_hz=scene["rate"],
            counts_per_rev=scene["counts"],
            angle_rad=start["angle"],
            velocity_rad_s=start["velocity"],
            samples=60,
        )
        ours = json.loads(engine.eval(f"motion({json.dumps(scene)}, 60)"))
        size = max(abs(trial.angle_rad))
        assert [one["angle"] for one in ours] == pytest.approx(trial.angle_rad[:60].tolist(), rel=1e-9, abs=1e-9 * size)
        most = max(1e-6, max(abs(trial.torque_nm)))
        held = trial.torque_nm[:60].tolist()
        if scene["delay"] % 1.0 == 0.0:
            assert [one["torque"] for one in ours] == pytest.approx(held, rel=1e-9, abs=1e-9 * most)


def test_a_scene_without_an_answer_says_so(engine: Any) -> None:
    """A knob that nothing holds runs away; what cannot be reduced to numbers is an error, not an answer."""
    scene = scenes("plain", 1)[0]
    loose = {**scene, "hand": None, "damping": 1e-4, "stiffness": 0.0, "push": 1e-3, "friction": 0.0}
    assert found(engine, loose)["outcome"] in ("diverged", "undecided")
    for wrong in ({**loose, "controller": {"kind": "matched_wall"}}, {**scene, "inertia": 1e-320, "hand": None}):
        answer = engine.eval(f"try {{ found({json.dumps(wrong)}, null) }} catch (error) {{ error.name }}")
        assert answer == "RangeError"


def test_what_a_spec_says_reaches_the_engine(engine: Any) -> None:
    """From spec to page to engine: the cycle of the spec's own trial."""
    for remedy in ("rounding", "velocity_damping"):
        scene = scenes(remedy, 1)[0]
        made = knobs_of(plan_of(scene), "spec.yaml").cells[0]["scene"]
        assert found(engine, made) == found(engine, scene)


def test_the_bounded_lag_begins_at_its_best(engine: Any) -> None:
    """The page's part of a step is that of the rule, to two digits, and the plain wall where the rule has none."""
    from hknob_cli.theory.staircase import best_keep, slowness

    remedies = (ROOT / "hknob_cli" / "page" / "explore" / "remedies.js").read_text(encoding="utf-8")
    engine.eval(f"{remedies}; var choices = Choices;")
    chance = random.Random(11)
    for _ in range(50):
        inertia, damping = 10.0 ** chance.uniform(-6.5, -4.0), 10.0 ** chance.uniform(-5.0, -2.5)
        hand = {"inertia": 2e-7, "damping": 3e-4, "stiffness": 0.04} if chance.random() < 0.7 else None
        scene = {"inertia": inertia, "damping": damping, "hand": hand}
        r = slowness(
            inertia_kg_m2=inertia + (hand["inertia"] if hand else 0.0),
            damping_nm_s_per_rad=damping + (hand["damping"] if hand else 0.0),
            time_constant_s=0.2,
        )
        found = engine.eval(f"choices.REMEDIES.bounded_lag.from({json.dumps(scene)}).keep")
        assert found == float(f"{best_keep(r):.2g}")
    assert engine.eval("choices.bestKeep({inertia: 2e-6, damping: 0, hand: null})") == 1
