"""Tests of `teeth.told` beside cogging: what is known of a step before it is taken, by hand."""

from collections import Counter
from random import Random

import numpy as np
import pytest

from hknob_cli.engine.general.cogging import CENTRE, LENGTH, ROOT, least_share
from hknob_cli.engine.general.teeth_ends import Bounds, Mode, told

from .toothed import body_of

FRICTIONLESS, RUBS = "strong", "rubs"


def scattered(chance: Random, low: float = -6.0, high: float = 1.0) -> float:
    """A number of any size, and either sign."""
    return float(chance.choice((-1.0, 1.0)) * 10.0 ** chance.uniform(low, high))


@pytest.mark.one_in(2)
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
        risen = told([z[0] + spacing, *z[1:]], 0.3, pad, Mode(side, toward, 1.0), h, Bounds(pace, twist, jerk), body)
        if share == 0.0:
            assert not risen
            seen["not bounded"] += 1
            continue
        flat = told(z, 0.3, pad, Mode(side, toward, 0.0), h, Bounds(pace / share, twist / share, jerk / share), body)
        assert risen == flat
        seen[risen, toward != 0] += 1
        seen["it matters"] += risen != told(z, 0.3, pad, Mode(side, toward, 0.0), h, Bounds(pace, twist, jerk), body)
    assert min(seen.values()) >= 20
    assert {True, False} <= {key[0] for key in seen if isinstance(key, tuple)}


def test_nothing_is_told_of_a_step_in_which_rates_may_double() -> None:
    body = body_of(FRICTIONLESS)
    root = body.cogs[ROOT]
    assert [least_share(body.cogs, 1.0, 0.5 / root), least_share(body.cogs, 1.0, 0.51 / root)] == [0.5, 0.0]
    z, pad = [0.0] * body.order, [0.0] * (2 * body.order)
    assert not told(z, 0.0, pad, Mode(1, 0, 1.0), 0.51 / root, Bounds(1e-300, 0.0, 0.0), body)
    assert told(z, 0.0, pad, Mode(1, 0, 1.0), 0.51 / root, Bounds(0.0, 0.0, 0.0), body)  # nothing moves
