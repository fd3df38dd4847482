"""Tests of `specs.capabilities`: sets of starts are proven where the table says, and it is told where they are not."""

from copy import deepcopy

import pytest

from hknob_cli.specs.bench import merged
from hknob_cli.specs.capabilities import (
    STARTS,
    engine_of,
)
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import SweepPlan, scene_at
from hknob_cli.specs.remarks import not_proven
from hknob_cli.specs.source import Source
from hknob_cli.stages.sweep.run import SweepStage
from tests.specs.small_cells import BASE, BESIDE, CHANGES, KINDS, MORE_STATES, check_sweep, planned


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("starts", ["one", "ranges"])
@pytest.mark.parametrize("part", [*BESIDE, *MORE_STATES])
def test_every_start_of_a_controller_beside_more(part: str, starts: str) -> None:
    """All of them are proven to end in what is listed."""
    source = Source("spec.yaml")
    source.value = {
        **merged(deepcopy(BASE), merged(CHANGES[part], CHANGES["controller"])),
        "starts": KINDS[starts],
    }
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    scene = scene_at(plan.scene, next(iter(cells_of(plan))))
    assert engine_of(scene, STARTS[starts]) == ("law_sets" if part in MORE_STATES else "friction_sets")
    cell = SweepStage(plan, jobs=1).run().cells.to_pylist()[0]
    assert (cell["certified_fraction"], cell["complete"]) == (1.0, True)


# Teeth that do not ring within a sample period, and friction that brings them to rest.
SOFT_TEETH = {
    "ratio": 2.0,
    "motor_inertia": 1e-7,
    "stiffness": 3.0,
    "mesh_damping": 4e-4,
    "motor_coulomb_torque": 1e-3,
}


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize(
    "beside",
    [
        ("friction",),
        ("controller",),
        ("several_readings",),
        ("hysteresis",),
        ("backlash",),
        ("several_readings", "hysteresis"),
    ],
)
@pytest.mark.parametrize("part", ["finger", "coil", "mesh"])
def test_every_phase_beside_friction_and_more(part: str, beside: tuple[str, ...]) -> None:
    """All of them are proven to end in what is listed."""
    source = Source("spec.yaml")
    rubs = {"scene": {"gear": SOFT_TEETH}} if part == "mesh" else CHANGES["friction"]
    change = merged(CHANGES[part], rubs)
    for other in beside:
        change = merged(change, {} if other == "friction" else CHANGES[other])
    source.value = {**merged(deepcopy(BASE), change), "starts": KINDS["one"]}
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    assert engine_of(scene_at(plan.scene, next(iter(cells_of(plan)))), STARTS["one"]) == "friction_arcs"
    assert not_proven(plan) == []
    cell = SweepStage(plan, jobs=1).run().cells.to_pylist()[0]
    assert (cell["certified_fraction"], cell["complete"]) == (1.0, True)


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("starts", ["one", "ranges", "anywhere"])
@pytest.mark.parametrize("part", CHANGES)
def test_sets_of_starts_are_proven_where_the_table_says(part: str, starts: str) -> None:
    check_sweep(part, starts)


@pytest.mark.parametrize(
    ("part", "starts", "said"),
    [
        ("lag", "one", []),
        ("bare", "phases", []),
        (
            "bare",
            "ranges",
            ["some starts will be followed, not all: sets of states are not followed with a continuous sensor"],
        ),
        ("kalman", "phases", []),
        ("speed_sensor", "phases", []),
    ],
)
def test_what_will_not_be_proven_is_told(part: str, starts: str, said: list[str]) -> None:
    plan = planned(part, starts=KINDS[starts])
    assert isinstance(plan, SweepPlan)
    assert not_proven(plan) == said


@pytest.mark.parametrize(
    ("part", "what", "starts", "start"),
    [
        ("play", "backlash of a gear", "one", "some phases of the start will be followed, not all"),
        ("cogging", "cogging torque", "ranges", "some starts will be followed, not all"),
    ],
)
def test_what_hinders_sets_with_a_controller_is_told(part: str, what: str, starts: str, start: str) -> None:
    source = Source("spec.yaml")
    source.value = {**merged(deepcopy(BASE), merged(CHANGES[part], CHANGES["controller"])), "starts": KINDS[starts]}
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    assert not_proven(plan)[0] == f"{start}: sets of states are not followed with a controller beside {what}"


@pytest.mark.parametrize(
    ("torque", "said"),
    [
        (7.4e-4, []),
        (
            7.5e-4,
            ["some starts will be followed, not all: sets of states are not followed with cogging that is stronger "
             "than the hand"],
        ),
    ],
)  # fmt: skip
def test_cogging_that_is_stronger_than_the_hand_is_told(torque: float, said: list[str]) -> None:
    """A slope of 2 · 84 / π a torque, against the hand's 0.04 N·m/rad."""
    source = Source("spec.yaml")
    cogs = {"cogging": {"torque": torque, "per_revolution": 84}, "hand": {"stiffness": 0.04}}
    source.value = {**merged(deepcopy(BASE), {"scene": cogs}), "starts": KINDS["ranges"]}
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    assert not_proven(plan) == said


def test_friction_with_a_finger_is_told_as_what_hinders() -> None:
    for starts, expected in (
        ("one", []),
        (
            "ranges",
            [
                "some starts will be followed, not all: sets of states are not followed with Coulomb friction "
                "and a finger apart from the knob"
            ],
        ),
    ):
        plan = planned("finger", starts=KINDS[starts])
        assert isinstance(plan, SweepPlan)
        rubbed = plan._replace(scene=plan.scene._replace(knob=plan.scene.knob._replace(coulomb_torque=1e-5)))
        assert not_proven(rubbed) == expected
