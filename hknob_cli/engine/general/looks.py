"""Looks at a trial while it is followed: whether it comes back to a checkpoint, is at rest, or acts alike for ever.

A checkpoint is a state at an event (the wall steps deeper), and moves on after 1, 2, 4, ... events: Brent's cycle
finding. When a trial comes back to it, the samples in between are a candidate period.
"""

from typing import NamedTuple

from hknob_cli.engine.certificate import PROVEN
from hknob_cli.engine.follow import (
    FIRST_REST_TEST,
    LEFT,
    REST_EDGE,
    REST_PROVEN,
    UNDAMPED,
    UNSETTLED,
)
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.controller import read_after
from hknob_cli.engine.general.inner_region import stands
from hknob_cli.engine.general.interval import jitters
from hknob_cli.engine.general.orbit_proof import certify
from hknob_cli.engine.general.standstill import SETTLING, is_followed, settles
from hknob_cli.engine.rest import AT_REST, LEAVES, MOVING, REST_ON_EDGE, RINGS


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


GOES_ON = -1  # no fate yet


class Looks(NamedTuple):
    """What looks at rest have found since a trial acts alike.

    ``due``: samples that it takes until the next; ``on_edge``: whether the last found it at rest on an edge;
    ``settling``: whether one found that its reading never changes, and that friction brings it to rest.
    """

    due: int
    on_edge: bool
    settling: bool


def no_looks():
    """None has been taken."""
    return Looks(FIRST_REST_TEST, False, False)


def unsettled(body):
    """Fate of a trial that has come to nothing: it may yet, where something damps it."""
    return UNSETTLED if body.damped else UNDAMPED


def contracts_to_rest(trial, shown, before, head, body, wall):
    """Whether the loop of a continuous sensor, whose intervals are alike, is proven to bring a trial to rest.

    Then its state and delay line are left as they are there.
    """
    z, ring, space = trial.z, trial.ring, trial.space
    if not is_followed(shown, wall) or jitters(wall.clock):
        return False
    status, _, _, _, _ = certify(z, before, ring, head, 1, body, wall, space)
    if status != PROVEN:
        return False
    copy_to(z, space.orbit)
    z[1] = 0.0
    copy_to(ring, space.orbit_line)
    return True


def look_at_rest(trial, shown, before, head, body, wall):
    """What becomes of a trial that may come to rest: ``(fate, reading, settling)``; at rest it is left there.

    `UNSETTLED` if nothing is known; ``settling``: whether its reading never changes, and friction brings it to rest.
    """
    z, ring, space = trial.z, trial.ring, trial.space
    fate, _ = settles(z, shown, before, ring, body, wall, space.orbit, space.away)
    settling = fate == SETTLING
    if fate == AT_REST or (settling and stands(z, before, ring, head, body, wall, space)):
        copy_to(z, space.orbit)
        return REST_PROVEN, shown if wall.hysteresis > 0.0 else before, settling
    if fate == MOVING and contracts_to_rest(trial, shown, before, head, body, wall):
        return REST_PROVEN, z[0], settling
    if fate == LEAVES:
        return LEFT, before, settling
    if fate == RINGS:
        return UNDAMPED, before, settling
    return REST_EDGE if fate == REST_ON_EDGE else UNSETTLED, before, settling


def go_on(run, looks, fate, settling):
    """What a look after ``run`` samples has come to: ``(fate, period, looks)``, `GOES_ON` if to no end."""
    looks = Looks(2 * run, fate == REST_EDGE, looks.settling or settling)
    if fate == REST_EDGE or fate == UNSETTLED:
        return GOES_ON, 0, looks
    return fate, (1 if fate == REST_PROVEN else 0), looks


def look_again(run, looks, trial, shown, before, head, body, wall):
    """Look at rest after ``run`` samples that act alike: ``(fate, period, reading, looks)``."""
    fate, reading, settling = look_at_rest(trial, shown, before, head, body, wall)
    fate, period, looks = go_on(run, looks, fate, settling)
    return fate, period, reading, looks


def last_look(trial, shown, before, head, body, wall, looks):
    """What a trial has come to that gets no more samples: ``(fate, period, reading)``; as `look_at_rest`.

    Looks grow rare: without one more, the share at rest could fall when the limit is raised.
    """
    z, ring, space = trial.z, trial.ring, trial.space
    if not looks.on_edge:
        shown = read_after(z[0], before, wall)
    fate, _ = settles(z, shown, before, ring, body, wall, space.orbit, space.away)
    if looks.on_edge:
        if fate == REST_ON_EDGE:
            copy_to(z, space.orbit)
        return REST_EDGE, 1, before
    if looks.settling or fate == SETTLING or fate == AT_REST:
        copy_to(z, space.orbit)
        return REST_PROVEN, 1, shown if wall.hysteresis > 0.0 else before
    if fate == MOVING and contracts_to_rest(trial, shown, before, head, body, wall):
        return REST_PROVEN, 1, z[0]
    return unsettled(body), 0, before
