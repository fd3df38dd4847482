"""The exact motion: against formulas, SciPy with events, the sample-by-sample engine, and the energy balance."""

import numpy as np
import pytest

from hknob_cli.apparatus.hand import SecondOrder, follow, increment, increments, mechanism, split, static_stiffness
from hknob_cli.apparatus.hand_recording import scaled_pulse
from hknob_cli.apparatus.people import EXPERIMENTS, grips, mean_hand
from hknob_cli.engine.general.advance import advance_span
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.plan import Actuator, Finger, Fingerpad, Knob, Scene, Wall
from hknob_cli.specs.plan import Hand as SceneHand
from tests.apparatus.reference import by_scipy, pulse_response

RATE, DT = 10_000.0, 1e-4
COULOMB, LAG = 0.56e-3, 50e-6
ROWS = [(number, grip) for number in EXPERIMENTS for grip in grips(number)]


def stretches(torque: float, after: int = 400) -> list[tuple[float, int]]:
    return [(0.0, 50), (torque, 200), (0.0, after)]


@pytest.mark.parametrize(("number", "grip"), ROWS)
def test_second_order_is_the_closed_form(number: int, grip: float) -> None:
    """To rounding: a sum of some hundred products of angles up to 0.1 rad, amplified by nearly equal roots."""
    hand, pulse = mean_hand(number, grip), scaled_pulse(number, grip)
    angle = follow(mechanism(hand), np.zeros(2), stretches(pulse.torque_nm), DT)[:, 0]
    times = np.arange(651) * DT - 5e-3
    assert np.abs(angle - pulse_response(hand, times, pulse.torque_nm, 0.02)).max() < 1e-12


def test_no_stiffness_is_a_free_knob() -> None:
    body = mechanism(SecondOrder(2e-6, 0.0, 0.0))
    states = follow(body, np.zeros(2), [(1e-3, 100), (0.0, 100)], DT)
    assert states[100] == pytest.approx([0.5 * 500.0 * 0.01**2, 5.0], rel=1e-13)
    assert states[200] == pytest.approx([0.025 + 0.05, 5.0], rel=1e-13)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("lag", [0.0, LAG])
@pytest.mark.parametrize("order", ["second", "fourth"])
@pytest.mark.parametrize(("number", "grip"), [(1, 0.71), (1, 4.3), (1, 14.2), (2, 0.71), (3, 2.4), (5, 14.2)])
def test_friction_agrees_with_scipy(number: int, grip: float, order: str, lag: float) -> None:
    """Within the integrator's own error: tolerance 1e-12 a step of 0.1 rad over some thousand steps."""
    hand = mean_hand(number, grip)
    hand = split(hand, knob_kg_m2=19.8e-7) if order == "fourth" else hand
    torque = scaled_pulse(number, grip).torque_nm
    body = mechanism(hand, coulomb=COULOMB, lag_s=lag)
    angle = follow(body, np.zeros(len(body.entry)), stretches(torque), DT)[:, 0]
    spans = [(0.0, 5e-3), (torque, 0.02), (0.0, 0.04)]
    expected, events = by_scipy(hand, spans, np.arange(651) * DT, coulomb=COULOMB, lag=lag)
    assert events >= 1
    assert np.abs(angle - expected).max() < 1e-9


@pytest.mark.parametrize("lag", [0.0, LAG])
@pytest.mark.parametrize("coulomb", [0.0, COULOMB, 3e-3])
@pytest.mark.parametrize(("number", "grip"), [(1, 2.4), (5, 14.2)])
@pytest.mark.parametrize("order", ["second", "fourth"])
def test_the_engine_goes_the_same_way(number: int, grip: float, order: str, coulomb: float, lag: float) -> None:
    """The engine's sample-by-sample motion is independent code; its events are exact to a bit of a sample period."""
    hand, torque = mean_hand(number, grip), scaled_pulse(number, grip).torque_nm
    parts = split(hand, knob_kg_m2=19.8e-7)
    four = order == "fourth"
    held = SceneHand(damping=hand.damping, stiffness=hand.stiffness)
    if four:
        held = SceneHand(
            finger=Finger(parts.finger_inertia, parts.finger_damping, parts.finger_stiffness),
            fingerpad=Fingerpad(parts.pad_damping, parts.pad_stiffness),
        )
    scene = Scene(
        knob=Knob(parts.inertia if four else hand.inertia, coulomb_torque=coulomb),
        hand=held,
        wall=Wall(0.0),
        bias=None,
        encoder=None,
        actuator=Actuator(time_constant=lag),
    )
    knob = sample_general(scene, sample_rate_hz=RATE, counts_per_rev=None)
    n = knob.body.order
    z, pad, angle = knob.start(0.0, 0.0), [0.0] * (2 * n), [0.0]
    for command, count in stretches(torque):
        for _ in range(count):
            advance_span(z, command / knob.torque_nm, 1.0, knob.body, pad)
            angle.append(knob.angle_rad(z[0]))
    body = mechanism(parts if four else hand, coulomb=coulomb, lag_s=lag)
    states = follow(body, np.zeros(len(body.entry)), stretches(torque), DT)
    assert np.abs(states[:, 0] - angle).max() < 1e-11


def test_friction_takes_what_the_pulse_gave() -> None:
    """Without damping: work of the pulse = energy left + friction times the way gone, at every sample.

    The way between samples is missed where the knob turns: at most a dt² / 4 of it each time.
    """
    hand, torque = SecondOrder(2e-6, 0.0, 0.08), 6e-3
    states = follow(mechanism(hand, coulomb=COULOMB), np.zeros(2), stretches(torque, 3000), DT)
    angle, speed = states.T
    way = np.concatenate([[0.0], np.abs(np.diff(angle)).cumsum()])
    work = torque * np.concatenate([angle[:251], np.full(3000, angle[250])])
    left = work - COULOMB * way - 0.5 * hand.inertia * speed**2 - 0.5 * hand.stiffness * angle**2
    turns = int((np.diff(np.sign(speed[50:])) != 0).sum())
    assert turns > 5
    fastest = (torque + COULOMB + hand.stiffness * np.abs(angle).max()) / hand.inertia
    assert np.abs(left).max() < COULOMB * turns * fastest * DT**2 / 4 + 1e-15
    # Then it is held, where friction can hold it.
    assert speed[-1] == 0.0
    assert abs(hand.stiffness * angle[-1]) <= COULOMB


@pytest.mark.parametrize("order", ["second", "fourth"])
@pytest.mark.parametrize("lag", [0.0, LAG])
def test_a_preloaded_knob_stays_until_the_pulse(order: str, lag: float) -> None:
    hand = mean_hand(1, 0.71)
    hand = split(hand, knob_kg_m2=19.8e-7) if order == "fourth" else hand
    body = mechanism(hand, coulomb=COULOMB, lag_s=lag)
    start = body.rest(0.9 * COULOMB)
    states = follow(body, start, [(0.0, 100), (4e-3, 10)], DT)
    assert states[100, 0] == start[0] == pytest.approx(0.9 * COULOMB / static_stiffness(hand))
    assert np.abs(states[:101] - start).max() < 1e-15 + 1e-12 * start[0]
    assert states[-1, 0] > start[0]


def test_too_weak_a_pulse_moves_nothing() -> None:
    body = mechanism(mean_hand(1, 0.71), coulomb=COULOMB, lag_s=LAG)
    assert not follow(body, np.zeros(3), stretches(0.999 * COULOMB), DT)[:, :2].any()


def test_increments_are_integrals_of_the_exponential() -> None:
    """Against the closed form of a rotation, D = [[sin, 1 - cos], [cos - 1, sin]]."""
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    table = increments(turn, 0.01, 1000)
    for k in (0, 1, 2, 3, 500, 999, 1000):
        t = 0.01 * k
        expected = np.array([[np.sin(t), 1 - np.cos(t)], [np.cos(t) - 1, np.sin(t)]])
        assert np.abs(table[k] - expected).max() < 1e-13
    assert np.abs(increment(turn, 7.0) - [[np.sin(7), 1 - np.cos(7)], [np.cos(7) - 1, np.sin(7)]]).max() < 1e-14
