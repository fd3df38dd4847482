"""When a knob that nothing holds is proven to leave: it turns the way it is driven, and no torque ahead changes."""

from typing import Any

import pytest

from hknob_cli.engine.general.search import as_list
from hknob_cli.engine.general.standstill import runs_off
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.plan import Actuator, Bias, Encoder, Hand, Knob, Profile, Scene, Wall

DRIVES = Profile(((-0.5, -0.002), (0.0, 0.0), (0.5, 0.002)))  # outwards, the same torque from 0.5 rad on


def knob(*, friction: float = 0.0, push: float = 0.0, profile: Profile | None = DRIVES, **parts: Any) -> GeneralKnob:
    hand, actuator = parts.get("hand"), parts.get("actuator")
    scene = Scene(
        Knob(2e-6, 3e-4, friction), Wall(0.0), hand, Bias(push) if push else None, Encoder(), actuator, profile=profile
    )
    return sample_general(scene, sample_rate_hz=1000.0, counts_per_rev=256)


def leaves(one: GeneralKnob, x: float, v: float, u: float) -> bool:
    z = [x, v, u, 0.0, 0.0][: one.body.order]
    return bool(runs_off(z, u, float(x // 1.0), one.body, as_list(one.wall)))


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_driven_the_way_it_turns_with_nothing_ahead(way: float) -> None:
    one = knob()
    far = 40.5 * way
    assert leaves(one, far, 1e-9 * way, 1e-9 * way)
    assert not leaves(one, far, 0.0, way)
    assert not leaves(one, far, -way, way)  # turns against the torque, and back
    assert not leaves(one, far, way, -way)
    assert not leaves(one, far, way, 0.0)
    assert not leaves(one, 2.5 * way, way, way)  # the torque changes ahead
    assert not leaves(one, -far, way, way)


def test_friction_and_push_count() -> None:
    rubbed = knob(friction=5e-4)
    level = rubbed.body.friction
    assert level > 0.0
    assert not leaves(rubbed, 40.5, 1.0, level)
    assert leaves(rubbed, 40.5, 1.0, level * 1.000001)
    pushed = knob(push=5e-4)
    assert not leaves(pushed, 40.5, 1.0, pushed.body.push)
    assert leaves(pushed, 40.5, 1.0, pushed.body.push * 1.000001)
    assert leaves(pushed, -40.5, -1.0, 0.0)


def test_whatever_holds_it_holds_it() -> None:
    assert not leaves(knob(hand=Hand(3e-7, 0.0, 1e-6)), 40.5, 1.0, 1.0)
    assert not leaves(knob(actuator=Actuator(time_constant=1e-3)), 40.5, 1.0, 1.0)
    assert not leaves(knob(profile=None), 40.5, 1.0, 1.0)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_cogging_counts_by_its_largest_torque(way: float) -> None:
    """Beside friction: a place of rest holds the knob wherever it is."""
    level = knob(friction=5e-4).body.friction
    for one, most in ((knob(), 3.0), (knob(friction=5e-4), 3.0 + level)):
        held = one._replace(body=one.body._replace(cogs=[0.75, 8.0, -20.5, 3.0, 0.75**0.5, 28.5]))
        assert not leaves(held, 40.5 * way, way, most * way)
        assert leaves(held, 40.5 * way, way, most * 1.000001 * way)
        assert leaves(one, 40.5 * way, way, most * way)
