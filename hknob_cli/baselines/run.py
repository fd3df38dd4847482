"""One trial by one method: from sample to sample, within a time limit."""

import time
from math import isfinite
from typing import Any, NamedTuple, Protocol

from hknob_cli.baselines.model import Controller
from hknob_cli.specs.plan import BenchScene

PHASE = 0.5  # of the first sample after the start, in sample periods
CALLS_A_LOOK = 64  # right-hand sides between two looks at the clock


class TooSlowError(Exception):
    """The time limit is reached."""


class LostError(Exception):
    """The method cannot go on, or cannot express the scene; the message says why."""


class Deadline:
    """The end of the time that a run may take; counts the right-hand sides it is asked at."""

    def __init__(self, seconds: float) -> None:
        """Allow ``seconds`` from now."""
        self.end = time.process_time() + seconds
        self.calls = 0

    def look(self) -> None:
        """Raise `TooSlowError` if the time is over."""
        if time.process_time() > self.end:
            raise TooSlowError

    def count(self) -> None:
        """Count a right-hand side, and look now and then."""
        self.calls += 1
        if self.calls % CALLS_A_LOOK == 0:
            self.look()


class Motion(NamedTuple):
    """Angles (rad) at the start of every sample interval and at the end of the last; the work they took.

    ``steps``: time steps; ``evaluations``: right-hand sides, None where the method does not say.
    """

    angles: list[Any]
    steps: int | None
    evaluations: int | None


class Integrator(Protocol):
    """A method, ready to move the state of one trial."""

    steps: int

    def hold(self, state: Any, command: Any, duration: Any) -> Any:
        """State after ``duration`` (s) under a constant ``command`` (N·m)."""

    def free(self, state: Any, duration: Any) -> Any:
        """State after ``duration`` (s) under a controller without a sample clock."""


def follow(trial: BenchScene, controller: Controller, integrator: Integrator, state: Any, deadline: Deadline) -> Motion:
    """Run a trial from ``state``, its first number the knob's angle.

    Raises `TooSlowError`, `LostError`, and whatever the method itself raises.
    """
    before = controller.period * controller.number(PHASE)
    nothing = controller.number(0.0)
    sampled = trial.scene.sampled
    state = integrator.hold(state, nothing, before) if sampled else integrator.free(state, before)
    angles = [state[0]]
    for _ in range(trial.samples):
        deadline.look()
        if not isfinite(state[0]):
            raise LostError("the angle is no longer a number")
        if sampled:
            for command, duration in controller.sample(state[0]):
                state = integrator.hold(state, command, duration)
        else:
            state = integrator.free(state, controller.period)
        angles.append(state[0])
    if not isfinite(state[0]):
        raise LostError("the angle is no longer a number")
    return Motion(angles, integrator.steps, deadline.calls or None)
