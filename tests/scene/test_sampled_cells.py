"""Many cells reduced at once: number for number what each gives alone."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.loop import Loop
from hknob_cli.errors import ComputationError
from hknob_cli.scene.plain_knob import GIVEN, hands_of, sample_cells, sample_knob
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import COUNTS, PERSON, RATE, SweepPlan, scene_at
from tests.conftest import EXPERIMENTS, SPEC, loaded

GRIPS = SPEC.replace("{inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}", "{table: 1, grip_n: 0.71}")
SCENES = {
    "plain": SPEC.replace("[1000]", "{log: [3, 70000, 7]}"),
    "half a count": SPEC.replace("{torque: 0.001}", "{half_quantum: true}").replace(
        "[1024]", "[1, 3, 1000, 2147483648]"
    ),
    "anything an axis": SPEC.replace(
        "grid:",
        "  encoder: {rounding: nearest}\n  actuator: {delay_samples: 0.1}\n"
        "grid:\n  actuator.delay_samples: [0, 0.3, 1, 2.7]\n  encoder.offset_counts: [0, 0.3]\n"
        "  knob.inertia: [1.0e-7, 3.0e-5]\n  hand.stiffness: [0, 0.1]\n  bias.torque: [0, 0.0013]\n",
    ),
    "truncated": SPEC.replace("grid:", "  encoder: {rounding: truncate, offset_counts: 0.7}\ngrid:"),
    "grips": GRIPS.replace("grid:\n", "grid:\n  hand.grip_n: [14.2, 0.71, 1.3]\n  hand.damping: [1.0e-4, 1.0e-3]\n"),
}


def check(plan: SweepPlan) -> None:
    every = cells_of(plan)
    many = sample_cells(plan.scene, every.columns(0, len(every)))
    angle, velocity = many.position(0.021), many.speed(-0.3)
    energy, theta = many.energy_j, many.angle_rad(1.7)
    for i, cell in enumerate(every):
        one = sample_knob(scene_at(plan.scene, cell), sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))

        def entry(values: Any, i: int = i) -> float:
            return float(np.broadcast_to(values, len(every))[i])

        numbers = [entry(value) for value in many.loop[:GIVEN]]
        assert numbers == list(one.loop[:GIVEN]), cell
        assert [entry(value) for value in many[1:]] == list(one[1:]), cell
        ours = [entry(value) for value in (angle, velocity, energy, theta)]
        assert ours == [one.position(0.021), one.speed(-0.3), one.energy_j, one.angle_rad(1.7)], cell
    assert Loop._fields[GIVEN] == "s1"


@pytest.mark.parametrize("name", SCENES)
def test_cells_are_those_one_by_one(name: str) -> None:
    check(loaded(SCENES[name]))


def test_people_are_those_one_by_one() -> None:
    plan = load(EXPERIMENTS / "population_table1.yaml")
    check(plan)
    hand = plan.scene.hand
    assert hand
    persons = np.array([7, 1, 7])
    assert hands_of(hand, persons).T.tolist() == [list(hand.by_person[person - 1][:3]) for person in persons]
    assert PERSON in plan.axes


def test_the_first_cell_that_overflows_is_named() -> None:
    text = SPEC.replace("[1000]", "[1000, 2000]").replace("inertia: 3.0e-7, ", "")
    text = text.replace("grid:\n", "grid:\n  knob.inertia: [1.0e-6, 1.0e-300]\n")
    plan = loaded(text)
    every = cells_of(plan)
    with pytest.raises(ComputationError, match="at 1000 Hz and 1024 counts"):
        sample_cells(plan.scene, every.columns(0, len(every)))
