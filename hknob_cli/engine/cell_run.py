"""Attractors of a run of cells, by compiled code: its work space, and its results as columns."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.attractors import CAPACITY, FATES, LANES, SLICE, StoppedError
from hknob_cli.engine.cells import FIELD, FIELDS, MEASURES, NUMBERS, UNMEASURED, Asked, Room
from hknob_cli.engine.orbit_cycle import CycleMeasures
from hknob_cli.engine.orbit_holds import PART, Holds
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets.cells import TOLD, ArcWork
from hknob_cli.engine.sets.room import ENDS, make_arc_room, make_known

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

MOST_PHASES = SLICE  # more trials a cell would leave no chance to be interrupted
SAMPLES = 10_000_000  # trial-samples between two chances to be interrupted, a fraction of a second
HOLDS = 65_536  # of a period, to begin with
ROWS = 4096  # of attractors between two returns from compiled code, or more where one cell may have more

END_OF = {**FATES, UNMEASURED: (Outcome.UNDECIDED, Reason.TOO_LONG)}
OUTCOME_OF, REASON_OF = np.full(max(END_OF) + 1, -1), np.full(max(END_OF) + 1, -1)
for _fate, (_outcome, _reason) in END_OF.items():
    OUTCOME_OF[_fate], REASON_OF[_fate] = _outcome, _reason


class Ends(NamedTuple):
    """Attractors of a run of cells, those of a cell together and ranked; arrays with one entry each.

    ``cell``: number within the run; ``outcome``, ``reason``: codes of `engine.outcome`; the rest as in `Attractor`, and
    ``measures`` NaN where nothing is measured, of a rest point its position and 0.
    """

    cell: Whole
    outcome: Whole
    reason: Whole
    trials: Array
    period: Whole
    edge: Array
    closure: Array
    measures: CycleMeasures


class FollowedCells(NamedTuple):
    """Of every cell of a run: whether its list is complete, and how many arcs were followed; no entries if sampled.

    ``share_error``: a bound on the error of a share; NaN where phases are sampled.
    """

    complete: NDArray[np.bool_]
    pieces: Whole
    share_error: Array


def run_cells(
    cells: Array,
    *,
    sense: float,
    phases: int,
    max_samples: int | None,
    functions: Mapping[str, Callable[..., Any]],
    stopped: Callable[[], bool] = lambda: False,
    sampled: bool = True,
) -> tuple[Ends, FollowedCells, int]:
    """Attractors of all ``cells``, how completely they are known, and the trial-samples they took.

    Args:
        cells: Numbers of each, `engine.cells.NUMBERS`, shape (n, 9).
        sense: Of the encoder, `engine.loop.Loop`.
        phases: Trials of a cell, at most `MOST_PHASES`.
        max_samples: That a trial may take; None: by the plant's slowest mode.
        functions: The compiled group "cells", or "arc_cells" where phases are not sampled.
        stopped: Asked every fraction of a second whether to give up.
        sampled: Whether ``phases`` are meant, not all of them; they are sampled also where all cannot be followed.

    Raises `StoppedError` when told to stop.
    """
    numbers = np.ascontiguousarray(cells, dtype=np.float64)
    longest_line = int(numbers[:, NUMBERS.index("delay_line")].max()) if len(numbers) else 0
    kept = min(CAPACITY, phases)
    room = _room(phases, longest_line, kept + 1 if sampled else ENDS + 2)
    told = np.zeros((0 if sampled else len(numbers), TOLD))
    run = "run_cells"
    work: tuple[ArcWork, ...] = ()
    if not sampled:
        arcs, known = make_arc_room(np.zeros, longest_line), make_known(np.zeros, longest_line)
        known = known._replace(table=room.table[: 10 * (ENDS + 1)], lines=room.lines)
        run, work = "sets.run_arc_cells", (ArcWork(arcs, known, told.reshape(-1), kept),)
    out = np.empty(FIELD * max(ROWS, 2 * len(room.order)))
    asked = Asked(sense, phases, max_samples or 0, SAMPLES)
    found: list[Array] = []
    at = taken = 0
    while at < len(numbers):
        if stopped():
            raise StoppedError
        at, rows, samples, holds = functions[run](numbers.ravel(), at, len(numbers), asked, *work, room, out)
        found.append(out[: FIELD * rows].reshape(rows, FIELD).copy())
        taken += samples
        if holds:
            room = room._replace(holds=_holds(2 * holds))
    followed = FollowedCells(complete=told[:, 0] > 0.0, pieces=told[:, 1].astype(np.int64), share_error=told[:, 2])
    return _columns(np.concatenate(found) if found else np.empty((0, FIELD))), followed, taken


def _room(phases: int, line: int, rows: int) -> Room:
    """Work space for cells with delay lines of up to ``line`` commands, and ``rows`` ends at most."""
    lanes = min(LANES, phases)
    return Room(
        x=np.zeros(lanes),
        v=np.zeros(lanes),
        line=np.zeros(lanes * line),
        ring=np.zeros(line),
        table=np.zeros(10 * rows),
        lines=np.zeros(max(1, rows * line)),
        order=np.zeros(rows),
        parts=np.zeros(2 * PART),
        outcome_of=OUTCOME_OF.astype(np.float64),
        holds=_holds(HOLDS),
    )


def _holds(count: int) -> Holds:
    return Holds(np.empty(count + 1), np.empty(count + 1), np.empty(count))


def _columns(rows: Array) -> Ends:
    column = dict(zip(FIELDS, rows.T, strict=True))
    whole = {name: column[name].astype(np.int64) for name in ("cell", "fate", "period")}
    return Ends(
        cell=whole["cell"],
        outcome=OUTCOME_OF[whole["fate"]],
        reason=REASON_OF[whole["fate"]],
        trials=column["trials"],
        period=whole["period"],
        edge=column["edge"],
        closure=column["closure"],
        measures=CycleMeasures(*(column[name] for name in FIELDS[MEASURES:])),
    )
