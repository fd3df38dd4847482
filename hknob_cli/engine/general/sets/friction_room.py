"""Numbers and work space by which sets of states with Coulomb friction are followed. Not compiled."""

from collections.abc import Callable
from math import inf, sqrt
from typing import Any, NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.laws.law import LOOK as LAW_LOOK
from hknob_cli.engine.general.laws.law import PIECE, Law
from hknob_cli.engine.general.laws.law import SPAN as LAW_SPAN
from hknob_cli.engine.general.laws.law import TORQUE as LAW_TORQUE
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.friction_piece import LEG, MOST, SET, SETS, SETS_LOOKED
from hknob_cli.engine.general.sets.friction_step import parts_of_hold
from hknob_cli.engine.general.sets.readings import deepest_level
from hknob_cli.engine.general.slide_two import coefficients

ROUNDED = 256.0  # units in the last place of all terms of a motion over one part of an interval
LEAST = 1e-10  # counts: a set of less radius is not cut where its motion is not smooth


class FrictionRoom(NamedTuple):
    """Work space of `friction_piece`.

    ``course``: parts of an interval, `friction_piece.LEG` numbers each; ``least[0]``: radius below which sets are not
    cut within it; ``torques``: of an interval; ``law``: of a controller, or None; ``sets``: that wait within an
    interval; ``seen``: what one has read within it; the others: of one set.
    """

    course: Any
    least: Any
    sets: Any
    seen: Any
    corners: Any
    one: Any
    other: Any
    space: Any
    line: Any
    z: Any
    ring: Any
    torques: Any
    law: Any = None


def can_rub(body: Body, wall: Controller, law: Law | None = None) -> bool:
    """Whether sets of states can be followed interval by interval: knob and hand, held by a spring, and an encoder.

    There is friction, or a law that is proven and feels no speed.
    """
    plane = body.order == 2 and body.damped and body.reach < inf and wall.analog == 0.0
    known = law is not None and law.provable and not law.senses
    told = body.friction > 0.0 if law is None else known
    return plane and told and bool(_course(body, wall, law))


def _course(body: Body, wall: Controller, law: Law | None) -> list[float]:
    """Parts of an interval: which torque acts, span, the plant's coefficients, and a look; empty: too many."""
    course: list[float] = []
    holds = [(0.0, wall.split, -1.0), (1.0, 1.0 - wall.split, -1.0)]
    if law is not None:
        starts, first = range(0, law.pieces * PIECE, PIECE), float(law.rows + 1)
        looks = [law.sched[at + LAW_LOOK] for at in starts]
        looks = [look - first if look >= 0.0 else -1.0 for look in looks]
        holds = [
            (law.sched[at + LAW_TORQUE], law.sched[at + LAW_SPAN], look) for at, look in zip(starts, looks, strict=True)
        ]
    for torque, span, look in holds:
        if span > 0.0:
            n = parts_of_hold(span, body)
            if n == 0:
                return []
            part = [torque, span / n, *coefficients(span / n, body)]
            course += [*((n - 1) * [*part, -1.0]), *part, look]
    return course


def make_friction_room(
    zeros: Callable[[int], Any],
    filled: Callable[[list[float]], Any],
    delay: int,
    body: Body,
    wall: Controller,
    law: Law | None = None,
) -> FrictionRoom:
    """Work space for a cell with ``delay`` commands under way, or numbers that the law remembers."""
    looks = 0 if law is None else law.looks
    return FrictionRoom(
        course=filled(_course(body, wall, law)),
        least=filled([LEAST]),
        sets=zeros((SET + looks) * (SETS_LOOKED if looks else SETS)),
        seen=zeros(looks),
        corners=zeros(2 * (4 * MOST + 2)),
        one=zeros(2 * MOST),
        other=zeros(2 * MOST),
        space=zeros(2 * (4 * MOST + 2)),
        line=zeros(3),
        z=zeros(2),
        ring=zeros(delay),
        torques=zeros(max(2, delay)),
        law=law,
    )


def friction_drift(body: Body, wall: Controller, law: Law | None = None) -> Drift:
    """Bounds on the roundings of one interval, in lists: of a centre, and of the corners relative to it.

    Each part of an interval rounds position, velocity and pull a few times, and the time of a stop; what that moves is
    of the same size.
    """
    parts = len(_course(body, wall, law)) // LEG
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
        bottom=deepest_level(wall) if law is None else -inf,
    )
