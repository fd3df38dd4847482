"""What the trials of a cell under a law settle to: `general.search.GeneralEngine` with the law's own loop."""

from collections.abc import Callable
from math import inf, nan
from typing import Any

import numpy as np

from hknob_cli.engine.attractors import USUAL, Patience
from hknob_cli.engine.budget import TrialBudget
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.ensemble import Batch, TrialSpace
from hknob_cli.engine.general.laws import sensed, step, trials
from hknob_cli.engine.general.laws.law import Law
from hknob_cli.engine.general.search import GeneralEngine, as_compiled
from hknob_cli.engine.general.torque_range import TorqueRange, torque_range


class LawEngine(GeneralEngine):
    """The general loop of one cell under its ``law``, plain or compiled; used as a `GeneralEngine` is.

    Its searches want ``delay_line`` to be `past_length`; an attractor's ``line`` is all that is remembered there.
    """

    def __init__(
        self,
        law: Law,
        functions: dict[str, Callable[..., Any]] | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patience: Patience = USUAL,
    ) -> None:
        """Make ready; ``functions``: compiled, by name, as `GeneralEngine` has them."""
        super().__init__(functions, stopped, patience)
        found = functions or {}
        self._law = self._ready(law)
        self._trials: Callable[..., Any] = found.get("general.laws.run_trials_with_law", trials.run_trials_with_law)
        self._pieces: Callable[..., Any] = found.get("general.laws.chart_with_law", step.chart_with_law)
        self._rate: Callable[..., Any] = found.get("general.laws.parting_with_law", sensed.parting_with_law)
        self._run_trials = self._run_with_law
        self._part = self._part_with_law
        self._chart = self._chart_with_law

    @property
    def law(self) -> Law:
        """The law as the loop has it, with room to work in."""
        return self._law

    @property
    def past_length(self) -> int:
        """How many numbers are remembered."""
        return len(self._law.beside)

    @staticmethod
    def torques(wall: Controller) -> TorqueRange:
        """As `GeneralEngine.torques`: beside a torque over the angle the law may command any."""
        over = torque_range(wall)
        return over if wall.table is None and wall.curve is None else over._replace(least=-inf, most=inf)

    def _ready(self, law: Law) -> Law:
        """The law as the loop wants it: compiled, its numbers arrays."""
        if not self.compiled:
            return law
        from hknob_cli.engine.jit import compiled_law

        filled = (np.array(value, dtype=np.float64) if isinstance(value, list) else value for value in law)
        return Law._make(filled)._replace(act=compiled_law(law.act))

    def law_beside(self, body: Any) -> Law:
        """The law, the wall that it watches with the same parts as the loop's."""
        if not self.compiled:
            return self._law
        return self._law._replace(watch=as_compiled(body, self._law.watch)[1])

    def _run_with_law(
        self, start: Any, batch: Batch, budget: TrialBudget, trial: TrialSpace, body: Any, wall: Any
    ) -> Any:
        return self._trials(start, batch, budget, trial, body, wall, self.law_beside(body))

    def _part_with_law(
        self, state: Any, before: float, past: Any, samples: int, body: Any, wall: Any, space: Any
    ) -> float:
        del before
        if wall.analog > 0.0:
            return nan  # what a law remembers of a continuous sensor's readings parts, too
        return float(self._rate(state, past, samples, body, wall, self.law_beside(body), space))

    def _chart_with_law(
        self, state: Any, before: float, past: Any, period: int, body: Any, wall: Any, *rest: Any
    ) -> Any:
        del before
        return self._pieces(state, past, period, body, wall, self.law_beside(body), *rest)
