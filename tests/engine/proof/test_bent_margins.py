"""What a torque that bends adds to a proof by tangents, on its margins: against matrices written out in numpy.

A sine of torque along the angle, without counts. The map of a sample is made of a matrix exponential and the slope of
the sine; what is off the tangent is at most the bend times the square of the difference.
"""

from math import cos, inf, nextafter, sin
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.general.orbit_proof import (
    TAIL,
    answer_to_torque,
    holds_though_bent,
    push_on,
    run_bent,
    sum_over_periods,
    turn_bound,
)
from hknob_cli.engine.general.powers import GONE
from hknob_cli.engine.general.search import as_list, make_space
from hknob_cli.scene.general_knob import GeneralKnob
from tests.engine.general.bodies import knob

DETENTS, CENTRE = 21, 0.03  # in a turn; rad
PERIOD = 3


def sined(delay: float = 0.0, **more: Any) -> GeneralKnob:
    parts: dict[str, Any] = {
        "knob": {"inertia": 1.9e-6},
        "encoder": "none",
        "wall": {"stiffness": 0.0},
        "detents": {"per_revolution": DETENTS, "torque": 4e-3, "centre": CENTRE},
        **more,
    }
    if delay:
        parts["actuator"] = {"delay_samples": delay, **parts.get("actuator", {})}
    return knob(counts=None, **parts)


def delayed(line: tuple[float, ...], **more: Any) -> GeneralKnob:
    """So that so many commands are under way: a line of one is that of less than a sample of delay."""
    return sined([0.0, 0.25, 1.0, 2.0][len(line)], **more)


class Motion(NamedTuple):
    """An orbit's samples, the maps from each to the next, the answers to a torque of 1, and the bend."""

    x: list[float]
    maps: list[Any]
    answers: list[Any]
    bend: float
    most: float  # torque
    wave: float
    centre: float

    def torque(self, x: float) -> float:
        return -self.most * sin(self.wave * (x - self.centre))


def worked_out(one: GeneralKnob, start: tuple[float, float], line: tuple[float, ...]) -> Motion:
    """Of state, commands under way from the oldest on, and the reading before."""
    body, most = one.body, 4e-3 / one.torque_nm
    wave, centre = DETENTS * one.quantum_rad, CENTRE / one.quantum_rad
    rates = np.array([[0.0, 1.0, 0.0], [-body.beta, -body.alpha, 1.0], [0.0, 0.0, 0.0]])
    delay, width = len(line), 3 + len(line)
    early, late = expm(rates * one.wall.split), expm(rates * (1.0 - one.wall.split))
    z, under_way = np.array(start), list(line)
    xs, maps, answers = [], [], []
    for k in range(PERIOD):
        x = float(z[0])
        xs.append(x)
        u, slope = -most * sin(wave * (x - centre)), -most * wave * cos(wave * (x - centre))
        step, answer = np.zeros((width, width)), np.zeros(width)
        step[:2, :2] = late[:2, :2] @ early[:2, :2]
        first, then = late[:2, :2] @ early[:2, 2], late[:2, 2]  # by what acts up to the split, and from there on
        step[-1, 0] = 1.0  # the reading before
        older = acting = u
        if delay:
            at = k % delay  # of the oldest, in whose place the newest comes
            where = (at + 1) % delay
            older, under_way[at] = under_way[at], u
            acting = under_way[where]
            for j in range(delay):
                step[2 + j, 2 + j] = 1.0
            step[2 + at] = 0.0
            step[2 + at, 0] = slope
            step[:2, 2 + at] += first
            if delay > 1:
                step[:2, 2 + where] += then
            answer[2 + at] = 1.0
        if delay < 2:
            step[:2, 0] += then * slope
            answer[:2] = np.abs(then)
        maps.append(step)
        answers.append(answer)
        z = late[:2, :2] @ (early[:2, :2] @ z + early[:2, 2] * (older + body.drive))
        z = z + then * (acting + body.drive)
    return Motion(xs, maps, answers, most * wave * wave, most, wave, centre)


def space_of(one: GeneralKnob, start: tuple[float, float], line: tuple[float, ...], trail: list[float]) -> Any:
    space = make_space(2, len(line), lambda count: [0.0] * count)
    for values, wanted in ((space.orbit, start), (space.orbit_line, line), (space.trail, trail)):
        for i, value in enumerate(wanted):
            values[i] = value
    for i in range(3):
        space.marks[i] = inf
    return space


START, TRAIL = (40.0, 2.0), [0.02, 0.03, 0.01]
LINES: list[tuple[float, ...]] = [(), (0.3,), (0.03, -0.02), (0.01, 0.05, -0.04)]


def bounded(motion: Motion, begun: Any, trail: list[float]) -> tuple[Any, Any, list[float], list[float]]:
    """What bends may have added by the end, what is new of it, and at each sample what was added and how far it is."""
    whole, new = np.array(begun, dtype=float), np.zeros(len(begun))
    added, far = [], []
    for k in range(PERIOD):
        added.append(float(whole[0]))
        far.append(trail[k] + added[-1])
        off = motion.bend * far[-1] ** 2 * motion.answers[k]
        whole, new = (np.abs(motion.maps[k]) @ one + off for one in (whole, new))
    return whole, new, added, far


@pytest.mark.parametrize("line", LINES)
def test_a_run_takes_bounds_along(line: tuple[float, ...]) -> None:
    """By the absolute maps of its samples; what is new is turned back to where the delay line began."""
    one = delayed(line)
    width = 3 + len(line)
    begun = [0.001 * (i + 1) for i in range(width)]
    space = space_of(one, START, line, TRAIL)
    space.matrix[:width] = begun
    kept, most = run_bent(START[0], 0, PERIOD, one.body, as_list(one.wall), space)
    motion = worked_out(one, START, line)
    whole, new, added, _ = bounded(motion, begun, TRAIL)
    assert most == pytest.approx(max(added), rel=1e-12)
    assert kept == all(a <= b for a, b in zip(added, TRAIL, strict=True))
    assert space.matrix[:width] == begun
    assert space.matrix[width : 2 * width] == pytest.approx(whole, rel=1e-9)
    if line:  # the head is elsewhere after the period
        head = PERIOD % len(line)
        new[2:-1] = [new[2 + (head + j) % len(line)] for j in range(len(line))]
    assert space.matrix[2 * width : 3 * width] == pytest.approx(new, rel=1e-9)
    assert new.max() > 1e-4 * max(begun)


def test_it_is_kept_while_no_more_is_added_than_by_the_tangents() -> None:
    one = sined()
    begun = [0.01, 0.0, 0.0]
    _, _, added, _ = bounded(worked_out(one, START, ()), begun, [1.0, 1.0, 1.0])
    for k in range(PERIOD):
        for trail_k, wanted in ((1.001, True), (0.999, False)):
            trail = [1.0, 1.0, 1.0]
            trail[k] = trail_k * added[k]
            if k:  # what is added later goes by how far an earlier sample is off
                trail[k] = trail_k * bounded(worked_out(one, START, ()), begun, trail)[2][k]
            space = space_of(one, START, (), trail)
            space.matrix[:3] = begun
            assert run_bent(START[0], 0, PERIOD, one.body, as_list(one.wall), space)[0] == wanted, k
    largest_first = space_of(one, START, (), [1e-3] * 3)
    largest_first.matrix[:3] = [0.5, 0.0, 0.0]
    assert run_bent(START[0], 0, PERIOD, one.body, as_list(one.wall), largest_first) == (False, 0.5)
    exact = space_of(one, START, (), [0.01, 1.0, 1.0])
    exact.matrix[:3] = begun
    assert run_bent(START[0], 0, PERIOD, one.body, as_list(one.wall), exact)[0]


@pytest.mark.parametrize("k", range(PERIOD))
def test_it_is_kept_while_no_sample_comes_to_the_end_of_its_room(k: int) -> None:
    """The room of a torque that is limited; of a reading, and of the one before."""
    motion = worked_out(sined(), START, ())
    torques = [abs(motion.torque(x)) for x in motion.x]
    limit = max(torques) * 1.05
    one = sined(actuator={"torque_limit": limit * sined().torque_nm})
    gaps = [(limit - u) / (motion.most * motion.wave) for u in torques]
    for part, wanted in ((0.999, True), (1.001, False)):
        trail = [0.05 * min(gaps)] * PERIOD
        _, _, added, _ = bounded(motion, [0.0] * 3, trail)
        room = min(gaps[k], gaps[k + 1]) if k + 1 < PERIOD else gaps[k]
        trail[k] = part * room - added[k]
        space = space_of(one, START, (), trail)
        found = run_bent(START[0], 0, PERIOD, one.body, as_list(one.wall), space)[0]
        _, _, added, far = bounded(motion, [0.0] * 3, trail)
        fits = all(max(far[i], far[i - 1] if i else 0.0) < gaps[i] for i in range(PERIOD))
        assert found == (wanted and fits and all(a <= b for a, b in zip(added, trail, strict=True)))
        assert fits == wanted or k < PERIOD - 1


def test_what_is_at_the_end_of_its_room_is_not_kept() -> None:
    one = sined(wall={"stiffness": 0.2})  # its edge, at 0
    for away, wanted in ((9.0, False), (nextafter(9.0, 0.0), True)):
        space = space_of(one, (9.0, 0.0), (), [away])
        assert run_bent(9.0, 0, 1, one.body, as_list(one.wall), space)[0] == wanted


@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("stiffness", [0.04, 40.0])
def test_the_answer_to_a_torque(line: tuple[float, ...], stiffness: float) -> None:
    """Of the body in what is left of a sample; with a delay it waits in the line, at the head. It is a size."""
    hand = {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": stiffness}
    one = delayed(line, hand=hand)
    space = space_of(one, START, line, TRAIL)
    space.state[:], space.line[:] = START, line
    at, head = space.width, len(line) - 1 if line else 0
    answer_to_torque(START[0], head, one.body, as_list(one.wall), space, at)
    wanted = list(worked_out(one, START, line).answers[0])
    if line:
        wanted[2:-1] = [float(j == head) for j in range(len(line))]
    assert space.matrix[at : at + space.width] == pytest.approx(wanted, rel=1e-9)
    assert list(space.state) == list(START)
    assert list(space.line) == list(line)


def test_a_bound_goes_by_the_size_of_each_entry() -> None:
    space = space_of(sined(), START, (), TRAIL)
    space.cols[:9] = [1.0, -2.0, 3.0, -4.0, 5.0, -6.0, 0.5, 0.25, -1.0]  # column by column
    space.matrix[3:6] = [1.0, 10.0, 100.0]
    push_on(space, 3, 3)
    assert space.matrix[3:6] == [1.0 + 40.0 + 50.0, 2.0 + 50.0 + 25.0, 3.0 + 60.0 + 100.0]


def test_a_delay_line_is_turned_back() -> None:
    space = space_of(sined(3.0), START, (0.0, 0.0, 0.0), TRAIL)
    space.matrix[6:12] = [1.0, 2.0, 10.0, 11.0, 12.0, 3.0]
    turn_bound(space, 6, 3, 1, 0)  # oldest at 0: it was at 1
    assert space.matrix[6:12] == [1.0, 2.0, 12.0, 10.0, 11.0, 3.0]


def test_the_sum_over_periods_has_a_tail() -> None:
    """Entries in the units of a norm: 1 of a position, the scale of a speed."""
    space = space_of(sined(), START, (), TRAIL)
    space.total[:9] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0]  # row by row
    space.matrix[6:9] = [0.5, 0.75, 0.25]
    for scale, largest in ((0.25, 3.0), (8.0, 0.5)):
        sum_over_periods(space, scale, 3)
        parts = [
            new + TAIL * GONE * largest * unit for new, unit in zip([0.5, 0.75, 0.25], [1.0, scale, 1.0], strict=True)
        ]
        wanted = np.array(space.total[:9]).reshape(3, 3) @ parts
        assert space.matrix[3:6] == pytest.approx(wanted, rel=1e-12)
    assert TAIL * (1.0 - GONE) > 1.0


SCALE = 0.5
TOTAL = np.array([[1.5, 0.3, 0.0], [0.4, 1.2, 0.0], [1.0, 0.2, 1.0]])


def summed(new: Any) -> Any:
    unit = np.array([1.0, SCALE, 1.0])
    return TOTAL @ (new + TAIL * GONE * (new / unit).max() * unit)


def held(away: list[float], trail: list[float], shape: str = "sine") -> tuple[bool, float]:
    return tried(away, trail, shape)[0]


def tried(away: list[float], trail: list[float], shape: str = "sine") -> tuple[tuple[bool, float], list[float]]:
    """The verdict, and what bends may add."""
    one = sined(detents={"per_revolution": DETENTS, "torque": 4e-3, "centre": CENTRE, "shape": shape})
    space = space_of(one, START, (), trail)
    space.total[:9] = TOTAL.ravel().tolist()
    space.away[:3] = away
    return holds_though_bent(START[0], 0, PERIOD, one.body, as_list(one.wall), space, SCALE), space.matrix[:3]


def test_what_bends_add_may_be_as_much_as_the_tangents_do() -> None:
    _, first = tried([inf] * 3, TRAIL)
    assert held(first, TRAIL)[0]
    assert held([0.0] * 3, TRAIL, "triangle") == (True, 0.0)


def test_a_proof_holds_with_twice_what_bends_add_at_first() -> None:
    """If that is added again it is no more, and no more than the differences by the tangents."""
    motion = worked_out(sined(), START, ())
    first = 2.0 * summed(bounded(motion, [0.0] * 3, TRAIL)[1])
    _, new, added, _ = bounded(motion, first, TRAIL)
    assert np.all(summed(new) < first)
    assert all(a < b for a, b in zip(added, TRAIL, strict=True))
    holds, most = held([1.001 * one for one in first], TRAIL)
    assert holds
    assert most == pytest.approx(max(added), rel=1e-9)
    for i in range(3):
        less = [0.999 * one if j == i else 1.001 * one for j, one in enumerate(first)]
        assert held(less, TRAIL) == (False, pytest.approx(max(added), rel=1e-9))


def test_a_proof_fails_where_differences_are_large() -> None:
    """So large that bends come to as much again; the bound is told."""
    motion = worked_out(sined(), START, ())
    kept, failed = 0, 0
    for size in np.geomspace(0.5, 100.0, 40):
        trail = [float(size) * one for one in (2.0, 3.0, 2.5)]
        first = 2.0 * summed(bounded(motion, [0.0] * 3, trail)[1])
        _, new, added, _ = bounded(motion, first, trail)
        inside = all(a <= b for a, b in zip(added, trail, strict=True))
        wanted = bool(inside and np.all(summed(new) <= first))
        holds, most = held([inf] * 3, trail)
        assert (holds, most) == (wanted, pytest.approx(max(added), rel=1e-9))
        kept += wanted
        failed += inside and not wanted
    assert 0 < kept < 40
