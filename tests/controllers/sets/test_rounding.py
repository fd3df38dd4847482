"""The bound on a centre's rounding, against the same motion at 40 digits under the same torques."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.batch_stepper import BatchStepper
from hknob_cli.controllers.controller import Action
from hknob_cli.controllers.sets.front import step_error
from tests import digits as mp
from tests.controllers.sets.cells import make_cell

# Controller, and scene; the last one's wall all but cancels a push a million times as large as what is left.
CASES: list[tuple[str, dict[str, Any]]] = [
    ("bounded lag", {}),
    ("impulse, timed", {"encoder": {"rounding": "ceil"}}),
    ("damping, differenced", {"bias": {"torque": 1e3}}),
]


@pytest.mark.parametrize(("name", "change"), CASES)
def test_the_error_of_a_centre_is_bounded(name: str, change: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Sample by sample, in the norm of the free plant, and not by more than some thousand times what it is."""
    remedy, batch, _ = make_cell(name, change=change)
    torques: list[list[float]] = []
    act = remedy.act

    def record(*known: Any) -> Action:
        action = act(*known)
        torques.append([float(one[0]) for one in action.torques])
        return action

    monkeypatch.setattr(remedy, "act", record)
    lanes = batch.lanes
    mover = BatchStepper(remedy, lanes)
    state = mover.start(batch.x, batch.v)
    alpha, beta, kappa, gamma = (mp.mpf(float(one[0])) for one in (lanes.alpha, lanes.beta, lanes.kappa, lanes.gamma))
    holds = [mp.expm(mp.matrix([[0, 1, 0], [-beta, -alpha, 1], [0, 0, 0]]) * mp.mpf(part)) for part in remedy.parts]
    exact = mp.matrix([mp.mpf(float(state.x[0])), mp.mpf(float(state.v[0])), 0])
    error, worst = np.zeros(1), 0.0
    for _ in range(300):
        step = mover.step(state)
        error = error + step_error(state, step, lanes.beta, lanes.gamma)
        for hold, torque in zip(holds, torques[-1], strict=True):
            exact[2] = kappa * mp.mpf(torque) - gamma
            exact = hold * exact
        state = step.state
        off_x, off_v = mp.mpf(float(state.x[0])) - exact[0], mp.mpf(float(state.v[0])) - exact[1]
        off = float(mp.sqrt(off_x**2 + off_v**2 / beta))
        assert off <= error[0]
        worst = max(worst, off / float(error[0]))
    assert worst > 1e-4
