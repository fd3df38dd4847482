"""Tests of `engine.general.sets.search`: complete only where it is, and why not; given up when told."""

from typing import Any

import pytest

from hknob_cli.engine.attractors import NeedsCompilerError, Patience, StoppedError
from hknob_cli.engine.general.sets.scope import can_follow
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.engine.outcome import Reason
from hknob_cli.scene.general_knob import GeneralKnob
from tests.engine.general.bodies import knob

from .cells import FREE, KINDS, cell


def search(engine: GeneralSetEngine, knob: GeneralKnob, **more: Any) -> Any:
    """What every clock phase of a start settles to."""
    given = {"rate": knob.rate, "delay_line": knob.delay_line, "max_samples": None, **more}
    return engine.search_phases(knob.body, knob.wall, knob.start(0.02, 0.0), **given)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_every_phase_has_a_proven_end(kind: str) -> None:
    """The list is complete, the shares are all there is, and every attractor is proven."""
    found = search(GeneralSetEngine(), cell(kind))
    assert found.complete
    assert found.why is Reason.NONE
    assert all(one.certified for one in found.attractors)
    assert sum(one.trials for one in found.attractors) == pytest.approx(1.0, abs=1e-12)


def test_few_samples_leave_phases_undecided() -> None:
    """A budget that no motion settles within: it says so, and nothing is complete."""
    found = search(GeneralSetEngine(), cell("lag"), max_samples=10)
    assert not found.complete
    assert found.why is Reason.NO_REPEAT
    assert sum(one.trials for one in found.attractors) == pytest.approx(1.0)


def test_no_time_means_undecided_and_says_so() -> None:
    """The phases that were still under way are counted, with the limit as their reason."""
    found = search(GeneralSetEngine(), cell("finger"), seconds=0.0)
    assert not found.complete
    assert found.why is Reason.TIME_LIMIT


def test_what_takes_long_in_the_interpreter_asks_for_the_compiler() -> None:
    """And is given up when told."""
    with pytest.raises(NeedsCompilerError):
        search(GeneralSetEngine(patience=Patience(seconds=0.0)), cell("finger"))
    with pytest.raises(StoppedError):
        search(GeneralSetEngine(stopped=lambda: True), cell("finger"))


def test_what_sets_are_not_followed_of() -> None:
    """Friction, a continuous sensor, and what nothing holds or damps."""
    assert can_follow(cell("finger").body, cell("finger").wall)
    for other in (
        knob(),
        knob(knob=FREE, counts=None, encoder="none"),
        knob(knob=FREE, hand={"damping": 3e-4}),
        knob(knob=FREE, hand={"stiffness": 0.04}),
    ):
        assert not can_follow(other.body, other.wall)
        assert search(GeneralSetEngine(), other) is None
