"""What a trial is compared with while it is followed, and which proofs have been tried so far.

A checkpoint is a state at an event (the wall steps deeper), and moves on after 1, 2, 4, ... events: Brent's cycle
finding. When a trial comes back to it, the samples in between are a candidate period.
"""

from typing import NamedTuple

from hknob_cli.engine.general.body import copy_to


class Checkpoint(NamedTuple):
    """The state in ``trial.check``, with ``trial.check_ring``.

    ``head``: where the oldest command is there; ``begun``: event at which it was kept, 0: none is yet; ``events``: so
    many so far; ``due``: the one at which it moves on.
    """

    head: int
    begun: int
    events: int
    due: int


class Attempts(NamedTuple):
    """When a proof is tried next: where a trial comes back to within ``tolerance``, not before sample ``wait``.

    ``left_alone``: returns that were not followed further, because they seemed to be to an orbit known already.
    """

    tolerance: float
    left_alone: int
    wait: int


class Repeat(NamedTuple):
    """What repeats without proof, in ``trial.keep``: its fate and period, the reading before, the head of its line."""

    fate: int
    period: int
    before: float
    head: int


def keep_checkpoint(trial, head, event):
    """The checkpoint where a trial is, kept at this event; the first is 1."""
    copy_to(trial.check, trial.z)
    copy_to(trial.check_ring, trial.ring)
    return Checkpoint(head, event, event, 2 * event)


def pass_event(mark, trial, head):
    """The checkpoint after one more event, at which it moves on to where the trial is if that is due."""
    events = mark.events + 1
    if events == mark.due:
        return keep_checkpoint(trial, head, events)
    return Checkpoint(mark.head, mark.begun, events, mark.due)


def compare_with_checkpoint(trial, body):
    """Leave in ``space.away`` what a trial's state differs by from the checkpoint's."""
    for j in range(body.order):
        trial.space.away[j] = trial.z[j] - trial.check[j]


def leave_at(trial, state, line):
    """Leave a trial at a state of an orbit, with what is under way there."""
    copy_to(trial.z, state)
    copy_to(trial.ring, line)
