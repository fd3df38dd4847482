"""Sliding and being held in many states, on its margins: which steps are taken, and how the end of a mode is bracketed.

Motions are written down: a state's first number is its time. What is bounded is told by hand, too.
"""

from collections.abc import Callable
from math import inf, nextafter, sqrt
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.general import slide_many as slides
from hknob_cli.engine.general.body import HALVES, HALVES_HELD
from hknob_cli.engine.general.slide_many import (
    FINEST,
    NIL,
    SHORTEST,
    accept,
    creep,
    crossed,
    held_bound,
    held_slope,
    slide_many,
    sliding_bound,
    stretch,
)
from tests.engine.general.test_body import FINGER, PLAIN

LAGGING = PLAIN._replace(order=3, lag=0.5, friction=2.0)


# What is bounded.


def test_a_state_is_stretched_by_a_matrix_over_its_rate() -> None:
    one: Any = SimpleNamespace(order=2, matrices=[9.0] * 4 + [1.0, 2.0, 3.0, 4.0])
    pad = [5.0, 6.0, 0.0, 0.0, 7.0]
    stretch([0.5, -0.5], pad, 1, one)
    assert pad == [5.0, 6.0, 0.5 + 17.0, -0.5 + 39.0, 7.0]
    z = [0.0, 0.0]
    accept(z, pad, 2)
    assert z == [17.5, 38.5]


def test_the_speed_bends_no_more_than_the_energy_of_rates_allows() -> None:
    """A root of 2.5 by the stiffness of 1; a lag of rate 3 counts in both, by 3 / (1/2) and 3."""
    assert sliding_bound([3.0, -2.0], 0, PLAIN) == 2.5
    assert sliding_bound([9.0, 3.0, -2.0], 1, PLAIN._replace(alpha=4.0)) == 2.5 * 4.5
    for late in (3.0, -3.0):
        assert sliding_bound([3.0, -2.0, late], 0, LAGGING) == 2.5 + 6.0 + 3.0
        assert sliding_bound([7.0, 3.0, -2.0, late], 1, LAGGING._replace(lag=4.0)) == 2.5 + 0.75 + 3.0


def test_a_held_knob_feels_what_lag_finger_and_winding_change() -> None:
    """The pad by 2 x 1/2 and -2 / 4, the winding by 4 x 3, the lag by its own rate."""
    rate = [9.0, 9.0, 0.5, -2.0, 3.0, -7.0]
    assert held_slope([9.0, 9.0], PLAIN) == 0.0
    for ratio in (4.0, 0.5):
        one = FINGER._replace(ratio=ratio)
        assert held_slope(rate, one) == 0.5 - 1.0
        assert held_slope(rate, one._replace(order=6, coil=4.0)) == 0.5 - 1.0 - 12.0
        assert held_slope(rate, one._replace(order=6, coil=4.0, lag=0.5)) == 0.5 - 1.0 - 12.0 - 7.0
    for lag, coil in ((0.5, 0.5), (4.0, 4.0)):
        assert held_slope([9.0, 9.0, -7.0], LAGGING._replace(lag=lag)) == -7.0
        assert held_slope([9.0, 9.0, 3.0], PLAIN._replace(order=3, coil=coil)) == -3.0 * coil


def test_the_torque_on_a_held_knob_bends_by_each_part() -> None:
    """A lag by its constant and rate. A winding by its spring as well. A finger by the energy of its rates."""
    for late in (3.0, -3.0):
        for lag in (0.5, 4.0):
            assert held_bound([9.0, 9.0, late], LAGGING._replace(lag=lag)) == 3.0 * lag
        for coil in (0.5, 4.0):
            wound = PLAIN._replace(order=3, coil=coil, coil_rate=0.25)
            assert held_bound([9.0, 9.0, late], wound) == 3.0 * 0.25 * coil
    assert held_bound([9.0, 9.0], PLAIN) == 0.0
    for ratio in (4.0, 0.25):
        one = FINGER._replace(ratio=ratio)
        root = sqrt(ratio)
        energy = sqrt(4.0 / ratio + (2.0 + 8.0 / ratio) * 0.25)
        jerk = root * (ratio * 0.25 + 0.125) + ratio * sqrt(2.0) + sqrt(8.0 * ratio)
        finger = energy * (0.25 * jerk + 2.0 * root)
        rate = [9.0, 9.0, 0.5, -2.0, 3.0, -7.0]
        assert held_bound(rate, one) == pytest.approx(finger, rel=1e-15)
        more = one._replace(order=6, coil=4.0, coil_rate=0.25, lag=0.5)
        assert held_bound(rate, more) == pytest.approx(finger + 3.0 + 3.5, rel=1e-15)


def test_the_end_of_a_mode_is_crossed_past_it() -> None:
    """A slide's once the speed has the other sign. Of a knob that is held once more than friction pulls, either way."""
    for mode, v, over in ((1, 0.5, False), (1, 0.0, False), (1, -0.5, True), (-1, 0.5, True), (-1, -0.5, False)):
        assert crossed([0.0, -v, 9.0, v], 0.0, mode, PLAIN) is over
    one = PLAIN._replace(friction=2.0, drive=-1.0, matrices=[7.0, 7.0, -0.5, 0.25])
    for x, u, over in ((0.0, 3.0, False), (0.0, 3.5, True), (0.0, -1.0, False), (0.0, -1.5, True)):
        assert crossed([99.0, 99.0, x, 0.0], u, 0, one) is over
    # -1 - 8 / 2 + 8 / 4 + u
    assert crossed([99.0, 99.0, 8.0, 8.0], 5.5, 0, one) is True
    assert crossed([99.0, 99.0, 8.0, 8.0], 5.0, 0, one) is False
    late = one._replace(order=3, lag=0.5, matrices=[7.0, 7.0, 7.0, -0.5, 0.25, 1.0])
    assert crossed([99.0] * 3 + [0.0, 0.0, 3.5], 0.0, 0, late) is True
    assert crossed([99.0] * 3 + [0.0, 0.0, 3.0], 99.0, 0, late) is False  # the command has not come yet


# A slide that begins with next to no acceleration.


@pytest.mark.parametrize("mode", [1, -1])
def test_a_slide_that_begins_slowly_takes_a_step_in_which_it_surely_grows(
    monkeypatch: pytest.MonkeyPatch, mode: int
) -> None:
    """Its second derivative is 4, by rates of rates. Where that changes by 32 a sample an eighth of one is told."""
    matrices = [0.0, 0.0, 0.0, 2.0 * mode, *[0.0] * 4]
    for bound, left, half in (
        (32.0, 1.0, 3),
        (nextafter(32.0, inf), 1.0, 4),
        (0.0, 1.0, 0),
        (0.0, 0.75, 1),
        (0.0, 0.125, 3),
        (32.0, 0.0625, 4),
        (inf, 1.0, SHORTEST),
        (4.0 * 2.0**20, 1.0, 20),
        (inf, 2.0**-21, -1),
        (0.0, 2.0**-20, 20),
    ):
        asked: list[Any] = []

        def bent(pad: Any, at: int, body: Any, bound: float = bound, asked: Any = asked) -> float:
            asked.append((at, list(pad[at : at + 2])))
            return bound

        def move(z: Any, pad: Any, matrix: int, body: Any) -> None:
            pad[2:4] = [z[0] + 0.5 ** (matrix - HALVES), pad[4]]

        monkeypatch.setattr(slides, "sliding_bound", bent)
        monkeypatch.setattr(slides, "stretch", move)
        one = PLAIN._replace(matrices=matrices)
        h = 0.5**half if half >= 0 else 0.0
        least = 0.3 * 4.0 * h * h
        for v, kept in ((2.0 * least, 2.0 * least), (0.5 * least, least), (-least, least), (0.0, least)):
            z = [0.0, 0.0]
            pad = [7.0, 2.0, 0.0, 0.0, v * mode]
            assert creep(z, mode, left, one, pad) == half
            assert z == ([h, kept * mode] if half >= 0 else [0.0, 0.0])
        assert asked[0] == (2, [0.0, 4.0 * mode])
    monkeypatch.setattr(slides, "sliding_bound", lambda *_: 4.0)
    one = PLAIN._replace(matrices=[0.0, 0.0, 0.0, 0.25 * mode, *[0.0] * 4])
    assert creep([0.0, 0.0], mode, 1.0, one, [7.0, 2.0, 0.0, 0.0, 0.0]) == 3  # a half, that changes by 4
    for bend in (0.0, -4.0):
        one = PLAIN._replace(matrices=[0.0, 0.0, 0.0, bend * mode, *[0.0] * 4])
        assert creep([0.0, 0.0], mode, 1.0, one, [7.0, 1.0, 0.0, 0.0]) == -1


# Steps.

Of = Callable[[float], float]


class Slide:
    """One mode over a motion that is written down: speed along the mode, or what friction has left, its rate and bound.

    Which steps were taken is noted, by the time that each reaches and its halvings.
    """

    def __init__(self, patch: pytest.MonkeyPatch, value: Of, slope: Of, bound: Of, **more: Any) -> None:
        """``end``: the last time before the mode is over; ``creeps``: what `creep` says, one after the other."""
        self.value, self.slope, self.bound, self.more = value, slope, bound, {"end": 9.0, "creeps": []} | more
        self.took: list[tuple[float, int]] = []
        self.crept = 0
        for name in ("rate_of", "stretch", "crossed", "creep", "sliding_bound", "held_bound", "held_slope"):
            patch.setattr(slides, name, getattr(self, name))
        patch.setattr(slides, "acceleration", self.acceleration)

    def rate_of(self, z: Any, u: float, mode: int, body: Any, out: Any) -> None:
        assert (u, mode) == (7.0, self.mode)
        self.now = z[0]
        out[0], out[1] = 1.0, mode * self.slope(z[0]) if mode else 99.0

    def sliding_bound(self, pad: Any, at: int, body: Any) -> float:
        assert (at, pad[0], self.mode != 0) == (0, 1.0, True)
        return self.bound(self.now)

    def held_bound(self, pad: Any, body: Any) -> float:
        assert (pad[0], self.mode) == (1.0, 0)
        return self.bound(self.now)

    def held_slope(self, pad: Any, body: Any) -> float:
        return self.slope(self.now)

    def acceleration(self, z: Any, u: float, body: Any) -> float:
        assert (u, z[0]) == (7.0, self.now)
        return float(self.more.get("sign", 1.0) * (body.friction - self.value(z[0])))

    def stretch(self, z: Any, pad: Any, matrix: int, body: Any) -> None:
        assert self.now == z[0]
        half = matrix - (HALVES if self.mode else HALVES_HELD)
        then = z[0] + 0.5**half
        pad[2:4] = [then, self.mode * max(self.value(then), 2.0**-60) if self.mode else 0.0]
        self.took.append((then, half))
        if len(self.took) == self.more.get("halts"):
            body.halt[0] = 0.5

    def crossed(self, pad: Any, u: float, mode: int, body: Any) -> bool:
        assert (u, mode) == (7.0, self.mode)
        return bool(pad[2] > self.more["end"])

    def creep(self, z: Any, mode: int, left: float, body: Any, pad: Any) -> int:
        self.crept += 1
        taken = self.more["creeps"].pop(0)
        if taken >= 0:
            z[0] += 0.5**taken
            z[1] = mode * self.value(z[0])
        return int(taken)

    def run(self, mode: int = 1, left: float = 1.0, halt: float = 0.0) -> tuple[float, bool]:
        self.mode, self.took = mode, []
        self.z = [0.0, mode * self.value(0.0)]
        one = PLAIN._replace(friction=2.0, halt=[halt])
        total, ended, _ = slide_many(self.z, 7.0, mode, left, one, [0.0] * 4)
        return total, ended


def always(value: float) -> Of:
    return lambda _: value


@pytest.mark.parametrize("mode", [1, -1, 0])
def test_a_step_is_taken_in_which_nothing_ends_or_all_is_monotone(monkeypatch: pytest.MonkeyPatch, mode: int) -> None:
    """1 - 1/4 h - 3/4 h^2 is used up at a sample, to the bit. A rate of 2 that changes by 2 does not keep its sign."""
    below, above = nextafter(1.5, 0.0), nextafter(2.0, 0.0)
    for slope, bound, first in (
        (-0.25, 1.5, 1),
        (-0.25, below, 0),
        (-2.0, 2.0, 1),  # over half a sample it is monotone
        (-2.0, above, 0),
        (-1.0, 0.5, 0),
        (0.0, 2.0, 1),
        (0.0, above, 0),
        (0.0, 0.0, 0),
        (-2.0, 16.0, 3),  # 1 - 1/4 - 1/8; 1 - 1/2 - 1/2
    ):
        for sign in (1.0, -1.0):
            slide = Slide(monkeypatch, always(1.0), always(slope), always(bound), sign=sign)
            assert slide.run(mode) == (1.0, False)
            assert slide.took[0] == (0.5**first, first)
    # In half a sample 1 - 3/4 - 3/32 is left, and 1 - 7/8.
    for slope, bound in ((-1.5, 0.75), (0.0, 7.0)):
        slide = Slide(monkeypatch, always(1.0), always(slope), always(bound), end=0.0, halts=1)
        assert slide.run(mode, 0.5) == (0.5, False)
        assert slide.took == [(0.5, 1)]
    # A speed that grows is safe by the bound alone; what friction has left is not safe by growing.
    slide = Slide(monkeypatch, always(1.0), always(1.0), always(1.5))
    assert slide.run(mode) == (1.0, False)
    assert slide.took[0] == ((0.5, 1) if mode == 0 else (1.0, 0))
    slide = Slide(monkeypatch, always(1.0), always(0.5), always(2.0))
    slide.run(mode)
    assert slide.took[0][1] == 1


def test_what_nothing_changes_goes_on_at_the_very_level_of_friction(monkeypatch: pytest.MonkeyPatch) -> None:
    slide = Slide(monkeypatch, always(0.0), always(0.0), always(0.0))
    assert slide.run(0) == (1.0, False)
    assert slide.took == [(1.0, 0)]
    for slope, bound in ((0.0, 1e-9), (1e-9, 1e-9)):
        slide = Slide(monkeypatch, always(0.0), always(slope), always(bound), halts=1)
        slide.run(0)
        assert slide.took[0][1] > 0 or slope > bound


def test_steps_grow_again_and_end_with_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twice as long each time, as long as that is told and there is time."""
    slide = Slide(monkeypatch, always(1.0), always(-0.25), lambda t: 24.0 if t < 0.25 else 0.0)
    assert slide.run() == (1.0, False)
    assert slide.took == [(0.25, 2), (0.75, 1), (1.0, 2)]
    slide = Slide(monkeypatch, always(1.0), always(-0.25), lambda t: 100.0 if t == 0.0 else 0.0)
    slide.run()
    assert slide.took == [(0.125, 3), (0.375, 2), (0.875, 1), (1.0, 3)]
    for left, took in (
        (0.75, [(0.5, 1), (0.75, 2)]),
        (0.625, [(0.5, 1), (0.625, 3)]),
        (2.0**-52 * 1.5, [(2.0**-52, 52)]),
        (2.0**-53, []),
        (0.0, []),
    ):
        slide = Slide(monkeypatch, always(1.0), always(0.0), always(0.0))
        assert slide.run(1, left) == (sum(0.5**half for _, half in took), False)
        assert slide.took == took
        assert slide.z[0] == (took[-1][0] if took else 0.0)
    assert FINEST == 2.0**52


@pytest.mark.parametrize("mode", [1, -1, 0])
def test_an_end_is_bracketed_to_the_last_bit(monkeypatch: pytest.MonkeyPatch, mode: int) -> None:
    """From before it; the speed is none then. Where the step is safe nothing ends in it, whatever rounding makes."""
    for end in (0.25, 0.3, 0.75, 1.0 - 2.0**-52):
        slide = Slide(monkeypatch, lambda t, end=end: 2.0 * (end - t), always(-2.0), always(0.0), end=end)
        total, ended = slide.run(mode)
        assert (total, ended) == (end // 2.0**-52 * 2.0**-52, True)
        assert slide.z == [total, 0.0]
        assert [half for _, half in slide.took] == list(range(53))
    slide = Slide(monkeypatch, always(1.0), always(0.0), always(0.0), end=0.0)
    assert slide.run(mode) == (1.0, False)
    # In a step of a quarter, after others.
    slide = Slide(monkeypatch, lambda t: 0.625 - t, always(-1.0), lambda t: 3.0 if t < 0.6 else 0.0, end=0.625)
    assert slide.run(mode) == (0.625, True)
    assert slide.took[0] == (0.25, 2)


def test_a_start_without_acceleration_creeps(monkeypatch: pytest.MonkeyPatch) -> None:
    """As long as it takes; what is nil counts by the friction level, 2."""

    def value(t: float) -> float:
        return t * t

    for slope, crept in ((0.0, 1), (2.0 * NIL, 1), (nextafter(2.0 * NIL, 1.0), 0), (-1.0, 1)):
        slide = Slide(monkeypatch, value, lambda t, slope=slope: slope if t == 0.0 else 9.0, always(1e-30), creeps=[2])
        for mode in (1, -1):
            slide.more["creeps"] = [2]
            slide.crept = 0
            assert slide.run(mode) == (1.0, False)
            assert slide.crept == crept
            assert slide.took == ([(0.5, 2), (1.0, 1)] if crept else [(1.0, 0)])
    slide = Slide(monkeypatch, value, always(0.0), always(0.0), creeps=[0])
    assert slide.run(1) == (1.0, False)
    assert (slide.crept, slide.took) == (1, [])
    slide = Slide(monkeypatch, always(0.0), always(0.0), always(0.0), creeps=[])
    slide.run(0)
    assert slide.crept == 0  # a knob that is held does not
    slide = Slide(monkeypatch, always(1.0), always(0.0), always(0.0), creeps=[])
    slide.run(1)
    assert slide.crept == 0


def test_a_start_that_cannot_be_told_is_a_millionth_of_a_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """In which it may end: then it stands after it. Later it is bracketed."""

    def rises(t: float) -> float:
        return 0.0 if t == 0.0 else 1.0

    def late(t: float) -> float:
        return 0.0 if t < 0.25 else 1.0

    slide = Slide(monkeypatch, rises, lambda t: 1.0 if t == 0.0 else 0.0, lambda t: 2.0**30 if t == 0.0 else 0.0)
    assert slide.run() == (1.0, False)
    assert slide.took[0] == (2.0**-20, 20)
    slide.more["end"] = 0.0
    assert slide.run() == (2.0**-20, True)
    assert (slide.z, slide.took) == ([2.0**-20, 0.0], [(2.0**-20, 20)])
    # Where it does not creep, for want of time or of a growing acceleration, it is taken so, too.
    slide = Slide(monkeypatch, rises, always(0.0), lambda t: 1.0 if t == 0.0 else 0.0, creeps=[-1], end=0.0)
    assert slide.run() == (2.0**-20, True)
    slide = Slide(monkeypatch, always(0.0), late, always(2.0**30), creeps=[2], end=0.0)
    assert slide.run() == (0.25 + 2.0**-20, True)
    slide = Slide(monkeypatch, always(2.0**-120), always(0.0), always(1.0), end=0.0)
    assert slide.run() == (0.0, True)
    assert slide.took == [(2.0**-52, 52)]


def test_a_halt_ends_the_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    slide = Slide(monkeypatch, always(1.0), always(-0.25), always(24.0), halts=2)
    assert slide.run() == (0.5, False)
    assert Slide(monkeypatch, always(1.0), always(0.0), always(0.0)).run(halt=0.5) == (0.0, False)
