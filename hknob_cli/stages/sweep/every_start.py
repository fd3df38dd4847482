"""All starts of a cell of a sweep at once: to the engine that follows them as sets."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.attractors import Attractor, NeedsCompilerError, Patience, Search
from hknob_cli.engine.outcome import WORDS, Reason
from hknob_cli.scene.plain_knob import SampledKnob
from hknob_cli.specs.plan import Starts, SweepPlan

if TYPE_CHECKING:
    from hknob_cli.controllers.scalar_law import LawKnob
    from hknob_cli.engine.general.laws.search import LawEngine
    from hknob_cli.scene.general_knob import GeneralKnob

INCOMPLETE = [
    *(WORDS[reason] for reason in Reason),
    "clock phases were sampled: sets of states are not followed in such a scene, or not to their end",
    "random starts were simulated: sets of states are not followed in such a scene, or not to their end",
]
SOME_PHASES, SOME_STARTS = len(Reason), len(Reason) + 1


class StartsFinder:
    """Finds what all starts of cells settle to; has the engines, plain or compiled, that they need. One per thread."""

    def __init__(
        self,
        functions: dict[str, dict[str, Callable[..., Any]]],
        stopped: Callable[[], bool],
        patience: Callable[[str], Patience],
    ) -> None:
        """Make ready; arguments as those of `stages.sweep.cell.CellFinder`."""
        self.functions = functions
        self.stopped = stopped
        self.patience = patience
        self._plain: Any = None
        self._general: Any = None

    def search_plain(self, plan: SweepPlan, knob: SampledKnob) -> Search | None:
        """What all starts of a plain cell settle to; None where they cannot be followed all at once."""
        from hknob_cli.engine.sets.search import SetEngine

        functions = self.functions.get("sets")
        if self._plain is None:
            self._plain = SetEngine(functions, self.stopped)
        self._plain.patience = self.patience("sets")
        starts = plan.starts
        given: dict[str, Any] = {"max_samples": plan.max_samples, "seconds": plan.seconds_per_cell}
        if not starts.many:
            at = {"x": knob.position(starts.angle), "v": knob.speed(starts.velocity)}
            try:
                found: Search | None = self._plain.search_phases(knob.loop, **at, delay_line=knob.delay_line, **given)
            except NeedsCompilerError:
                raise NeedsCompilerError("sets") from None
            return found
        if functions is None:
            raise NeedsCompilerError("sets")
        if starts.anywhere:
            every: Search = self._plain.search_anywhere(knob.loop, **given)
            return every
        boxed: Search = self._plain.search_box(knob.loop, _box(plan, knob), **given)
        return boxed

    def search_general(self, plan: SweepPlan, knob: "GeneralKnob", group: str) -> Search | None:
        """What all starts of a cell of the general loop settle to; None where they cannot be followed all at once.

        ``group``: of engine functions, with or without friction.
        """
        from hknob_cli.engine.general.sets.cog_search import CogSetEngine
        from hknob_cli.engine.general.sets.friction_arc_search import FrictionArcEngine
        from hknob_cli.engine.general.sets.friction_search import FrictionSetEngine
        from hknob_cli.engine.general.sets.search import GeneralSetEngine

        functions = self.functions.get(group)
        kinds: dict[str, Callable[..., Any]] = {
            "friction sets": FrictionSetEngine,
            "friction arcs": FrictionArcEngine,
            "cogging sets": CogSetEngine,
        }
        kind = kinds.get(group, GeneralSetEngine)
        if type(self._general) is not kind:
            self._general = kind(functions=functions, stopped=self.stopped)
        self._general.patience = self.patience(group)
        return _search_sets(self._general, plan, knob, group, rate=knob.rate, memory=knob.delay_line)

    def search_law(self, plan: SweepPlan, made: "LawKnob", engine: "LawEngine", group: str) -> Search | None:
        """The same of a cell under a controller, whose trials ``engine`` follows.

        None, too, where sets take more work than a cell may: trials then tell more than sets that are given up.
        """
        from hknob_cli.engine.general.sets.friction_arc_search import FrictionArcEngine
        from hknob_cli.engine.general.sets.law_search import LawSetEngine, LawStatesEngine

        kinds: dict[str, Callable[..., Any]] = {"friction sets": LawSetEngine, "friction arcs": FrictionArcEngine}
        sets = kinds.get(group, LawStatesEngine)(
            engine.law, self.functions.get(group), self.stopped, self.patience(group)
        )
        found = _search_sets(sets, plan, made.knob, group, rate=made.rate, memory=engine.past_length)
        return None if found is not None and found.why is Reason.WORK_LIMIT else found


def _search_sets(
    engine: Any, plan: SweepPlan, knob: "GeneralKnob", group: str, *, rate: float, memory: int
) -> Search | None:
    starts = plan.starts
    given: dict[str, Any] = {
        "rate": rate,
        "delay_line": memory,
        "max_samples": plan.max_samples,
        "seconds": plan.seconds_per_cell,
    }
    found: Search | None
    if starts.anywhere and engine.compiled:
        found = engine.search_anywhere(knob.body, knob.wall, **given)
    elif not starts.many:
        found = engine.search_phases(knob.body, knob.wall, knob.start(starts.angle, starts.velocity), **given)
    elif not engine.able(knob.body, knob.wall):
        found = None
    elif not engine.compiled:
        raise NeedsCompilerError(group)
    else:
        found = engine.search_box(knob.body, knob.wall, _box(plan, knob), **given)
    return found


def _box(plan: SweepPlan, knob: Any) -> Any:
    """The ranges of a sweep's starts, in counts and counts per sample of a cell."""
    from hknob_cli.engine.sets.search import Box

    assert plan.starts.span
    low, high, slowest, fastest = plan.starts.span
    return Box(knob.position(low), knob.position(high), knob.speed(slowest), knob.speed(fastest))


def why_open(attractors: Sequence[Attractor]) -> Reason:
    """Why starts have no proven end, where a search does not tell: as most of those that are listed without one."""
    return next((one.reason for one in attractors if not one.certified), Reason.NO_REPEAT)


def why_incomplete(complete: Any, pieces: Any, why: Any, starts: Starts) -> NDArray[np.int64]:
    """Why most of the starts of each cell that have no proven end have none, as numbers of `INCOMPLETE`.

    Args:
        complete: Whether all starts have one, (n,).
        pieces: Sets of starts that were followed, (n,); 0 where starts are sampled.
        why: `engine.outcome.Reason` of those that were followed, (n,).
        starts: Of the sweep.
    """
    sampled = SOME_STARTS if starts.span else SOME_PHASES
    unknown = np.where(np.asarray(pieces) == 0, sampled, Reason.NO_REPEAT)
    found = np.where(np.asarray(why) == Reason.NONE, unknown, why)
    return np.where(np.asarray(complete, dtype=bool), Reason.NONE, found).astype(np.int64)
