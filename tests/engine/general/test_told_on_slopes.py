"""What is told of teeth beside cogging before a step is taken, and which mode follows an end: by hand."""

from collections import Counter
from math import inf
from random import Random

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cogging import CENTRE, FALLEN, LENGTH, RISEN, ROOT, TURNED, least_share
from hknob_cli.engine.general.flanks import kind_of, pass_any_end, pass_end, still_in_teeth
from hknob_cli.engine.general.teeth import (
    APART,
    BACK,
    ON_STABLE,
    ON_UNSTABLE,
    SPRUNG,
    STUCK_APART,
    STUCK_BACK,
    told,
)

from .toothed import Array, Toothed, body_of

FRICTIONLESS, RUBS = "strong", "rubs"


def scattered(chance: Random, low: float = -6.0, high: float = 1.0) -> float:
    """A number of any size, and either sign."""
    return float(chance.choice((-1.0, 1.0)) * 10.0 ** chance.uniform(low, high))


@pytest.mark.parametrize("name", [FRICTIONLESS, RUBS])
def test_bounds_on_an_unstable_slope_grow_by_the_share_that_is_left(name: str) -> None:
    """There all second derivatives may be as much larger as the rates may grow; on a stable slope they are not."""
    body = body_of(name)
    spacing = 2.0**-3  # so that a slope further on is as far from its middle, to the last bit
    cogs = np.array(body.cogs)
    cogs[CENTRE], cogs[LENGTH] = 0.0, spacing
    body = body._replace(cogs=cogs)
    chance, seen = Random(name), Counter()
    for _ in range(40_000):
        h = 2.0 ** -chance.randint(0, 12)
        share = least_share(cogs, 1.0, h)
        side, toward = chance.choice((1, 0, -1)), chance.choice((1, -1) if body.friction > 0.0 else (1, 0, -1))
        z = [spacing * chance.randint(-32, 32) / 64.0, *(scattered(chance) for _ in range(body.order - 1))]
        pad = [scattered(chance) for _ in range(2 * body.order)]
        pace, twist, jerk = (abs(scattered(chance)) for _ in range(3))
        risen = told([z[0] + spacing, *z[1:]], 0.3, pad, side, toward, h, pace, twist, jerk, body, 1.0)
        if share == 0.0:
            assert not risen
            seen["not bounded"] += 1
            continue
        flat = told(z, 0.3, pad, side, toward, h, pace / share, twist / share, jerk / share, body, 0.0)
        assert risen == flat
        seen[risen, toward != 0] += 1
        seen["it matters"] += risen != told(z, 0.3, pad, side, toward, h, pace, twist, jerk, body, 0.0)
    assert min(seen.values()) >= 20
    assert {True, False} <= {key[0] for key in seen if isinstance(key, tuple)}


def test_nothing_is_told_of_a_step_in_which_rates_may_double() -> None:
    body = body_of(FRICTIONLESS)
    root = body.cogs[ROOT]
    assert [least_share(body.cogs, 1.0, 0.5 / root), least_share(body.cogs, 1.0, 0.51 / root)] == [0.5, 0.0]
    z, pad = [0.0] * body.order, [0.0] * (2 * body.order)
    assert not told(z, 0.0, pad, 1, 0, 0.51 / root, 1e-300, 0.0, 0.0, body, 1.0)
    assert told(z, 0.0, pad, 1, 0, 0.51 / root, 0.0, 0.0, 0.0, body, 1.0)  # nothing moves


@pytest.mark.parametrize("name", [FRICTIONLESS, RUBS])
def test_a_corner_changes_the_slope_alone_and_another_end_leaves_it(name: str) -> None:
    body = body_of(name)
    chance = Random(name)
    for _ in range(300):
        z = [chance.gauss(0.0, 1.0) for _ in range(body.order)]
        u, slope = chance.gauss(0.0, 1.0), float(chance.randint(-4, 4))
        side, toward = chance.choice((1, 0, -1)), chance.choice((1, 0, -1))
        kept = list(z)
        assert pass_any_end(z, u, side, toward, slope, RISEN, body) == (side, toward, slope + 1.0)
        assert pass_any_end(z, u, side, toward, slope, FALLEN, body) == (side, toward, slope - 1.0)
        assert z == kept
        for end in (TURNED, SPRUNG):
            z, other = list(kept), list(kept)
            expected = pass_end(other, u, side, toward, end, body, slope)
            assert pass_any_end(z, u, side, toward, slope, end, body) == (*expected, slope)
            assert z == other


def test_a_piece_is_known_by_its_flank_its_way_and_the_kind_of_its_slope() -> None:
    slopes = {0.0: ON_STABLE, 2.0: ON_STABLE, -4.0: ON_STABLE, 1.0: ON_UNSTABLE, -3.0: ON_UNSTABLE}
    for name in (FRICTIONLESS, RUBS):
        body = body_of(name)
        for slope, more in slopes.items():
            for way in (1, -1):
                kinds = [kind_of(side, way, body, slope) for side in (1, 0, -1)]
                assert kinds == [way * (kind + more) for kind in (1, APART, BACK)]
    assert [kind_of(side, 0, body_of(RUBS), 1.0) for side in (1, 0, -1)] == [0, STUCK_APART, STUCK_BACK]
    plain = body_of(FRICTIONLESS)._replace(cogs=None)
    assert [kind_of(side, -1, plain, 1.0) for side in (1, 0, -1)] == [-1, -APART, -BACK]
    marks = [abs(kind) + more for kind in (1, APART, BACK) for more in (0, ON_STABLE, ON_UNSTABLE)]
    assert len({*marks, 0, STUCK_APART, STUCK_BACK}) == 12  # no two modes share a number


def settled_at(body: Body, u: float) -> tuple[Array, Array]:
    """Where a motion on the wall's flank and the first slope would settle, and the matrix of its rates."""
    gear, n = Toothed(body), body.order
    gear.on(0.0)
    matrix = gear.rates[1, 0]
    return np.linalg.solve(matrix[:n, :n], -(matrix[:n, n] + matrix[:n, n + 1] * u)), matrix


@pytest.mark.parametrize("seed", range(8))
def test_a_motion_that_has_settled_in_teeth_moves_by_less_than_is_said(seed: int) -> None:
    """By exponentials of its slope's matrix; nothing is said where teeth are apart, or friction acts."""
    chance, body = Random(seed), body_of(FRICTIONLESS)
    n, u = body.order, 0.02 * chance.gauss(0.0, 1.0)
    cogs = np.array(body.cogs)
    cogs[CENTRE] = settled_at(body, u)[0][0]  # where it settles cogging does not pull
    body = body._replace(cogs=cogs)
    resting, matrix = settled_at(body, u)
    for size in (0.0, 1e-13, 1e-9, 1e-5):
        z = [x + size * chance.gauss(0.0, 1.0) for x in resting]
        pad = [0.0] * (2 * n)
        said = still_in_teeth(z, u, 1, 0.0, 1.0, body, pad)
        assert said < inf
        assert still_in_teeth(z, u, 1, 0.0, 0.25, body, pad) == 0.25 * said
        states = [expm(matrix * t) @ [*z, 1.0, u] for t in np.linspace(0.0, 1.0, 33)]
        way = max(abs(state[0] - z[0]) for state in states)
        assert way <= said * (1.0 + 1e-9) + 1e-14
        assert size == 0.0 or said < 1e4 * size
        assert still_in_teeth(z, u, 0, 0.0, 1.0, body, pad) == inf
    assert still_in_teeth([0.0] * n, u, 1, 0.0, 1.0, body_of(RUBS), [0.0] * (2 * n)) == inf
    fast = [*resting[:1], 0.6 * body.cogs[LENGTH], *resting[2:]]
    assert still_in_teeth(fast, u, 1, 0.0, 1.0, body, pad) == inf  # past a corner, or so that teeth part
