"""Pieces of a motion by hand: their rates, by a body's own numbers, and the least and the most that a mesh carries."""

from itertools import count, pairwise, product
from math import factorial
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.cogging import CENTRE, LENGTH, STABLE, UNSTABLE
from hknob_cli.engine.general.search import PeriodSegments
from hknob_cli.engine.general.teeth import APART, BACK, ON_STABLE, ON_UNSTABLE, STUCK_APART, STUCK_BACK
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure import general_orbit
from hknob_cli.measure.forms import WALL, cogs_of, generator, loss_form, piece_starts, regime_of, ways
from hknob_cli.measure.general_orbit import GeneralMeasurer, _terms
from hknob_cli.measure.orbit import OrbitMeasures, at_rest
from hknob_cli.measure.pieces import _balanced, _exponential, _refined, extremes, mesh_row
from tests.engine.general.bodies import knob
from tests.engine.general.cogs import Cogged, body_of, by_hand
from tests.engine.general.gears import Gear, geared

FLANKS = {WALL: 1, APART: 0, BACK: -1}


def period(states: Any, modes: Any, commands: Any = None, spans: Any = None) -> PeriodSegments:
    """A chart of these pieces, a sample each unless told otherwise."""
    number = len(modes)
    table = np.array(states, dtype=float)
    return PeriodSegments(
        np.ones(number) if spans is None else np.array(spans, dtype=float),
        np.array(modes, dtype=float),
        np.zeros(number) if commands is None else np.array(commands, dtype=float),
        table,
    )


class Known:
    """An engine that has one chart, and one rate at which teeth part."""

    compiled_leak = None

    def __init__(self, chart: PeriodSegments | None) -> None:
        self.one = chart

    def chart(self, *_: Any) -> PeriodSegments | None:
        return self.one

    def parting_rate(self, *_: Any) -> float:
        return 0.25


def measurer_of(chart: PeriodSegments | None, one: Any = None) -> GeneralMeasurer:
    engine: Any = Known(chart)
    return GeneralMeasurer(one or knob(), engine)


# Rates.


@pytest.mark.parametrize("lag", [0.0, 1e-3])
@pytest.mark.parametrize("wound", [False, True])
def test_a_gears_rates_are_those_of_its_numbers(wound: bool, lag: float) -> None:
    """On each flank and on none, each way and held; friction acts against the way."""
    body = geared(2e-4, wound=wound, lag=lag)
    n, known = body.order, Gear(body)
    for (teeth, flank), way in product(FLANKS.items(), (1, -1, 0)):
        rates = generator(body, held=way == 0, teeth=teeth)
        assert not rates[n:].any()
        found = rates[:n, : n + 2].copy()
        found[:, n] -= way * body.friction * rates[:n, n + 2]
        wanted = known.rates[flank, way][:n]
        assert found == pytest.approx(wanted, rel=1e-12, abs=1e-12 * np.abs(wanted).max())


def test_a_knob_that_is_held_stands_still() -> None:
    """Whatever its finger does; and a torque that lags goes on, to what is commanded."""
    finger = {
        "finger": {"inertia": 3e-7, "damping": 2.9e-3, "stiffness": 0.4},
        "fingerpad": {"damping": 3.8e-4, "stiffness": 0.05},
    }
    for body in (knob().body, knob(hand=finger).body):
        assert not generator(body, held=True)[:2].any()
        assert generator(body, held=False)[0, 1] == 1.0
    body = knob(actuator={"time_constant": 1e-3}).body
    rates = generator(body, held=True)
    assert np.flatnonzero(rates.any(axis=1)).tolist() == [2]
    assert rates[2].tolist() == pytest.approx([0.0, 0.0, -body.lag, 0.0, body.lag, 0.0])


def test_teeth_apart_damp_nothing() -> None:
    """Each damper takes its resistance times its speed squared, the finger's per its own inertia."""
    body = geared()
    for teeth in FLANKS:
        form = loss_form(body, teeth)
        assert form[3, 3] == pytest.approx(
            (0.0 if teeth == APART else body.pad_damping) + body.finger_damping / body.ratio, rel=1e-14
        )
    assert body.pad_damping > 0.0


def test_modes_say_what_moves() -> None:
    assert [regime_of(kind) for kind in (0, 1, APART, BACK, STUCK_APART, STUCK_BACK)] == [
        (True, WALL, 0),
        (False, WALL, 0),
        (False, APART, 0),
        (False, BACK, 0),
        (True, APART, 0),
        (True, BACK, 0),
    ]
    for add, slope in ((ON_STABLE, STABLE), (ON_UNSTABLE, UNSTABLE)):
        assert regime_of(slope) == (False, WALL, slope)
        for teeth in (WALL, APART, BACK):
            assert regime_of(add + teeth) == (False, teeth, slope)
    modes = np.array([0, 1, -1, APART, -BACK, STUCK_APART, -STUCK_BACK], dtype=float)
    assert ways(modes).tolist() == [0.0, 1.0, -1.0, 1.0, -1.0, 0.0, 0.0]


def test_a_piece_begins_with_all_that_moves_it() -> None:
    """State, one, torque, and friction against the way."""
    body = geared(2e-4)
    states = [[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [9.0, 8.0, 7.0, 6.0]]
    chart = period(states, [-1, STUCK_APART], [0.5, -0.25])
    assert piece_starts(body, chart).tolist() == [
        [*states[0], 1.0, 0.5, body.friction],
        [*states[1], 1.0, -0.25, 0.0],
    ]


def test_what_is_constant_of_cogging_is_that_of_the_slope() -> None:
    """From corner to corner, upwards and downwards: what acts at x = 0 if the slope went on to there."""
    body = body_of("strong")
    centre, length = body.cogs[CENTRE], body.cogs[LENGTH]
    corners = [centre + (k + 0.5) * length for k in (-2, -1, 0, 1, 0, -1, -2)]
    chart = period([[x, 0.0] for x in corners], [6, 7, 6, -6, -7, -6])
    wanted = []
    for one, other in pairwise(corners):
        known = Cogged(body, [0.5 * (one + other), 0.0], 0.0)
        plain = Cogged(body._replace(cogs=(0.0, *body.cogs[1:])), [0.5 * (one + other), 0.0], 0.0)
        wanted.append(float(known.pull()[body.order] - plain.pull()[body.order]))
    assert cogs_of(body, chart) == pytest.approx(wanted, rel=1e-12)
    assert piece_starts(body, chart)[:, body.order + 2] == pytest.approx(
        np.array(wanted) - ways(chart.modes) * body.friction, rel=1e-12
    )


# What lies behind a gear.


def test_a_column_of_zeros_is_left_as_it_is() -> None:
    """That of an angle which nothing pulls at: there is nothing to even out."""
    plain = np.array([[0.0, 1.0, 2.0], [0.0, -3.0, 8.0], [0.0, 4.0, 1.0]])
    found = _balanced(plain)
    assert np.isfinite(found).all()
    assert np.sort(np.linalg.eigvals(found).real) == pytest.approx(np.sort(np.linalg.eigvals(plain).real))


def test_sizes_differ_by_no_more_than_two_afterwards() -> None:
    """Of 3 and a third, too, which one power of 2 brings together."""
    found = np.abs(_balanced(np.array([[1.0, 3.0], [1.0 / 3.0, 1.0]])))
    assert (np.abs(np.log2(found.sum(axis=1) / found.sum(axis=0))) < 1.0).all()


def test_exponentials_of_short_times() -> None:
    g = np.random.default_rng(5).standard_normal((4, 4))
    times = np.array([0.0, 0.01, 0.1, 0.3])
    assert _exponential(g, times) == pytest.approx(np.array([expm(g * t) for t in times]), rel=1e-13, abs=1e-14)


def test_a_turn_is_found_to_the_last_digits() -> None:
    """Of a cosine, from before its top to after it; also of one that begins all but at its top."""
    pace, row = 0.8, np.array([1.0, 0.0])
    g = np.array([[0.0, 1.0], [-pace * pace, 0.0]])
    before, step = np.array([0.1, 0.55, 0.9]), np.array([0.95, 0.9, 0.95])
    begun = np.stack([3.0 * np.cos(-pace * before), -3.0 * pace * np.sin(-pace * before)], axis=1)
    ended = [expm(g * t) @ z for t, z in zip(step, begun, strict=True)]
    rates = np.array([z @ g.T @ row for z in begun]), np.array([z @ g.T @ row for z in ended])
    assert (rates[0] * rates[1] < 0.0).all()
    assert _refined(g, row, begun, step, *rates) == pytest.approx([3.0] * 3, rel=1e-14)
    still = np.array([[3.0, 1e-30]])
    after = expm(g * 0.5) @ still[0] @ g.T @ row
    found = _refined(g, row, still, np.array([0.5]), np.array([1e-30]), np.array([after]))
    assert found == pytest.approx([3.0], rel=1e-14)


@pytest.mark.parametrize("teeth", [WALL, BACK])
def test_what_the_mesh_carries_is_from_its_least_to_its_most(teeth: int) -> None:
    """Over a piece on a flank: against the motion by its numbers alone, at 4001 times."""
    body = geared()
    known, flank = Gear(body), FLANKS[teeth]
    at = 0.02 if teeth == WALL else -body.play - 0.02
    begun = np.array([0.0, 0.3, at, 0.2, 1.0, -0.1])
    rates = known.rates[flank, 1]
    course = [expm(rates * t) @ begun for t in np.linspace(0.0, 1.0, 4001)]
    carried = [flank * known.mesh(z, flank) for z in course]
    chart = period([begun[:-2], course[-1][:-2]], [teeth], [-0.1])
    wanted = min(carried), max(carried)
    found = extremes(body, chart, mesh_row)
    spread = wanted[1] - wanted[0]
    assert found == pytest.approx(wanted, abs=1e-5 * spread)


def test_a_piece_of_no_length_turns_nowhere() -> None:
    """As where an event comes with a sample."""
    body = geared()
    state = [0.0, 0.0, 0.02, 0.0]
    carried = body.pad_stiffness * 0.02
    chart = period([state, state], [WALL], spans=[0.0])
    assert extremes(body, chart, mesh_row) == pytest.approx((carried, carried), rel=1e-14)


# Orbits.


def test_teeth_that_part_rattle_from_the_least_to_the_most() -> None:
    """With teeth that can part, or cogging, and a state to go on from; else nothing is said."""
    chart = period([[1.0, 0.0], [4.0, 0.0], [-1.5, 0.0]], [1, -1])
    plain = knob()
    end = Attractor(Outcome.UNDECIDED, Reason.NO_REPEAT, 1.0, state=(0.5, 0.25))
    for play, state, rattles in ((0.5, end.state, True), (0.5, (), False), (0.0, end.state, False)):
        one = plain._replace(body=plain.body._replace(play=play))
        said = measurer_of(chart, one).measure(end._replace(state=state))
        wanted = OrbitMeasures(rattle_p2p_rad=5.5 * one.quantum_rad, parting_per_s=0.25 / one.period_s)
        assert said == pytest.approx(wanted if rattles else OrbitMeasures(), nan_ok=True)
    assert measurer_of(None, one).measure(end) == pytest.approx(OrbitMeasures(), nan_ok=True)


@pytest.mark.parametrize(
    ("modes", "swing", "turns"), [([1, -1, -1, 1], 5.5, 1), ([1, 1, 1, 1], 0.0, 0), ([1, -1, 1, -1], 3.5, 2)]
)
def test_a_jittering_motion_swings_between_its_turns(modes: list[int], swing: float, turns: int) -> None:
    """From the mean of its tops to that of its bottoms; as often as it has a top, over the time of its pieces."""
    tops = {1: [4.0], 2: [4.0, 2.0], 0: []}[turns]
    bottoms = {1: [-1.5], 2: [-1.5, 0.5], 0: []}[turns]
    states = {1: [[0.0], [4.0], [1.0], [-1.5], [0.0]], 2: [[-1.5], [4.0], [0.5], [2.0], [-1.5]]}
    table = states.get(turns, [[-1.5], [0.0], [1.0], [2.0], [4.0]])
    one = knob()
    chart = period([[*x, 0.0] for x in table], modes, spans=[1.0, 2.0, 3.0, 4.0])
    said = measurer_of(chart, one).measure(Attractor(Outcome.UNDECIDED, Reason.JITTERS, 1.0))
    if turns:
        assert swing == np.mean(tops) - np.mean(bottoms)
    assert said.cycles == 0
    assert said.jitter_p2p_rad == pytest.approx(swing * one.quantum_rad)
    assert said.jitter_range_rad == pytest.approx(5.5 * one.quantum_rad)
    if turns:
        assert said.jitter_frequency_hz == pytest.approx(turns / (10.0 * one.period_s))
    else:
        assert np.isnan(said.jitter_frequency_hz)


def test_a_cycle_of_too_many_pieces_has_no_measures() -> None:
    said = measurer_of(None).measure(Attractor(Outcome.CYCLE, Reason.NONE, 1.0, period=4))
    assert said == pytest.approx(OrbitMeasures(), nan_ok=True)


def test_a_knob_at_rest_stands_still() -> None:
    said = at_rest(-0.5, 0.25)
    assert (said.min_rad, said.max_rad, said.cycles) == (-0.5, 0.25, 0)
    zero = ("p2p_rad", "rms_rad", "frequency_hz", "knob_p2p_rad", "wall_work_j", "damping_loss_j", "friction_loss_j")
    late = ("late_entry_j", "late_exit_j", "staircase_j")
    assert {name: getattr(said, name) for name in (*zero, *late)} == dict.fromkeys((*zero, *late), 0.0)


@pytest.mark.parametrize(("sense", "analog", "edge"), [(-1.0, 0.0, -1.0), (1.0, 0.0, 0.0), (-1.0, 1.0, 0.0)])
def test_a_wall_that_answers_at_once_begins_at_its_edge(
    sense: float, analog: float, edge: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A count further in where a level holds up to its upper edge; without counts at 0, whatever levels would be."""
    asked: list[float] = []
    monkeypatch.setattr(general_orbit, "split_leak", lambda *_, edge, **more: asked.append(edge))
    one = knob()
    measurer_of(None, one._replace(wall=one.wall._replace(sense=sense, analog=analog)))._leak(np.zeros(2), np.zeros(1))
    assert asked == [edge]


def test_a_fast_decay_is_integrated_to_rounding() -> None:
    """Of x'' = -50 x' - x from (0, 3): by its two exponentials."""
    alpha, beta = 50.0, 1.0
    one = knob()._replace(body=by_hand(alpha, beta))
    root = np.sqrt(alpha * alpha / 4.0 - beta)
    fast, slow = -alpha / 2.0 - root, -alpha / 2.0 + root
    size, span = 3.0 / (slow - fast), 0.9
    end = size * (np.exp(slow * span) - np.exp(fast * span))
    chart = period([[0.0, 3.0], [end, 0.0]], [1], spans=[span])
    totals = measurer_of(chart, one)._few_states(chart, 0.0)

    def over(rate: float) -> float:
        return float(np.expm1(rate * span) / rate)

    assert totals.mean == pytest.approx(size * (over(slow) - over(fast)), rel=1e-11)
    square = size**2 * (over(2.0 * slow) - 2.0 * over(slow + fast) + over(2.0 * fast))
    assert totals.square == pytest.approx(square, rel=1e-11)
    speed = size**2 * (slow**2 * over(2.0 * slow) - 2.0 * slow * fast * over(slow + fast) + fast**2 * over(2.0 * fast))
    assert totals.loss == pytest.approx(alpha * speed, rel=1e-11)


def test_a_series_has_the_terms_that_change_a_digit() -> None:
    """Of damping alone a^k / (k + 2)!, of stiffness alone c^(k/2) / (k + 2)! at even k: down to 1e-20 of two."""
    for number in np.linspace(0.05, 1.0, 60).tolist():

        def damped(k: int, a: float = number) -> float:
            return float(a**k / factorial(k + 2))

        def stiff(k: int, c: float = number) -> float:
            return 0.0 if k % 2 else float(c ** (k // 2) / factorial(k + 2))

        for term, numbers in ((damped, (number, 0.0)), (stiff, (0.0, number))):
            assert _terms(*numbers) == next(k for k in count(1) if term(k) + term(k - 1) <= 1e-20)
