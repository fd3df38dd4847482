"""Cogging in specs: what it goes with, faults with their place, its words, and what a sweep's files have."""

from copy import deepcopy
from math import pi
from typing import Any

import pytest

from hknob_cli.errors import ComputationError, SpecError
from hknob_cli.report.derived_numbers import derived_numbers
from hknob_cli.report.scene_words import scene_sentences
from hknob_cli.specs.bench import merged
from hknob_cli.specs.capabilities import parts_of
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import SweepPlan, scene_at
from hknob_cli.specs.source import Source
from hknob_cli.stages.sweep.run import SweepStage
from tests.specs.small_cells import BASE, CHANGES, KINDS, swept

COGGING = {"scene": {"cogging": {"torque": 1e-3, "per_revolution": 84, "centre": 0.0374}}}


def planned(*changes: dict[str, Any]) -> SweepPlan:
    """The base with cogging and with more; without keys that are None."""
    return swept(COGGING, *changes)


def of_cogging(**keys: Any) -> dict[str, Any]:
    """A change of its keys."""
    return {"scene": {"cogging": keys}}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (of_cogging(torque=-0.1), "scene.cogging.torque: must be >= 0"),
        (of_cogging(torque="5 mm"), "scene.cogging.torque: '5 mm' is in millimeter, which is not a kind of N*m"),
        ({"scene": {"cogging": {"per_revolution": None}}}, "scene.cogging.per_revolution: missing, and required"),
        (of_cogging(per_revolution=0), "scene.cogging.per_revolution: must be >= 1"),
        (of_cogging(per_revolution=1.5), "scene.cogging.per_revolution: must be a whole number"),
        (of_cogging(per_rev=84), "scene.cogging.per_rev: unknown key; did you mean 'per_revolution'?"),
        (CHANGES["unsampled"], "scene.cogging.torque: must be absent where sampling is continuous: cogging torque is"),
        (
            {"starts": None} | {"starts": "anywhere"},
            "scene.cogging.torque: must be absent where starts are anywhere: no region is known",
        ),
    ],
)
def test_faults(change: dict[str, Any], said: str) -> None:
    with pytest.raises(SpecError) as error:
        planned(change)
    (fault,) = error.value.faults
    assert f"{fault.key}: {fault.message}".startswith(said)


@pytest.mark.parametrize("kind", ["dfa", "predict"])
def test_formulas_refuse_it(kind: str) -> None:
    source = Source("spec.yaml")
    source.value = {**merged(deepcopy(BASE), COGGING), "kind": kind}
    with pytest.raises(SpecError) as error:
        validate(source)
    assert all(fault.key == "scene.cogging.torque" for fault in error.value.faults)


def test_a_grid_of_it_has_its_place() -> None:
    axis = {"grid": {"cogging.torque": [0.0, 1e-3]}, "scene": {"cogging": {"torque": 0.0}}}
    assert planned(axis).axes["cogging.torque"] == [0.0, 1e-3]
    with pytest.raises(SpecError) as error:
        planned(axis, {"starts": None} | {"starts": "anywhere"})
    (fault,) = error.value.faults
    assert fault.key == 'grid["cogging.torque"]'
    assert planned(axis, CHANGES["play"]).axes["cogging.torque"] == [0.0, 1e-3]


def test_no_torque_is_no_part() -> None:
    def parts(torque: float) -> frozenset[str]:
        plan = planned(of_cogging(torque=torque))
        return parts_of(scene_at(plan.scene, next(iter(cells_of(plan)))))

    assert parts(1e-3) - parts(0.0) == {"cogging"}


def test_a_unit_and_a_torque_behind_a_gear() -> None:
    """At the motor's shaft: behind 1:4 four times the torque, at a quarter of the angle."""
    plan = planned(of_cogging(torque="1 mN*m", centre="4 deg"), CHANGES["gear"])
    made = scene_at(plan.scene, next(iter(cells_of(plan)))).cogging
    assert made is not None
    ratio = CHANGES["gear"]["scene"]["gear"]["ratio"]
    assert made.torque == pytest.approx(1e-3 * ratio, rel=1e-15)
    assert made.per_revolution == 84 * ratio
    assert made.centre == pytest.approx(4.0 * 3.141592653589793 / 180.0 / ratio, rel=1e-15)


@pytest.mark.parametrize("starts", ["phases", "one", "ranges"])
def test_files_have_the_swing_of_what_does_not_repeat(starts: str, loop_not_kept: None) -> None:
    plan = planned({"grid": {"cogging.torque": [0.0, 1e-3], "counts_per_rev": [1024]}, "starts": None})
    plan = planned(
        {"grid": {"cogging.torque": [0.0, 1e-3], "counts_per_rev": [1024]}, "starts": None}, {"starts": KINDS[starts]}
    )
    plan = plan._replace(starts=plan.starts._replace(phases=2), max_samples=4096)
    tables = SweepStage(plan, jobs=1).run()
    still, moved = tables.cells.to_pylist()
    assert still["certified_fraction"] == 1.0
    assert still["rattle_max_rad"] is None
    assert moved["certified_fraction"] == 0.0
    row = next(row for row in tables.orbits.to_pylist() if row["cogging.torque"] == 1e-3)
    assert row["outcome"] == "undecided"
    assert moved["rattle_max_rad"] == row["rattle_p2p_rad"] > 1e-4
    assert row["parting_per_s"] > 1.0


def test_words_of_a_scene() -> None:
    plan = planned()
    begun = "Cogging: up to 0.001 N*m toward 84 places of rest in a turn of the motor"
    assert f"{begun}, one of them at 0.0374 rad; a triangle wave." in list(scene_sentences(plan.scene, plan.axes))
    central = planned(of_cogging(centre=0))
    assert f"{begun}; a triangle wave." in list(scene_sentences(central.scene, central.axes))
    (stiff,) = [one for one in derived_numbers(plan.scene, plan.axes) if one.name == "stiffness of cogging"]
    assert stiff.least == stiff.largest == pytest.approx(0.001 / (2.0 * pi / 84 / 4))


def test_a_slope_too_steep_for_numbers_is_said_without_a_warning() -> None:
    with pytest.raises(ComputationError, match="the scene's numbers overflow"):
        SweepStage(planned(of_cogging(torque=1e6)), jobs=1).run()
