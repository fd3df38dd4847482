"""Functions and numbers of the controllers by hand: what they say of their guards, their slopes and their roundings."""

from fractions import Fraction
from math import cos, exp, inf, log, pi
from random import Random
from typing import Any

import pytest

from hknob_cli.controllers import phase_damping
from hknob_cli.controllers.controller import ControlLaw, Plant, make_control_law
from hknob_cli.controllers.estimated_velocity import adaptive_velocity, filter_and_act, spring_and_damper
from hknob_cli.controllers.first_order_hold import LINE, FirstOrderHold
from hknob_cli.controllers.half_sample import half_sample
from hknob_cli.controllers.impulse_damping import ImpulseDamping, impulse_damping
from hknob_cli.controllers.matched_wall import MatchedWall, matched_gains, matched_wall
from hknob_cli.controllers.passivity_control import passivity
from hknob_cli.controllers.phase_damping import PhaseDamping
from hknob_cli.controllers.stiffening_wall import stiffening
from hknob_cli.specs.scene import SceneSpec

PLANT = Plant(alpha=0.1, beta=0.02, kappa=0.12, offset=0.25, period_s=1e-3, quantum_rad=0.01, stiffness=0.27)


def control_of(**numbers: Any) -> ControlLaw:
    """The controller of a scene."""
    scene = {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "controller": {"kind": "velocity_damping", "damping": 2.7e-4, **numbers},
    }
    plan = SceneSpec.model_validate(scene).plain().controller
    assert plan is not None
    return make_control_law(plan)


# An estimated speed.


def fixed_of(
    *, gain: float = -2.0, everywhere: float = 0.0, goes: float = 0.25, most: float = inf, filtered: float = 1.0
) -> list[float]:
    """Offset, gain, where it acts, low-pass, cut-off, whether the spring acts on what is filtered."""
    return [0.25, gain, everywhere, goes, most, filtered, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("shown", [-3.0, 2.0])
def test_where_damping_begins_is_a_guard_of_a_filtered_angle(shown: float) -> None:
    """At the wall's edge, on either side, if there is damping that acts inside alone; and never farther than others."""
    at = shown + 0.25 - 0.5
    for gain, everywhere, room in ((-2.0, 0.0, abs(at)), (-1.0, 0.0, abs(at)), (0.0, 0.0, 9.0), (-2.0, 1.0, 9.0)):
        out = [7.0]
        assert spring_and_damper(shown, 0.5, -0.5, 9.0, fixed_of(gain=gain, everywhere=everywhere), out) == room
        damped = everywhere > 0.0 or at < 0.0
        assert out == [max(-at, 0.0) + (gain * 0.5 if damped else 0.0)]
    assert spring_and_damper(shown, 0.5, -0.5, 0.125, fixed_of(), [7.0]) == 0.125
    assert spring_and_damper(shown, 0.5, -0.5, 9.0, fixed_of(filtered=0.0), [7.0]) == 9.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_cut_off_is_a_guard_from_both_sides(sign: float) -> None:
    """Beyond it nothing is commanded, which is told by the guard's sign."""
    for pace, guard, torque in ((1.0, 1.0, -2.0 * sign), (1.75, 0.25, -3.5 * sign), (3.0, -1.0, 0.0)):
        past, out = [sign * pace], [7.0]
        fixed = fixed_of(most=2.0, filtered=0.0, everywhere=2.0)
        assert filter_and_act(1.0, sign * pace, 0.0, past, 0, fixed, out) == guard
        assert out == [torque]


@pytest.mark.parametrize(("window", "row"), [(1, 0), (3, 2)])
def test_an_estimates_filter_is_slow_and_coarse_by_its_fade(window: int, row: int) -> None:
    """A time constant of -1 / log(fade) samples; each update rounds, and 1 / (1 - fade) of them are kept."""
    filtered = control_of(velocity="adaptive", window=window, low_pass=0.004)
    fade = exp(-0.25)
    fading = filtered.fading(PLANT)
    assert (fading.row, fading.fade) == (row, pytest.approx(fade, rel=1e-14))
    assert filtered.settling(PLANT) == pytest.approx(-1.0 / log(fade), rel=1e-12)
    assert filtered.settling(PLANT) == pytest.approx(4.0, rel=1e-12)
    assert filtered.coarseness(PLANT) == pytest.approx(1.0 + 1.0 / (1.0 - fade), rel=1e-12)
    strong = control_of(velocity="adaptive", window=window, low_pass=0.004, damping=-8.1e-4)
    assert strong.coarseness(PLANT) == pytest.approx(1.0 + 3.0 / (1.0 - fade), rel=1e-12)
    plain = control_of(velocity="adaptive", window=window, damping=8.1e-4)
    assert plain.settling(PLANT) == 0.0
    assert plain.coarseness(PLANT) == pytest.approx(4.0, rel=1e-12)


def test_a_tracked_speeds_first_row_fades_too() -> None:
    tracked = control_of(velocity="tracking", bandwidth=200.0, damping=8.1e-4)
    fading = tracked.fading(PLANT)
    assert (fading.row, fading.guarded) == (0, False)
    assert tracked.coarseness(PLANT) == pytest.approx(1.0 + 3.0 / (1.0 - fading.fade), rel=1e-12)
    assert tracked.settling(PLANT) == pytest.approx(-1.0 / log(fading.fade), rel=1e-12)


def test_what_fades_is_guarded_where_it_decides() -> None:
    """By a cut-off, and of an angle by where damping begins."""
    for guarded, more in (
        (True, {"angle": "filtered"}),
        (False, {"angle": "filtered", "damping": 0.0}),
        (False, {"angle": "filtered", "everywhere": True}),
        (True, {"angle": "filtered", "everywhere": True, "cut_off": 2.0}),
        (False, {}),
        (True, {"cut_off": 2.0}),
    ):
        control = control_of(**{"velocity": "tracking", "bandwidth": 200.0, **more})
        assert control.fading(PLANT).guarded is guarded


def test_a_differenced_speeds_filter_is_coarse_by_what_it_adds_up() -> None:
    fade = exp(-0.25)
    assert control_of(low_pass=0.004, damping=8.1e-4).coarseness(PLANT) == pytest.approx(1.0 + 3.0 / (1.0 - fade))
    assert control_of(damping=8.1e-4).coarseness(PLANT) == pytest.approx(4.0)


# Torques and slopes.


def test_the_slope_of_a_prediction_is_that_inside() -> None:
    """0.5 of the speed, and a fifth less for the yielding; its guard is the speed that brings it to the edge."""
    fixed = [0.25, 0.5, 0.75, 0.8, 1.0]
    for shown, speed in ((-4.0, 1.0), (-4.0, 9.0), (3.0, 1.0), (3.0, -9.0)):
        out, past = [7.0, 7.0], [0.0]
        middle = (0.75 * (shown + 0.25) + 0.5 * speed) * 0.8
        assert half_sample(shown, speed, past, fixed, out) == pytest.approx(abs(middle) / 0.4, rel=1e-14)
        assert out == [pytest.approx(max(-middle, 0.0)), pytest.approx(-0.4 if middle < 0.0 else 0.0)]
        assert past == [shown + 0.25]


def test_a_matched_wall_acts_inside_alone() -> None:
    for shown, inside in ((-3.0, True), (-1.0, True), (0.0, False), (0.5, False), (2.0, False)):
        out, past = [7.0, 7.0], [0.0]
        assert matched_wall(shown, 0.5, past, [0.25, 2.0, 0.125, 1.0], out) == inf
        assert out == ([-(2.0 * (shown + 0.25) + 0.0625), -0.125] if inside else [0.0, 0.0])


def test_an_impulse_and_the_rest_make_an_interval() -> None:
    for pulse, parts in ((0.25, (0.25, 0.75)), (1.0, (1.0,)), (0.9375, (0.9375, 0.0625))):
        one = ImpulseDamping(pulse, -0.5, 3)
        assert one.parts == parts
        assert one.coarseness(PLANT) == 1.0 + 0.5 * 3 / pulse
        assert ImpulseDamping(pulse, 0.5, 3).coarseness(PLANT) == one.coarseness(PLANT)


def test_energy_that_is_owed_is_taken_back_and_by_how_much_it_may_rise() -> None:
    """Owed 1 after a count: a damper of 1, at most 0.25; until nothing is owed nothing is done."""
    for energy, travel, most, torque, guard in (
        (-1.0, 1.0, 9.0, -1.0, 1.0 - 9.0),
        (-1.0, 2.0, 9.0, -0.5, 1.0 - 36.0),
        (-1.0, 2.0, 0.125, -0.25, 1.0 - 0.5),
        (0.0, 1.0, 9.0, 0.0, -9.0),
        (1.0, -2.0, 0.125, 0.0, -1.0 - 0.5),
    ):
        out, past = [7.0], [2.25 - travel, 0.0, energy, 7.0]
        assert passivity(2.0, 0.0, past, [0.25, most, 0.0], out) == guard
        assert out == [torque]
        assert past == [2.25, torque, energy, 0.0]
    out, past = [7.0], [2.25, 0.0, -1.0, 7.0]
    assert passivity(2.0, 0.0, past, [0.25, 9.0, 0.0], out) == inf
    assert out == [0.0]


# By phase.


def test_a_phase_is_timed_where_a_cycle_has_been_seen_however_short() -> None:
    """By samples since a crossing, each half a sample late; of one crossing a cycle, or of both."""
    for cycle in (0.75, 1.0, 8.0):
        for both in (0.0, 1.0):
            past = [0.0, 0.5, 0.0, cycle, cycle, 1e3, 1e3, 1.0]  # outside below its mean, and so it is now
            out = [7.0]
            phase_damping.phase_damping(1.0, 0.0, past, [0.25, 2.0, 9.0, both, 0.0], out)
            turn = 1.5 / cycle * (0.5 if both else 1.0)
            assert out == [pytest.approx(2.0 * cos(2.0 * pi * turn))]


def test_an_estimated_phase_is_as_coarse_as_its_updates() -> None:
    """Four units of its height; a plain time is a count of samples."""
    assert phase_damping.KALMAN == 4.0
    for kalman, coarse in ((True, 1.0 + 4.0 * 0.5), (False, 1.0)):
        assert PhaseDamping(0.5, 90.0, both=False, kalman=kalman).coarseness(PLANT) == coarse


def test_a_pace_that_is_not_filtered_has_no_guard() -> None:
    out = [7.0]
    assert filter_and_act(-3.0, 0.5, 0.0, [7.0], 0, fixed_of(goes=0.0, filtered=0.0), out) == inf
    assert out == [2.75 - 1.0]


def test_an_estimate_without_a_filter_remembers_readings_alone() -> None:
    assert control_of(velocity="adaptive", window=3).rows == 2
    assert control_of(velocity="adaptive", window=3, low_pass=0.004).rows == 2 + 1
    assert control_of(velocity="adaptive", window=3, low_pass=0.004, angle="filtered").rows == 2 + 2


def test_a_hold_of_one_step_without_looks_has_no_line_to_weigh() -> None:
    for detections, steps, coarse in ((1, 1, 1.0), (2, 1, LINE), (1, 2, LINE)):
        assert FirstOrderHold(correct=True, detections=detections, steps=steps).coarseness(PLANT) == coarse
    assert LINE > 1.0


def test_a_matched_wall_is_as_coarse_as_both_gains() -> None:
    place, pace = matched_gains(PLANT)
    assert MatchedWall(sensor=False).coarseness(PLANT) == pytest.approx(1.0 + abs(place) + abs(pace), rel=1e-15)
    assert min(abs(place), abs(pace)) > 0.0


def test_a_phase_is_guarded_by_where_its_mean_is_crossed() -> None:
    """By this sample's distance and the last one's, the nearer."""
    for shown, last, mean in ((-1.0, 0.0, 0.5), (-1.0, 0.25, 0.3), (3.0, 0.0, 64.0)):
        past, out = [last, mean, 0.0, 8.0, 8.0, 1e3, 1e3, 1.0], [7.0]
        now = max(-(shown + 0.25), 0.0) if shown < 0.0 else 0.0
        then = mean + (now - mean) / 64.0
        wanted = min(abs(now - then), abs(last - mean))
        assert phase_damping.phase_damping(shown, 0.0, past, [0.25, 2.0, 9.0, 0.0, 0.0], out) == pytest.approx(wanted)


def test_a_stiffening_wall_is_at_most_as_stiff_as_asked_for() -> None:
    """Half of it at the surface, all from four counts on."""
    for shown, torque in ((0.5, 0.0), (-2.0, 2.0 * 0.75), (-4.0, 4.0), (-8.0, 8.0)):
        out = [7.0]
        assert stiffening(shown, 0.0, [], [0.0, 0.25, 0.5], out) == inf
        assert out == [torque]


def longest_line(moves: list[int]) -> Fraction:
    """Slope of the longest line, from the newest reading back, that passes none of these by more than a count."""
    best = Fraction(moves[0])
    for n in range(2, len(moves) + 1):
        slope = Fraction(sum(moves[:n]), n)
        if any(abs(sum(moves[:k]) - k * slope) > 1 for k in range(1, n)):
            break
        best = slope
    return best


def test_the_longest_line_is_within_a_count_of_all_that_it_passes() -> None:
    """Exactly: each reading is a count, and each slope a fraction. Without a wall the damper acts alone."""
    chance = Random(7)
    fixed = [0.0, 1.0, 2.0, 0.0, inf, 0.0, 7.0, 8.0]
    for _ in range(3000):
        moves = [chance.choice([-1, 0, 0, 1, 1, 2, 3]) for _ in range(8)]
        past, out = [*map(float, moves[1:]), 5.0], [7.0]
        adaptive_velocity(5.0 + moves[0], 0.0, past, fixed, out)
        assert out[0] == pytest.approx(float(longest_line(moves)), rel=1e-15)
        assert past[:7] == list(map(float, moves[:7]))


def test_without_a_wall_there_is_no_spring() -> None:
    for everywhere, deep in ((0.0, 2.75), (1.0, 2.75), (2.0, 0.0)):
        out = [7.0]
        spring_and_damper(-3.0, 0.5, 0.0, inf, fixed_of(filtered=0.0, everywhere=everywhere), out)
        assert out == [deep - 1.0]


def test_an_impulse_of_a_whole_interval_leaves_no_rest() -> None:
    """It gives back half of what the last count changed, over the whole of it: there is no other torque."""
    past, out = [0.75, 0.0], [7.0]
    assert impulse_damping(-3.0, 0.0, past, [0.25, 1.0, 0.5, 0.0], out) == inf
    assert (past[0], out) == (2.75, [2.75 + 0.5 * 0.5 * 2.0])
    out = [7.0, 7.0]
    impulse_damping(-3.0, 0.0, [0.75, 0.0], [0.25, 0.5, 0.5, 0.0], out)
    assert out == [2.75 + 0.5 * 0.5 * 2.0 / 0.5, 2.75]
