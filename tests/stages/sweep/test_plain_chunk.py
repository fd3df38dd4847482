"""Cells run all in compiled code: the same tables as one by one, whatever the scene."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine import cell_run
from hknob_cli.engine.attractors import StoppedError
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import WORDS, Reason
from hknob_cli.engine.sets import room
from hknob_cli.errors import ComputationError, SpecError
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import load, validate
from hknob_cli.specs.plan import SweepPlan, scene_at
from hknob_cli.specs.source import Source
from hknob_cli.stages.sweep.cell import CellFinder, group_of
from hknob_cli.stages.sweep.plain_chunk import EVERY_PHASE_GROUP, GROUP, plain_chunk, takes_plain
from hknob_cli.stages.sweep.run import SweepStage
from hknob_cli.stages.sweep.tables import SweepTables, cells_table, orbits_table
from tests.conftest import EXPERIMENTS, SPEC, loaded

Functions = dict[str, Callable[..., Any]]
HAND = {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04}


@pytest.fixture(scope="module")
def functions() -> Functions:
    return compiled(GROUP)


@pytest.fixture(scope="module")
def arc_functions() -> Functions:
    return compiled(EVERY_PHASE_GROUP)


def planned(
    *,
    hand: dict[str, Any] | None = None,
    wall: float = 0.27,
    bias: Any = 0.001,
    encoder: dict[str, Any] | None = None,
    delay: float = 0.0,
    limit: int | None = None,
    starts: dict[str, Any] | None = None,
    **grid: Any,
) -> SweepPlan:
    source = Source("chunk")
    source.value = {
        "kind": "sweep",
        "name": "chunk",
        "scene": {
            "knob": {"inertia": 1.9e-6},
            "hand": hand or HAND,
            "wall": {"stiffness": wall},
            "bias": {"half_quantum": True} if bias == "half" else {"torque": bias},
            "encoder": encoder or {},
            "actuator": {"delay_samples": delay},
        },
        "grid": {"sample_rate_hz": 1000, "counts_per_rev": 1024, **{k.replace("__", "."): v for k, v in grid.items()}},
        "starts": {"angle": 0.02, "phases": 4, **(starts or {})},
        "limits": {"max_samples": limit},
    }
    return validate(source)


def one_by_one(plan: SweepPlan, functions: Functions) -> SweepTables:
    """The tables by the way that has a Python object for every cell and orbit."""
    finder = CellFinder({"plain": functions, "sets": functions})
    results = [finder.find(plan, cell) for cell in cells_of(plan)]
    return SweepTables(
        cells_table(plan, results), orbits_table(plan, results), sum(result.samples for result in results)
    )


def all_at_once(plan: SweepPlan, functions: Functions) -> SweepTables:
    assert takes_plain(plan)
    every = cells_of(plan)
    return plain_chunk(plan, every.columns(0, len(every)), functions)


def assert_same(one: SweepTables, other: SweepTables) -> None:
    for ours, theirs in zip(one[:2], other[:2], strict=True):
        ours.validate(full=True)
        assert ours.schema.equals(theirs.schema, check_metadata=True)
        for name in ours.column_names:
            assert ours[name].equals(theirs[name]), name
            values = ours[name].combine_chunks()
            if pa.types.is_floating(values.type):
                # `equals` takes 0 for -0; the files would not.
                bits = [np.signbit(table[name].drop_null().to_numpy()) for table in (ours, theirs)]
                assert (bits[0] == bits[1]).all(), name
    assert one.samples == other.samples


EVERY = {"phases": None}  # clock phases


def given_every(scene: dict[str, Any]) -> dict[str, Any]:
    """The scene with every clock phase of its start."""
    return {**scene, "starts": {**scene.get("starts", {}), **EVERY}}


ZERO_OR = st.just(0.0)
SCENES = st.fixed_dictionaries(
    {
        "hand": st.fixed_dictionaries(
            {
                "inertia": ZERO_OR | st.floats(1e-8, 1e-5),
                "damping": ZERO_OR | st.floats(-6.0, 0.0).map(lambda power: 10.0**power),
                "stiffness": ZERO_OR | st.floats(-3.0, 3.0).map(lambda power: 10.0**power),
            }
        ),
        "wall": ZERO_OR | st.floats(-2.0, 1.5).map(lambda power: 10.0**power),
        "bias": st.just("half") | ZERO_OR | st.floats(1e-5, 1e-1),
        "encoder": st.fixed_dictionaries(
            {
                "rounding": st.sampled_from(["floor", "nearest", "ceil", "truncate"]),
                "offset_counts": ZERO_OR | st.floats(0.0, 0.99),
            }
        ),
        "delay": st.sampled_from([0.0, 0.0, 0.5, 1.0, 2.0]) | st.floats(0.0, 4.0),
        "limit": st.integers(100, 20_000),
        "starts": st.fixed_dictionaries(
            {
                "angle": ZERO_OR | st.floats(-0.2, 0.2),
                "velocity": ZERO_OR | st.floats(-3.0, 3.0),
                "phases": st.integers(1, 9) | st.just(70),
            }
        ),
        "sample_rate_hz": st.lists(
            st.floats(1.0, 4.3).map(lambda power: 10.0**power), min_size=1, max_size=2, unique=True
        ),
        "counts_per_rev": st.lists(st.integers(1, 10_000) | st.just(2**31), min_size=1, max_size=2, unique=True),
    }
)
# Further axes, of values that the scene has as well.
AXES = st.dictionaries(
    st.sampled_from(["knob__inertia", "hand__damping", "hand__stiffness", "hand__inertia", "wall__stiffness"])
    | st.sampled_from(["knob__damping", "encoder__offset_counts", "actuator__delay_samples", "knob__coulomb_torque"]),
    st.just([0.001, 0.5]) | st.just([1e-5, 2.0]) | st.just([0.25]) | st.just([0.0]),
    max_size=2,
)


@settings(max_examples=40, deadline=None)
@given(scene=SCENES, axes=AXES)
def test_tables_are_those_of_the_cells_one_by_one(functions: Functions, scene: Any, axes: Any) -> None:
    try:
        plan = planned(**{**scene, **axes})
    except SpecError:  # an offset of two counts
        return
    groups = {group_of(scene_at(plan.scene, cell)) for cell in cells_of(plan)}
    assert takes_plain(plan) == (groups == {"plain"})
    if takes_plain(plan):
        assert_same(all_at_once(plan, functions), one_by_one(plan, functions))


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(scene=SCENES, axes=AXES)
def test_tables_of_every_phase_are_those_of_the_cells_one_by_one(
    arc_functions: Functions, scene: Any, axes: Any
) -> None:
    try:
        plan = planned(**given_every({**scene, **axes}))
    except SpecError:  # an offset of two counts
        return
    if takes_plain(plan):
        assert_same(all_at_once(plan, arc_functions), one_by_one(plan, arc_functions))


NO_DAMPING = {"damping": 0.0, "stiffness": 0.04}
# Scenes by what must be among their ends: outcome and, where it is not proven, why.
ENDS: dict[str, tuple[dict[str, Any], set[tuple[str, Reason]]]] = {
    "coexisting cycles": (
        {"bias": "half", "counts_per_rev": [1024, 4096], "starts": {"phases": 64}},
        {("cycle", Reason.NONE)},
    ),
    "a delay of part of a sample": ({"delay": 0.3, "sample_rate_hz": [215, 1000]}, {("cycle", Reason.NONE)}),
    "several samples under way": (
        {"bias": "half", "actuator__delay_samples": [0.0, 1.6, 30.0], "starts": {"phases": 16}},
        {("cycle", Reason.NONE)},
    ),
    "many turns in a hold": (
        {"hand": {**HAND, "stiffness": 4.0}, "wall": 40.0, "sample_rate_hz": [20, 37], "counts_per_rev": 256},
        {("cycle", Reason.NONE)},
    ),
    "rest": ({"hand": {**HAND, "stiffness": 0.08}, "counts_per_rev": [2048, 4096]}, {("rest", Reason.NONE)}),
    "rest on an edge": (
        {"hand": {**HAND, "damping": 0.1}, "bias": (0.27 + 0.04) * 2 * np.pi / 1024, "starts": {"angle": -0.006}},
        {("rest", Reason.REST_ON_EDGE)},
    ),
    "growth": ({"wall": 1e3, "delay": 2.0}, {("diverged", Reason.GREW)}),
    "nothing holds it": (
        {"hand": {"damping": 1e-4}, "wall": 0.0},
        {("diverged", Reason.LEAVES)},
    ),
    "no damping": (
        {"hand": NO_DAMPING, "wall": 0.0, "bias": 0.0, "starts": {"phases": 2}},
        {("undecided", Reason.NO_DAMPING)},
    ),
    "no damping in some cells": (
        {"hand__damping": [0.0, 3.45e-4], "starts": {"phases": 2}},
        {("diverged", Reason.GREW), ("cycle", Reason.NONE)},
    ),
    "no stiffness": (
        {"hand": {"damping": 3.45e-4}, "bias": "half", "starts": {"phases": 3}},
        {("cycle", Reason.CONTINUUM)},
    ),
    "no stiffness, nothing repeats": (
        {"hand": {"damping": 3.45e-4}, "limit": 1000},
        {("undecided", Reason.NO_STIFFNESS)},
    ),
    "too few samples": ({"sample_rate_hz": 1e5, "limit": 13_000}, {("undecided", Reason.NO_REPEAT)}),
    "too slow": ({"knob__inertia": [1.0], "limit": 1000}, {("undecided", Reason.TOO_SLOW)}),
    "too fine": (
        {"bias": 1e9, "counts_per_rev": [1024, 2**31]},
        {("undecided", Reason.TOO_FINE)},
    ),
}


@pytest.mark.parametrize("name", ENDS)
def test_every_end_is_told_alike(functions: Functions, name: str) -> None:
    scene, ends = ENDS[name]
    plan = planned(**scene)
    found = all_at_once(plan, functions)
    assert_same(found, one_by_one(plan, functions))
    told = set(zip(found.orbits["outcome"].to_pylist(), found.orbits["reason"].to_pylist(), strict=True))
    assert {(outcome, WORDS[reason]) for outcome, reason in ends} <= told


@pytest.mark.long
@pytest.mark.parametrize("name", ENDS)
def test_every_end_of_every_phase_is_told_alike(arc_functions: Functions, name: str) -> None:
    """Also where arcs cannot be cut, and 64 phases are sampled."""
    scene, ends = ENDS[name]
    plan = planned(**given_every(scene))
    found = all_at_once(plan, arc_functions)
    assert_same(found, one_by_one(plan, arc_functions))
    sampled = {Reason.NO_DAMPING, Reason.NO_STIFFNESS, Reason.CONTINUUM, Reason.LEAVES, Reason.TOO_FINE}
    for cell in found.cells.to_pylist():
        assert not cell["complete"] or (cell["certified_fraction"] == 1.0 and cell["piece_count"] > 0)
    if {reason for _, reason in ends} & sampled:
        assert 0 in found.cells["piece_count"].to_pylist()


def test_an_arc_over_too_many_edges_is_sampled(arc_functions: Functions) -> None:
    """In a run of cells, beside one that is followed."""
    plan = planned(starts={"angle": 0.1, "velocity": -2000.0, **EVERY}, counts_per_rev=[16, 8192])
    found = all_at_once(plan, arc_functions)
    assert_same(found, one_by_one(plan, arc_functions))
    assert [count > 0 for count in found.cells["piece_count"].to_pylist()] == [True, False]


def test_a_run_that_stops_within_a_cell_goes_on_there(
    arc_functions: Functions, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One sample at a time, with and without a delay: the same to the last bit."""
    scene = {"sample_rate_hz": [464, 1000], "actuator__delay_samples": [0.0, 1.6], "starts": EVERY}
    plan = planned(**scene)
    whole = all_at_once(plan, arc_functions)
    assert min(whole.cells["piece_count"].to_pylist()) > 1
    monkeypatch.setattr(cell_run, "HOLDS", 1)
    monkeypatch.setattr(cell_run, "ROWS", 1)
    monkeypatch.setattr(cell_run, "SAMPLES", 0)
    assert_same(all_at_once(plan, arc_functions), whole)


def test_more_ends_than_a_cell_keeps(arc_functions: Functions, monkeypatch: pytest.MonkeyPatch) -> None:
    """Arcs that end in others are undecided, in both ways."""
    plan = planned(bias="half", hand={**HAND, "stiffness": 0.08}, counts_per_rev=[1024, 4096], starts=EVERY)
    assert max(all_at_once(plan, arc_functions).cells["orbit_count"].to_pylist()) > 2
    for module in (room, cell_run):
        monkeypatch.setattr(module, "ENDS", 1)
    found = all_at_once(plan, arc_functions)
    assert_same(found, one_by_one(plan, arc_functions))
    assert max(found.cells["orbit_count"].to_pylist()) == 2
    assert max(found.cells["undecided_fraction"].to_pylist()) > 0.0


@pytest.mark.parametrize("phases", [4, 200])
@pytest.mark.parametrize("limit", [None, 150])
def test_ends_that_coexist_come_in_the_same_order(functions: Functions, phases: int, limit: int | None) -> None:
    """Up to five in a cell: cycles of several periods or of one, rest, and what does not repeat in time."""
    grid = {"sample_rate_hz": [215, 464, 1000], "counts_per_rev": [1024, 2048, 4096]}
    plan = planned(hand={**HAND, "stiffness": 0.08}, starts={"phases": phases}, limit=limit, **grid)
    found = all_at_once(plan, functions)
    assert_same(found, one_by_one(plan, functions))
    assert found.orbits.num_rows > 1.5 * found.cells.num_rows


def test_more_orbits_than_a_cell_keeps(functions: Functions) -> None:
    """Without stiffness every trial has a cycle of its own."""
    plan = planned(hand={"damping": 3.45e-4}, bias="half", counts_per_rev=8192, starts={"phases": 1500})
    found = all_at_once(plan, functions)
    assert_same(found, one_by_one(plan, functions))
    assert WORDS[Reason.TOO_MANY] in found.orbits["reason"].to_pylist()


@pytest.mark.parametrize("name", ["hand_on_knob", "hand_on_knob_half_quantum", "population_table1"])
def test_of_an_experiment(functions: Functions, name: str) -> None:
    """With a population: the columns of its people, too."""
    plan = load(EXPERIMENTS / f"{name}.yaml", ("starts.phases=3",))
    assert_same(all_at_once(plan, functions), one_by_one(plan, functions))


def test_of_a_printed_hand_at_several_grips(functions: Functions) -> None:
    text = SPEC.replace("{inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}", "{table: 1, grip_n: 0.71}")
    text = text.replace("grid:\n", "grid:\n  hand.grip_n: [14.2, 0.71, 1.3]\n  hand.damping: [1.0e-4, 1.0e-3]\n")
    assert_same(all_at_once(loaded(text), functions), one_by_one(loaded(text), functions))


def test_tables_of_every_phase_are_those_of_the_interpreter(arc_functions: Functions) -> None:
    plan = planned(sample_rate_hz=[215, 464], starts=EVERY)
    finder = CellFinder({})
    results = [finder.find(plan, cell) for cell in cells_of(plan)]
    taken = sum(result.samples for result in results)
    assert_same(
        SweepTables(cells_table(plan, results), orbits_table(plan, results), taken), all_at_once(plan, arc_functions)
    )


@pytest.mark.parametrize("text", [SPEC.replace("[1000]", "[215, 1000]"), SPEC.replace("8192", "{torque: 0.002}")])
def test_tables_are_those_of_the_interpreter(functions: Functions, text: str) -> None:
    stage = SweepStage(loaded(text), jobs=1)
    result = stage.run()
    assert not stage.compiled
    assert_same(result, all_at_once(stage.plan, functions))


@pytest.mark.parametrize(("jobs", "phases"), [(1, 400), (2, 400), (2, None)])
def test_many_cells_are_found_in_runs(
    functions: Functions, arc_functions: Functions, jobs: int, phases: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hknob_cli.stages.sweep.run.MANY", 4)
    monkeypatch.setattr("hknob_cli.stages.sweep.run.COMPILE_ABOVE", 100_000)
    plan = planned(sample_rate_hz=[215, 464, 1000], hand__damping=[1e-4, 3e-4, 1e-3], starts={"phases": phases})
    told: list[tuple[int, int]] = []
    monkeypatch.setattr(SweepStage, "run_cell", None)
    result = SweepStage(plan, jobs=jobs).run(lambda done, total: told.append((done, total)))
    assert_same(result, one_by_one(plan, functions if phases else arc_functions))
    assert told[-1] == (9, 9)
    assert len(told) > 2


def test_runs_of_many_cells_give_up_when_interrupted(functions: Functions, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hknob_cli.stages.sweep.run.MANY", 4)
    stage = SweepStage(
        planned(sample_rate_hz=[215, 464, 1000], hand__damping=[1e-4, 1e-3], starts={"phases": 400}), jobs=2
    )

    def interrupt(_done: int, _total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stage.run(interrupt)
    assert stage.stopped()


def test_chunks_are_parts_of_the_whole(functions: Functions) -> None:
    plan = planned(sample_rate_hz=[215, 464, 1000], hand__damping=[1e-4, 3e-4, 1e-3])
    cells = cells_of(plan)
    parts = [plain_chunk(plan, cells.columns(a, b), functions) for a, b in ((0, 1), (1, 6), (6, 9))]
    whole = all_at_once(plan, functions)
    assert pa.concat_tables([part.cells for part in parts]).equals(whole.cells)
    assert pa.concat_tables([part.orbits for part in parts]).equals(whole.orbits)
    assert sum(part.samples for part in parts) == whole.samples


def test_room_grows_and_results_do_not_depend_on_it(functions: Functions, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = planned(sample_rate_hz=[1000, 4000], delay=0.3, counts_per_rev=[512, 1024, 8192])
    whole = all_at_once(plan, functions)
    monkeypatch.setattr(cell_run, "HOLDS", 1)
    monkeypatch.setattr(cell_run, "ROWS", 1)
    monkeypatch.setattr(cell_run, "SAMPLES", 0)
    assert_same(all_at_once(plan, functions), whole)
    assert max(whole.orbits["period_samples"].to_pylist()) > 50


@pytest.mark.parametrize("phases", [4, None])
def test_it_stops_when_told_to(
    functions: Functions, arc_functions: Functions, phases: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With arcs within a cell, too."""
    plan = planned(sample_rate_hz=[500, 1000, 2000], starts={"phases": phases})
    asked: list[bool] = []

    def stopped() -> bool:
        asked.append(True)
        return len(asked) > 2

    monkeypatch.setattr(cell_run, "SAMPLES", 0)
    with pytest.raises(StoppedError):
        plain_chunk(plan, cells_of(plan).columns(0, 3), functions if phases else arc_functions, stopped)
    assert len(asked) == 3


def test_numbers_that_overflow_are_refused_as_ever(functions: Functions) -> None:
    plan = planned(wall__stiffness=[1.0, 1e12], knob__inertia=[1e-300, 1.0], hand={"stiffness": 0.04})
    with pytest.raises(ComputationError) as one:
        one_by_one(plan, functions)
    with pytest.raises(ComputationError) as all_of_them:
        all_at_once(plan, functions)
    assert str(one.value) == str(all_of_them.value)
    assert "overflow" in str(one.value)


@pytest.mark.parametrize(
    "change",
    [
        {"actuator__time_constant": [0.0, 1e-4]},
        {"actuator__torque_limit": [0.1]},
        {"knob__coulomb_torque": [0.0, 1e-4]},
        {"wall__damping": [1e-4]},
        {"starts": {"phases": 20_000}},
        {"starts": {"angle": [-0.02, 0.02], "velocity": [-1.0, 1.0], "phases": None}},
        {"hand": {"stiffness": 0.0}, "hand__stiffness": [0.0, 0.04]},  # the bouncing ball, in one cell
        {"hand": {"inertia": 1e-7}},
    ],
)
def test_what_is_not_plain_throughout_is_not_taken(change: dict[str, Any]) -> None:
    assert not takes_plain(planned(**change))


def test_a_ball_that_nothing_pushes_is_plain() -> None:
    assert takes_plain(planned(hand={"inertia": 1e-7}, bias=0.0))


def test_what_more_is_asked_for_is_not_taken() -> None:
    assert takes_plain(loaded())
    assert not takes_plain(loaded(SPEC + "perceive: {knob_radius: 8.9 mm}\n"))
    assert not takes_plain(loaded(SPEC.replace("grid:", "  controller: {kind: first_order_hold}\ngrid:")))
