"""Rest inside the wall: where the package reports it, and where it must exist.

Source: the theory, "A stable rest point inside the wall exists iff g/((K+k) dtheta) lies in (m - k/(K+k), m] for a
whole number m >= 1". Verified both ways over random scenes, and on the main grid (stiffness 0.08, bias
0.001 N m). The condition is evaluated at 60 digits on the doubles of the scene; the package's certificate claims a
margin above its own rounding, so no tolerance is needed.
"""

from dataclasses import dataclass
from typing import Any

import hypothesis.strategies as st
import pytest
from hypothesis import Phase, assume, event, given, settings

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.follow import REST_PROVEN, follow
from hknob_cli.engine.outcome import Outcome
from tests import digits as mp

from .reference import Cell, build_cell
from .scenes import BIASES, COUNTS, RATES_HZ, STIFFNESSES, hand_on_knob, sample, settle, settle_grid

EPSILON = 2.0**-52
SAMPLES = 2**20  # of a trial; a knob that creeps for longer is hardly ever proven to rest

SETTINGS = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    database=None,
    phases=[Phase.explicit, Phase.generate, Phase.shrink],
)


def condition(cell: Cell) -> int:
    """The level m >= 1 at which the knob can rest inside the wall, 0 if there is none: the line of the theory."""
    total = cell.wall_stiffness + cell.plant.stiffness
    ratio = cell.plant.bias / (total * cell.quantum)
    m = int(mp.ceil(ratio))
    return m if m >= 1 and ratio > m - cell.plant.stiffness / total else 0


def rest_angle(cell: Cell, m: int) -> Any:
    """Where hand, wall at level -m, and bias balance: k theta = K m dtheta - g."""
    return (cell.wall_stiffness * m * cell.quantum - cell.plant.bias) / cell.plant.stiffness


@dataclass(frozen=True)
class Draw:
    """A random scene: the rest point of level -m would lie at (-m + part) counts, in the level where 0 <= part < 1."""

    scene: dict[str, Any]
    counts: int
    m: int
    part: float

    def cell(self, rate_hz: float) -> Cell:
        """The 60-digit model."""
        return build_cell(self.scene, sample_rate_hz=rate_hz, counts_per_rev=self.counts)


@st.composite
def draws(draw: st.DrawFn, damping_ratio: tuple[float, float], part: st.SearchStrategy[float]) -> Draw:
    """Scenes whose bias puts the rest point of level -m at a chosen part of a count."""

    def log10(low: float, high: float) -> float:
        return 10.0 ** draw(st.floats(low, high))

    counts = draw(st.integers(16, 20_000))
    m = draw(st.integers(1, 6))
    where = draw(part)
    inertia, wall = log10(-7, -4), log10(-3, 1)
    hand = wall * log10(-1.5, 0.5)
    quantum = 2.0 * 3.141592653589793 / counts
    bias = (m * wall + (m - where) * hand) * quantum
    assume(bias >= 0.0)
    ratio = draw(st.floats(*damping_ratio))
    scene = {
        "knob": {"inertia": inertia, "damping": 2.0 * ratio * (inertia * hand) ** 0.5},
        "hand": {"stiffness": hand},
        "wall": {"stiffness": wall},
        "bias": {"torque": bias},
    }
    return Draw(scene=scene, counts=counts, m=m, part=where)


def fast_clock(cell: Cell, m: int, room: float) -> float:
    """A rate at which a trial that starts at rest stays within ``room`` counts, though torque is zero at first.

    By its first sample, at most T later, it has moved by K m T^2/2J counts at most, and runs at K m T/J counts per
    second at most; overdamped, it runs on by no more than that speed times J/b.
    """
    pull = cell.wall_stiffness * m
    plant = cell.plant
    return float(1 / min(mp.sqrt(room * plant.inertia / pull), room / 2 * plant.damping / pull))


@SETTINGS
@given(
    draw=draws((0.05, 20.0), st.floats(-1.5, 2.5)),
    pace=st.floats(-2.0, 0.7),
    away=st.floats(-1.5, 1.5),
    speed=st.floats(-0.5, 0.5),
)
def test_rest_is_reported_only_where_the_condition_holds(
    engine: Engine, draw: Draw, pace: float, away: float, speed: float
) -> None:
    """Trials from near a possible rest point, with and without one there, under- and overdamped."""
    plant = draw.cell(1.0).plant
    time_constant = min(plant.inertia / plant.damping, mp.sqrt(plant.inertia / plant.stiffness))
    rate_hz = float(1 / (time_constant * 10.0**pace))
    cell = draw.cell(rate_hz)
    holds_for = condition(cell)
    angle = float((-draw.m + draw.part + away) * cell.quantum)
    velocity = float(speed * cell.quantum / cell.period)
    resting = False
    start = {"angle": angle, "velocity": velocity}
    for one in settle(engine, draw.scene, rate_hz, draw.counts, **start, phases=3, max_samples=SAMPLES):
        if one.attractor.outcome is not Outcome.REST or not one.attractor.certified:
            continue
        assert one.measures.p2p_rad == one.measures.rms_rad == one.measures.frequency_hz == 0.0
        level = cell.level(one.measures.min_rad)
        if level < 0:
            resting = True
            assert holds_for == -level, f"rest at level {level}; the condition holds for {holds_for or 'none'}: {one}"
            exact = rest_angle(cell, -level)
            # theta_e is a difference of two torques over k; six roundings of each, at most, on the way.
            scale = (cell.wall_stiffness * -level * cell.quantum + cell.plant.bias) / cell.plant.stiffness
            assert abs(one.measures.min_rad - exact) <= 8 * EPSILON * scale
    event(f"condition holds: {holds_for > 0}, rest found: {resting}")


@SETTINGS
@given(draw=draws((1.0001, 20.0), st.floats(0.02, 0.98)), phases=st.integers(1, 5))
def test_rest_is_found_where_the_condition_holds(engine: Engine, draw: Draw, phases: int) -> None:
    """Overdamped trials that start exactly at the rest point of a strictly met condition stay, and p2p is exactly 0."""
    room = min(draw.part, 1.0 - draw.part) / 2
    rate_hz = fast_clock(draw.cell(1.0), draw.m, room)
    cell = draw.cell(rate_hz)
    assert condition(cell) == draw.m, "the draw does not do what it says"
    theta = rest_angle(cell, draw.m)
    assert cell.level(theta) == -draw.m, "the condition of the theory does not put the rest point into its level"
    # At a sample: the engine's own verdict, before anything moves.
    knob = sample(draw.scene, rate_hz, draw.counts)
    fate, period, x, v, _, _ = follow(knob.position(float(theta)), 0.0, [], 0, 1000, 1e6, knob.loop)
    assert (fate, period, v) == (REST_PROVEN, 1, 0.0)
    # As trials, which fall freely until their first sample.
    found = list(settle(engine, draw.scene, rate_hz, draw.counts, angle=float(theta), phases=phases))
    assert len(found) == 1, [str(one) for one in found]
    one = found[0]
    assert one.attractor.outcome is Outcome.REST, one
    assert one.attractor.certified, one
    assert one.attractor.trials == phases
    assert one.attractor.x == x
    assert one.measures.p2p_rad == one.measures.rms_rad == one.measures.frequency_hz == 0.0
    assert one.measures.min_rad == one.measures.max_rad
    assert abs(one.measures.min_rad - theta) <= 1e-9 * cell.quantum


# Rest points in the level meant for them, or in a neighbour; on an edge, rest is not for either side to prove.
OFF_EDGE = st.builds(float.__add__, st.sampled_from([0.0, 0.0, -1.0, 1.0]), st.floats(0.001, 0.999))


def capturing_level(cell: Cell, start: tuple[Any, Any], samples: int) -> int:
    """Level inside the wall that a trial comes to rest in, 0 if none captures it within ``samples``.

    While a level acts, k (theta - theta_e)^2 + J omega^2 never grows; once it allows no excursion past an edge of the
    level, none will ever happen.
    """
    plant, known = cell.plant, {}
    for (theta, omega), level in cell.run(start, samples):
        if level >= 0:
            continue
        if level not in known:
            still = rest_angle(cell, -level)
            room = min(still - level * cell.quantum, (level + 1) * cell.quantum - still)
            known[level] = still, plant.stiffness * room**2 if room > 0 else mp.mpf(0)
        still, most = known[level]
        if plant.stiffness * (theta - still) ** 2 + plant.inertia * omega**2 < most:
            return level
    return 0


@SETTINGS
@given(
    draw=draws((0.2, 1.5), OFF_EDGE),
    pace=st.floats(-1.0, 0.7),
    away=st.floats(-1.5, 1.5),
    speed=st.floats(-0.5, 0.5),
)
def test_a_trial_rests_exactly_when_a_level_captures_it(
    engine: Engine, draw: Draw, pace: float, away: float, speed: float
) -> None:
    """One trial at a time, at 60 digits: rest where a level captures it, and no rest where none does.

    1000 samples are at least 12 time constants of the slowest mode (damping ratio 1.5, T = J/10b); what has not been
    captured by then, to parts of 1e-5 of a count, cycles or diverges.
    """
    assume(draw.scene["bias"]["torque"] > 0.0)
    plant = draw.cell(1.0).plant
    time_constant = min(plant.inertia / plant.damping, mp.sqrt(plant.inertia / plant.stiffness))
    rate_hz = float(1 / (time_constant * 10.0**pace))
    cell = draw.cell(rate_hz)
    angle = float((-draw.m + draw.part + away) * cell.quantum)
    velocity = float(speed * cell.quantum / cell.period)
    expected = capturing_level(cell, cell.start((mp.mpf(angle), mp.mpf(velocity)), 0, 1), 1000)
    (one,) = settle(engine, draw.scene, rate_hz, draw.counts, angle=angle, velocity=velocity, phases=1)
    assert one.attractor.certified or one.attractor.outcome is Outcome.DIVERGED, one
    at_rest = one.attractor.outcome is Outcome.REST
    assert at_rest == (expected < 0), f"captured by level {expected}, reported {one.attractor.outcome.name}: {one}"
    if at_rest:
        assert cell.level(one.measures.min_rad) == expected, one
    event(f"at rest: {at_rest}")


@pytest.mark.parametrize("bias", BIASES)
@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_grid(engine: Engine, bias: str, stiffness: float) -> None:
    """Over the grid, rest is reported only in the columns of counts where the condition holds, and at its level."""
    scene = hand_on_knob(bias, stiffness)
    allowed = {n: condition(build_cell(scene, sample_rate_hz=1000.0, counts_per_rev=n)) for n in COUNTS}
    for one in settle_grid(engine, scene):
        if one.attractor.outcome is Outcome.REST:
            assert allowed[one.counts] > 0, one
            assert -allowed[one.counts] <= one.attractor.x < 1 - allowed[one.counts], one
            assert one.measures.p2p_rad == 0.0, one
    if stiffness == 0.04 or bias == "half_quantum":
        assert not any(allowed.values())
    else:
        assert {n for n, m in allowed.items() if m} == {2048, 4096}  # the known print errors


ENCODERS: dict[str, dict[str, Any]] = {
    "nearest": {"rounding": "nearest"},
    "nearest, offset": {"rounding": "nearest", "offset": 0.3},
    "ceil": {"rounding": "ceil"},
    "ceil, offset": {"rounding": "ceil", "offset": 0.6},
    "floor, offset, delay": {"offset": 0.85, "delay": 1.6},
}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("bias", BIASES)
@pytest.mark.parametrize("name", ENCODERS)
def test_rest_with_other_encoders_balances_the_torques(engine: Engine, bias: str, name: str) -> None:
    """Wherever rest is reported, k theta = tau(theta) - g to a few roundings of the torques, read by that encoder."""
    scene = hand_on_knob(bias, 0.08, **ENCODERS[name])
    for one in settle_grid(engine, scene):
        if one.attractor.outcome is Outcome.REST and one.attractor.certified:
            cell = build_cell(scene, sample_rate_hz=one.rate_hz, counts_per_rev=one.counts)
            theta = mp.mpf(one.measures.min_rad)
            wall, spring = cell.command(theta), cell.plant.stiffness * theta
            assert abs(wall - cell.plant.bias - spring) <= 16 * EPSILON * (wall + cell.plant.bias + abs(spring)), one
            assert one.measures.p2p_rad == one.measures.rms_rad == one.measures.frequency_hz == 0.0, one


def test_rest_at_2048_and_4096_counts(engine: Engine) -> None:
    """Stiffness 0.08, bias 0.001: rest at 2048 and 4096 counts over several rates, p2p exactly 0 (as promised)."""
    resting: dict[int, set[float]] = {}
    scene = hand_on_knob("torque", 0.08)
    for counts in (2048, 4096):
        for rate_hz in RATES_HZ:
            for one in settle(engine, scene, rate_hz, counts):
                if one.attractor.outcome is Outcome.REST:
                    assert one.attractor.certified, one
                    assert one.measures.p2p_rad == 0.0, one
                    resting.setdefault(counts, set()).add(rate_hz)
    assert all(len(resting.get(counts, ())) >= 2 for counts in (2048, 4096)), resting
