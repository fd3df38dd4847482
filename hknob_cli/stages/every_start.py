"""All starts of a cell of a sweep at once: to the engine that follows them as sets."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hknob_cli.engine.attractors import NeedsCompilerError, Patience, Search
from hknob_cli.engine.outcome import WORDS, Reason
from hknob_cli.scene.sampled_knob import SampledKnob
from hknob_cli.spec.plan import Starts, SweepPlan

if TYPE_CHECKING:
    from hknob_cli.scene.general_knob import GeneralKnob

SAMPLED = "clock phases were sampled: sets of states are not followed in such a scene"


class StartsFinder:
    """Finds what all starts of cells settle to; has the engines, plain or compiled, that they need. One per thread."""

    def __init__(
        self,
        functions: dict[str, dict[str, Callable[..., Any]]],
        stopped: Callable[[], bool],
        patience: Callable[[str], Patience],
    ) -> None:
        """Make ready; arguments as those of `stages.cell.CellFinder`."""
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
        starts, most = plan.starts, plan.max_samples
        if starts.span is None:
            found: Search | None = self._plain.search_phases(
                knob.loop,
                x=knob.position(starts.angle),
                v=knob.speed(starts.velocity),
                delay_line=knob.delay_line,
                max_samples=most,
            )
            return found
        if functions is None:
            raise NeedsCompilerError("sets")
        seconds = plan.seconds_per_cell
        boxed: Search = self._plain.search_box(knob.loop, _box(plan, knob), max_samples=most, seconds=seconds)
        return boxed

    def search_general(self, plan: SweepPlan, knob: "GeneralKnob", group: str) -> Search | None:
        """What all starts of a cell of the general loop settle to; None where they cannot be followed all at once.

        ``group``: of engine functions, with or without friction.
        """
        from hknob_cli.engine.general.sets.friction_search import FrictionSetEngine
        from hknob_cli.engine.general.sets.search import GeneralSetEngine

        functions = self.functions.get(group)
        kind = FrictionSetEngine if group == "friction sets" else GeneralSetEngine
        if type(self._general) is not kind:
            self._general = kind(functions, self.stopped)
        self._general.patience = self.patience(group)
        starts = plan.starts
        given: dict[str, Any] = {
            "rate": knob.rate,
            "delay_line": knob.delay_line,
            "max_samples": plan.max_samples,
            "seconds": plan.seconds_per_cell,
        }
        if starts.span is None:
            start = knob.start(starts.angle, starts.velocity)
            found: Search | None = self._general.search_phases(knob.body, knob.wall, start, **given)
            return found
        if functions is None:
            raise NeedsCompilerError(group)
        boxed: Search = self._general.search_box(knob.body, knob.wall, _box(plan, knob), **given)
        return boxed


def _box(plan: SweepPlan, knob: Any) -> Any:
    """The ranges of a sweep's starts, in counts and counts per sample of a cell."""
    from hknob_cli.engine.sets.search import Box

    assert plan.starts.span
    low, high, slowest, fastest = plan.starts.span
    return Box(knob.position(low), knob.position(high), knob.speed(slowest), knob.speed(fastest))


def why_incomplete(complete: bool, pieces: int, why: Reason, starts: Starts) -> str:
    """Why most of the starts of a cell that have no proven end have none, in words; empty where all have one."""
    if complete:
        return ""
    if why is Reason.NONE and pieces == 0 and starts.span is None:
        return SAMPLED
    return WORDS[Reason.NO_REPEAT if why is Reason.NONE else why]
