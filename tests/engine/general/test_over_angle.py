"""Trials under a torque over the angle: what must not change a bit, places of rest, and knobs that turn on for ever."""

from typing import Any

import pytest

from hknob_cli.engine.attractors import Attractor, Patience
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.plan import (
    Actuator,
    Bias,
    DeadZone,
    Detents,
    Encoder,
    EndStops,
    Finger,
    Fingerpad,
    Hand,
    Knob,
    Profile,
    Scene,
    Wall,
)

GRASP = Hand(3e-7, 3.45e-4, 0.04)
FINGER = Hand(finger=Finger(3e-7, 3e-4, 0.5), fingerpad=Fingerpad(1e-3, 20.0))
LONG = Patience(samples=10**9, seconds=100.0)


def knob(
    *,
    counts: int = 256,
    stiffness: float = 0.0,
    wall_damping: float = 0.0,
    push: float = 0.0,
    friction: float = 0.0,
    hand: Hand | None = GRASP,
    encoder: Encoder | None = None,
    **parts: Any,
) -> GeneralKnob:
    scene = Scene(
        Knob(1.9e-6, 0.0 if hand else 3e-4, friction),
        Wall(stiffness, wall_damping),
        hand,
        Bias(push) if push else None,
        encoder or Encoder(),
        parts.pop("actuator", None),
        **parts,
    )
    return sample_general(scene, sample_rate_hz=1000.0, counts_per_rev=counts)


def settle(
    one: GeneralKnob, angle: float = 0.02, velocity: float = 0.0, phases: int = 4, samples: int | None = None
) -> tuple[Attractor, ...]:
    """What trials settle to, in the interpreter."""
    engine = GeneralEngine(patience=LONG)
    return engine.search(
        one.body,
        one.wall,
        one.start(angle, velocity),
        rate=one.rate,
        phases=phases,
        delay_line=one.delay_line,
        max_samples=samples,
    ).attractors


WALLED: dict[str, dict[str, Any]] = {
    "plain": {},
    "friction": {"friction": 1e-5},
    "strong friction": {"friction": 5.6e-4},
    "finger": {"hand": FINGER},
    "delay": {"actuator": Actuator(delay_samples=1.4)},
    "lag": {"actuator": Actuator(time_constant=3e-4)},
    "limit": {"actuator": Actuator(torque_limit=0.004)},
    "step": {"actuator": Actuator(torque_step=2.3e-4)},
    "virtual damping": {"wall_damping": 4e-5},
    "ceil": {"encoder": Encoder("ceil")},
    "truncate": {"encoder": Encoder("truncate", 0.3)},
    "nearest": {"encoder": Encoder("nearest")},
    "all": {
        "friction": 1e-5,
        "wall_damping": 2e-5,
        "encoder": Encoder("nearest"),
        "actuator": Actuator(0.4, 3e-4, 0.02, 1e-4),
    },
}


@pytest.mark.parametrize("name", WALLED)
def test_a_table_of_the_wall_is_the_wall_to_the_last_bit(name: str) -> None:
    """A stop far away makes a table of the wall; margins and bounds of proofs are the same, too."""
    plain = knob(stiffness=0.27, push=0.001, **WALLED[name])
    tabled = knob(stiffness=0.27, push=0.001, end_stops=EndStops(1.0, high=50.0), **WALLED[name])
    assert plain.wall.table is None
    assert len(tabled.wall.table) > 2000
    found, again = settle(plain), settle(tabled)
    assert found[0].outcome in (Outcome.CYCLE, Outcome.REST)
    ours = [one._replace(closure=0.0, bound=0.0) for one in found]
    assert [one._replace(closure=0.0, bound=0.0) for one in again] == ours
    for one, other in zip(found, again, strict=True):
        assert other.bound >= one.bound  # the size of the command counts in it
        assert other.bound <= 64.0 * one.bound


@pytest.mark.one_in(4)
@pytest.mark.parametrize("friction", [0.0, 1e-4])
@pytest.mark.parametrize("delay", [0.0, 1.5])
def test_a_turn_of_the_pattern_shifts_nothing_but_the_angle(friction: float, delay: float) -> None:
    """With a hand that holds nothing, a start 3 detents on, a whole turn of 64 counts, ends 64 counts on."""
    one = knob(
        hand=Hand(3e-7, 3e-4),
        friction=friction,
        actuator=Actuator(delay) if delay else None,
        detents=Detents(0.008, 12, shape="triangle"),
        push=0.002,
    )
    turn = one.wall.table[1]
    assert turn == 64.0
    there = turn * one.quantum_rad
    found, moved = settle(one, 0.1, 2.0), settle(one, 0.1 + there, 2.0)
    assert {(end.outcome, end.reason, end.period) for end in found} == {
        (end.outcome, end.reason, end.period) for end in moved
    }
    for end in moved:  # cycles that nothing holds form a continuum: not to the last digits
        assert end.outcome is Outcome.UNDECIDED or min(abs(end.x - turn - other.x) for other in found) < 1e-5


def test_rests_in_the_detent_that_it_comes_to() -> None:
    """Friction stops it beside a detent; each is a place of rest, and the hand's spring is too weak to draw it out."""
    one = knob(hand=Hand(3e-7, 1e-3, 0.001), friction=4e-4, detents=Detents(0.008, 12, shape="triangle"), counts=1024)
    for number in range(-3, 4):
        for found in settle(one, 0.5236 * number + 0.05):
            assert found.outcome is Outcome.REST
            assert found.reason is Reason.NONE
            assert abs(one.angle_rad(found.x) - 0.5236 * number) < 0.1


def test_push_over_the_detents() -> None:
    """With a push beyond the detents' torque it leaves for ever, which is proven; below it, it rests in one."""
    detents = Detents(0.008, 12)
    pushed = settle(knob(hand=None, push=0.009, detents=detents))
    assert [(one.outcome, one.reason) for one in pushed] == [(Outcome.DIVERGED, Reason.LEAVES)]
    held = settle(knob(hand=None, push=0.004, detents=detents, friction=5e-4))
    assert {one.outcome for one in held} == {Outcome.REST}


@pytest.mark.long
def test_a_start_that_is_fast_enough_spins_for_ever() -> None:
    """Below the detents' torque a push keeps a lightly damped knob turning that turns already; this is not proven."""
    one = knob(hand=Hand(3e-7, 1e-4), push=0.007, detents=Detents(0.008, 12))
    assert [(one.outcome, one.reason) for one in settle(one, 0.0, -20.0)] == [(Outcome.DIVERGED, Reason.SPINS)]
    assert Outcome.DIVERGED not in {end.outcome for end in settle(one, -0.0888)}


@pytest.mark.parametrize("friction", [0.0, 1e-3])
def test_a_torque_that_drives_leaves(friction: float) -> None:
    """Driven up by a torque that ends nowhere: proven as soon as no change of it lies ahead."""
    profile = Profile(((-0.5, -0.002), (0.0, 0.0), (0.5, 0.002)))
    for start, way in ((0.3, 1.0), (-0.3, -1.0)):
        one = knob(hand=None, friction=friction, profile=profile)
        found = settle(one, start, 5.0 * way)
        assert [(one.outcome, one.reason) for one in found] == [(Outcome.DIVERGED, Reason.LEAVES)]


def test_nothing_leaves_that_virtual_damping_brakes() -> None:
    """A knob that turns freely away from an end stop, below 0: the damping stops it, from count to count."""
    one = knob(hand=Hand(3e-7), counts=1024, wall_damping=1e-6, end_stops=EndStops(0.2, high=0.05))
    assert Reason.LEAVES not in {end.reason for end in settle(one, -0.02, -0.05, samples=2000)}


def test_a_push_bounces_on_virtual_damping_alone() -> None:
    """Damping acts on the way in, and not on the step out of the wall: it throws the knob out again, for ever."""
    one = knob(hand=Hand(3e-7, 1e-5), counts=1024, wall_damping=5e-3, push=0.001)
    assert Reason.LEAVES not in {end.reason for end in settle(one, samples=2000)}


def test_rests_anywhere_in_a_dead_zone() -> None:
    """The zone has no torque, so that a count's edge in it is no edge: a rest there is proven wherever it is."""
    one = knob(hand=Hand(3e-7, 1e-3), dead_zone=DeadZone(0.5, 0.3))
    for start in (-0.2, -0.05, 0.0, 0.0001, 0.1):
        for found in settle(one, start, 1.0):
            assert found.outcome is Outcome.REST
            assert found.reason is Reason.NONE
    wide = settle(one, 0.0, 3.0)[0]
    assert wide.margin == 0.0 or wide.outcome is not Outcome.CYCLE


def test_a_table_has_no_late_entry() -> None:
    """Late entry, late exit and staircase are of a wall; work and losses balance all the same."""
    one = knob(push=0.001, detents=Detents(0.02, 12, shape="spring"))
    found = settle(one)[0]
    assert found.outcome is Outcome.CYCLE
    measures = GeneralMeasurer(one, GeneralEngine()).measure(found)
    assert measures.staircase_j != measures.staircase_j
    assert measures.wall_work_j == pytest.approx(measures.damping_loss_j, rel=1e-9)
