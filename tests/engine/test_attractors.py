"""Attractors of whole cells: what is known to exist is found, and every path of the engine agrees."""

from collections import Counter
from math import floor

import pytest

from hknob_cli.engine.attractors import (
    USUAL,
    Engine,
    NeedsCompilerError,
    Patience,
    Search,
    attractor_of,
    unfinished,
)
from hknob_cli.engine.budget import sample_limit, settling_samples
from hknob_cli.engine.ensemble import ROW, SAMPLES
from hknob_cli.engine.follow import REST_PROVEN
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.propagator import slowest_rate
from hknob_cli.scene.plain_knob import SampledKnob, sample_knob
from hknob_cli.specs.scene import SceneSpec

BASE = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
}


def knob(rate: float = 1000.0, counts: int = 1024, **parts: object) -> SampledKnob:
    return sample_knob(SceneSpec.model_validate({**BASE, **parts}).plain(), sample_rate_hz=rate, counts_per_rev=counts)


def search(engine: Engine, one: SampledKnob, phases: int = 64, max_samples: int | None = None) -> Search:
    return engine.search(
        one.loop, x=one.position(0.02), v=0.0, phases=phases, delay_line=one.delay_line, max_samples=max_samples
    )


@pytest.mark.parametrize("rate", [215.44, 1000.0, 4641.6])
@pytest.mark.parametrize("counts", [128, 1024, 8192])
@pytest.mark.parametrize(
    "parts",
    [
        {},
        {"bias": {"half_quantum": True}},
        {"actuator": {"delay_samples": 0.3}},
        {"actuator": {"delay_samples": 2.0}},
        {"encoder": {"rounding": "ceil"}},
        {"encoder": {"rounding": "nearest", "offset_counts": 0.25}},
    ],
    ids=["printed", "half", "fraction", "two", "ceil", "nearest"],
)
def test_compiled_and_interpreted_agree_to_the_last_bit(rate: float, counts: int, parts: dict[str, object]) -> None:
    one = knob(rate, counts, **parts)
    plain, fast = Engine(), Engine(compiled())
    found = search(plain, one, phases=6)
    assert found == search(fast, one, phases=6)
    for orbit in found.attractors:
        if orbit.outcome is Outcome.CYCLE:
            assert plain.measure(one.loop, orbit) == fast.measure(one.loop, orbit)
            pairs = zip(plain.holds(one.loop, orbit), fast.holds(one.loop, orbit), strict=True)
            assert all((a == b).all() for a, b in pairs)


def test_blocks_of_lanes_are_one_ensemble() -> None:
    """257 phases run in five blocks; each trial ends as it does in an ensemble of its own."""
    one = knob()
    found = search(Engine(compiled()), one, phases=257)
    assert sum(a.trials for a in found.attractors) == 257
    periods = {a.period for a in found.attractors}
    assert {10, 47} <= periods


def test_orbits_of_10_12_and_14_samples_coexist() -> None:
    """the theory: at 1 kHz with half-quantum bias all three exist and attract, at any resolution."""
    trials: Counter[int] = Counter()
    for counts in (128, 256, 512, 1024, 2048, 4096, 8192):
        for a in search(Engine(compiled()), knob(counts=counts, bias={"half_quantum": True})).attractors:
            assert a.certified
            trials[a.period] += a.trials
    assert {10, 12, 14} <= set(trials)


def test_ladder_of_periods_over_bias() -> None:
    """the known print errors: 12, 25/2, 13, 31/2 and 21 samples a cycle at g / (K dtheta) = .5, .3, .2, .1, .05.

    Several orbits may coexist; the stated one is among them.
    """
    from hknob_cli.measure.orbit import Measurer

    quantum = knob().quantum_rad
    for part, wanted in ((0.5, 12), (0.3, 12.5), (0.2, 13), (0.1, 15.5), (0.05, 21)):
        one = knob(bias={"torque": part * 0.27 * quantum})
        engine = Engine(compiled())
        measurer = Measurer(one, engine)
        found = search(engine, one, phases=256).attractors
        assert wanted in {a.period / measurer.measure(a).cycles for a in found}


def test_an_orbit_found_over_several_turns_is_one_orbit() -> None:
    found = search(Engine(compiled()), knob(counts=8192, actuator={"delay_samples": 1.3}))
    orbits = [(a.period, a.x) for a in found.attractors]
    for n, x in orbits:
        assert not any(m > n and m % n == 0 and abs(y - x) < 1e-6 for m, y in orbits)


def test_attractors_come_most_frequent_first() -> None:
    trials = [a.trials for a in search(Engine(), knob(counts=4096, bias={"half_quantum": True}), 32).attractors]
    assert trials == sorted(trials, reverse=True)


def test_a_limit_on_samples_gives_undecided_with_its_reason() -> None:
    (only,) = search(Engine(compiled()), knob(rate=1e5), phases=4, max_samples=13_000).attractors
    assert (only.outcome, only.reason) == (Outcome.UNDECIDED, Reason.NO_REPEAT)
    heavy = knob(knob={"inertia": 1.0})
    (only,) = search(Engine(compiled()), heavy, phases=1, max_samples=1000).attractors
    assert (only.outcome, only.reason) == (Outcome.UNDECIDED, Reason.TOO_SLOW)


def test_the_interpreter_hands_long_trials_over() -> None:
    with pytest.raises(NeedsCompilerError):
        search(Engine(), knob(hand={}), phases=1)


def test_samples_follow_the_slowest_mode() -> None:
    loop = knob().loop
    rate = slowest_rate(loop.alpha, loop.beta)
    limit = sample_limit(rate, damped=True)
    # The plant decays at b / 2J = 78.41 / s: ten time constants are 127.5 samples at 1 kHz, 600 are 7652.
    assert settling_samples(rate, limit) == 127
    assert limit == 65_536  # the least there is
    fast = knob(rate=1e5).loop
    assert sample_limit(slowest_rate(fast.alpha, fast.beta), damped=True) == 765_217


def test_reasons_have_words() -> None:
    from hknob_cli.engine.outcome import WORDS

    assert set(WORDS) == set(Reason)
    assert all(WORDS[reason] for reason in Reason if reason is not Reason.NONE)


def test_every_sample_of_a_limited_trial_is_counted() -> None:
    """Of a knob so heavy that nothing repeats, those that pass before anything is looked for too."""
    heavy = knob(knob={"inertia": 1.0})
    for phases in (1, 3):
        found = search(Engine(), heavy, phases=phases, max_samples=800)
        assert found.attractors[0].reason is Reason.TOO_SLOW
        assert found.samples == 800 * phases


def test_the_samples_of_all_trials_are_those_of_each_end() -> None:
    engine, one, kept = Engine(), knob(bias={"half_quantum": True}), []
    run = engine._ensemble

    def kernel(*given):  # type: ignore[no-untyped-def]
        kept.append(given[-2].table)
        return run(*given)

    engine._ensemble = kernel
    found = search(engine, one, phases=12)
    assert len(found.attractors) > 1
    (table,) = kept
    assert sum(table[ROW * row + SAMPLES] for row in range(len(found.attractors))) == found.samples
    assert found.samples > 12 * settling_samples(slowest_rate(one.loop.alpha, one.loop.beta), 10**6)


class Heard(Exception):
    """The kernel has been called."""


def test_the_interpreter_follows_no_longer_than_its_patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """All trials at once where there is no limit on the clock; each for the samples that pass, and its patience."""
    long = knob(rate=1e5)
    rate = slowest_rate(long.loop.alpha, long.loop.beta)
    limit = sample_limit(rate, damped=True)
    skip = settling_samples(rate, limit)
    for patience, samples, final in ((1000, 1000 + skip, False), (limit, limit, True)):
        engine = Engine(patience=Patience(patience))

        def kernel(at, phases, start, stop, budget, *rest, samples=samples, final=final):  # type: ignore[no-untyped-def]
            assert (budget.skip, budget.samples, budget.final) == (skip, samples, final)
            assert (start, stop) == (0, 500)
            raise Heard

        monkeypatch.setattr(engine, "_ensemble", kernel)
        with pytest.raises(Heard):
            search(engine, long, phases=500)


def test_time_that_is_over_is_told_and_patience_hands_over() -> None:
    """Patience is the interpreter's alone, and a limit of the cell that is shorter comes first."""
    hurried = Patience(seconds=2.0)
    for seconds, patience, fast in (
        (None, USUAL, False),
        (1.0, hurried, False),
        (None, hurried, True),
        (3.0, hurried, True),
    ):
        left = unfinished(3, seconds, patience, compiled=fast)
        assert (left.outcome, left.reason, left.trials) == (Outcome.UNDECIDED, Reason.TIME_LIMIT, 3)
    for seconds in (None, 3.0):
        with pytest.raises(NeedsCompilerError):
            unfinished(3, seconds, hurried, compiled=False)


@pytest.mark.parametrize(
    ("x", "edge"), [(-1.25, 0.25), (-0.75, 0.25), (-1.75, 0.25), (2.125, 0.125), (-0.5, 0.5), (1.875, 0.125)]
)
def test_a_rest_is_as_far_from_an_edge_as_from_the_next_whole_number(x: float, edge: float) -> None:
    row = [float(REST_PROVEN), 1.0, x, 0.0, 9.0, 9.0, 0.0, 0.0, 3.0, 0.0]
    assert attractor_of(row, [], Reason.NO_REPEAT).edge == edge


def test_the_torques_of_an_orbit_are_those_under_way_and_then_those_of_its_own_readings() -> None:
    """With 2.3 samples of delay three are under way, the oldest first; each is of the level that was read then."""
    one = knob(rate=400.0, actuator={"delay_samples": 2.3})
    engine = Engine()
    orbit = next(a for a in search(engine, one, phases=4).attractors if a.outcome is Outcome.CYCLE)
    xs, _, older, newer = engine.trace(one.loop, orbit)
    levels = [*orbit.line, *(min(floor(x), 0.0) for x in xs[:-1])]
    wanted = [0.0 - one.loop.kappa * (level + one.loop.offset) * (level < 0.0) - one.loop.gamma for level in levels]
    assert len(orbit.line) == 3
    assert len(set(orbit.line)) > 1
    assert older.tolist() == pytest.approx(wanted[: orbit.period], rel=1e-15)
    assert newer.tolist() == pytest.approx(wanted[1 : orbit.period + 1], rel=1e-15)
