"""Cells by number: any run of them is that part of the list, as cells and as columns."""

from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.specs.cells import Cells
from hknob_cli.specs.plan import COUNTS, RATE

VALUES = st.lists(st.floats(0.1, 1e4), min_size=1, max_size=4, unique=True)
WHOLE = st.lists(st.integers(1, 2**31), min_size=1, max_size=4, unique=True)


@given(rates=VALUES, counts=WHOLE, stiffness=VALUES, data=st.data())
def test_a_run_of_cells_is_that_part_of_the_list(
    rates: list[float], counts: list[int], stiffness: list[float], data: st.DataObject
) -> None:
    every = Cells({RATE: rates, COUNTS: counts, "hand.stiffness": stiffness})
    listed = list(every)
    assert len(listed) == len(every) == len(rates) * len(counts) * len(stiffness)
    start = data.draw(st.integers(0, len(every)))
    stop = data.draw(st.integers(start, len(every)))
    assert list(every.run(start, stop)) == listed[start:stop]
    columns = every.columns(start, stop)
    assert list(columns) == [RATE, COUNTS, "hand.stiffness"]
    assert [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)] == listed[start:stop]


def test_a_grid_without_axes_is_one_cell() -> None:
    assert list(Cells({})) == [{}]
    assert len(Cells({})) == 1
