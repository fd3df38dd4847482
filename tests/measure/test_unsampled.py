"""Trials without a sample clock: energy, rest, chatter, settling, and recordings."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.unsampled.state_machine import potential, rest_range
from hknob_cli.errors import ComputationError
from hknob_cli.measure.unsampled import Motion, UnsampledTrial, events, settle
from hknob_cli.scene.plain_knob import UnsampledKnob, reduce_unsampled
from hknob_cli.specs.scene import SceneSpec

J, K, G, B = 2.2e-6, 0.27, 0.001, 3.45e-4
BALL: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3e-7},
    "wall": {"stiffness": K},
    "bias": {"torque": G},
    "sampling": "continuous",
}
HAND = {"inertia": 3e-7, "damping": B}


def knob(counts: int | None = 1024, **parts: object) -> UnsampledKnob:
    return reduce_unsampled(SceneSpec.model_validate({**BALL, **parts}).plain(), counts_per_rev=counts)


def trial(one: UnsampledKnob, angle: float = 0.02, velocity: float = 0.0, **options: Any) -> UnsampledTrial:
    return settle(one, angle_rad=angle, velocity_rad_s=velocity, **{"max_events": 2_000_000, **options})


def record(one: UnsampledKnob, duration: float, angle: float = 0.02, velocity: float = 0.0, **options: Any) -> Motion:
    return events(one, angle_rad=angle, velocity_rad_s=velocity, duration_s=duration, **options)


def energies(motion: Motion) -> np.ndarray:
    """Energy at each event, from the state alone, in units of the loop."""
    x = motion.rows[:, 2] + motion.rows[:, 3]
    return 0.5 * motion.rows[:, 4] ** 2 + np.array([potential(float(at), motion.knob.loop) for at in x])


def remaining(motion: Motion, time_s: float) -> float:
    """Span of the motion from a time on: extremes are events."""
    now = motion.at(np.array([time_s]))[0]
    return float(np.ptp(np.concatenate([now, motion.angle_rad[motion.time_s >= time_s]])))


SCENES = {
    "fig 23": knob(2650),
    "coarse": knob(64),
    "fig 24": knob(1024, wall={"stiffness": 1e4 * K}),
    "continuous sensor": knob(encoder="none"),
    "hand": knob(1024, hand={"inertia": 3e-7, "stiffness": 0.04}),
    "offset": knob(1024, encoder={"rounding": "nearest", "offset_counts": 0.37}),
}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("angle", [0.02, 0.0123456, 0.0033])
def test_energy_of_a_million_bounces(name: str, angle: float, functions: Any) -> None:
    """Required: constant to 1e-10. A velocity is rounded once an edge: by random walk 8e6 edges give 2.2e-16 * 3e3."""
    found = trial(SCENES[name], angle, max_events=10**9, max_peaks=10**6, functions=functions)
    assert (found.outcome, found.reason) == (Outcome.CYCLE, Reason.CONSERVATIVE)
    assert found.bounces >= 10**6
    assert found.energy_drift <= 1e-12


@pytest.mark.parametrize("name", SCENES)
def test_compiled_and_interpreted_agree_to_the_last_bit(name: str, functions: Any) -> None:
    one = SCENES[name]
    assert trial(one, functions=functions, max_peaks=50) == pytest.approx(trial(one, max_peaks=50), rel=0, nan_ok=True)
    damped = UnsampledKnob(one.loop._replace(alpha=0.4, phi=0.01), *one[1:])
    assert trial(damped, functions=functions) == pytest.approx(trial(damped), rel=0, nan_ok=True)
    rows = record(damped, 0.2).rows
    assert np.array_equal(rows, record(damped, 0.2, functions=functions).rows)


def test_ball_on_a_linear_wall_in_closed_form() -> None:
    """Continuous sensor, no hand: parabola outside, half a sine about -g/K inside."""
    found = trial(knob(None, encoder="none"))
    w, sink, speed = math.sqrt(K / J), G / K, math.sqrt(2.0 * G / J * 0.02)
    depth = sink + math.hypot(sink, speed / w)
    inside = 2.0 * (math.pi - math.atan2(speed / w, sink)) / w
    flight = 2.0 * speed * J / G
    assert found.p2p_rad == pytest.approx(0.02 + depth, rel=1e-13)
    assert found.min_rad == pytest.approx(-depth, rel=1e-13)
    assert found.max_rad == pytest.approx(0.02, rel=1e-13)
    assert found.frequency_hz == pytest.approx(1.0 / (inside + flight), rel=1e-13)
    assert found.cycles == 1


@pytest.mark.parametrize("name", SCENES)
def test_rms_and_period_are_those_of_the_recorded_motion(name: str) -> None:
    """One recorded period, its mean square by Gauss-Legendre over each piece between its events."""
    one = SCENES[name]
    found = trial(one)
    period = 1.0 / found.frequency_hz
    motion = record(one, 1.5 * period)
    turning = np.flatnonzero(motion.rows[:, 4] == 0.0)
    assert motion.time_s[turning[2]] == pytest.approx(period, rel=1e-13)
    nodes, weights = np.polynomial.legendre.leggauss(16)
    first = second = 0.0
    times = motion.time_s[: turning[2] + 1]
    for start, end in pairwise(times):
        at = np.linspace(start, end, 5)
        for a, b in pairwise(at):
            theta = motion.at(0.5 * (a + b) + 0.5 * (b - a) * nodes)[0]
            first += 0.5 * (b - a) * float(weights @ theta)
            second += 0.5 * (b - a) * float(weights @ theta**2)
    mean = first / period
    assert found.rms_rad == pytest.approx(math.sqrt(second / period - mean**2), rel=1e-10)
    assert found.max_rad == pytest.approx(0.02, rel=1e-14)


def test_staircase_is_the_same_in_and_out() -> None:
    """Fig. 23: no work is left over; torques on the way out are those of the way in, in reverse."""
    motion = record(SCENES["fig 23"], 0.045)
    turning = np.flatnonzero(motion.rows[:, 4] == 0.0)
    way_in, way_out = motion.torque_nm[: turning[1]], motion.torque_nm[turning[1] : turning[2]]
    assert len(way_in) > 5
    assert np.array_equal(way_in, way_out[::-1])


@pytest.mark.parametrize("counts", [512, 1024, 2048, 2650, 4096, 8192])
def test_contact_of_fig_26_settles_in_about_50_ms(counts: int) -> None:
    """From 50 ms after first contact on the knob stays within one count, and within 3 % of the first swing."""
    one = knob(counts, hand=HAND)
    found = trial(one)
    assert found.outcome is Outcome.REST
    assert found.settling_s - found.contact_s < 0.05
    motion = record(one, 0.4)
    first = 0.02 - motion.angle_rad.min()
    assert remaining(motion, found.contact_s + 0.05) < min(one.unit_rad, 0.03 * first)
    assert remaining(motion, found.settling_s + 1e-9) <= one.unit_rad
    assert remaining(motion, found.settling_s - 1e-9) > one.unit_rad


def test_contact_with_a_continuous_sensor() -> None:
    """Damped sine about -g/K: settled within 1 % of the first bounce, checked on the recorded motion."""
    one = knob(None, encoder="none", hand=HAND)
    found = trial(one)
    assert found.outcome is Outcome.REST
    assert found.min_rad == pytest.approx(-G / K, rel=1e-15)
    motion = record(one, 0.3)
    turning = motion.angle_rad[motion.rows[:, 4] == 0.0]
    span = 0.01 * abs(turning[2] - turning[1])
    assert remaining(motion, found.settling_s + 1e-9) <= span
    assert remaining(motion, found.settling_s - 1e-9) > span


def test_chatter_ends_on_the_edge_exactly() -> None:
    """At 2650 counts g lies between the torques of one count and none: the knob comes to rest on an edge."""
    one = knob(2650, hand=HAND)
    found = trial(one)
    q = 2.0 * math.pi / 2650
    m = math.floor(G / (K * q))
    assert (found.outcome, found.reason) == (Outcome.REST, Reason.NONE)
    assert found.min_rad == found.max_rad == -m * one.unit_rad
    assert found.events < 100
    assert (found.p2p_rad, found.rms_rad, found.frequency_hz) == (0.0, 0.0, 0.0)
    motion = record(one, 1.0)
    assert motion.rows[-1, 5] == 0.0
    assert motion.angle_rad[-1] == found.min_rad
    assert motion.torque_nm[-1] == pytest.approx(G, rel=1e-14)
    theta, omega, torque = motion.at(np.array([1.0]))
    assert (theta[0], omega[0]) == (found.min_rad, 0.0)
    assert torque[0] == motion.torque_nm[-1]
    assert found.damping_loss_j + found.wall_work_j * -1.0 == pytest.approx(G * (0.02 - found.min_rad), rel=1e-13)


def test_chatter_under_friction_converges_to_the_edge() -> None:
    """Friction alone: crossings pile up geometrically, v' / v = sqrt((y - phi)/(y + phi)) on each side."""
    one = knob(2650, knob={"inertia": 1.9e-6, "coulomb_torque": 2e-4})
    found = trial(one)
    assert (found.outcome, found.reason) == (Outcome.REST, Reason.NONE)
    assert found.min_rad == -one.unit_rad
    assert found.friction_loss_j == pytest.approx(G * 0.02 - (-found.wall_work_j) + G * one.unit_rad, rel=1e-12)
    motion = record(one, 2.0, chatter_counts=1e-9)
    assert motion.rows[-1, 5] == 0.0
    crossings = motion.rows[(motion.rows[:, 2] == -1.0) & (motion.rows[:, 3] == 0.0)][-9:-1]
    phi = one.loop.phi
    up, down = one.loop.gamma - one.loop.kappa, 2.0 * one.loop.kappa - one.loop.gamma
    ratios = np.abs(crossings[1:, 4] / crossings[:-1, 4])
    wanted = [math.sqrt((y - phi) / (y + phi)) for y in (up, down)]
    assert sorted(ratios)[0] == pytest.approx(min(wanted), rel=1e-9)
    assert sorted(ratios)[-1] == pytest.approx(max(wanted), rel=1e-9)


def test_chatter_is_cut_where_it_stays_within_the_height_asked_for() -> None:
    one = knob(2650, hand=HAND)
    fine = record(one, 0.2)
    for height in (1e-1, 1e-2, 1e-3):
        cut = record(one, 0.2, chatter_counts=height).time_s[-1]
        left = fine.rows[fine.time_s >= cut]
        assert len(left) > 20
        beyond = np.abs(left[:, 2] + left[:, 3] + 1.0).max()
        assert 0.2 * height < beyond <= height


@pytest.mark.parametrize("counts", [2650, 8192, None])
def test_losses_are_those_of_damping_and_of_friction(counts: int | None) -> None:
    """Against the integral of b v^2, and friction times the way, over the recorded motion.

    With an encoder the recording ends in chatter of 1e-7 counts, and the trial of 1e-6 at most: relative to the way of
    some counts, which is what the friction's part may miss.
    """
    friction = 1e-4
    encoder = "none" if counts is None else {"rounding": "floor"}
    one = knob(counts, knob={"inertia": 1.9e-6, "coulomb_torque": friction}, hand=HAND, encoder=encoder)
    found = trial(one)
    motion = record(one, 0.4, chatter_counts=1e-7)
    assert motion.rows[-1, 5] == 0.0
    nodes, weights = np.polynomial.legendre.leggauss(12)
    burnt = 0.0
    for a, b in pairwise(motion.time_s):
        omega = motion.at(0.5 * (a + b) + 0.5 * (b - a) * nodes)[1]
        burnt += 0.5 * (b - a) * B * float(weights @ omega**2)
    rubbed = friction * float(np.abs(np.diff(motion.angle_rad)).sum())
    assert found.friction_loss_j == pytest.approx(rubbed, rel=1e-5)
    assert found.damping_loss_j == pytest.approx(burnt, rel=1e-5)


def test_friction_holds_the_knob_where_it_stops() -> None:
    """Outside the wall with g < T_c the knob does not move; thrown, it stops after J v^2 / 2 (T_c + g)."""
    one = knob(1024, knob={"inertia": 1.9e-6, "coulomb_torque": 1.5e-3})
    still = trial(one, 0.02)
    assert (still.outcome, still.min_rad, still.settling_s, still.events) == (Outcome.REST, 0.02, 0.0, 0)
    thrown = trial(one, 0.02, velocity=1.0)
    assert thrown.min_rad == pytest.approx(0.02 + 0.5 * J / (1.5e-3 + G), rel=1e-13)
    assert thrown.friction_loss_j == pytest.approx(1.5e-3 * (thrown.min_rad - 0.02), rel=1e-12)


def test_friction_stops_it_inside_a_level() -> None:
    one = knob(8192, knob={"inertia": 1.9e-6, "coulomb_torque": 4e-4})
    low, high = (one.angle_rad(x) for x in rest_range(one.loop))
    assert high - low > one.unit_rad
    found = trial(one)
    assert (found.outcome, found.reason) == (Outcome.REST, Reason.NONE)
    assert low <= found.min_rad <= high


def test_without_bias_it_is_repelled_and_leaves_or_stops() -> None:
    """The knob "will be repelled from the barrier once and come to rest" (Hasser, sec. 6.4.1), if anything damps it."""
    away = trial(knob(bias={"torque": 0.0}), 0.01, velocity=-2.0)
    assert (away.outcome, away.reason, away.bounces) == (Outcome.DIVERGED, Reason.LEAVES, 1)
    assert math.isnan(away.p2p_rad)
    stops = trial(knob(bias={"torque": 0.0}, hand=HAND), 0.01, velocity=-5.0)
    assert (stops.outcome, stops.reason, stops.bounces) == (Outcome.REST, Reason.NONE, 1)
    motion = record(knob(bias={"torque": 0.0}, hand=HAND), 1.0, 0.01, -5.0)
    out = motion.rows[-1]
    assert out[1] == 0.0
    assert stops.min_rad == pytest.approx(motion.velocity_rad_s[-1] * J / B, rel=1e-13)
    still = trial(knob(bias={"torque": 0.0}), 0.01)
    assert (still.outcome, still.min_rad) == (Outcome.REST, 0.01)


def test_nothing_holds_it_without_a_wall() -> None:
    found = trial(knob(wall={"stiffness": 0.0}, hand=HAND))
    assert (found.outcome, found.reason) == (Outcome.DIVERGED, Reason.LEAVES)


def test_free_oscillation_beside_the_wall() -> None:
    """A hand without bias, thrown lightly enough inside the first count: no edge is met but the wall's."""
    found = trial(knob(None, encoder="none", bias={"torque": 0.0}, hand={"inertia": 3e-7, "stiffness": 0.04}), 0.02)
    inside, outside = math.sqrt((K + 0.04) / J), math.sqrt(0.04 / J)
    assert found.frequency_hz == pytest.approx(1.0 / (math.pi / inside + math.pi / outside), rel=1e-13)
    assert found.min_rad == pytest.approx(-0.02 * outside / inside, rel=1e-13)


def test_rest_on_an_edge_by_rounding_is_not_certified() -> None:
    """g is the torque of one count exactly: the knob is held anywhere in it, or, hand added, at its very edge."""
    q = 2.0 * math.pi / 1024
    hand = {**HAND, "stiffness": 0.04}
    found = trial(knob(bias={"torque": K * q + 0.04 * q}, hand=hand))
    assert found.outcome is Outcome.REST
    assert found.min_rad == pytest.approx(-q, rel=1e-14)
    assert found.reason is Reason.REST_ON_EDGE


def test_limits_are_said() -> None:
    one = knob(8192, hand={"inertia": 3e-7, "damping": 1e-9})
    assert trial(one, max_events=100)[:2] == (Outcome.UNDECIDED, Reason.EVENT_LIMIT)
    fine = knob(2**40, hand=HAND)
    assert trial(fine, 1e6)[:2] == (Outcome.UNDECIDED, Reason.TOO_FINE)
    with pytest.raises(ComputationError, match="events"):
        record(one, 10.0, max_events=1000)
    with pytest.raises(ValueError, match="times"):
        record(one, 0.1).at(np.array([0.2]))


@settings(max_examples=150, deadline=None)
@given(
    counts=st.sampled_from([64, 300, 1024, 2650]),
    rounding=st.sampled_from(["floor", "nearest", "ceil", "truncate", None]),
    offset=st.sampled_from([0.0, 0.5, 0.37]),
    damping=st.sampled_from([0.0, 1e-5, 3.45e-4, 5e-3]),
    friction=st.sampled_from([0.0, 5e-5, 4e-4, 3e-3]),
    stiffness=st.sampled_from([0.0, 0.04]),
    bias=st.sampled_from([0.0, 0.001, 0.27 * 2.0 * math.pi / 1024, 0.0013]),
    angle=st.floats(-0.03, 0.03),
    velocity=st.sampled_from([0.0, -3.0, 2.0]),
)
def test_every_motion_keeps_its_books(
    counts: int,
    rounding: str | None,
    offset: float,
    damping: float,
    friction: float,
    stiffness: float,
    bias: float,
    angle: float,
    velocity: float,
) -> None:
    """Time runs on, pieces hold the positions, energy never grows, losses are no gains, and rest is a rest point."""
    one = knob(
        counts,
        knob={"inertia": 1.9e-6, "coulomb_torque": friction},
        hand={"inertia": 3e-7, "damping": damping, "stiffness": stiffness},
        bias={"torque": bias},
        encoder={"rounding": rounding, "offset_counts": offset} if rounding else "none",
    )
    loop = one.loop
    motion = record(one, 0.1, angle, velocity)
    t, n, edge, u, v, way = motion.rows.T
    x = edge + u
    assert np.all(np.diff(t) >= 0.0)
    assert np.all(way * v >= 0.0)
    if rounding:
        assert np.all((n == 0.0) | ((x >= -n) & (x <= 1.0 - n)))
        assert np.all((n > 0.0) | (x >= 0.0))
    energy = energies(motion)
    scale = 1.0 + np.max(np.abs(energy))
    assert np.all(np.diff(energy) <= 1e-13 * scale)
    if damping == friction == 0.0:
        assert np.ptp(energy) <= 1e-12 * scale
    theta, _, _ = motion.at(np.minimum(motion.time_s, 0.1))
    # Where events crowd, a time tells only which of them it is to rounding: the angle, not the velocity.
    assert np.allclose(theta, motion.angle_rad, rtol=0.0, atol=1e-11)
    found = trial(one, angle, velocity, max_events=200_000)
    assume(found.reason is not Reason.EVENT_LIMIT or damping + friction <= 1e-5)
    if found.outcome is Outcome.REST:
        low, high = rest_range(loop)
        at = one.position(found.min_rad)
        assert low - 1e-9 <= at <= high + 1e-9
        lost = found.damping_loss_j + found.friction_loss_j
        assert found.damping_loss_j >= -1e-13 * one.energy_j * scale
        assert found.friction_loss_j >= -1e-13 * one.energy_j * scale
        assert lost == pytest.approx((energy[0] - potential(at, loop)) * one.energy_j, abs=1e-12 * one.energy_j * scale)
        assert found.settling_s >= 0.0
    elif found.outcome is Outcome.DIVERGED:
        assert bias == stiffness == 0.0
    else:
        assert damping + friction <= 1e-5
