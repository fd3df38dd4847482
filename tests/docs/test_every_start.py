"""The numbers of docs/explanation/every_start.md: how many cycles there are, of what kind at half a count's bias."""

from math import pi

import pytest

from hknob_cli.engine.jit import compiled
from hknob_cli.engine.sets.search import SetEngine
from hknob_cli.theory.relay import Relay, tsypkin
from tests.conftest import EXPERIMENTS, swept
from tests.verification.scenes import RATES_HZ, hand_on_knob, sample
from tests.verification.test_two_level_cycles import lists

from .page import agrees, table

PAGE = "explanation/every_start.md"
COUNTS = 2048


def test_how_many_cycles_there_are_by_kind() -> None:
    rows = table(PAGE, "## How many there are")
    printed = [[cell or "0" for cell in row[1:]] for row in rows]
    sets = SetEngine(compiled("sets"))
    for i, rate in enumerate(RATES_HZ):
        knob = sample(hand_on_knob("half_quantum"), rate, COUNTS)
        found = lists(sets, knob)
        symmetric = sum(n == 2 * inside and (upper, lower) == (0, -1) for n, inside, upper, lower in found.listed)
        apart = len(found.listed) - symmetric
        assert [int(row[i]) for row in printed[:4]] == [
            symmetric,
            apart,
            found.others,
            len(found.listed) + found.others,
        ]
        (latest,) = tsypkin(Relay(knob.loop.alpha, knob.loop.beta, 1.0, 1.0))
        assert agrees(printed[4][i], 2.0 * pi / latest.omega)


def test_the_readme_has_the_table_of_the_page() -> None:
    assert table("../README.md", "from every start:") == [
        [cell.replace("**", "") for cell in row] for row in table(PAGE, "where that differs:")
    ]


@pytest.mark.long
def test_the_grid_from_one_start_and_from_every_start() -> None:
    """How many cycles, and the largest in mrad."""
    rows = table("../README.md", "from every start:")
    before = swept(EXPERIMENTS / "hand_on_knob.yaml", "starts={angle: 0.02, phases: 64}")
    after = swept(EXPERIMENTS / "every_start.yaml")
    assert all(after.cells["complete"].to_pylist())
    told: list[list[str]] = []
    for one in (before, after):
        cells = one.cells.select(["sample_rate_hz", "counts_per_rev", "p2p_max_rad"]).to_pylist()
        counted = one.orbits.group_by(["sample_rate_hz", "counts_per_rev"]).aggregate([([], "count_all")]).to_pylist()
        number = {(row["sample_rate_hz"], row["counts_per_rev"]): row["count_all"] for row in counted}
        told.append(
            [
                f"{number[cell['sample_rate_hz'], cell['counts_per_rev']]}; {1e3 * cell['p2p_max_rad']:.3g}"
                for cell in cells
            ]
        )
    printed = [cell for row in rows for cell in row[1:]]
    for cell, *numbers in zip(printed, *told, strict=True):
        for part, ends in zip(cell.split("; "), zip(*(one.split("; ") for one in numbers), strict=True), strict=True):
            assert part.split(" → ") == list(dict.fromkeys(ends))
