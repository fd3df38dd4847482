"""Every start at once: the arcs of clock phases and the polygons of a box, against starts followed one by one.

Verified by two programs that share nothing with the engine: trials at 60 digits, from phases beside the ends of every
arc; and a simulation by matrix exponentials of random starts, which may end in no orbit that the list lacks.
"""

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.loop import Loop
from hknob_cli.engine.orbit_holds import Holds, trace
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.sets.room import make_arc_room, make_known
from hknob_cli.engine.sets.search import Box, SetEngine
from tests import digits as mp
from tests.engine.sets.loops import follow_all

from .reference import build_cell
from .scenes import COUNTS, RATES_HZ, START_RAD, hand_on_knob, sample

ANGLE, VELOCITY = 0.05, 5.0  # of the box: 50 mrad, 5 rad/s

Levels = tuple[int, ...]


@pytest.fixture(scope="session")
def sets() -> SetEngine:
    """The search as a sweep runs it: compiled."""
    return SetEngine(compiled("sets"))


def turned(levels: Levels) -> Levels:
    """One period of levels, turned so that every way to write it is the same."""
    return min(levels[i:] + levels[:i] for i in range(len(levels)))


def levels_of(loop: Loop, x: float, v: float, n: int, line: tuple[float, ...] = ()) -> Levels:
    """Levels of one period of an orbit, by the package's own trace."""
    kinds = 2 if loop.split > 0.0 else 1
    holds = Holds(*([0.0] * (n * kinds + 1) for _ in range(3)))
    trace(x, v, list(line), 0, n, loop, holds)
    return turned(tuple(min(int(x // 1) if loop.sense > 0 else -int(-x // 1), 0) for x in holds.x[: n * kinds : kinds]))


ARCS = [
    # stiffness, bias, rate, counts, rounding, offset, delay, samples of a 60-digit trial
    (0.04, "torque", 100.0, 2048, "floor", 0.0, 0.0, 60),
    (0.04, "half_quantum", 1000.0, 1024, "floor", 0.0, 0.0, 500),
    (0.04, "torque", 1000.0, 4096, "floor", 0.0, 0.0, 500),
    (0.08, "torque", 464.2, 2048, "floor", 0.0, 0.0, 300),  # some phases rest
    (0.04, "torque", 464.2, 2048, "ceil", 0.25, 0.0, 300),
    (0.04, "torque", 1000.0, 1024, "nearest", 0.0, 1.0, 500),
    (0.04, "torque", 464.2, 512, "floor", 0.0, 0.4, 300),
]


@pytest.mark.parametrize(("stiffness", "bias", "rate", "counts", "rounding", "offset", "delay", "samples"), ARCS)
def test_phases_beside_the_ends_of_every_arc(
    stiffness: float, bias: str, rate: float, counts: int, rounding: str, offset: float, delay: float, samples: int
) -> None:
    """At 60 digits the middle of an arc, and its ends except for a billionth, end where the arc does."""
    scene = hand_on_knob(bias, stiffness, rounding=rounding, offset=offset, delay=delay)
    knob = sample(scene, rate, counts)
    known, room = make_known(np.zeros, knob.delay_line), make_arc_room(np.zeros, knob.delay_line)
    x, v = knob.position(START_RAD), knob.speed(0.0)
    _, arcs, undecided, _, covered, cut = follow_all(x, v, knob.delay_line, 65_536, 200, 1e9, room, known, knob.loop)
    assert cut
    assert undecided == 0.0
    assert 0.0 <= covered - 1.0 < 1e-7  # arcs overlap by what rounding may move their ends, and leave no gap
    table, d = known.table.reshape(-1, 10), knob.delay_line
    expected = []
    for row in range(int(known.counts[0])):
        n, at_x, at_v = int(table[row, 1]), table[row, 2], table[row, 3]
        expected.append(levels_of(knob.loop, at_x, at_v, n, tuple(known.lines[row * d : row * d + d])))
    cell = build_cell(scene, sample_rate_hz=rate, counts_per_rev=counts)
    ends = sorted(tuple(one) for one in room.ended.reshape(-1, 3)[:arcs])
    assert ends[0][0] == 0.0
    assert max(high for _, high, _ in ends) == 1.0
    assert all(after[0] <= one[1] for one, after in pairwise(ends)), "no gap between arcs"
    for low, high, row in ends:
        inside = 1e-9 * (high - low) + (covered - 1.0)  # past what overlaps, where the arcs' ends are one of two
        for phase in (low + inside, 0.5 * (low + high), high - inside):
            start = cell.plant.move((mp.mpf(START_RAD), mp.mpf(0)), (mp.mpf(0), cell.period * mp.mpf(phase)))
            last = [min(level, 0) for _, level in cell.run(start, samples)][-samples // 2 :]
            n = len(expected[int(row)])
            assert last[n:] == last[:-n], f"phase {phase}: another period"
            assert turned(tuple(last[:n])) == expected[int(row)], f"phase {phase}"


class Matrices:
    """Many trials of a plain cell side by side, by matrix exponentials in SI units."""

    def __init__(self, scene: dict, rate: float, counts: int) -> None:
        knob, hand = scene["knob"], scene["hand"]
        inertia = knob["inertia"] + hand["inertia"]
        self.stiffness, self.quantum, self.period = scene["wall"]["stiffness"], 2 * np.pi / counts, 1 / rate
        bias = scene["bias"]
        self.push = 0.5 * self.stiffness * self.quantum if bias.get("half_quantum") else bias["torque"]
        plant = np.array(
            [[0, 1, 0], [-hand["stiffness"] / inertia, -hand["damping"] / inertia, 1 / inertia], [0, 0, 0]]
        )
        self.hold = expm(plant * self.period)

    def run(self, theta: NDArray, omega: NDArray, samples: int) -> tuple[NDArray, NDArray]:
        for _ in range(samples):
            level = np.floor(theta / self.quantum)
            torque = np.where(level < 0, -self.stiffness * self.quantum * level, 0.0) - self.push
            theta, omega = (
                self.hold[0, 0] * theta + self.hold[0, 1] * omega + self.hold[0, 2] * torque,
                self.hold[1, 0] * theta + self.hold[1, 1] * omega + self.hold[1, 2] * torque,
            )
        return theta, omega


BOXES = [
    (stiffness, bias, rate, counts)
    for stiffness in (0.04, 0.08)
    for bias in ("torque", "half_quantum")
    for rate, counts in ((100.0, 512), (100.0, 8192), (464.2, 2048), (1000.0, 512))
]


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("stiffness", "bias", "rate", "counts"), BOXES)
def test_random_starts_end_in_listed_orbits(
    sets: SetEngine, stiffness: float, bias: str, rate: float, counts: int
) -> None:
    """Of 20,000 random starts of a box each lies, after 40 time constants, on a sample of a listed orbit."""
    scene = hand_on_knob(bias, stiffness)
    knob = sample(scene, rate, counts)
    box = Box(knob.position(-ANGLE), knob.position(ANGLE), knob.speed(-VELOCITY), knob.speed(VELOCITY))
    found = sets.search_box(knob.loop, box, max_samples=None)
    assert found.complete
    assert found.undecided == 0.0
    chance = np.random.default_rng(1)
    theta, omega = chance.uniform(-ANGLE, ANGLE, 20_000), chance.uniform(-VELOCITY, VELOCITY, 20_000)
    settled = int(40.0 / min(knob.loop.alpha / 2, 2.0)) + 200
    theta, omega = Matrices(scene, rate, counts).run(theta, omega, settled)
    x, v = theta / knob.quantum_rad, omega * knob.period_s / knob.quantum_rad
    near = on_listed(found.attractors, knob.loop, x, v)
    assert near.all(), f"{np.count_nonzero(~near)} starts end elsewhere, the first at {x[~near][0]}, {v[~near][0]}"


@pytest.mark.parametrize(("stiffness", "bias", "rate", "counts"), BOXES[1::3])
def test_starts_from_far_outside_end_in_listed_orbits(
    sets: SetEngine, stiffness: float, bias: str, rate: float, counts: int
) -> None:
    """Of 5,000 random starts up to a thousand times as far as the region each comes in, and ends on a listed orbit."""
    scene = hand_on_knob(bias, stiffness)
    knob = sample(scene, rate, counts)
    found = sets.search_anywhere(knob.loop, max_samples=None)
    assert found.complete
    assert found.region is not None
    low, high, slowest, fastest = found.region
    chance = np.random.default_rng(2)
    scale = 10.0 ** chance.uniform(0.0, 3.0, 5_000) * knob.quantum_rad
    theta = chance.uniform(-1.0, 1.0, 5_000) * scale * max(-low, high)
    omega = chance.uniform(-1.0, 1.0, 5_000) * scale / knob.period_s * max(-slowest, fastest)
    matrices, came = Matrices(scene, rate, counts), np.zeros(5_000, dtype=bool)
    for _ in range(int(50.0 / min(knob.loop.alpha / 2, 2.0)) + 200):
        x, v = theta / knob.quantum_rad, omega * knob.period_s / knob.quantum_rad
        came |= (x >= low) & (x <= high) & (v >= slowest) & (v <= fastest)
        theta, omega = matrices.run(theta, omega, 1)
    assert came.all()
    x, v = theta / knob.quantum_rad, omega * knob.period_s / knob.quantum_rad
    assert on_listed(found.attractors, knob.loop, x, v).all()


def on_listed(attractors: tuple[Attractor, ...], loop: Loop, x: NDArray, v: NDArray) -> NDArray:
    """Which states are samples of listed attractors, to a millionth of a count."""
    near = np.zeros(len(x), dtype=bool)
    for one in attractors:
        assert one.outcome in (Outcome.CYCLE, Outcome.REST)
        holds = Holds([0.0] * (one.period + 1), [0.0] * (one.period + 1), [0.0] * one.period)
        if one.outcome is Outcome.CYCLE:
            trace(one.x, one.v, [], 0, one.period, loop, holds)
        else:
            holds = Holds([one.x], [0.0], [])
        for at_x, at_v in zip(holds.x, holds.v, strict=False):
            near |= (np.abs(x - at_x) < 1e-6) & (np.abs(v - at_v) < 1e-6)
    return near


@pytest.mark.parametrize("bias", ["torque", "half_quantum"])
def test_shares_of_phases_are_those_of_many_samples(sets: SetEngine, bias: str) -> None:
    """Ten thousand phases of each cell find no other orbit, and shares that differ by no more than the arcs' ends."""
    from hknob_cli.engine.attractors import Engine

    engine, phases = Engine(compiled()), 10_000
    for rate in RATES_HZ[:5]:
        for counts in COUNTS[::2]:
            knob = sample(hand_on_knob(bias), rate, counts)
            start = {"x": knob.position(START_RAD), "v": 0.0, "delay_line": 0, "max_samples": None}
            whole = sets.search_phases(knob.loop, **start)
            assert whole is not None
            assert whole.complete
            shares = {(one.period, round(one.x, 6)): one.trials for one in whole.attractors}
            for one in engine.search(knob.loop, phases=phases, **start).attractors:
                share = shares.pop((one.period, round(one.x, 6)))
                assert abs(one.trials / phases - share) <= whole.pieces / phases
            assert all(share < whole.pieces / phases for share in shares.values())
