"""Cogging from corner to corner: against matrix exponentials, event by event, and what is asked for, by hand."""

from random import Random
from types import SimpleNamespace

import numpy as np
import pytest

from hknob_cli.engine.general import slopes
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cogging import FALLEN, FREE, LENGTH, RISEN, STABLE, TURNED, UNSTABLE, slope_at
from hknob_cli.engine.general.slopes import cog_acceleration, cog_chart, cog_many, cog_rate, pass_on, roll, way_from

from .cogs import COGS, PLAIN, RUBS, SCENES, SEEDS, Script, body_of, case_of


@pytest.mark.parametrize("name", SCENES)
def test_rates_are_those_of_the_torques(name: str) -> None:
    """On both kinds of slope; held, sliding, and free."""
    body = body_of(name)
    for seed in SEEDS:
        case = case_of(name, seed, False)
        known = case.begin()
        slope = slope_at(case.z[0], body.cogs)
        assert slope == known.slope
        for known.slope in (slope, slope + 1.0, slope - 2.0):
            pull = known.pull() @ known.z
            size = 1e-12 * (1.0 + np.abs(known.pull() * known.z).sum())
            assert cog_acceleration(case.z, case.u, known.slope, body) == pytest.approx(pull, abs=size)
            for mode in (FREE, 1, -1, 0):
                known.mode = mode
                out = [0.0] * body.order
                cog_rate(case.z, case.u, known.slope, mode, body, out)
                a = known.rates()
                sizes = 1e-12 * (1.0 + (np.abs(a) @ np.abs(known.z))[:-2])
                assert (np.abs(out - (a @ known.z)[:-2]) <= sizes).all()


@pytest.mark.parametrize("name", SCENES)
def test_a_motion_and_its_chart_go_from_event_to_event(name: str) -> None:
    """The same ends, in the same order; a chart has a piece for each, with its mode, and stops where its rows do."""
    events = 0
    for seed in SEEDS:
        case = case_of(name, seed, True)
        body, n = case.body, case.body.order
        z = list(case.z)
        cog_many(body.cogs, z, case.u, case.span, body, case.pad)
        assert case.near(z, case.end)
        events += len(case.events)
        pieces = SimpleNamespace(spans=[0.0] * 60, modes=[9] * 60, commands=[0.0] * 60, states=[0.0] * (61 * n))
        z = list(case.z)
        rows = cog_chart(body.cogs, z, case.u, case.span, body, case.pad, 2, pieces)
        assert case.near(z, case.end)
        assert pieces.states[rows * n : rows * n + n] == z
        assert sum(pieces.spans) == pytest.approx(case.span, rel=1e-12)
        assert pieces.commands == [0.0] * 2 + [case.u] * (rows - 2) + [0.0] * (60 - rows)
        starts = [0.0, *(one.time for one in case.events)]
        modes = [case.begin(), *case.events]
        seen = np.cumsum(pieces.spans[2:rows])
        assert all(min(abs(t - one) for one in [*starts, case.span]) < 1e-9 for t in seen)
        for row in range(2, rows):
            if pieces.spans[row] > 1e-9:
                at = 0.0 if row == 2 else seen[row - 3]
                now = next(mode for mode, one in reversed(list(zip(modes, starts, strict=True))) if one < at + 1e-9)
                assert pieces.modes[row] == now.mode * (STABLE if now.slope % 2.0 == 0.0 else UNSTABLE)
        full = SimpleNamespace(spans=[0.0] * 3, modes=[0] * 3, commands=[0.0] * 3, states=[0.0] * (4 * n))
        assert cog_chart(body.cogs, list(case.z), case.u, case.span, body, case.pad, 2, full) == 3
        assert full.spans[2] == pieces.spans[2]
    assert events >= 2


@pytest.mark.parametrize("name", SCENES)
def test_one_mode_is_left_at_its_end(name: str) -> None:
    """Where it ends, and as what; without turning points, too."""
    for seed in SEEDS:
        for ways in (True, False):
            case = case_of(name, seed + 50, ways)
            body, known = case.body, case.begin()
            z = list(case.z)
            slope, mode = slope_at(z[0], body.cogs), way_from(z, case.u, known.slope, body) if known.ways else FREE
            assert mode == known.mode
            fresh = mode not in (0, FREE) and z[1] == 0.0
            t, end = roll(z, case.u, slope, mode, case.span, fresh, body, case.pad)
            if not case.events:
                assert (t, end) == (case.span, 0)
                assert case.near(z, case.end)
                continue
            first = case.events[0]
            assert (t, end) == (pytest.approx(first.time, abs=1e-9), first.end)
            state = first.state.copy()
            if end == TURNED and mode != 0:
                assert abs(z[1]) < 1e-9 * case.size
                state[1] = z[1]
            assert case.near(z, state)


# What is asked for, mode by mode: `roll` is written down.


def test_without_cogging_nothing_moves() -> None:
    z = [1.0, 2.0]
    cog_many(None, z, 0.0, 1.0, PLAIN, [])
    assert cog_chart(None, z, 0.0, 1.0, PLAIN, [], 3, None) == 3
    assert z == [1.0, 2.0]


def test_after_an_end_comes_the_next_slope_or_the_other_way() -> None:
    for mode in (FREE, 1, -1):
        assert pass_on([4.0, 1.0], 0.0, 0.0, mode, RISEN, RUBS) == (1.0, mode)
        assert pass_on([-4.0, -1.0], 0.0, 0.0, mode, FALLEN, RUBS) == (-1.0, mode)
    for mode in (1, -1):
        for u, then in ((4.0, 1), (2.0, 0), (-2.0, 0), (-4.0, -1)):
            z = [0.0, 1e-17]
            assert pass_on(z, u, 0.0, mode, TURNED, RUBS) == (0.0, then)
            assert z == [0.0, 0.0]
    for u, then in (
        (2.0, 1),
        (0.5, 1),
        (-0.5, -1),
        (-2.0, -1),
        (0.0, -1),
    ):  # released, though rounding may say otherwise
        z = [0.0, 0.0]
        assert pass_on(z, u, 0.0, 0, TURNED, RUBS) == (0.0, then)
    # Of an unstable slope, too: at 9, a count beyond the top, cogging pulls by 1/4, the hand by 9.
    for u, then in ((9.0 - 0.25 + 2.0, 0), (9.0 - 0.25 + 2.0 + 1e-9, 1), (9.0 - 0.25 - 2.0 - 1e-9, -1)):
        assert pass_on([9.0, 0.0], u, 1.0, 1, TURNED, RUBS) == (1.0, then)
        assert way_from([9.0, 0.0], u, 1.0, RUBS) == then
    assert way_from([9.0, 1e-300], 0.0, 1.0, RUBS) == 1
    assert way_from([9.0, -1e-300], 0.0, 1.0, RUBS) == -1


def test_what_friction_just_holds_or_just_lets_go_moves_on() -> None:
    """Torques that balance friction to the last bit: one sum of them decides, and the motion ends in few steps."""
    body = body_of("rubs")
    held = 0
    for seed in range(60):
        random = Random(seed)
        z = [random.uniform(-3.0, 3.0) * body.cogs[LENGTH], 0.0]
        slope = slope_at(z[0], body.cogs)
        u = random.choice((-1.0, 1.0)) * body.friction - cog_acceleration(z, 0.0, slope, body)
        mode, left, ends, pad = way_from(z, u, slope, body), 1.0, 0, [0.0] * 4
        held += mode == 0
        assert mode in (0, 1 if u + cog_acceleration(z, 0.0, slope, body) > 0.0 else -1)
        while True:
            t, end = roll(z, u, slope, mode, left, mode != 0, body, pad)
            left -= t
            if end == 0:
                break
            slope, mode = pass_on(z, u, slope, mode, end, body)
            ends += 1
            assert ends < 10
        assert left == 0.0
    assert 0 < held < 60


@pytest.mark.parametrize("body", [PLAIN, RUBS])
def test_a_motion_goes_on_until_nothing_is_left(monkeypatch: pytest.MonkeyPatch, body: Body) -> None:
    """On the slope and in the mode that the last end leads to; what begins where another has ended is fresh."""
    rubs = body.friction > 0.0
    for v, u, way in ((0.5, 0.0, 1), (-0.5, 0.0, -1), (0.0, 0.0, 0), (0.0, 3.0, 1), (0.0, -3.0, -1), (1.0, 0.0, 1)):
        mode = way if rubs else FREE
        fresh = v == 0.0 and mode != 0
        script = Script(
            monkeypatch, slopes, [(0.25, RISEN, 4.0, 1.0), (0.125, FALLEN, 4.0, -1.0), (0.625, TURNED, 1.0, 0.0)]
        )
        z = [0.0, v]
        cog_many(COGS, z, u, 1.0, body, [])
        assert script.asked == [(0.0, mode, 1.0, fresh), (1.0, mode, 0.75, True), (0.0, mode, 0.625, True)]
        assert z == [1.0, 0.0]
        script = Script(monkeypatch, slopes, [(0.5, 0, 4.0, 1.0)])  # given up: all is over
        cog_many(COGS, z, 0.0, 1.0, body, [])
        assert len(script.asked) == 1
    script = Script(monkeypatch, slopes, [])
    cog_many(COGS, z, 0.0, 0.0, body, [])
    assert script.asked == []


def test_a_chart_has_no_pieces_without_length(monkeypatch: pytest.MonkeyPatch) -> None:
    for body in (PLAIN, RUBS):
        for v, u, way in ((0.5, 0.0, 1), (0.0, 0.0, 0), (0.0, 3.0, 1), (0.0, -3.0, -1)):
            if body is PLAIN and v == u == 0.0:
                continue
            script = Script(
                monkeypatch,
                slopes,
                [
                    (0.25, RISEN, 4.0, 1.0),
                    (0.0, FALLEN, 3.0, -1.0),
                    (0.5, FALLEN, -4.0, -1.0),
                    (0.25, RISEN, -4.0, 0.0),
                ],
            )
            pieces = SimpleNamespace(spans=[0.0] * 9, modes=[9] * 9, commands=[0.0] * 9, states=[7.0] * 20)
            assert cog_chart(COGS, [0.0, v], u, 1.0, body, [], 1, pieces) == 4
            assert script.asked == [
                (0.0, way, 1.0, v == 0.0 and way != 0),
                (1.0, way, 0.75, True),
                (0.0, way, 0.75, True),
                (-1.0, way, 0.25, True),
            ]
            assert pieces.spans == [0.0, 0.25, 0.5, 0.25, *[0.0] * 5]
            assert pieces.modes[:5] == [9, STABLE * way, STABLE * way, UNSTABLE * way, 9]
            assert pieces.commands == [0.0, u, u, u, *[0.0] * 5]
            assert pieces.states == [7.0, 7.0, 0.0, v, 3.0, -1.0, -4.0, -1.0, -4.0, 0.0, *[7.0] * 10]
            given_up = Script(monkeypatch, slopes, [(0.5, 0, 4.0, 1.0)])
            assert cog_chart(COGS, [0.0, v], u, 1.0, body, [], 1, pieces) == 2
            assert len(given_up.asked) == 1
            nothing = Script(monkeypatch, slopes, [])
            assert cog_chart(COGS, [0.0, v], u, 0.0, body, [], 1, pieces) == 1
            assert nothing.asked == []
