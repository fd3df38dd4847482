"""Numbers and work space by which sets of states with Coulomb friction are followed. Not compiled."""

from collections.abc import Callable
from math import inf, sqrt
from typing import Any, NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.friction_piece import MOST, SET, SETS
from hknob_cli.engine.general.sets.friction_step import parts_of_hold
from hknob_cli.engine.general.sets.readings import deepest_level
from hknob_cli.engine.general.slide_two import coefficients

ROUNDED = 256.0  # units in the last place of all terms of a motion over one part of an interval
LEAST = 1e-10  # counts: a set of less radius is not cut where its motion is not smooth


class FrictionRoom(NamedTuple):
    """Work space of `friction_piece`.

    ``course``: parts of an interval, `friction_piece.LEG` numbers each; ``least[0]``: radius below which sets are not
    cut within it; ``sets``: that wait within an interval; the others: of one set.
    """

    course: Any
    least: Any
    sets: Any
    corners: Any
    one: Any
    other: Any
    space: Any
    line: Any
    z: Any
    ring: Any


def can_rub(body: Body, wall: Controller) -> bool:
    """Whether sets of states with friction can be followed: knob and hand, held by a spring, and an encoder."""
    plane = body.order == 2 and body.friction > 0.0 and body.reach < inf and wall.analog == 0.0
    return plane and bool(_course(body, wall))


def _course(body: Body, wall: Controller) -> list[float]:
    """Parts of an interval: whether under the newer command, span, and the plant's coefficients; empty: too many."""
    course: list[float] = []
    for newer, span in ((0.0, wall.split), (1.0, 1.0 - wall.split)):
        if span > 0.0:
            n = parts_of_hold(span, body)
            if n == 0:
                return []
            course += n * [newer, span / n, *coefficients(span / n, body)]
    return course


def make_friction_room(
    zeros: Callable[[int], Any], filled: Callable[[list[float]], Any], delay: int, body: Body, wall: Controller
) -> FrictionRoom:
    """Work space for a cell with ``delay`` commands under way."""
    return FrictionRoom(
        course=filled(_course(body, wall)),
        least=filled([LEAST]),
        sets=zeros(SET * SETS),
        corners=zeros(2 * (4 * MOST + 2)),
        one=zeros(2 * MOST),
        other=zeros(2 * MOST),
        space=zeros(2 * (4 * MOST + 2)),
        line=zeros(3),
        z=zeros(2),
        ring=zeros(delay),
    )


def friction_drift(body: Body, wall: Controller) -> Drift:
    """Bounds on the roundings of one interval, in lists: of a centre, and of the corners relative to it.

    Each part of an interval rounds position, velocity and pull a few times, and the time of a stop; what that moves is
    of the same size.
    """
    parts = len(_course(body, wall)) // 5
    root = sqrt(body.beta)
    per = ROUNDED * EPSILON * parts
    push = per * (1.0 + root)
    constant = push * (abs(body.drive) + body.friction)
    return Drift(
        powers=[0.0],
        once=[constant, push, per * root + push * body.beta, push],
        units=[root, 1.0],
        blur=ROUNDED * EPSILON * parts,
        coast=0.0,  # of arcs, which are not used
        bottom=deepest_level(wall),
    )
