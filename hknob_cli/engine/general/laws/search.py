"""What the trials of a cell under a law settle to: `general.search.GeneralEngine` with the law's own loop."""

from collections.abc import Callable
from typing import Any

import numpy as np

from hknob_cli.engine.attractors import USUAL, Attractor, Patience, Search
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.laws import chart, kinds, trials
from hknob_cli.engine.general.laws.law import Law
from hknob_cli.engine.general.search import GeneralEngine, PeriodSegments


class LawEngine(GeneralEngine):
    """The general loop under a law, plain or compiled; one per thread."""

    def __init__(
        self,
        functions: dict[str, Callable[..., Any]] | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patience: Patience = USUAL,
    ) -> None:
        """Make ready; as `GeneralEngine`."""
        super().__init__(functions, stopped, patience)
        found = functions or {}
        self._trials: Callable[..., Any] = found.get("general.laws.run_trials_with_law", trials.run_trials_with_law)
        self._pieces: Callable[..., Any] = found.get("general.laws.chart_with_law", chart.chart_with_law)

    def ready(self, law: Law) -> Law:
        """The law as the loop wants it: its function by name becomes one that can be called, its numbers arrays."""
        if not self.compiled:
            return law._replace(act=getattr(kinds, law.act))
        from hknob_cli.engine.jit import compiled_law

        filled = (np.array(value, dtype=np.float64) if isinstance(value, list) else value for value in law)
        return Law._make(filled)._replace(act=compiled_law(law.act))

    def settle(self, body: Body, wall: Controller, law: Law, start: list[float], **given: Any) -> Search:
        """Run trials from ``start`` and name what they settle to; as `GeneralEngine.search`, whose keys these are."""
        acting = self.ready(law)

        def run(*values: Any) -> Any:
            *search, ready, known, space, z, past, check, checkpast, keep, keeppast = values
            work = (z, past, check, checkpast, keep, keeppast)
            return self._trials(*search, ready, known, acting, space, *work)

        self._run_trials = run
        return self.search(body, wall, start, delay_line=len(law.beside), **given)

    def chart_period(self, body: Body, wall: Controller, law: Law, orbit: Attractor) -> PeriodSegments | None:
        """One period of an orbit from event to event; None if it has too many pieces."""
        acting = self.ready(law)

        def write(state: Any, before: float, past: Any, head: int, period: int, ready: Body, *rest: Any) -> Any:
            del before, head
            known, pad, *room = rest
            return self._pieces(state, past, period, ready, known, acting, pad, *room)

        self._chart = write
        return self.chart(body, wall, orbit)
