"""Tests of `stages.design.ranking`: what other levels, thresholds and people would have made of an answer."""

from math import inf
from typing import Any

import pytest

from hknob_cli.perception.level import Doubt, doubts, other_sets
from hknob_cli.specs.stage_plans import Limit
from hknob_cli.stages.design.designs import Design
from hknob_cli.stages.design.ranking import Judged, answer_if, judge, meets, redrawn
from hknob_cli.stages.design.work import DesignStage
from hknob_cli.stages.sweep.run import Engines
from tests.designs import DESIGN, planned

ABOVE = Limit(most_db=0.0, people=0.0, above_present=True)


def judged(touch: list[float], *, others: list[float] | None = None, limit: Limit = ABOVE, **fails: str) -> Judged:
    over = sum(one > limit.most_db for one in touch) > limit.people * len(touch)
    return Judged(
        row={},
        fails={**fails, **({"touch": "+"} if over else {})},
        felt_db=max(touch),
        asked={"touch": (limit, touch)},
        others={"thenar": others or touch},
    )


def test_a_tenth_of_a_decibel_does_not_decide_unsaid() -> None:
    """The design that fails by 0.1 dB is the answer if levels are 2 dB lower; that is said beside the answer."""
    cheap, dear = Design(0, (), 0.05), Design(0, (), 1.05)
    done = {cheap: judged([-3.0, 0.1]), dear: judged([-9.0, -4.5])}
    order = {cheap: 0, dear: 1}
    assert answer_if(done, order, Doubt("as given"), 1.05) == dear
    assert answer_if(done, order, Doubt("lower", -2.0), 1.05) == cheap
    assert answer_if(done, order, Doubt("higher", 2.0), 1.05) == dear
    assert answer_if(done, order, Doubt("higher", 5.0), 1.05) is None


def test_other_thresholds_judge_touch_and_leave_what_else_fails() -> None:
    one = judged([1.0, 1.0], others=[-1.0, -1.0])
    assert not meets(one, Doubt("as given"))
    assert meets(one, Doubt("thenar", thresholds="thenar"))
    assert not meets(judged([-1.0], stiffness="0.2 N*m/rad"), Doubt("lower", -2.0))
    # What rests stays below every limit, what is not known above, whatever the levels are.
    assert meets(judged([-inf]), Doubt("higher", 50.0))
    assert not meets(judged([inf]), Doubt("lower", -50.0))


def test_the_present_design_is_no_louder_than_itself_whatever_levels_are() -> None:
    assert meets(judged([0.0, 0.0]), Doubt("higher", 2.0))
    assert not meets(judged([0.0, -1.0]), Doubt("higher", 2.0))
    assert not meets(judged([0.0], limit=Limit(1.0, 0.0, above_present=False)), Doubt("higher", 2.0))


def test_one_person_of_twenty_who_is_over_may_or_may_not_be_drawn() -> None:
    """1 - (1 - 1/20)^20 = 64 % of redraws have the one who is over the limit."""
    cheap, dear = Design(0, (), 0.0), Design(0, (), 1.0)
    done = {cheap: judged([-1.0] * 19 + [1.0]), dear: judged([-1.0] * 20)}
    found = redrawn(done, {cheap: 0, dear: 1})
    assert found[cheap] + found[dear] == pytest.approx(1.0, abs=1e-12)
    assert found[dear] == pytest.approx(1.0 - 0.95**20, abs=0.06)  # four standard deviations of 1000 redraws
    assert redrawn({dear: done[dear]}, {dear: 0}) == {dear: 1.0}
    assert redrawn({cheap: judged([1.0])}, {cheap: 0}) == {}


def test_every_published_set_and_both_ways_are_asked() -> None:
    plan = planned()
    assert "pen_hold" not in other_sets(plan)
    names = [one.name for one in doubts(plan)]
    assert names[:2] == ["levels 2 dB lower", "levels 2 dB higher"]
    assert names[2:] == [f"thresholds {name}" for name in other_sets(plan)]
    assert doubts(plan._replace(touch=None)) == ()


@pytest.mark.long
def test_a_search_says_what_would_change_its_answer() -> None:
    """Sensitive hands: the row that `answer_if` names is what the search answers under the limit moved so."""
    plan = planned(DESIGN.replace("{above_present: 0}", "{at_most: 20}"))
    rows = DesignStage(plan._replace(exhaustive=True), jobs=1).run().to_pylist()
    chosen = next(row for row in rows if row["chosen"])
    assert chosen["margin_db"] == pytest.approx(20.0 - chosen["touch_db"])
    for name, most in (("levels 2 dB lower", 22.0), ("levels 2 dB higher", 18.0)):
        named = [row for row in rows if name in row["answer_if"].split("; ")]
        other = plan._replace(touch=Limit(most, 0.0, above_present=False), exhaustive=True)
        answer = [row for row in DesignStage(other, jobs=1).run().to_pylist() if row["chosen"]]
        assert [_which(row) for row in named] == [_which(row) for row in answer]


def _which(row: dict[str, Any]) -> tuple[Any, ...]:
    return row["remedy"], row["sample_rate_hz"], row["counts_per_rev"], row["knob.damping"]


def test_a_cycle_without_a_level_beside_one_with_a_level_is_not_known() -> None:
    """The loudest of two cycles is not known where one has no level: the limit must not pass by the other alone."""
    from hknob_cli.engine.attractors import Attractor
    from hknob_cli.engine.outcome import Outcome, Reason
    from hknob_cli.measure.orbit import OrbitMeasures
    from hknob_cli.stages.design.designs import Evaluator
    from hknob_cli.stages.sweep.cell import CellResult
    from hknob_cli.stages.sweep.perceived import Perceived

    plan = planned()
    evaluator = Evaluator(plan, Engines())
    scene = plan.candidates[0].sweep.scene
    cycle = Attractor(outcome=Outcome.CYCLE, reason=Reason.NONE, trials=1)
    cell = {"sample_rate_hz": 500.0, "counts_per_rev": 360, "person": 1}
    shares = {"undecided_fraction": 0.0, "diverged_fraction": 0.0, "at_rest_fraction": 0.0, "certified_fraction": 1.0}
    row = {**shares, "touch_db": 5.0, "hearing_relative_db": -3.0, "torque_step_db": 1.0}
    levels = Perceived(touch_db=5.0, hearing_db=-3.0, others_db=(1.0, 2.0, 3.0))
    both = CellResult(
        cell, 1e-3, (cycle, cycle), (OrbitMeasures(), OrbitMeasures()), 0, perceived=(levels, Perceived())
    )
    found = evaluator._person(row, both, scene)
    assert found["touch_db"] is None
    assert found["hearing_relative_db"] is None
    assert set(found["by_set"].values()) == {inf}
    assert judge(plan, [found, found], [found, found], 0.27).fails["touch"] == "not known"
    one = evaluator._person(
        row, both._replace(attractors=(cycle,), measures=(OrbitMeasures(),), perceived=(levels,)), scene
    )
    assert one["touch_db"] == 5.0
    assert list(one["by_set"].values()) == [1.0, 2.0, 3.0]
