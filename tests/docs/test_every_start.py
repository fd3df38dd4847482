"""The numbers of docs/explanation/every_start.md: how many cycles there are at half a count's bias, of what kind."""

from math import pi

from hknob_cli.engine.jit import compiled
from hknob_cli.engine.sets.search import SetEngine
from hknob_cli.theory.relay import Relay, tsypkin
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
