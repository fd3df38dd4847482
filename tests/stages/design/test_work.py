"""Tests of `stages.design.work`: against brute force over all designs, and what is said of the answer."""

from math import inf, log, pi
from random import Random
from typing import Any

import pytest

from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.specs.stage_plans import DesignPlan, Limit
from hknob_cli.stages.design.designs import Design, Evaluator, Rows, _pushes, designs, present, relaxed, surface
from hknob_cli.stages.design.ranking import above, exceeded_by, judge, level
from hknob_cli.stages.design.work import DesignStage
from hknob_cli.stages.sweep.run import Engines
from tests.designs import DESIGN, planned

Found = dict[Design, tuple[Rows, float]]


@pytest.fixture(scope="module")
def everything() -> dict[tuple[int, tuple[Any, ...]], tuple[Rows, float]]:
    """People's rows and stiffness of every design, by remedy and values."""
    plan = planned()
    every = designs(plan)
    found = Evaluator(plan, Engines()).evaluate(every)
    return {(one.candidate, one.values): rows for one, rows in zip(every, found, strict=True)}


class Known:
    """An evaluator that has been everywhere, and counts where it is asked to go."""

    def __init__(self, everything: Any) -> None:
        self.everything, self.asked = everything, 0

    def evaluate(self, some: Any) -> Any:
        self.asked += len(some)
        return [self.everything[one.candidate, one.values] for one in some]


def searched(plan: DesignPlan, everything: Any) -> list[dict[str, Any]]:
    stage = DesignStage(plan, jobs=1)
    stage._evaluator = Known(everything)
    rows: list[dict[str, Any]] = stage.run().to_pylist()
    assert stage._evaluator.asked == len(rows)  # nothing is evaluated twice
    return rows


@pytest.mark.one_in(2)
@pytest.mark.parametrize("exhaustive", [False, True])
def test_processes_find_what_one_finds(monkeypatch: pytest.MonkeyPatch, exhaustive: bool) -> None:
    monkeypatch.setattr("hknob_cli.stages.design.work.FEW", 0)
    plan = planned()._replace(exhaustive=exhaustive)
    alone = DesignStage(plan, jobs=1).run()
    done: list[int] = []
    with DesignStage(plan, jobs=2) as stage:
        assert stage.jobs == 2
        together = stage.run(lambda some, _all: done.append(some))
    assert together.equals(alone)
    assert done == sorted(done)
    assert done[-1] == len(alone)


def priced(plan: DesignPlan, random: Random) -> DesignPlan:
    """The plan at other costs, some of them equal."""
    choices = tuple(
        one._replace(options=tuple(option._replace(cost=float(random.randrange(5))) for option in one.options))
        for one in plan.choices
    )
    candidates = tuple(
        one._replace(cost=0.0 if one.name == plan.reference else float(random.randrange(4))) for one in plan.candidates
    )
    return plan._replace(choices=choices, candidates=candidates)


def brute_force(plan: DesignPlan, everything: Any) -> list[Design]:
    """The cheapest designs for which every person's level is at most the limit, by the rows themselves."""
    good = []
    for one in designs(plan):
        rows, stiffness = everything[one.candidate, one.values]
        assert all(row["touch_db"] is not None or row["at_rest_fraction"] == 1.0 for row in rows)
        felt = [row["touch_db"] for row in rows if row["touch_db"] is not None]
        assert plan.touch
        assert plan.stiffness
        allowed = int(plan.touch.people * len(rows))
        if sum(db > plan.touch.most_db for db in felt) <= allowed and stiffness >= plan.stiffness - 1e-9:
            good.append(one)
    least = min((one.cost for one in good), default=inf)
    return [one for one in good if one.cost == least]


@pytest.mark.one_in(5)
@pytest.mark.parametrize("seed", range(40))
def test_nothing_that_brute_force_finds_is_cheaper(seed: int, everything: Any) -> None:
    random = Random(seed)
    limit = Limit(random.uniform(-5.0, 42.0), random.choice([0.0, 0.5]), above_present=False)
    plan = priced(planned(), random)._replace(touch=limit)
    best = brute_force(plan, everything)
    rows = searched(plan, everything)
    chosen = [row for row in rows if row["chosen"]]
    assert len(chosen) == bool(best)
    if not best:
        assert len(rows) == plan.size
        return
    names = [one.name for one in plan.choices]
    key = (chosen[0]["remedy"], *(chosen[0][name] for name in names))
    assert key in [(plan.candidates[one.candidate].name, *one.values) for one in best]
    tied = [row for row in rows if row["feasible"] and row["cost"] == chosen[0]["cost"]]
    assert len(tied) == len(best)
    assert min(row["touch_db"] or -inf for row in tied) == (chosen[0]["touch_db"] or -inf)
    # What is cheaper was evaluated, not guessed.
    seen = {(row["remedy"], *(row[name] for name in names)) for row in rows}
    cheaper = [one for one in designs(plan) if one.cost < chosen[0]["cost"]]
    assert seen >= {(plan.candidates[one.candidate].name, *one.values) for one in cheaper}


def test_exhaustive_evaluates_all_and_agrees(everything: Any) -> None:
    plan = planned()
    some, all_ = searched(plan, everything), searched(plan._replace(exhaustive=True), everything)
    assert len(some) < len(all_) == plan.size == 30
    assert [row for row in some if row["chosen"]] == [row for row in all_ if row["chosen"]]
    below = next(row for row in some if row["chosen"])["cost"]
    for mine, whole in ((some, all_), (all_, some)):
        front = [row for row in mine if row["front"] and row["cost"] <= below]
        assert front == [row for row in whole if row["front"] and row["cost"] <= below]


def test_the_front_is_what_nothing_beats(everything: Any) -> None:
    rows = searched(planned()._replace(exhaustive=True), everything)
    stiff = [row for row in rows if row["stiffness_nm_per_rad"] >= 0.26]

    def felt(row: Any) -> float:
        return -inf if row["touch_db"] is None else row["touch_db"]

    for row in stiff:
        beaten = any(
            one["cost"] <= row["cost"]
            and felt(one) <= felt(row)
            and (one["cost"], felt(one)) != (row["cost"], felt(row))
            for one in stiff
        )
        assert row["front"] <= (not beaten)
        if not beaten:
            assert any((one["cost"], felt(one)) == (row["cost"], felt(row)) for one in stiff if one["front"])


def test_what_binds_is_one_step_cheaper_and_fails(everything: Any) -> None:
    plan = planned()
    rows = searched(plan, everything)
    chosen = next(row for row in rows if row["chosen"])
    steps = [row for row in rows if row["relaxes"]]
    assert steps
    for row in steps:
        assert row["cost"] < chosen["cost"]
        assert not row["feasible"]
        differ = [name for name in ("remedy", *(one.name for one in plan.choices)) if row[name] != chosen[name]]
        assert row["relaxes"] in differ
    cheaper = next(row for row in rows if row["next_cheaper"])
    assert cheaper["cost"] == max(row["cost"] for row in rows if row["cost"] < chosen["cost"])


def test_a_remedy_that_makes_a_choice_is_not_charged_for_it() -> None:
    plan = planned(DESIGN.replace("cost: 0.75", "cost: 0.8"))
    fast = [one for one in designs(plan) if plan.candidates[one.candidate].name == "fast"]
    assert len(fast) == 6
    assert {one.values[0] for one in fast} == {4000.0}
    assert min(one.cost for one in fast) == 0.8
    back = relaxed(plan, next(one for one in fast if one.values[1:] == (2650, 0.0)))
    assert [(name, plan.candidates[one.candidate].name, one.values) for name, one in back] == [
        ("counts_per_rev", "fast", (4000.0, 1440, 0.0)),
        ("remedy", "bounded lag", (1000.0, 2650, 0.0)),  # at the present rate, which is 0.05 cheaper together
    ]
    dearer = planned(DESIGN.replace("cost: 0.75", "cost: 0.7"))
    fast = [one for one in designs(dearer) if one.candidate == 2 and one.values[1:] == (2650, 0.0)]
    assert [name for name, _ in relaxed(dearer, fast[0])] == ["counts_per_rev"]


def test_costs_that_differ_by_rounding_are_equal() -> None:
    text = (
        DESIGN.replace("cost: 0.5}", "cost: 0.2}").replace("cost: 0.25", "cost: 0.1").replace("cost: 2}", "cost: 0.3}")
    )
    costs = {one.cost for one in designs(planned(text))}
    assert 0.3 in costs
    assert all(cost == 0.3 or abs(cost - 0.3) > 1e-6 for cost in costs)


def test_the_notional_surface_is_that_of_figure_70(everything: Any) -> None:
    plan = planned()
    rows = {(row[RATE], row[COUNTS]): row for row in searched(plan, everything) if row["notional"] is not None}
    assert len(rows) == len(surface(plan)) == 6
    sizes = [log(row["p2p_max_rad"]) for row in rows.values()]
    pitches = [row["frequency_at_max_hz"] for row in rows.values()]
    for row in rows.values():
        size = (log(row["p2p_max_rad"]) - min(sizes)) / (max(sizes) - min(sizes))
        pitch = (row["frequency_at_max_hz"] - min(pitches)) / (max(pitches) - min(pitches))
        assert row["notional"] == pytest.approx(max(size, pitch), rel=1e-12)
        assert row["remedy"] == "plain wall"
        assert row["knob.damping"] == 0.0


def test_plain_walls_render_their_stiffness_and_a_lag_takes_none_at_rest(everything: Any) -> None:
    """Between two pushes n counts apart a buzz within a count moves the middle by less than one: 1 in n."""
    plan = planned()
    for (candidate, values), (_, stiffness) in everything.items():
        if plan.candidates[candidate].sweep.scene.controller is None:
            assert stiffness == 0.27
        elif values[1] == 2650:
            quantum = 2.0 * pi / 2650
            first, second = _pushes(plan.torques, 0.27, 0.04, 2650)
            apart = (second - first) / (0.31 * quantum)
            assert stiffness + 0.04 == pytest.approx(0.31, rel=1.0 / (apart - 1.0))


def test_pushes_are_between_the_torques_of_two_counts() -> None:
    quantum = 2.0 * pi / 360
    for push in _pushes((0.005, 0.025), 0.27, 0.04, 360):
        edge = round((push / quantum - 0.135) / 0.31)  # the count on whose edge the knob is held, by balance
        assert push == pytest.approx((0.27 * (edge + 0.5) + 0.04 * edge) * quantum, rel=1e-12)
    low, high = _pushes((1e-6, 2e-6), 0.27, 0.04, 360)
    assert high > low


def row(**values: Any) -> dict[str, Any]:
    """A person's row."""
    known = {"touch_db": 10.0, "hearing_relative_db": -20.0, "torque_step_db": 20.0, "p2p_rad": 1e-3}
    known |= {"p2p_max_rad": 2e-3, "frequency_at_max_hz": 70.0, "by_set": {"thenar": -15.0}}
    shares = {"at_rest_fraction": 0.0, "undecided_fraction": 0.0, "diverged_fraction": 0.0, "certified_fraction": 1.0}
    return {**known, **shares, "frequency_hz": 80.0, **values}


def test_a_level_is_none_at_rest_and_unknown_without_a_proof_of_repetition() -> None:
    assert level(row(), "touch_db") == 10.0
    assert level(row(touch_db=None, at_rest_fraction=1.0), "touch_db") == -inf
    assert level(row(at_rest_fraction=0.5), "touch_db") == 10.0
    assert level(row(undecided_fraction=0.5), "touch_db") == inf
    assert level(row(diverged_fraction=0.1), "touch_db") == inf
    assert level(row(touch_db=None), "touch_db") == inf


def test_levels_above_the_present_ones() -> None:
    assert above(10.0, 4.0) == 6.0
    assert above(-inf, -inf) == -inf
    assert above(10.0, -inf) == inf
    assert above(10.0, inf) == inf
    assert above(inf, inf) == inf


def test_a_share_of_the_people_may_be_above() -> None:
    levels = [float(i) for i in range(20)]
    assert exceeded_by(levels, 0.0) == 19.0
    assert exceeded_by(levels, 0.05) == 18.0
    assert exceeded_by(levels, 0.0999) == 18.0
    assert exceeded_by(levels, 0.1) == 17.0
    assert exceeded_by([0.1 * i for i in range(10)], 0.3) == pytest.approx(0.6)  # 0.3 * 10 is 3, whatever floats say


@pytest.mark.parametrize(
    ("limits", "mine", "fails"),
    [
        ({}, {}, ""),
        ({"touch": Limit(10.0, 0.0, above_present=False)}, {}, ""),
        ({"touch": Limit(9.0, 0.0, above_present=False)}, {}, "touch +1.0 dB"),
        ({"touch": Limit(9.0, 0.5, above_present=False)}, {}, ""),
        ({"touch": Limit(0.0, 0.0, above_present=True)}, {}, ""),
        ({"touch": Limit(0.0, 0.0, above_present=True)}, {"touch_db": 12.5}, "touch +2.5 dB"),
        ({"hearing": Limit(0.0, 0.0, above_present=True)}, {"hearing_relative_db": -16.0}, "hearing +4.0 dB"),
        ({"touch": Limit(50.0, 0.0, above_present=False)}, {"undecided_fraction": 0.5}, "touch not known"),
        ({"touch": Limit(50.0, 0.5, above_present=False)}, {"undecided_fraction": 0.5}, ""),
        ({"torque_step_db": 19.0}, {}, "torque step +1.0 dB"),
        ({"stiffness": 0.3}, {}, "stiffness 0.27 N*m/rad"),
        ({"stiffness": 0.27}, {}, ""),
    ],
)
def test_limits_by_one_person_of_two(limits: dict[str, Any], mine: dict[str, Any], fails: str) -> None:
    plan = planned()._replace(**{"touch": None, "stiffness": None, **limits})
    there = [row(), row(touch_db=5.0)]
    found = judge(plan, [row(**mine), row(touch_db=5.0)], there, 0.27)
    assert found.row["fails"] == fails
    assert found.row["feasible"] == (fails == "")


def test_one_unproven_trial_labels_the_design() -> None:
    plan, there = planned(), [row(), row()]
    assert judge(plan, there, there, 0.27).row["certified"]
    found = judge(plan, [row(), row(certified_fraction=0.5)], there, 0.27).row
    assert not found["certified"]
    assert found["feasible"]
    assert found["certified_fraction"] == 0.75


def test_the_present_design_is_in_the_plan() -> None:
    assert present(planned()).values == (1000.0, 2650, 0.0)
    assert present(planned(DESIGN.replace("present: {sample_rate_hz: 1000, counts_per_rev: 2650}\n", ""))).values == (
        500.0,
        360,
        0.0,
    )
