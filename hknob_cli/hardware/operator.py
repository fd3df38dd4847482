"""Who watches a campaign: what is shown of a trial, and what may be wished for while it runs."""

from enum import Enum
from typing import NamedTuple, Protocol

from hknob_cli.hardware.order import Trial

HANDS_OFF = "hands off"  # the state of a trial that has not begun


class Wish(str, Enum):
    """What the operator wants of the trial at hand."""

    GO_ON = "go on"
    END = "end"
    REPEAT = "repeat"
    STOP = "stop"


class View(NamedTuple):
    """What is seen of a trial at an instant: ``state`` in a word; time (s) in it and since the start; forces."""

    trial: Trial
    trials: int
    state: str
    state_s: float = 0.0
    running_s: float = 0.0
    grip_n: float | None = None
    torque_nm: float = 0.0


class Operator(Protocol):
    """Sees a campaign and decides."""

    def ready(self, view: View) -> Wish:
        """Wait until the trial may begin, hands off the knob; `Wish.STOP` ends the campaign."""

    def look(self, view: View) -> Wish:
        """See the trial at hand, and say what to do with it."""


class Nobody:
    """An operator who is not there."""

    def ready(self, _view: View) -> Wish:
        """Begin at once."""
        return Wish.GO_ON

    def look(self, _view: View) -> Wish:
        """Go on."""
        return Wish.GO_ON
