"""The average of a first-order hold, by extrapolation of the wall's torque, with or without correction of its error.

Ellis, Sarkar & Jenkins (1996, 1997), as the dissertation describes it (Sections 6.2, 10.4): the torque of the next
sample is extrapolated from the last two, and the mean of now and then is held; what the last mean missed is added.
"""

from hknob_cli.controllers.controller import Action, Plain, Reading
from hknob_cli.controllers.plant_batch import Array
from hknob_cli.specs.controller import Controller


class FirstOrderHold(Plain):
    """Mean of this torque and the next one extrapolated; ``correct``: what the last prediction missed is added."""

    rows = 2
    counted: tuple[int, ...] = (0, 1)

    def __init__(self, *, correct: bool) -> None:
        self.correct = correct

    @classmethod
    def of(cls, plan: Controller) -> "FirstOrderHold":
        """With the numbers of a spec."""
        return cls(correct=plan.correct)

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """Torque from the last three of the wall."""
        del fixed
        now, before, earlier = reading.depth, memory[0], memory[1]
        torque = 1.5 * now - 0.5 * before
        if self.correct:
            torque = torque + 0.5 * (now + before) - (1.5 * before - 0.5 * earlier)
        memory = memory.copy()
        memory[0], memory[1] = now, before
        return Action((torque,), memory)
