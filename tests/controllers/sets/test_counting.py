"""The counts that a controller tells apart: every position has one, between that count's edges."""

import numpy as np
import pytest

from hknob_cli.controllers.sets.counting import Counting

EVERY = [(sense, outside) for sense in (1.0, -1.0, 0.0) for outside in (True, False)]


@pytest.mark.parametrize(("sense", "outside"), EVERY)
def test_a_position_lies_between_the_edges_of_its_count(sense: float, outside: bool) -> None:
    """Edges themselves, the numbers next to them, and positions between."""
    counting = Counting(sense, outside)
    whole = np.arange(-4.0, 5.0)
    x = np.concatenate([whole, np.nextafter(whole, -9.0), np.nextafter(whole, 9.0), whole + 0.5])
    count = counting.at(x)
    assert (counting.lower(count) <= x).all()
    assert (x <= counting.upper(count)).all()
    assert (np.diff(counting.at(np.sort(x))) >= 0.0).all()
    assert (count == counting.told(count)).all()


@pytest.mark.parametrize(("sense", "outside"), EVERY)
def test_positions_between_the_edges_of_a_count_have_it(sense: float, outside: bool) -> None:
    """A little inside both edges."""
    counting = Counting(sense, outside)
    count = np.arange(-4.0, 5.0 if outside else 1.0)
    low, high = counting.lower(count), np.minimum(counting.upper(count), 9.0)
    for x in (low + 1e-9, 0.5 * (low + high), high - 1e-9):
        assert (counting.at(x) == count).all()
    assert not outside or (high[:-1] == low[1:]).all()
