"""Measures of trials without a sample clock, by hand: from what the engine found to what is said, and each bound."""

from math import inf, isnan, sqrt
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.budget import FINEST
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.unsampled import settling
from hknob_cli.engine.unsampled.state_machine import Unsampled, potential, rest_range, wall_potential
from hknob_cli.errors import ComputationError
from hknob_cli.measure import unsampled
from hknob_cli.measure.unsampled import CHATTER, Motion, UnsampledTrial, _is_doubtful, _reach, events, settle
from tests.measure.test_unsampled import B, knob

EPSILON = 2.0**-52
LOOP = Unsampled(alpha=0.0, beta=0.0, kappa=2.0, gamma=6.0, phi=0.0, offset=0.0, counted=1.0)


def found(one: Any, fate: int, *, moments: Any = None, **values: float) -> UnsampledTrial:
    """What is said of a trial from 0.02 rad and 0.5 rad/s that the engine ends so."""
    names = ("end", "events", "bounces", "contact", "settled", "path", "top", "bottom", "drift")
    said = (fate, *(values.get(name, 0.0) for name in names))
    functions = {"unsampled.settle_motion": lambda *_: said, "unsampled.swing_moments": lambda *_: moments}
    return settle(one, angle_rad=0.02, velocity_rad_s=0.5, max_events=9, functions=functions)


def energy_at_the_start(one: Any) -> float:
    x, v = one.position(0.02), one.speed(0.5)
    return 0.5 * v * v + potential(x, one.loop)


def test_a_period_is_said_in_si() -> None:
    """Half of it takes 4, in which the distance from the middle has the integral 2 and its square 9."""
    one = knob(1024)
    low, _ = rest_range(one.loop)
    values = {"events": 7.0, "bounces": 3.0, "contact": 2.5, "top": 5.0, "drift": 0.75}
    said = found(one, settling.BOUNCES_ON, moments=(4.0, -3.0, 2.0, 9.0), **values)
    assert (said.outcome, said.reason, said.cycles) == (Outcome.CYCLE, Reason.CONSERVATIVE, 1)
    assert (said.bounces, said.events) == (3, 7)
    assert said.contact_s == pytest.approx(2.5 * one.unit_s)
    assert said.p2p_rad == pytest.approx(8.0 * one.unit_rad)
    assert (said.min_rad, said.max_rad) == (one.angle_rad(-3.0), one.angle_rad(5.0))
    assert said.rms_rad == pytest.approx(sqrt(9.0 / 4.0 - 0.25) * one.unit_rad)
    assert said.frequency_hz == pytest.approx(0.125 / one.unit_s)
    assert said.energy_drift == pytest.approx(0.75 / (energy_at_the_start(one) - potential(low, one.loop)))
    assert (said.wall_work_j, said.damping_loss_j, said.friction_loss_j) == (0.0, 0.0, 0.0)


def test_what_never_touches_the_wall_has_no_contact() -> None:
    said = found(knob(1024), settling.GOES_AWAY, contact=inf)
    assert isnan(said.contact_s)
    assert (said.outcome, said.reason) == (Outcome.DIVERGED, Reason.LEAVES)
    assert found(knob(1024), settling.OUT_OF_EVENTS).reason is Reason.EVENT_LIMIT


@pytest.mark.parametrize(
    ("damping", "friction"), [(B, 0.0), (B, 1e-4), (0.0, 1e-4)], ids=["damping", "both", "friction"]
)
def test_what_is_lost_is_lost_to_damping_or_friction(damping: float, friction: float) -> None:
    """Friction takes its torque times the path; without damping it has taken all."""
    one = knob(1024, knob={"inertia": 1.9e-6, "coulomb_torque": friction}, hand={"inertia": 3e-7, "damping": damping})
    said = found(one, 99, end=-2.5, path=30.0, settled=6.0)
    low, high = rest_range(one.loop)
    rest = -2.5 if low != high else low
    lost = (energy_at_the_start(one) - potential(rest, one.loop)) * one.energy_j
    rubbed = one.loop.phi * 30.0 * one.energy_j if damping else lost
    assert said.outcome is Outcome.REST
    assert said.friction_loss_j == pytest.approx(rubbed)
    assert said.damping_loss_j == pytest.approx(lost - rubbed, abs=1e-15)
    work = wall_potential(one.position(0.02), one.loop) - wall_potential(rest, one.loop)
    assert said.wall_work_j == pytest.approx(work * one.energy_j)
    assert said.settling_s == pytest.approx(6.0 * one.unit_s)
    assert said.min_rad == said.max_rad == one.angle_rad(rest)
    assert (said.p2p_rad, said.rms_rad, said.frequency_hz) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("x", "v", "changes", "reach"),
    [
        (-9.0, 1.0, {}, 9.0),
        (0.0, -9.0, {"kappa": 200.0}, 9.0),
        (0.0, 0.0, {}, 3.0),
        (0.0, 0.0, {"gamma": -6.0}, 3.0),
        (1.0, 0.0, {"gamma": 16.0, "kappa": 0.5}, 32.0),
        (-1.0, 0.0, {"gamma": 16.0, "kappa": 0.0, "beta": 8.0}, 2.0),
        (1.0, 6.0, {"gamma": 0.0}, 6.0),
        (1.0, 6.0, {"gamma": 0.0, "kappa": 0.5}, 12.0),
        (2.0, 1.0, {"kappa": 0.0}, 2.0),
        (0.5, 0.25, {"kappa": 0.0}, 0.5),
    ],
)
def test_how_far_a_motion_may_reach(x: float, v: float, changes: dict[str, float], reach: float) -> None:
    """To where it is, rests, is after a unit of time, or swings by its energy."""
    assert _reach(x, v, LOOP._replace(**changes)) == pytest.approx(reach)


def test_rest_on_an_edge_is_doubtful_within_the_roundings() -> None:
    """Eight of each torque, added in size: where the push is the wall's just above the edge, or just below it."""
    bound = 8.0 * EPSILON * (2.0 * 4.0 + 6.0)
    for beside in (4.0, 6.0, 8.0):  # at -3 the wall pushes back by 6 above the edge, and by 8 below it
        for off in (-1.5, -0.5, 0.5, 1.5):
            gamma = beside + off * bound
            decided = gamma - bound > 6.0 and gamma + bound < 8.0
            assert _is_doubtful(-3.0, LOOP._replace(gamma=gamma)) is not decided


def test_damping_and_friction_are_no_torques_of_rest() -> None:
    assert not _is_doubtful(-3.0, LOOP._replace(gamma=7.0))
    assert not _is_doubtful(-3.0, LOOP._replace(gamma=6.0, counted=0.0))
    assert not _is_doubtful(-3.0, LOOP._replace(gamma=6.0, kappa=0.0))


@pytest.mark.parametrize(("beta", "phi"), [(1.0, 0.0), (1.0, 5.0), (3.0, 0.0)])
def test_rest_beside_an_edge_is_doubtful_within_the_roundings(beta: float, phi: float) -> None:
    loop = LOOP._replace(beta=beta, phi=phi)
    bound = 8.0 * EPSILON * (2.0 * 4.0 + 6.0 + beta * 3.0 + phi) / beta
    for sign in (-1.0, 1.0):
        assert _is_doubtful(-3.0 + sign * 0.8 * bound, loop)
        assert not _is_doubtful(-3.0 + sign * 1.3 * bound, loop)
    assert not _is_doubtful(7.0, loop)  # outside the wall the nearest edge is the wall's


def test_chatter_is_rest_a_millionth_of_a_count_from_its_edge() -> None:
    """As it is where nothing else is asked for."""
    assert CHATTER == 1e-6
    one = knob(64, hand={"inertia": 3e-7, "damping": B})
    plain = events(one, angle_rad=0.02, velocity_rad_s=0.0, duration_s=0.5)
    asked = events(one, angle_rad=0.02, velocity_rad_s=0.0, duration_s=0.5, chatter_counts=1e-6)
    assert plain.rows.tolist() == asked.rows.tolist()


@pytest.mark.parametrize(
    ("push", "beta", "wall"), [(5.0, 0.0, 6.0), (7.0, 0.0, 7.0), (9.0, 0.0, 8.0), (10.0, 1.0, 7.0)]
)
def test_torque_of_the_wall_at_rest_on_an_edge(push: float, beta: float, wall: float) -> None:
    """What holds the push and a hand, between what the wall has on both sides; friction takes the rest."""
    one = knob(1024)._replace(loop=LOOP._replace(gamma=push, beta=beta, phi=3.0))
    motion = Motion(one, 1.0, np.array([[0.0, 3.0, -3.0, 0.0, 0.0, 0.0]]))
    assert motion.torque_nm == pytest.approx([wall * one.torque_nm])


@pytest.mark.parametrize(
    ("changes", "row", "wall"),
    [
        ({"counted": 0.0}, [0.0, 1.0, 0.0, -2.5, 1.0, -1.0], 5.0),
        ({"counted": 0.0}, [0.0, 0.0, 0.0, 2.5, 1.0, -1.0], 0.0),
        ({}, [0.0, 3.0, -3.0, 0.5, 1.0, 1.0], 6.0),
        ({}, [0.0, 3.0, -3.0, 0.0, 1.0, 1.0], 6.0),
        ({}, [0.0, 3.0, -3.0, 0.5, 0.0, 0.0], 6.0),
        ({}, [0.0, 0.0, 0.0, 0.5, 1.0, 1.0], 0.0),
        ({"kappa": 0.0}, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.0),
    ],
)
def test_torque_of_the_wall_just_after_an_event(changes: dict[str, float], row: list[float], wall: float) -> None:
    """Of a continuous sensor by the depth, else that of the level, wherever in it the knob is."""
    one = knob(1024)._replace(loop=LOOP._replace(**changes))
    assert Motion(one, 1.0, np.array([row])).torque_nm == pytest.approx([wall * one.torque_nm])


def test_a_motion_is_known_from_its_start_to_its_end() -> None:
    motion = events(knob(64), angle_rad=0.02, velocity_rad_s=0.0, duration_s=0.1)
    assert motion.at(np.array([0.0, 0.1]))[0][0] == pytest.approx(0.02)
    for time in (-1e-9, 0.1 + 1e-9):
        with pytest.raises(ValueError, match=r"between 0 and 0\.1 s"):
            motion.at(np.array([0.05, time]))


@pytest.mark.parametrize(("angle", "speed"), [(1e290, 0.0), (0.0, 1e290), (-1e290, 0.0)])
def test_a_motion_beyond_all_numbers_is_refused(angle: float, speed: float) -> None:
    with pytest.raises(ComputationError, match="overflow"):
        events(knob(64), angle_rad=angle, velocity_rad_s=speed, duration_s=1e10)


def test_without_damping_nothing_is_lost_to_it() -> None:
    """Whatever the roundings of the balance of energy leave."""
    one = knob(1024, knob={"inertia": 1.9e-6, "coulomb_torque": 1e-4}, hand={"inertia": 3e-7})
    said = found(one, 99, end=-2.5, path=30.0)
    assert said.damping_loss_j == 0.0
    assert said.friction_loss_j > 0.0


def test_rest_at_the_edge_of_the_wall_is_on_an_edge() -> None:
    """There, too, the torques on both sides decide."""
    loop = LOOP._replace(gamma=1.0)
    assert not _is_doubtful(0.0, loop)
    assert _is_doubtful(0.0, loop._replace(gamma=2.0))
    assert _is_doubtful(0.0, loop._replace(gamma=0.0))
    assert _reach(-4.0, 0.0, LOOP._replace(gamma=16.0, kappa=0.5)) == pytest.approx(32.0)
    assert _reach(-25.0, 0.0, LOOP._replace(gamma=4.0, kappa=0.25)) == pytest.approx(sqrt(800.0))


def test_a_position_that_is_as_far_as_a_double_tells_is_too_fine(monkeypatch: pytest.MonkeyPatch) -> None:
    for reach, reason in ((FINEST, Reason.TOO_FINE), (FINEST / 2.0, Reason.EVENT_LIMIT)):
        monkeypatch.setattr(unsampled, "_reach", lambda *_, reach=reach: reach)
        assert found(knob(1024), settling.OUT_OF_EVENTS).reason is reason


@pytest.mark.parametrize(
    ("rest", "numbers", "doubtful"),
    [
        # Drawn away from an edge by 4 units in the last place of the wall's torque, or by a lot.
        (0.0, {"kappa": 1.0, "gamma": 4.0 * EPSILON}, True),
        (0.0, {"kappa": 1.0, "gamma": 1e-3}, False),
        # By just the bound: 8 units of (1 + itself).
        (0.0, {"kappa": 1.0, "gamma": 8.0 * EPSILON * (1.0 + 8.0 * EPSILON)}, True),
        # Pushed up by 0.25, which is the friction; and by a little more or less.
        (-1.0, {"kappa": 1.0, "gamma": 0.75, "phi": 0.25}, True),
        (-1.0, {"kappa": 1.0, "gamma": 0.875, "phi": 0.25}, False),
        # Pushed down by 0.9 above it, and up by 0.1 below it, where friction helps.
        (-1.0, {"kappa": 1.0, "gamma": 1.9, "phi": 0.25}, False),
        (-1.0, {"kappa": 1.0, "gamma": 2.2, "phi": 0.25}, False),
        (-1.0, {"kappa": 1.0, "gamma": 2.4, "phi": 0.25}, True),
        # Pushed up below the edge by just the bound: 8 units of 2.
        (0.0, {"kappa": 1.0 + 8.0 * EPSILON, "gamma": 1.0 - 8.0 * EPSILON}, True),
        # Pushed out of the wall and held by a spring, as far from its edge as 12 units; the bound is 16.
        (12.0 * EPSILON, {"kappa": 1.0, "gamma": -1.0, "beta": 1.0}, True),
        # A count above the wall's edge there is no edge.
        (1.0, {"kappa": 1.0, "gamma": 0.5, "beta": 1.0}, False),
        # Below the wall's edge by just the bound, of a spring of 1, and by a bit more; of a wall of 2000 by 1.5 of it.
        (-8.0 * EPSILON * (1.0 + 16.0 * EPSILON), {"kappa": 1.0, "beta": 1.0}, True),
        (-8.0 * EPSILON * 1.001, {"kappa": 1.0, "beta": 1.0}, False),
        (-8.0 * EPSILON * 3000.0, {"kappa": 2000.0, "beta": 1.0}, False),
        (-8.0 * EPSILON * 1900.0, {"kappa": 2000.0, "beta": 1.0}, True),
    ],
)
def test_a_rest_on_an_edge_is_doubtful_where_roundings_decide(
    rest: float, numbers: dict[str, float], doubtful: bool
) -> None:
    assert _is_doubtful(rest, LOOP._replace(**{"gamma": 0.0, **numbers})) is doubtful


def test_a_knob_at_rest_beside_an_edge_is_held_by_its_own_count() -> None:
    """On it by what balances the push, within what the counts on both sides command."""
    one = knob(1024)._replace(loop=LOOP._replace(gamma=3.0))
    motion = Motion(one, 1.0, np.zeros((1, 6)))
    for edge, u, wall in ((-1.0, 0.0, 3.0), (-1.0, -0.25, 4.0), (-2.0, 0.0, 4.0), (0.0, 0.0, 2.0)):
        n = 2.0 if u else 0.0
        row = np.array([0.0, n, edge, u, 0.0, 0.0])
        assert motion._torque(row, edge + u) == pytest.approx(wall * one.torque_nm)
    free = Motion(one._replace(loop=LOOP._replace(kappa=0.0)), 1.0, np.zeros((1, 6)))
    assert free._torque(np.zeros(6), 0.0) == 0.0


def test_chatter_is_followed_where_friction_leaves_more_than_one_rest() -> None:
    """From just below the edge at -2 it is pushed up by 0.9, above it down by 0.1, with a friction of 0.5.

    It comes to the edge with v^2 = 0.8e-8, and stops 0.8e-8 / 1.2 beyond.
    """
    loop = LOOP._replace(kappa=1.0, gamma=2.1, phi=0.5)
    assert rest_range(loop) == (-2.0, -1.0)
    one = knob(1024)._replace(loop=loop, unit_rad=1.0, unit_s=1.0, shift=0.0)
    motion = events(one, angle_rad=-2.0 - 1e-8, velocity_rad_s=0.0, duration_s=10.0)
    assert len(motion.rows) == 3
    assert motion.rows[-1][2:4] == pytest.approx([-2.0, 0.8e-8 / 1.2], rel=1e-6)
    assert motion.rows[-1][5] == 0.0


def test_a_knob_that_stands_still_loses_nothing() -> None:
    """Whatever rest and start differ by."""
    said = found(knob(1024), settling.CAME_TO_REST, end=-2.5)
    assert (said.damping_loss_j, said.friction_loss_j) == (0.0, 0.0)
    damped = found(knob(1024, hand={"inertia": 3e-7, "damping": B}), settling.CAME_TO_REST, end=-2.5)
    assert damped.damping_loss_j > 0.0


def test_a_motion_may_have_as_many_events_as_are_allowed() -> None:
    """And none more, however many rows there is room for."""
    one = knob(64)
    for duration in (0.05, 2.0):
        motion = events(one, angle_rad=0.02, velocity_rad_s=0.0, duration_s=duration)
        met = len(motion.rows) - 1
        again = events(one, angle_rad=0.02, velocity_rad_s=0.0, duration_s=duration, max_events=met)
        assert again.rows.tolist() == motion.rows.tolist()
        with pytest.raises(ComputationError, match=f"more than {met - 1} events"):
            events(one, angle_rad=0.02, velocity_rad_s=0.0, duration_s=duration, max_events=met - 1)
    assert met > 256


def test_compiled_code_writes_the_events_down() -> None:
    """Where there is any."""

    def recorded(state: Any, ending: Any, loop: Any, rows: Any, filled: int, capacity: int) -> tuple[int, bool]:
        rows[6 * filled : 6 * filled + 6] = 9.0
        return filled + 1, True

    functions = {"unsampled.record_motion": recorded}
    found = events(knob(64), angle_rad=0.02, velocity_rad_s=0.0, duration_s=1.0, functions=functions)
    assert found.rows[1:].tolist() == [[9.0] * 6]


def test_the_energy_that_drifts_is_a_share_of_that_above_rest() -> None:
    """Pushed by 7 it rests three counts down, at 7 * -3 + 2 * (1 + 2 + 3) = -9."""
    one = knob(1024)._replace(loop=LOOP._replace(gamma=7.0))
    assert rest_range(one.loop) == (-3.0, -3.0)
    said = found(one, settling.BOUNCES_ON, moments=(4.0, -3.0, 2.0, 9.0), top=5.0, drift=0.75)
    start = 0.5 * one.speed(0.5) ** 2 + 7.0 * one.position(0.02)
    assert said.energy_drift == pytest.approx(0.75 / (start + 9.0), rel=1e-13)


def test_no_times_have_no_motion() -> None:
    motion = events(knob(64), angle_rad=0.02, velocity_rad_s=0.0, duration_s=0.1)
    assert [len(column) for column in motion.at(np.array([]))] == [0, 0, 0]
