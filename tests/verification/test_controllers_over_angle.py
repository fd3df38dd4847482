"""Controllers beside a torque over the angle, against the 60-digit model of both.

Random scenes under each controller get one or two parts with a torque over the angle. Without a wall the controller is
virtual damping that acts everywhere, as a SmartKnob's acts on its detents. Trials, and cycles derived again, are
compared as in `test_laws_in_the_general_loop`; random starts end in the complete lists as in `test_law_starts`.
"""

from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.outcome import Outcome
from tests.controllers.laws import EVERY

from .law_scenes import Drawn, reduce, search
from .test_laws_in_the_general_loop import LONGEST, ORDER, balance, check_orbit, check_trial, scenes
from .test_over_angle import random_part

ON_ITS_OWN = [name for name in ORDER if EVERY[name]["kind"] == "velocity_damping" and "angle" not in EVERY[name]]


def shaped(controller: str, count: int, seed: int, *, walled: bool = True) -> list[Drawn]:
    """Random scenes under a controller, with parts over the angle; without a wall, damped everywhere."""
    chance = Random(f"{controller} {seed}")
    found = []
    for one in scenes(controller, count, seed):
        made: dict[str, Any] = {**one.scene, **random_part(chance)}
        if not walled:
            made["wall"] = {"stiffness": 0.0}
            made["controller"] = {**made["controller"], "everywhere": True}
            made["bias"] = {"torque": 0.001}
        found.append(one._replace(scene=made))
    return found


def compare(drawn: list[Drawn], *, in_code: bool) -> tuple[int, int]:
    """Trials that could be compared, and proven cycles derived again; ``in_code``: searched for by compiled code."""
    trials = cycles = 0
    for one in drawn:
        trials += bool(np.isfinite(check_trial(one)))
        made = reduce(one)
        engine, attractors = search(one, made, in_code=in_code)
        for orbit in attractors:
            if orbit.outcome is Outcome.CYCLE and orbit.certified and orbit.period <= LONGEST:
                check_orbit(one, made, orbit)
                balance(made, engine, orbit, one)
                cycles += 1
    return trials, cycles


@pytest.mark.one_in(32)
@pytest.mark.parametrize("controller", ORDER)
def test_beside_a_wall(controller: str) -> None:
    trials, _ = compare(shaped(controller, 3, seed=5), in_code=False)
    assert trials, "rounding could decide in all scenes: nothing was tested"


@pytest.mark.one_in(6)
@pytest.mark.parametrize("controller", ON_ITS_OWN)
def test_without_a_wall(controller: str) -> None:
    trials, _ = compare(shaped(controller, 3, seed=6, walled=False), in_code=False)
    assert trials, "rounding could decide in all scenes: nothing was tested"


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("controller", ORDER)
def test_many_scenes(controller: str) -> None:
    drawn = shaped(controller, 8, seed=7)
    if controller in ON_ITS_OWN:
        drawn += shaped(controller, 8, seed=8, walled=False)
    trials, cycles = compare(drawn, in_code=True)
    assert trials
    assert cycles, "no proven cycle: nothing was tested"
