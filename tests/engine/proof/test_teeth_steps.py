"""Steps of a mode of teeth with play, over a motion that is written down, and the bounds by which they are told.

A state's first number is its time.
"""

from math import inf
from random import Random
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.general import teeth_ends
from hknob_cli.engine.general.body import HALVES, HALVES_HELD, HALVINGS, STUCK_HALVES
from hknob_cli.engine.general.cogging import TURNED
from hknob_cli.engine.general.teeth import SPRUNG
from hknob_cli.engine.general.teeth_ends import Bounds, Mode, press
from tests.engine.general.gears import Gear
from tests.engine.general.test_flanks import BODIES, body_of

from .test_teeth_modes import HAND, SLOW


class Course:
    """What is told, and what has ended, by time; how each step was taken is noted."""

    def __init__(self, patch: pytest.MonkeyPatch, **more: Any) -> None:
        """``told``: longest step that is told, from a time on; ``turned``, ``sprung``: last time before these ends."""
        self.more = {"told": [(0.0, 9.0)], "turned": 9.0, "sprung": 9.0, "torques": []} | more
        self.asked: list[float] = []  # lengths of steps
        self.took: list[tuple[float, int]] = []  # times that are reached, and which matrix has done it
        self.bounds: list[Bounds] = []
        self.rates = 0
        for name in ("told", "over_now", "stretch", "least_torque", "teeth_rate"):
            patch.setattr(teeth_ends, name, getattr(self, name))

    def teeth_rate(self, z: Any, u: float, side: int, toward: int, body: Any, out: Any, slope: float) -> None:
        assert (u, side, toward, slope) == (7.0, *self.mode)
        self.rates += 1
        out[: body.order] = self.more.get("rates", [0.0] * body.order)

    def told(self, z: Any, u: float, pad: Any, mode: Mode, h: float, bounds: Bounds, body: Any) -> bool:
        assert (u, mode) == (7.0, self.mode)
        self.asked.append(h)
        self.bounds.append(bounds)
        return h <= next(most for time, most in reversed(self.more["told"]) if z[0] >= time)

    def stretch(self, z: Any, pad: Any, matrix: int, body: Any) -> None:
        assert self.rates > len(self.took)  # the rate is that of where the step begins
        pad[body.order :] = [z[0] + 0.5 ** (matrix - self.table), *z[1:]]
        self.took.append((pad[body.order], matrix))
        if len(self.took) == self.more.get("halts"):
            body.halt[0] = 0.5

    def over_now(self, pad: Any, u: float, side: int, toward: int, body: Any, slope: float) -> int:
        assert (u, side, toward, slope) == (7.0, *self.mode)
        if pad[body.order] > self.more["turned"]:
            return TURNED
        return SPRUNG if pad[body.order] > self.more["sprung"] else 0

    def least_torque(self, z: Any, pad: Any, side: int, h: float, twist: float, body: Any) -> float:
        assert (h, twist) == (self.asked[-1], self.bounds[-1][1])
        return float(self.more["torques"].pop(0)) if self.more["torques"] else 4.0

    def run(
        self, span: float = 1.0, mode: tuple[int, int] = (1, 1), table: int = HALVES, one: Any = HAND, **more: Any
    ) -> Any:
        self.mode, self.table = Mode(*mode, more.get("slope", 0.0)), table
        self.z = [0.0, *[9.0] * (one.order - 1)]
        one = one._replace(halt=[more.get("halt", 0.0)])
        return press(self.z, 7.0, self.mode, span, more.get("fresh", False), one, [0.0] * (2 * one.order))


def test_a_mode_is_gone_through_in_steps_that_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """As long as there is time; after one that is, twice as long is tried."""
    for span, most, asked, ends in (
        (1.0, 9.0, [1.0], [1.0]),
        (0.75, 9.0, [0.5, 0.25], [0.5, 0.75]),
        (1.0, 0.25, [1.0, 0.5, 0.25, 0.5, 0.25, 0.5, 0.25, 0.25], [0.25, 0.5, 0.75, 1.0]),
        (0.625, 0.5, [0.5, 0.125], [0.5, 0.625]),
        (1.0 - 2.0**-53, 2.0**-1, [0.5, *(0.5**k for k in range(2, 53))], None),
        (0.0, 9.0, [], []),
    ):
        course = Course(monkeypatch, told=[(0.0, most)])
        total = sum(asked[-1:] and [span // 2.0**-52 * 2.0**-52])
        assert course.run(span) == (total, 0, 4.0 if asked else inf)
        assert course.asked == asked
        assert course.z == [total, 9.0, 9.0, 9.0]
        if ends is not None:
            assert [time for time, _ in course.took] == ends


def test_each_mode_has_its_own_matrices(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of teeth that press, or that are apart; of a motor that friction holds, likewise."""
    rubs = HAND._replace(friction=0.5)
    for one, mode, table in (
        *((one, (side, way), HALVES) for one in (HAND, rubs) for side in (1, -1) for way in (1, -1)),
        *((one, (0, way), HALVES_HELD) for one in (HAND, rubs) for way in (1, -1)),
        *((HAND, (side, 0), HALVES_HELD if side == 0 else HALVES) for side in (1, 0, -1)),
        *((rubs, (side, 0), STUCK_HALVES + (HALVINGS if side == 0 else 0)) for side in (1, 0, -1)),
    ):
        course = Course(monkeypatch)
        assert course.run(0.75, mode, table, one) == (0.75, 0, inf if mode[0] == 0 else 4.0)
        assert [matrix - table for _, matrix in course.took] == [1, 2]


@pytest.mark.parametrize("mode", [(1, 1), (0, 1)])
@pytest.mark.parametrize("fresh", [False, True])
def test_an_end_is_left_past_it_by_the_last_bit(
    monkeypatch: pytest.MonkeyPatch, mode: tuple[int, int], *, fresh: bool
) -> None:
    for last in (0.0, 0.25, 0.3, 0.75, 1.0 - 2.0**-52):
        for end in ("turned", "sprung"):
            course = Course(monkeypatch, **{end: last})
            total, ended, least = course.run(1.0, mode, HALVES_HELD if mode[0] == 0 else HALVES, fresh=fresh)
            assert total == course.z[0] == last // 2.0**-52 * 2.0**-52 + 2.0**-52
            assert ended == (TURNED if end == "turned" else SPRUNG)
            assert least == (-1.0 if ended == SPRUNG else inf if mode[0] == 0 else 4.0)
            assert course.rates == 1 + 52 + 1  # each part of the step has its own rate
    # It may be another that comes first.
    course = Course(monkeypatch, turned=0.75, sprung=0.25)
    assert course.run() == (0.25 + 2.0**-52, SPRUNG, -1.0)
    course = Course(monkeypatch, turned=0.25, sprung=0.75)
    assert course.run() == (0.25 + 2.0**-52, TURNED, 4.0)
    # In a second step, of which a quarter was told.
    course = Course(monkeypatch, turned=0.3125, told=[(0.0, 0.25)])
    assert course.run()[:2] == (0.3125 + 2.0**-52, TURNED)
    assert course.asked == [1.0, 0.5, 0.25, 0.5, 0.25]


def test_what_is_never_told_is_taken_in_the_smallest_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the begin of a fresh mode 2^-20 of a sample, whatever ends in it; after that the last bit."""
    halvings = [0.5**k for k in range(21)]
    course = Course(monkeypatch, told=[(0.0, 0.0), (2.0**-20, 9.0)])
    assert course.run(1.0, fresh=True) == (1.0, 0, 4.0)
    assert course.asked[:22] == [*halvings, 2.0**-19]
    for end, least in (("turned", 3.0), ("sprung", -1.0)):
        course = Course(monkeypatch, **{end: 0.0}, told=[(0.0, 0.0)], torques=[3.0])
        assert course.run(1.0, fresh=True) == (2.0**-20, TURNED if end == "turned" else SPRUNG, least)
        assert course.took == [(2.0**-20, HALVES + 20)]
        assert course.z[0] == 2.0**-20
        course = Course(monkeypatch, **{end: 0.0}, told=[(0.0, 0.0)], torques=[3.0])
        assert course.run(1.0) == (2.0**-52, TURNED if end == "turned" else SPRUNG, least)
        assert course.asked == [0.5**k for k in range(53)]
        # One that is told at once is bracketed, though fresh.
        course = Course(monkeypatch, **{end: 0.0}, told=[(0.0, 2.0**-19)], torques=[3.0])
        assert course.run(1.0, fresh=True)[0] == 2.0**-52
    # Only the first step is fresh.
    course = Course(monkeypatch, told=[(0.0, 0.5), (0.5, 0.0)], turned=0.5)
    assert course.run(1.0, fresh=True) == (0.5 + 2.0**-52, TURNED, 4.0)


def test_the_least_torque_is_that_of_all_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last, too, which is not gone through to its end."""
    for torques, turned, least in (
        ([3.0, 2.0, 5.0, 6.0], 9.0, 2.0),
        ([3.0, 2.0, 1.0, 6.0], 0.6, 1.0),
        ([0.5, 2.0, 1.0, 6.0], 0.6, 0.5),
        ([3.0, 2.0, 5.0, 1.0], 9.0, 1.0),
    ):
        course = Course(monkeypatch, told=[(0.0, 0.25)], torques=list(torques), turned=turned)
        assert course.run()[2] == least
    course = Course(monkeypatch, told=[(0.0, 0.25)], torques=[1.0] * 4)
    assert course.run(1.0, (0, 1), HALVES_HELD)[2] == inf  # between the flanks there is none


def test_a_halt_ends_the_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    course = Course(monkeypatch, told=[(0.0, 0.25)], halts=2)
    assert course.run()[:2] == (0.5, 0)
    assert Course(monkeypatch).run(halt=0.5) == (0.0, 0, inf)


RATES_NOW = [0.5, 1.0, 0.25, -2.0]


@pytest.mark.parametrize("side", [1, 0, -1])
def test_what_changes_is_bounded_by_the_energy_of_the_rates(monkeypatch: pytest.MonkeyPatch, side: int) -> None:
    """By hand: a finger of a quarter of the motor's inertia, whose rate is 1 + 2, off by 1/4; springs of 4 and 16.

    Energy 1 + 4 / 16 + (9 + 16 / 16) / 4 = 3.75. The mesh's angle goes by the rates of motor and finger, whose energy
    is a quarter; the finger is moved by the mesh, four times, and by its own parts.
    """
    one = HAND._replace(
        ratio=4.0, pad_stiffness=4.0, pad_damping=0.5, finger_stiffness=16.0, finger_damping=0.25, alpha=0.125
    )
    course = Course(monkeypatch, rates=RATES_NOW)
    table = HALVES_HELD if side == 0 else HALVES
    course.run(1.0, (side, 1), table, one)
    size = 3.75**0.5
    pace = 3.0 * size
    jerk = size * (0.125 + 0.5 * 3.0 + 2.0)
    own = 4.0 * 2.0 + 4.0 * 0.5 * 3.0 + 0.25 * 2.0 + 8.0
    twist = 4.0 * pace + 0.5 * (jerk + own * size)
    assert course.bounds[0] == pytest.approx((pace, twist, jerk), rel=1e-14)
    # Between the flanks the motor is on its own, if its speed matters, or if it is slowed down quickly.
    for changed, alpha in (({"friction": 0.5}, 0.125), ({"friction": 1.5}, 0.125), ({"alpha": 1.5}, 1.5)):
        course = Course(monkeypatch, rates=RATES_NOW)
        course.run(1.0, (side, 1), table, one._replace(**changed))
        jerk = size * (alpha + 0.5 * 3.0 + 2.0)
        twist = 4.0 * pace + 0.5 * (jerk + own * size)
        bound = alpha if side == 0 else jerk
        assert course.bounds[0] == pytest.approx((pace, twist, bound), rel=1e-14)
    course = Course(monkeypatch, rates=RATES_NOW)
    course.run(1.0, (side, 1), table, one._replace(alpha=1.0))
    assert course.bounds[0][2] == pytest.approx(size * (1.0 + 0.5 * 3.0 + 2.0), rel=1e-14)


@pytest.mark.parametrize("name", [*BODIES, *SLOW])
def test_no_motion_changes_faster_than_its_bounds(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """From below: by exponentials of each mode, within a sample; from above: one comes to a quarter of each."""
    body = SLOW[name] if name in SLOW else body_of(name)
    gear, n, chance = Gear(body), body.order, Random(name)
    most = [0.0, 0.0, 0.0]
    for side in (1, 0, -1):
        for way in (1, 0, -1) if body.friction > 0.0 else (1,):
            rates = gear.rates[side, way]
            whole = [expm(rates * k / 16.0) for k in range(17)]
            for _ in range(40):
                # The energy of the rates in one part or another.
                z = np.array(
                    [chance.gauss(0.0, 1.0) * 10.0 ** chance.uniform(-3.0, 3.0) for _ in range(n)] + [1.0, 0.3]
                )
                if way == 0:
                    z[1] = 0.0
                course = Course(monkeypatch, rates=(rates @ z)[:n].tolist())
                table = HALVES if side else HALVES_HELD
                if way == 0:
                    table = STUCK_HALVES + (0 if side else HALVINGS)
                course.run(1.0, (side, way), table, body)
                pace, twist, jerk = course.bounds[0]
                for over in whole:
                    second = rates @ rates @ over @ z
                    torque = body.pad_stiffness * second[2] + body.pad_damping * second[3]
                    found = (abs(second[2]), abs(torque), abs(second[1]) if way else 0.0)
                    for k, (one, bound) in enumerate(zip(found, (pace, twist, jerk), strict=True)):
                        assert one <= bound * (1.0 + 1e-9) + 1e-12 * (bound == 0.0)
                        most[k] = max(most[k], one / bound if bound > 0.0 else 0.0)
    assert min(most) > 0.25
