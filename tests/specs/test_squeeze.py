"""A grip that follows the push: at the ends of its pieces, in every engine alike, and its faults.

`tests/verification/test_squeeze.py` has it against every rest at 60 digits.
"""

from copy import deepcopy
from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from hknob_cli.errors import SpecError
from hknob_cli.printed import grasps
from hknob_cli.report.derived_numbers import derived_numbers
from hknob_cli.report.scene_words import scene_sentences
from hknob_cli.scene.plain_knob import scene_along
from hknob_cli.specs.bench import merged
from hknob_cli.specs.hand import HandSpec
from hknob_cli.specs.load import validate
from hknob_cli.specs.parts import Bias, Wall
from hknob_cli.specs.plan import COUNTS, GRIP, RATE, SweepPlan, placed, scene_at
from hknob_cli.specs.source import Source
from hknob_cli.specs.squeeze import grip_of, hand_at, left_out, squeezed
from hknob_cli.stages.sweep.run import SweepStage

SQUEEZE = {"friction": 0.7, "radius": 8.9e-3, "margin": 1.5}
STIFFENING = {"kind": "stiffening", "surface": 0.3, "depth": 0.2}
COGGING = {"cogging": {"per_revolution": 84, "torque": 1e-3}}
RIGID = {"ratio": 2.5, "motor_inertia": 1e-8}
MESH = {"gear": {**RIGID, "stiffness": 0.5, "mesh_damping": 1e-3}}
PLAY = {"gear": {**MESH["gear"], "backlash": 0.002}}
BASE: dict[str, Any] = {
    "kind": "sweep",
    "name": "small",
    "scene": {
        "knob": {"inertia": 1.9e-6},
        "hand": {"table": 1, "grip_n": 0.71},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.02},
        "squeeze": SQUEEZE,
    },
    "grid": {RATE: [1000.0], COUNTS: [2650]},
    "starts": {"angle": 0.02, "phases": 4},
}


def planned(scene: dict[str, Any] | None = None, **grid: Any) -> SweepPlan:
    source = Source("spec.yaml")
    source.value = merged(deepcopy(BASE), {"scene": scene or {}, "grid": grid})
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    return plan


def faults(scene: dict[str, Any], **grid: Any) -> list[str]:
    with pytest.raises(SpecError) as raised:
        planned(scene, **grid)
    return [f"{fault.key}: {fault.message}" for fault in raised.value.faults]


def test_beyond_its_depth_the_wall_is_a_spring() -> None:
    deep = planned({"controller": {**STIFFENING, "depth": 0.001}, "bias": {"torque": 0.04}}).scene
    assert grip_of(deep) == grip_of(planned({"bias": {"torque": 0.04}}).scene)


def test_a_push_of_one_newton_meter_is_like_any_other() -> None:
    slack = {**SQUEEZE, "radius": 0.1}
    one, less = (grip_of(planned({"squeeze": slack, "bias": {"torque": push}}).scene) for push in (1.0, 0.999))
    assert 0.0 < one - less < 0.02 * one


def test_a_light_push_leaves_the_hand_as_it_is() -> None:
    """Two fingers at 0.71 N hold 2 * 0.7 * 8.9 mm * 0.71 N / 1.5 = 5.9 mN·m."""
    scene = planned({"bias": {"torque": 0.001}}).scene
    assert scene_at(scene, {}) == placed(scene, {})._replace(squeeze=None)
    assert grip_of(scene) == 0.71
    firm = planned({"bias": {"torque": 0.04}}).scene
    assert grip_of(firm) > 3.0
    held, own = scene_at(firm, {}).hand, firm.hand
    assert held is not None
    assert own is not None
    assert held.damping > own.damping
    assert held.stiffness > own.stiffness


def test_at_a_row_of_the_table_it_is_that_row() -> None:
    """The push at which the grip is exactly 4.3 N, from the row's own stiffness."""
    torque = 4.3 * 2.0 * 0.7 * 8.9e-3 / 1.5
    push = torque + 0.11 * torque / 0.27
    made = scene_at(planned({"bias": {"torque": push}}).scene, {}).hand
    row = next(grasp for grasp in grasps(1) if grasp.grip_n == 4.3)
    assert made is not None
    assert made[:3] == pytest.approx(row[1:4], rel=1e-13)


def test_many_cells_at_once_are_each_alone() -> None:
    """Columns of every axis that the grip depends on, and of one that it does not."""
    axes = {
        "bias.torque": [0.001, 0.03],
        GRIP: [0.71, 2.4],
        "squeeze.friction": [0.5, 0.9],
        "wall.damping": [0.0, 1e-5],
    }
    plan = planned(**axes)
    combinations = np.array(np.meshgrid(*axes.values())).reshape(len(axes), -1)
    columns = dict(zip(axes, combinations, strict=True))
    size = combinations.shape[1]
    along = scene_along(plan.scene, {**columns, RATE: np.full(size, 1000.0), COUNTS: np.full(size, 2650)})
    assert along.hand is not None
    for i in range(size):
        alone = scene_at(plan.scene, {name: float(values[i]) for name, values in columns.items()})
        assert alone.hand is not None
        assert tuple(np.asarray(value)[i] for value in along.hand[:3]) == alone.hand[:3]
    bare = scene_along(plan.scene, {RATE: np.array([1000.0]), COUNTS: np.array([2650])})
    assert bare == scene_at(plan.scene, {})


def by_numbers(plan: SweepPlan, **cell: float) -> dict[str, Any]:
    """The change of the scene that gives it the hand of its squeeze, written as numbers."""
    hand = squeezed(placed(plan.scene, cell)).hand
    assert hand is not None
    numbers = {"inertia": hand.inertia, "damping": hand.damping, "stiffness": hand.stiffness}
    return {"hand": {**numbers, "table": None, "grip_n": None}, "squeeze": None}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("parts", [{}, COGGING, MESH, PLAY, {**COGGING, **MESH}])
def test_a_sweep_has_the_motion_of_that_hand(parts: dict[str, Any]) -> None:
    follows = SweepStage(planned(parts)).run()
    same = SweepStage(planned({**parts, **by_numbers(planned(parts))})).run()
    other = SweepStage(planned({**parts, "squeeze": None})).run()
    assert follows.orbits.num_rows
    assert follows.orbits.equals(same.orbits)
    assert not follows.orbits.equals(other.orbits)


@pytest.mark.parametrize("parts", [COGGING, MESH])
def test_a_grid_has_the_hand_of_each_push(parts: dict[str, Any]) -> None:
    """And of each stiffness of the mesh, if there is one."""
    axes: dict[str, list[float]] = {"bias.torque": [0.001, 0.03]}
    if "gear" in parts:
        axes["gear.stiffness"] = [0.5, 20.0]
    plan = planned(parts, **axes)
    grid = SweepStage(plan).run().orbits.to_pylist()
    hands = []
    for values in product(*axes.values()):
        cell = dict(zip(axes, values, strict=True))
        change = by_numbers(plan, **cell)
        hands.append(change["hand"]["damping"])
        alone = planned({**parts, **change}, **{name: [value] for name, value in cell.items()})
        rows = [row for row in grid if all(row[name] == value for name, value in cell.items())]
        assert rows == SweepStage(alone).run().orbits.to_pylist() != []
    assert len(set(hands)) == len(hands) - (1 if "gear" in parts else 0)  # a light push leaves the hand as it is


@pytest.mark.parametrize(("gear", "controller"), [({}, None), (MESH, None), (PLAY, None), (MESH, STIFFENING)])
def test_the_knob_rests_where_the_grip_was_sought(gear: dict[str, Any], controller: dict[str, Any] | None) -> None:
    """With a continuous sensor, where its motion has died away to roundings: by a root of the balance for that hand."""
    change = {**gear, "encoder": "none", **({"controller": controller} if controller else {})}
    plan = planned({**change, "knob": {"damping": 1e-3}}, **{COUNTS: None})
    hand, mesh = squeezed(plan.scene).hand, gear["gear"]["stiffness"] if gear else np.inf
    assert hand is not None
    stiffness = hand.stiffness

    def torque(depth: float) -> float:
        share = 0.3 + 0.7 * min(depth / 0.2, 1.0) if controller else 1.0
        return 0.27 * depth * share

    depth = brentq(lambda d: torque(d) + stiffness * (d + torque(d) / mesh) - 0.02, 0.0, 1.0, xtol=1e-15)
    assert grip_of(plan.scene) == pytest.approx(1.5 * torque(depth) / (2.0 * 0.7 * 8.9e-3), rel=1e-12)
    (row,) = SweepStage(plan).run().orbits.to_pylist()
    assert row["outcome"] == "rest"
    assert row["min_rad"] == pytest.approx(-depth, rel=1e-12)


def test_a_mesh_so_soft_that_its_twist_overflows_holds_nothing_of_the_grip() -> None:
    soft = planned({"gear": {**MESH["gear"], "stiffness": 1e-320}})
    assert grip_of(soft.scene) == 0.71


def test_a_softer_mesh_leaves_more_to_the_hands_spring() -> None:
    """Its numbers are told at both ends of an axis of the gear, and of a torque limit."""
    grips = [grip_of(planned({"gear": {**MESH["gear"], "stiffness": one}}).scene) for one in (0.05, 0.5, 5.0, 1e12)]
    assert grips == sorted(set(grips))
    assert grips[-1] == pytest.approx(grip_of(planned().scene), rel=1e-9)
    for parts, axis in ((MESH, {"gear.stiffness": [0.5, 20.0]}), ({}, {"actuator.torque_limit": [0.008, 0.5]})):
        plan = planned(parts or {"actuator": {"torque_limit": 0.5}}, **axis)
        (damping,) = (one for one in derived_numbers(plan.scene, plan.axes) if one.name == "damping of knob and hand")
        ((name, values),) = axis.items()
        hands = [squeezed(placed(plan.scene, {name: value})).hand for value in values]
        assert [damping.least, damping.largest] == [one.damping for one in hands if one]


@pytest.mark.parametrize(
    ("parts", "torque"),
    [
        ({}, 0.0),
        (COGGING, 1e-3),
        ({"knob": {"coulomb_torque": 2e-4}, **COGGING}, 1.2e-3),
        ({"knob": {"coulomb_torque": 2e-4}, "gear": {**RIGID, "motor_coulomb_torque": 1e-4}, **COGGING}, 2.95e-3),
        ({"gear": {**MESH["gear"], "motor_coulomb_torque": 1e-4}, **COGGING}, 2.75e-3),
    ],
)
def test_what_friction_and_cogging_may_change(parts: dict[str, Any], torque: float) -> None:
    """Margin C / (2 mu r) for all that they give, that of the motor 2.5 times."""
    assert left_out(planned(parts).scene) == pytest.approx(1.5 * torque / (2 * 0.7 * 8.9e-3), rel=1e-15)


def test_what_it_says() -> None:
    plan = planned(**{"bias.torque": [0.001, 0.02]})
    (said,) = (text for text in scene_sentences(plan.scene, plan.axes) if text.startswith("Hand"))
    assert said == (
        "Hand: measured, at the grip that the push asks for, 0.71 to 1.906 N: 1.5 times what holds at a friction of"
        " 0.7."
    )


def test_it_says_what_friction_and_cogging_may_change() -> None:
    """At the most of all cells: 1.5 mN·m of the motor behind 2.5 ask for 0.4515 N."""
    plan = planned({**COGGING, "gear": RIGID}, **{"cogging.torque": [0.0, 1.5e-3]})
    (said,) = (text for text in scene_sentences(plan.scene, plan.axes) if text.startswith("Hand"))
    assert said.endswith(" at a friction of 0.7. Cogging, left out of it, may change it by up to 0.4514 N.")
    both = planned({**MESH, **COGGING}, **{"gear.motor_coulomb_torque": [0.0, 1e-4]})
    (said,) = (text for text in scene_sentences(both.scene, both.axes) if text.startswith("Hand"))
    assert said.endswith(" Friction of the bearings and cogging, left out of it, may change it by up to 0.3311 N.")
    rubbing = planned({"knob": {"coulomb_torque": 1e-4}})
    (said,) = (text for text in scene_sentences(rubbing.scene, rubbing.axes) if text.startswith("Hand"))
    assert said.endswith(" Friction of the bearings, left out of it, may change it by up to 0.01204 N.")


def test_a_wall_that_gives_no_more_than_its_limit_asks_for_no_firmer_grip() -> None:
    """Two fingers at 0.96 N hold 8 mN·m 1.5 times; the words say the grips at both ends of a limit that is varied."""
    limited = planned({"actuator": {"torque_limit": 0.008}})
    assert grip_of(limited.scene) == pytest.approx(1.5 * 0.008 / (2 * 0.7 * 8.9e-3), rel=1e-15)
    free = planned({"actuator": {"torque_limit": 0.5}})
    assert grip_of(free.scene) == grip_of(planned().scene)
    varied = planned({"actuator": {"torque_limit": 0.5}}, **{"actuator.torque_limit": [0.008, 0.5]})
    (said,) = (text for text in scene_sentences(varied.scene, varied.axes) if text.startswith("Hand"))
    assert "0.9631 to 1.906 N" in said


@pytest.mark.parametrize(
    ("scene", "grid", "said"),
    [
        ({"hand": {"table": None, "grip_n": None, "damping": 1e-4}}, {}, "squeeze: must be absent where the hand has"),
        ({"bias": {"torque": None, "half_quantum": True}}, {}, "bias.half_quantum: must be absent where"),
        ({"detents": {"per_revolution": 12, "torque": 0.002}}, {}, "detents: must be absent where 'squeeze' is given"),
        ({}, {"hand.stiffness": [0.1, 0.2]}, "must be absent where 'squeeze' is given"),
        ({"controller": {"kind": "half_sample"}}, {}, "controller.kind: must be one without a model of knob and hand"),
        ({"bias": {"torque": 0.3}}, {}, "squeeze: must ask for at most 14.2 N, the firmest"),
        ({}, {"squeeze.friction": [0.01, 0.5]}, "squeeze: must ask for at most 14.2 N"),
        ({"knob": {"inertia": 3e-7}}, {}, "squeeze: must leave an inertia above 0"),
        ({"squeeze": {"friction": 0}}, {}, "squeeze.friction: must be > 0"),
        ({"squeeze": {"margin": 0.5}}, {}, "squeeze.margin: must be >= 1"),
    ],
)  # fmt: skip
def test_faults_have_their_place(scene: dict[str, Any], grid: dict[str, Any], said: str) -> None:
    found = faults(scene, **grid)
    assert any(said in one for one in found), found


def test_a_grip_of_a_row_has_its_numbers_to_the_last_bit() -> None:
    for number in range(1, 6):
        hand = HandSpec(table=number, grip_n=0.71).plain()
        for grip, row in hand.by_grip:
            assert hand_at(hand, grip)[:3] == row[:3]


@pytest.mark.parametrize("surface", [0.3, 0.5])
def test_a_wall_that_stiffens_asks_for_less_where_it_is_soft(surface: float) -> None:
    """By SciPy's root of the balance at rest, T(d) + k d = g, k of the grip for T(d)."""
    scene = planned({"controller": {**STIFFENING, "surface": surface}}).scene
    grips, stiffness = zip(*((one.grip_n, one.stiffness) for one in grasps(1)), strict=True)

    def torque(depth: float) -> float:
        return 0.27 * depth * (surface + (1.0 - surface) * min(depth / 0.2, 1.0))

    def grip(depth: float) -> float:
        return max(0.71, 1.5 * torque(depth) / (2.0 * 0.7 * 8.9e-3))

    depth = brentq(lambda d: torque(d) + np.interp(grip(d), grips, stiffness) * d - 0.02, 0.0, 1.0, xtol=1e-15)
    assert grip(depth) > 0.71
    assert grip_of(scene) == pytest.approx(grip(depth), rel=1e-12)


def test_a_squeeze_of_no_hand_is_none() -> None:
    scene = planned().scene._replace(hand=None)
    assert squeezed(scene) is scene


def test_the_smallest_knob_of_a_grid_asks_for_the_firmest_grip() -> None:
    assert planned(**{"squeeze.radius": [8.9e-3, 5e-3]})
    with pytest.raises(SpecError, match=r"a push of 0.02 N.m may ask for 21.43 N"):
        planned(**{"squeeze.radius": [8.9e-3, 1e-3]})


def test_without_a_push_the_grip_is_that_of_the_hand() -> None:
    scene = planned().scene
    assert grip_of(scene._replace(bias=None)) == 0.71
    assert grip_of(scene._replace(bias=Bias(half_quantum=True))) == 0.71
    assert grip_of(scene._replace(wall=Wall(1.0))) > grip_of(scene)
    assert grip_of(scene) > 0.71


@pytest.mark.parametrize("surface", [1.0, 0.3])
@pytest.mark.parametrize("stiffness", [0.0, 5e-324, 1e-310, 1e-9])
def test_a_wall_that_holds_next_to_nothing_asks_for_no_grip(stiffness: float, surface: float) -> None:
    """Though the push would go into it for ever without a hand."""
    stiffening = {"controller": {**STIFFENING, "surface": surface}} if surface < 1.0 else {}
    assert grip_of(planned(stiffening).scene._replace(wall=Wall(stiffness))) == 0.71


def test_what_does_not_change_the_torque_at_rest_does_not_change_the_grip() -> None:
    plain = grip_of(planned().scene)
    for parts in ({"actuator": {"delay_samples": 0.5}}, {"controller": {"kind": "bounded_lag"}}, {"gear": RIGID}):
        assert grip_of(planned(parts).scene) == plain
    lags = planned({"controller": {"kind": "bounded_lag"}}).scene
    assert lags.controller is not None
    of_another = lags.controller._replace(surface=0.3, depth=10.0)
    assert grip_of(lags._replace(controller=of_another)) == plain
