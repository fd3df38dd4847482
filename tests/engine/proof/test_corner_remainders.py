"""What the proof of cycles over corners says of motions beside one: against those motions themselves.

Each is followed beside a proven orbit. Off the derivative it may be no more than is said; and within the room it gets
the commands of the orbit, and comes to it.
"""

from functools import cache
from math import exp
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.certificate import PROVEN
from hknob_cli.engine.general import corners, orbit_proof
from hknob_cli.engine.general.body import norm
from hknob_cli.engine.general.cogging import SLOPE, far_around
from hknob_cli.engine.general.columns import CORNER_ROOM, LOOSE, RELEASING, SLOWNESS, STUCK_FOR, SWOLLEN, TURNING
from hknob_cli.engine.general.controller import command, read_after
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.orbit_proof import certify
from hknob_cli.engine.general.search import as_list, make_space
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.engine.general.cogs import COIL, LIGHT
from tests.verification.general_scenes import TWO_PARTS, scene

SETTLING = 1500  # samples
TURNS = 20  # periods that a motion is followed for


def cogged(torque: float, per_revolution: int, centre: float, **parts: Any) -> dict[str, Any]:
    return scene(cogging={"torque": torque, "per_revolution": per_revolution, "centre": centre}, **parts)


LAG = {"time_constant": 3e-4}
TWO_LATE = {"delay_samples": 2.0}
# Scene, sample rate, counts, start (counts, counts a sample) and period (samples) of a cycle over corners.
CELLS: dict[str, tuple[dict[str, Any], float, int, tuple[float, float], int]] = {
    "alone": (cogged(1.65e-4, 132, 0.0107), 250.0, 1024, (-2.0, 0.5), 16),
    "winding": (cogged(2.77e-4, 200, 0.0095, motor=COIL), 250.0, 1024, (-2.0, 0.5), 6),
    "finger": (cogged(1.12e-3, 132, 0.016, hand=TWO_PARTS), 500.0, 128, (-2.0, 0.5), 12),
    "lag": (cogged(7.06e-4, 132, 0.0441, actuator=LAG), 500.0, 512, (-2.0, -0.5), 10),
    "friction": (cogged(1.25e-4, 132, -0.0419, knob=LIGHT), 500.0, 128, (-2.0, 0.5), 9),
    "sticks": (
        cogged(1.81e-3, 132, 0.0136, knob={"coulomb_torque": 7.22e-4}, actuator=TWO_LATE), 500.0, 256, (-2.0, 0.5), 16
    ),
    "sticks longer": (
        cogged(1.19e-4, 36, -0.0104, knob={"coulomb_torque": 2.451e-3}, actuator=TWO_LATE, bias={"torque": 0.004}),
        250.0, 1024, (-2.0, 0.5), 34,
    ),
    "friction, finger": (
        cogged(9.48e-4, 84, 0.004, knob={"coulomb_torque": 2.25e-4}, hand=TWO_PARTS, actuator=TWO_LATE,
               bias={"torque": 0.004}), 1000.0, 512, (-2.0, 0.5), 23,
    ),
    "friction, winding": (
        cogged(2.52e-4, 132, -0.0042, knob={"coulomb_torque": 5.04e-5}, motor=COIL, bias={"torque": 5e-4}),
        500.0, 256, (-2.0, 0.5), 8,
    ),
    "friction, finger, winding, lag": (
        cogged(6.45e-4, 200, -0.0257, knob={"coulomb_torque": 1.63e-4}, hand=TWO_PARTS, motor=COIL, actuator=LAG,
               bias={"torque": 0.002}), 500.0, 512, (-2.0, 0.5), 6,
    ),
    "sticks, winding": (
        cogged(4.07e-4, 132, -0.0386, knob={"coulomb_torque": 9.08e-4}, motor=COIL, actuator={"delay_samples": 1.4},
               bias={"torque": 0.002}), 250.0, 1024, (-2.0, 0.5), 9,
    ),
    "sticks, is let go, lag": (
        cogged(1.44e-4, 84, 0.0449, knob={"coulomb_torque": 3.22e-3},
               actuator={"time_constant": 1e-3, "delay_samples": 2.0}, bias={"torque": 0.004}),
        250.0, 256, (-2.0, 0.5), 12,
    ),
    "sticks, is let go, gear": (
        cogged(2.01e-4, 132, -0.0344, knob={"coulomb_torque": 0.0}, actuator={"delay_samples": 1.4},
               gear={"ratio": 2.5, "motor_inertia": 3e-7, "stiffness": 5.0, "mesh_damping": 1e-3,
                     "motor_coulomb_torque": 4.44e-4}, bias={"torque": 0.002}),
        1000.0, 128, (-2.0, 0.5), 20,
    ),
}  # fmt: skip


PARTS_OF_ROOM = ("pass_corners", "turn_alike", "missed_by", "swell_of", "carried_between")


class Cycle:
    """A proven cycle over corners, and what its proof is made of."""

    def __init__(self, name: str) -> None:
        parts, rate, counts, (x, v), self.period = CELLS[name]
        one = sample_general(
            reduced(SceneSpec.model_validate(parts).plain()), sample_rate_hz=rate, counts_per_rev=counts
        )
        self.body = one.body._replace(
            **{name: list(getattr(one.body, name)) for name in ("cogs", "matrices", "vectors", "halt")}
        )
        self.wall, self.n = as_list(one.wall), one.body.order
        self.ring, self.head = [0.0] * one.delay_line, 0
        z = [x, v] + [0.0] * (self.n - 2)
        self.before = read_after(x, 0.0, self.wall)
        for _ in range(SETTLING):
            self.before, self.head = self.step(z, self.before, self.ring, self.head)
        space = make_space(self.n, len(self.ring), lambda count: [0.0] * count)
        said: dict[str, Any] = {"turn_alike": (0.0, 0.0)}
        with pytest.MonkeyPatch.context() as patch:
            for module, part in (
                *(
                    (corners, part)
                    for part in ("pass_corners", "turn_alike", "missed_by", "swell_of", "carried_between")
                ),
                (orbit_proof, "room_over_corners"),
            ):
                patch.setattr(module, part, self.noting(getattr(module, part), part, said))
            found = certify(z, self.before, self.ring, self.head, self.period, self.body, self.wall, space)
        assert found[0] == PROVEN
        self.marks, width = list(space.marks), space.width
        self.derivative = np.array([[space.cols[c * width + i] for c in range(self.n)] for i in range(self.n)])
        self.orbit = np.array(space.orbit)
        self.room, _, grown = said["room_over_corners"]
        rate = corners.growth_rate(self.body)
        # What is added goes on by its rates, or by the derivative from the end of a sample; no period has more parts.
        carried = min(grown, said["carried_between"][1] * exp(rate * min(self.marks[LOOSE], 1.0) + 0.1))
        self.bend = (said["pass_corners"][1] + said["turn_alike"][1]) * carried
        # What a difference grows to at most, so too.
        self.most = min(grown, 2.0 * max(1.0, self.marks[SWOLLEN]) * exp(rate + 0.1))
        self.largest = 2.0 * said["swell_of"] * (self.room / corners.unit_reach(self.body) + said["missed_by"])
        self.end, self.commands = self.follow(self.orbit)
        self.course = self.path
        self.rounding = 1e-13 * (1.0 + float(np.abs(self.orbit).max())) * self.period * grown

    @staticmethod
    def noting(function: Any, part: str, said: dict[str, Any]) -> Any:
        def noted(*given: Any) -> Any:
            said[part] = function(*given)
            return said[part]

        return noted

    def step(self, z: list[float], before: float, ring: list[float], head: int) -> tuple[float, int]:
        found: tuple[float, int] = advance(z, before, ring, head, self.body, self.wall, [0.0] * (2 * self.n))
        return found

    def follow(self, start: Any, periods: int = 1) -> tuple[Any, list[float]]:
        """State after so many periods, and the commands; states at samples are left in ``path``."""
        z, ring, before, head, commands = [float(x) for x in start], list(self.ring), self.before, self.head, []
        self.path = list[Any]()
        for _ in range(periods * self.period):
            last = before
            before, head = self.step(z, before, ring, head)
            self.path.append(np.array(z))
            commands.append(command(before, last, self.wall))
        return np.array(z), commands

    def size(self, d: Any) -> float:
        """Root of the energy with the spring of a stable slope; a lag by what may still arrive."""
        dz = [float(x) for x in d]
        late = abs(dz[-1]) / self.body.lag if self.body.lag > 0.0 else 0.0
        return float(np.sqrt((norm(dz, self.body) - late) ** 2 + self.body.cogs[SLOPE] * dz[0] ** 2) + late)

    def scaled(self, direction: tuple[float, ...], size: float) -> Any:
        """A difference of a size, in a direction of numbers up to 1 of the largest entries of each."""
        entries = [0.0] * self.n
        corners.largest_entries(self.body, entries)
        d = np.array(direction[: self.n]) * entries
        return d * (size / self.size(d))


@cache
def cycle_of(name: str) -> Cycle:
    return Cycle(name)


DIRECTION = st.tuples(*[st.floats(-1.0, 1.0)] * 6).filter(lambda d: max(abs(x) for x in d[:2]) > 0.1)
PART = st.floats(0.01, 1.0)


def check_remainders(name: str, one: tuple[float, ...], other: tuple[float, ...], part: float, less: float) -> None:
    """Of a difference of up to the largest size, and of that of two such motions.

    With ``bend`` q times the most that the difference is in a period.
    """
    cycle = cycle_of(name)
    first, second = cycle.scaled(one, part * cycle.largest), cycle.scaled(other, part * less * cycle.largest)
    beside, alike = cycle.follow(cycle.orbit + second)
    end, commands = cycle.follow(cycle.orbit + first)
    assert commands == cycle.commands
    assert alike == cycle.commands
    grown = cycle.derivative @ first
    q = cycle.most * part * cycle.largest
    assert cycle.size(grown) <= q + cycle.rounding
    assert max(cycle.size(z - at) for z, at in zip(cycle.path, cycle.course, strict=True)) <= q + cycle.rounding
    assert cycle.size(end - cycle.end - grown) <= cycle.bend * q * q + cycle.rounding
    off = cycle.size(end - beside - cycle.derivative @ (first - second))
    assert off <= cycle.bend * q * cycle.most * cycle.size(first - second) + cycle.rounding


def check_room(name: str, direction: tuple[float, ...], part: float) -> None:
    """The commands of the orbit, however often it comes round; no difference larger than the largest; and together."""
    cycle = cycle_of(name)
    d = cycle.scaled(direction, 1.0)
    d = d * (part * cycle.room / far_around(cycle.body.cogs, list(d), cycle.orbit[0], cycle.body))
    z, commands = cycle.orbit + d, []
    for _ in range(TURNS):
        assert cycle.size(z - cycle.orbit) <= cycle.largest
        z, got = cycle.follow(z)
        commands += got
    assert commands == cycle.commands * TURNS
    assert cycle.size(z - cycle.orbit) <= 0.5 * cycle.size(d) + cycle.rounding


@pytest.mark.parametrize("name", CELLS)
def test_cycles_pass_corners_and_are_proven(name: str) -> None:
    """Over slopes that do not hold, with turns and stops where there is friction; the room is far above roundings."""
    cycle = cycle_of(name)
    assert cycle.marks[CORNER_ROOM] == -1.0
    assert cycle.marks[LOOSE] > 0.0
    assert 0.0 < cycle.marks[SLOWNESS] < np.inf
    assert (cycle.marks[TURNING] > 0.0) == (cycle.body.friction > 0.0)
    assert (cycle.marks[STUCK_FOR] < np.inf) == ("sticks" in name)
    assert (cycle.marks[RELEASING] > 0.0) == ("let go" in name)
    assert cycle.room > 1e-10
    assert cycle.bend * cycle.most * cycle.largest <= 0.5 * (1.0 + 1e-12)
    np.testing.assert_allclose(cycle.end, cycle.orbit, atol=1e-12 * (1.0 + np.abs(cycle.orbit).max()))


@pytest.mark.parametrize("name", [name for name in CELLS if "sticks" not in name])
def test_what_is_off_the_derivative_is_seen(name: str) -> None:
    """A millionth of what is said, at least: no rounding. Where friction holds the knob nothing is left."""
    cycle, ratios = cycle_of(name), []
    numbers = np.random.default_rng(5)
    for _ in range(6):
        d = cycle.scaled(tuple(numbers.uniform(-1.0, 1.0, 6)), cycle.largest)
        end, _ = cycle.follow(cycle.orbit + d)
        off = cycle.size(end - cycle.end - cycle.derivative @ d)
        ratios.append(off / (cycle.bend * (cycle.most * cycle.largest) ** 2 + cycle.rounding))
    assert 1e-6 < max(ratios) <= 1.0


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(sorted(CELLS)), DIRECTION, DIRECTION, PART, PART)
def test_a_motion_is_no_further_off_the_derivative_than_is_said(
    name: str, one: tuple[float, ...], other: tuple[float, ...], part: float, less: float
) -> None:
    check_remainders(name, one, other, part, less)


@settings(max_examples=15, deadline=None)
@given(st.sampled_from(sorted(CELLS)), DIRECTION, PART)
def test_a_motion_within_the_room_comes_to_the_cycle(name: str, direction: tuple[float, ...], part: float) -> None:
    check_room(name, direction, part * 0.999)


@pytest.mark.long
@settings(max_examples=2000, deadline=None)
@given(st.sampled_from(sorted(CELLS)), DIRECTION, DIRECTION, PART, PART)
def test_many_motions_are_no_further_off_the_derivative(
    name: str, one: tuple[float, ...], other: tuple[float, ...], part: float, less: float
) -> None:
    check_remainders(name, one, other, part, less)


@pytest.mark.long
@settings(max_examples=300, deadline=None)
@given(st.sampled_from(sorted(CELLS)), DIRECTION, PART)
def test_many_motions_within_the_room_come_to_the_cycle(name: str, direction: tuple[float, ...], part: float) -> None:
    check_room(name, direction, part * 0.999)
