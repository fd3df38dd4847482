"""Why motions need not come into any region: what is said of a loop that has none, with what moves a region scripted.

It must never sound like a proof: nothing is complete, and every start is undecided, or proven to grow.
"""

from math import inf, nextafter
from typing import Any

import pytest

from hknob_cli.engine.attractors import Attractor, Search
from hknob_cli.engine.loop import make_loop
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets import absorbing
from hknob_cli.engine.sets.absorbing import RegionFinder, pushes
from hknob_cli.engine.sets.room import make_region_room

from .rooms import zeros
from .test_absorbing_margins import LOOP, Script

UNTIL = 5.0  # s on the clock


def why(script: Script, until: float = inf, **changed: float) -> Search:
    """What is said of a loop with these numbers ``changed``."""
    loop = LOOP._replace(**changed)
    return RegionFinder(script.function, make_region_room(zeros), lambda: False).why_none(loop, pushes(loop), until)


def undecided(outcome: Outcome, reason: Reason, **more: Any) -> Search:
    """All starts end as this, and none of them is proven to end in an attractor."""
    end = Attractor(outcome=outcome, reason=reason, trials=1.0)
    return Search((end,), 0, complete=False, undecided=1.0, **more)


@pytest.mark.parametrize(
    ("alpha", "beta", "reason"),
    [
        (0.0, 0.08, Reason.NO_DAMPING),
        (0.3, 0.0, Reason.NO_STIFFNESS),
        (0.0, 0.0, Reason.NO_DAMPING),
        (0.0, 1.0, Reason.NO_DAMPING),
        (1.0, 0.0, Reason.NO_STIFFNESS),
    ],
)
def test_a_loop_that_nothing_brakes_or_holds_is_not_searched(alpha: float, beta: float, reason: Reason) -> None:
    """Nothing has to be moved to see that."""
    script = Script()
    assert why(script, alpha=alpha, beta=beta) == undecided(Outcome.UNDECIDED, reason)
    assert script.squares == []


@pytest.mark.parametrize(("alpha", "beta"), [(0.3, 0.08), (1.0, 0.08), (0.3, 1.0), (1.0, 1.0)])
def test_a_braked_and_held_loop_is_asked_whether_it_grows(alpha: float, beta: float) -> None:
    """Backward in time, with the pushes as they are in the end; what is within the last region may do anything."""
    script = Script(left=4)
    found = why(script, alpha=alpha, beta=beta)
    assert found == undecided(Outcome.DIVERGED, Reason.NONE, why=Reason.LEAVES, grows=(0.0, 6.0, 1.0, 7.0))
    assert all(back for *_, back, _ in script.shrunk)
    assert script.shrunk[-1][4] == pushes(LOOP._replace(alpha=alpha, beta=beta))


@pytest.mark.parametrize(
    ("now", "reason"),
    [
        (0.0, Reason.NO_REGION),
        (nextafter(UNTIL, 0.0), Reason.NO_REGION),
        (UNTIL, Reason.TIME_LIMIT),
        (nextafter(UNTIL, inf), Reason.TIME_LIMIT),
        (99.0, Reason.TIME_LIMIT),
    ],
)
def test_a_search_that_time_ended_does_not_say_that_there_is_none(
    now: float, reason: Reason, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the very moment of the limit, too: nothing is moved any more then."""
    monkeypatch.setattr(absorbing, "monotonic", lambda: now)
    script = Script((4, 4096, 0.9), (4, 4096, inf))
    assert why(script, UNTIL) == undecided(Outcome.UNDECIDED, reason)
    assert (script.shrunk == []) is (reason is Reason.TIME_LIMIT)


def test_growth_is_looked_for_in_the_time_that_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is not told twice as long, and what it found before the end counts."""
    now = [0.0]
    monkeypatch.setattr(absorbing, "monotonic", lambda: now[0])

    class Late(Script):
        def area_of(self, region: Any, count: int) -> float:
            now[0] = UNTIL + 1.0
            return super().area_of(region, count)

    assert why(Late(), UNTIL).why is Reason.LEAVES


def test_a_loop_without_damping_neither_comes_in_nor_grows() -> None:
    """It keeps what it has: no time is one in which all would halve."""
    for alpha, there in ((0.0, False), (1.0, True), (1e-300, True)):
        for way in ("find", "find_growth"):
            script = Script()
            loop = make_loop(alpha, 0.08, 0.5, 0.3, 1.0, 0.0, 0.0)
            assert (script.find(way, loop=loop) is not None) is there
            assert (script.shrunk != []) is there


def test_a_loop_with_a_stiffness_of_1_is_held() -> None:
    script = Script()
    assert script.find(loop=make_loop(1.0, 1.0, 0.5, 0.3, 1.0, 0.0, 0.0)) is not None
