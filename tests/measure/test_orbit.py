"""Tests of `measure.orbit`: harmonics against moments in closed form, and against the motion that they add up to."""

from math import sqrt
from typing import Any

import mpmath
import numpy as np
import pytest

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.forms import generator
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.measure.orbit import MOST_HARMONICS, Harmonics, Measurer, harmonic_count
from hknob_cli.measure.pieces import _scattered, _shared, _sight, _transform
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests.engine.general.law_runs import states_with_law
from tests.verification.general_scenes import LIGHT, STIFF, TWO_PARTS, scene

HIGHEST_HZ = 5e5
# Amplitudes fall as the cube of the frequency, for the acceleration jumps: of the mean square of an orbit near 100 Hz
# (100 Hz / 500 kHz)^5 is left out, and of a position at a sample (100 Hz / 500 kHz)^2 of the swing, 4e-8.
PLAIN = {
    "plain": scene(),
    "half a sample late": scene(actuator={"delay_samples": 0.4}),
    "late": scene(actuator={"delay_samples": 2.0}),
    "nearest": scene(encoder={"rounding": "nearest"}),
}
GENERAL = {
    "plain": scene(),
    "friction": scene(knob=LIGHT),
    "late, with friction": scene(knob=LIGHT, actuator={"delay_samples": 0.4}),
    "two parts": scene(hand=TWO_PARTS),
    "two parts and friction": scene(hand=TWO_PARTS, knob=LIGHT),
    "stiff finger": scene(hand=STIFF),
    "lag": scene(actuator={"time_constant": 2e-4}),
    "lag, friction, two parts": scene(hand=TWO_PARTS, knob=LIGHT, actuator={"time_constant": 2e-4}),
    "damped wall": scene(wall={"damping": 1e-4}),
}


def cycles(measurer: Any, search: Any) -> list[Any]:
    found = [one for one in search.attractors if one.outcome is Outcome.CYCLE]
    assert found
    return found


def check_moments(measurer: Any, orbit: Any) -> None:
    """Half the sum of squared amplitudes is the mean square about the mean (Parseval)."""
    lines = measurer.harmonics(orbit, HIGHEST_HZ)
    rms = sqrt(float((np.abs(lines.angle_rad) ** 2).sum()) / 2.0)
    assert rms == pytest.approx(measurer.measure(orbit).rms_rad, rel=1e-10)
    first = 1.0 / (orbit.period * measurer.knob.period_s)
    assert lines.frequency_hz[0] == pytest.approx(first)
    assert lines.frequency_hz[-1] <= HIGHEST_HZ < lines.frequency_hz[-1] + 1.001 * first


def check_motion(measurer: Any, orbit: Any, positions: np.ndarray) -> None:
    """The harmonics add up to the motion at its samples."""
    lines = measurer.harmonics(orbit, HIGHEST_HZ)
    phase = 2.0 * np.pi * np.outer(np.arange(orbit.period) * measurer.knob.period_s, lines.frequency_hz)
    motion = (np.exp(1j * phase) * lines.angle_rad).real.sum(axis=1)
    wanted = (positions - positions.mean()) * measurer.knob.quantum_rad
    assert motion - motion.mean() == pytest.approx(wanted, abs=2e-7 * np.ptp(wanted))


@pytest.mark.parametrize("name", PLAIN)
def test_of_the_plain_loop(name: str) -> None:
    plan = SceneSpec.model_validate(PLAIN[name]).plain()
    knob = sample_knob(plan, sample_rate_hz=1000.0, counts_per_rev=1024)
    engine = Engine()
    found = engine.search(
        knob.loop, x=knob.position(0.02), v=0.0, phases=8, delay_line=knob.delay_line, max_samples=None
    )
    measurer = Measurer(knob, engine)
    for orbit in cycles(measurer, found):
        check_moments(measurer, orbit)
        check_motion(measurer, orbit, engine.trace(knob.loop, orbit)[0][:-1])


@pytest.fixture(scope="module")
def engine() -> GeneralEngine:
    return GeneralEngine(compiled("general"))


WITHOUT_COUNTS = ("friction", "two parts", "two parts and friction", "lag, friction, two parts")


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("name", "counts"), [*((name, 1024) for name in GENERAL), *((name, None) for name in WITHOUT_COUNTS)]
)
def test_beyond_the_plain_loop(name: str, counts: int | None, engine: GeneralEngine) -> None:
    parts = GENERAL[name] if counts else {**GENERAL[name], "encoder": "none", "wall": {"stiffness": 3.0}}
    knob = sample_general(SceneSpec.model_validate(parts).plain(), sample_rate_hz=1000.0, counts_per_rev=counts)
    found = engine.search(
        knob.body,
        knob.wall,
        knob.start(0.02, 0.0),
        rate=knob.rate,
        phases=4,
        delay_line=knob.delay_line,
        max_samples=None,
    )
    measurer = GeneralMeasurer(knob, engine)
    for orbit in cycles(measurer, found):
        check_moments(measurer, orbit)


GEARED = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 1e-3},
    "gear": {"ratio": 7.4, "motor_inertia": 1e-8, "stiffness": 10.0, "mesh_damping": 2e-4},
}


@pytest.mark.parametrize(
    ("parts", "counts"),
    [(scene(), 1024), (GENERAL["late, with friction"], 1024), (GENERAL["lag"], 1024), (GEARED, 360)],
    ids=["plain", "late, with friction", "lag", "behind a gear"],
)
def test_harmonics_are_of_what_the_hand_holds(parts: Any, counts: int, engine: GeneralEngine) -> None:
    """They add up to its motion at the samples: behind an elastic gear to that of the knob, not of the motor."""
    plan = reduced(SceneSpec.model_validate(parts).plain())
    knob = sample_general(plan, sample_rate_hz=1000.0, counts_per_rev=counts)
    found = engine.search(
        knob.body,
        knob.wall,
        knob.start(0.02, 0.0),
        rate=knob.rate,
        phases=2,
        delay_line=knob.delay_line,
        max_samples=16384,
    )
    measurer = GeneralMeasurer(knob, engine)
    for orbit in cycles(measurer, found):
        chart = engine.chart(knob.body, knob.wall, orbit)
        assert chart is not None
        begins = np.concatenate([[0.0], np.cumsum(chart.spans)[:-1]])
        at = [int(np.abs(begins - sample).argmin()) for sample in range(orbit.period)]
        assert np.abs(begins[at] - np.arange(orbit.period)).max() < 1e-9
        states = chart.states[at]
        check_motion(measurer, orbit, states[:, 0] - states[:, 2] if knob.behind else states[:, 0])


def test_the_number_of_harmonics_is_up_to_and_with_the_highest() -> None:
    """100 Hz from 10 samples of 1 kHz: 0.1 * 10 rounds to below 1, which must not cost a harmonic."""
    assert harmonic_count(10, sample_period_s=1e-3, highest_hz=300.0) == 3
    assert harmonic_count(10, sample_period_s=1e-3, highest_hz=299.0) == 2
    assert harmonic_count(10, sample_period_s=1e-3, highest_hz=99.0) == 0
    assert harmonic_count(10**9, sample_period_s=1e-3, highest_hz=99.0) == MOST_HARMONICS


def test_one_harmonic_reaches_below_the_next() -> None:
    one = Harmonics(np.array([10.0]), np.array([1.0 + 0.0j]))
    assert one.reach(19.9)
    assert not one.reach(20.0)


def test_what_is_missing_is_known() -> None:
    some = Harmonics(np.array([100.0, 200.0, 300.0]), np.ones(3, complex))
    assert some.reach(320.0)
    assert not some.reach(400.0)
    assert not Harmonics(np.zeros(0), np.zeros(0, complex)).reach(1.0)


@pytest.mark.parametrize(("jumps", "count"), [(1, 1), (5, 37), (200, 1500)])
def test_jumps_between_samples_are_summed_to_rounding(jumps: int, count: int) -> None:
    """Against 30 digits.

    The points of the period are a power of two, so that what is left of a turn is exact. Each term of the series, at
    most 26, and each level of its transform rounds once, and the sizes of the terms sum up to exp(π/2) at most.
    """
    draw = np.random.default_rng(jumps)
    turns, sizes = np.sort(draw.random(jumps)), draw.normal(size=(jumps, 2))
    found = _scattered(turns, sizes, count)
    assert found.shape == (count, 2)
    levels = (2 * count).bit_length()
    bound = np.exp(np.pi / 2.0) * (26 + 2 * levels) * np.finfo(float).eps * np.abs(sizes).sum(axis=0)
    with mpmath.workdps(30):
        for k in {1, count // 2 + 1, count}:
            waves = [mpmath.expjpi(-2 * k * mpmath.mpf(float(turn))) for turn in turns]
            for column in range(2):
                exact = mpmath.fdot(waves, [mpmath.mpf(float(size)) for size in sizes[:, column]])
                assert abs(complex(exact) - found[k - 1, column]) <= bound[column]


def test_jumps_at_the_same_part_of_an_interval_are_summed_as_those_at_samples_are() -> None:
    """Against 30 digits: at samples, a fortieth after them, and at any time; each transform has its own levels."""
    draw, n, count = np.random.default_rng(3), 64, 150
    at = np.arange(float(n))
    times = np.sort(np.concatenate([at, at + 0.025, n * draw.random(5)]))
    sizes = draw.normal(size=(len(times), 2))
    assert _shared(times - np.rint(times)) == pytest.approx([0.0, 0.025], abs=1e-14)
    w = 2.0 * np.pi / n * np.arange(1, count + 1)
    found = _transform(times, sizes, n, w)
    # A time is rounded by half a digit of n, which turns a wave by w times that.
    turned = w[-1] * n * np.finfo(float).eps
    rounded = np.exp(np.pi / 2.0) * (26 + 2 * (2 * count).bit_length()) * np.finfo(float).eps
    bound = (turned + rounded) * np.abs(sizes).sum(axis=0)
    with mpmath.workdps(30):
        for k in (1, 63, 64, 65, count):
            waves = [mpmath.expjpi(-2 * k * mpmath.mpf(float(time)) / n) for time in times]
            for column in range(2):
                exact = mpmath.fdot(waves, [mpmath.mpf(float(size)) for size in sizes[:, column]])
                assert abs(complex(exact) - found[k - 1, column]) <= bound[column]


def test_times_that_few_share_get_no_transform_of_their_own() -> None:
    """Of 40 times, 4 share a part of an interval, and 5 another."""
    parts = np.concatenate([np.linspace(-0.4, 0.4, 31), [0.123] * 4, [0.321] * 5])
    assert _shared(parts) == pytest.approx([0.0, 0.321], abs=1e-15)


@pytest.mark.parametrize("name", ["plain", "two parts", "lag, friction, two parts"])
@pytest.mark.parametrize("held", [False, True])
def test_what_sees_the_angle_of_a_motion_is_a_row_of_its_resolvent(name: str, held: bool) -> None:
    """Of all numbers, those that are constant between events with them, against 30 digits."""
    spec = SceneSpec.model_validate(GENERAL[name]).plain()
    body = sample_general(spec, sample_rate_hz=1000.0, counts_per_rev=1024).body
    g, w = generator(body, held=held), np.array([0.01, 0.3, 7.0])
    row = np.array([1.0, 0.0, -0.5, 0.0, 0.0, 0.0])[: body.order]
    found = _sight(g, row, w)
    for k, one in enumerate(w):
        with mpmath.workdps(30):
            shifted = mpmath.matrix(g.tolist()) - mpmath.mpc(0.0, float(one)) * mpmath.eye(len(g))
            padded = mpmath.matrix([[*row.tolist(), 0.0, 0.0, 0.0]])
            exact = [complex(value) for value in padded * shifted**-1]
        assert found[k].tolist() == pytest.approx(exact, rel=1e-11, abs=1e-14 * float(np.abs(exact).max()))


@pytest.mark.parametrize("name", ["friction", "two parts"])
def test_an_orbit_is_charted_once_for_its_measures_and_its_harmonics(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    knob = sample_general(SceneSpec.model_validate(GENERAL[name]).plain(), sample_rate_hz=1000.0, counts_per_rev=1024)
    engine = GeneralEngine(compiled("general"))
    found = engine.search(
        knob.body, knob.wall, knob.start(0.02, 0.0), rate=knob.rate, phases=4, delay_line=0, max_samples=None
    )
    measurer, orbit, charted = GeneralMeasurer(knob, engine), found.attractors[0], []
    chart = engine.chart
    monkeypatch.setattr(engine, "chart", lambda *given: charted.append(given[2]) or chart(*given))
    before, lines = measurer.measure(orbit), measurer.harmonics(orbit, 5000.0)
    assert charted == [orbit]
    other = orbit._replace(period=2 * orbit.period)
    assert measurer.harmonics(other, 5000.0).frequency_hz[1] == pytest.approx(lines.frequency_hz[0])
    assert measurer.measure(orbit) == before
    assert charted == [orbit, other, orbit]


CONTROLLERS = {
    "one part": {"kind": "bounded_lag", "keep": 0.15, "time_constant": 0.01},
    "short pulse": {"kind": "impulse_damping", "pulse": 0.025},
    "timed pulse": {"kind": "impulse_damping", "pulse": 0.1, "detections": 5},
    "predicts": {"kind": "half_sample"},
}


@pytest.mark.parametrize("name", CONTROLLERS)
def test_harmonics_of_orbits_under_controllers(name: str) -> None:
    """Parseval, and the motion at samples, under torques that change within an interval."""
    from hknob_cli.controllers.scalar_law import make_law
    from hknob_cli.engine.general.laws.search import LawEngine
    from hknob_cli.measure.general_orbit import LawMeasurer

    spec = SceneSpec.model_validate(scene(controller=CONTROLLERS[name])).plain()
    made = make_law(spec, sample_rate_hz=1000.0, counts_per_rev=1024)
    engine, knob = LawEngine(made.law), made.knob
    measurer = LawMeasurer(knob, engine)
    found = engine.search(
        knob.body,
        knob.wall,
        knob.start(0.02, 0.0),
        rate=made.rate,
        phases=4,
        delay_line=engine.past_length,
        max_samples=None,
    )
    some = [one for one in found.attractors if one.outcome is Outcome.CYCLE]
    assert some
    for one in some:
        lines = measurer.harmonics(one, HIGHEST_HZ)
        rms = sqrt(float((np.abs(lines.angle_rad) ** 2).sum()) / 2.0)
        assert rms == pytest.approx(measurer.measure(one).rms_rad, rel=1e-9)
        few = min(one.period, 8)  # instants, for the matrix to be small
        states = states_with_law(knob, made.law, [one.x, one.v], list(one.line), few)
        turns = np.exp(2j * np.pi * np.outer(np.arange(few) * knob.period_s, lines.frequency_hz))
        motion, there = (turns @ lines.angle_rad).real, states[:few, 0] * knob.quantum_rad
        off = (motion - motion.mean()) - (there - there.mean())
        assert np.abs(off).max() <= 1e-6 * np.ptp(there)
