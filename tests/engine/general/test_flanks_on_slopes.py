"""Tests of `flanks` beside cogging: the mode after an end, its number, and how far a settled motion moves, by hand."""

from math import inf
from random import Random

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.general import teeth
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cogging import CENTRE, FALLEN, LENGTH, RISEN, TURNED
from hknob_cli.engine.general.flanks import kind_of, pass_any_end, pass_end, still_in_teeth
from hknob_cli.engine.general.teeth import APART, BACK, ON_STABLE, ON_UNSTABLE

from .toothed import Array, Toothed, body_of

FRICTIONLESS, RUBS = "strong", "rubs"
STUCK = [0, teeth.STUCK_APART, teeth.STUCK_BACK]


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
        for end in (TURNED, teeth.SPRUNG):
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
    assert [kind_of(side, 0, body_of(RUBS), 1.0) for side in (1, 0, -1)] == STUCK
    plain = body_of(FRICTIONLESS)._replace(cogs=None)
    assert [kind_of(side, -1, plain, 1.0) for side in (1, 0, -1)] == [-1, -APART, -BACK]
    marks = [abs(kind) + more for kind in (1, APART, BACK) for more in (0, ON_STABLE, ON_UNSTABLE)]
    assert len({*marks, *STUCK}) == 12  # no two modes share a number


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
