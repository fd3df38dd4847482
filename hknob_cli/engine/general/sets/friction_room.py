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
from hknob_cli.engine.general.sets.drift import POINT, Drift, exponential, product, whole_matrix
from hknob_cli.engine.general.sets.friction_set import ACTS, LEG, MOST, SET, SETS, SETS_LOOKED
from hknob_cli.engine.general.sets.friction_step import parts_of_hold
from hknob_cli.engine.general.sets.lagged_step import DEEPEST
from hknob_cli.engine.general.sets.lagged_stops import LAGS
from hknob_cli.engine.general.sets.readings import deepest_level
from hknob_cli.engine.general.slide_two import coefficients
from hknob_cli.engine.turning import zero_spacing

ROUNDED = 256.0  # units in the last place of all terms of a motion over one part of an interval
LEAST = 1e-10  # counts: a set of less radius is not cut where its motion is not smooth


class FrictionRoom(NamedTuple):
    """Work space of `friction_piece`.

    ``course``: parts of an interval, `friction_piece.LEG` numbers each; ``least[0]``: radius below which sets are not
    cut within it; ``torques``: of an interval; ``sets``: that wait within an interval; ``seen``: what one has read
    within it. With a lag ``acts``: the torque of one; ``plane``: the body without
    lag; ``lags``: halves, and halves of these, of each length that a part has, `lagged_stops.LAGS` numbers each, and
    ``halves``: where those of each part begin. Without a lag ``lags`` is None. The others: of one set.
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
    acts: Any
    plane: Body
    lags: Any
    halves: Any
    lag: Any
    moved: Any
    pad: Any


def plane_of(body: Body) -> Body:
    """A body of second order: knob and hand, as a torque that does not lag moves them."""
    if body.lag == 0.0:
        return body
    return body._replace(order=2, lag=0.0, spacing=zero_spacing(body.alpha, body.beta), terms=0)


def can_rub(body: Body, wall: Controller, law: Law | None = None) -> bool:
    """Whether sets of states can be followed interval by interval: knob and hand, held by a spring, and an encoder.

    There is friction, or a law that is proven and feels no speed. The torque may lag, which no state changes.
    """
    order = 3 if body.lag > 0.0 else 2
    plane = body.order == order and body.damped and body.reach < inf and wall.analog == 0.0
    known = law is not None and law.provable and not law.senses
    told = body.friction > 0.0 if law is None else known
    return plane and told and bool(_course(body, wall, law))


def _course(body: Body, wall: Controller, law: Law | None) -> list[float]:
    """Parts of an interval, `friction_piece.LEG` numbers each; empty: too many."""
    return _plan(body, wall, law)[0]


def _halves(body: Body, span: float) -> list[float]:
    """Numbers of `lagged_stops` of a part of a hold of this length, of its half, and of half of each."""
    a = whole_matrix(body)
    plane, rows = plane_of(body), []
    phi, _ = exponential(a, span / 2.0**DEEPEST)
    for depth in range(DEEPEST, -1, -1):
        part = span / 2.0**depth
        late = [row[2] / POINT for row in phi]
        rows.append([part, *coefficients(part, plane), *late])
        phi = product(phi, phi)
    return [number for row in reversed(rows) for number in row]


def holds_of(wall: Controller, law: Law | None) -> list[tuple[float, float, float]]:
    """Holds of an interval: which of its torques acts, how long, and which look into it is at the end, or -1."""
    holds = [(0.0, wall.split, -1.0), (1.0, 1.0 - wall.split, -1.0)]
    if law is not None:
        starts, first = range(0, law.pieces * PIECE, PIECE), float(law.rows + 1)
        looks = [law.sched[at + LAW_LOOK] for at in starts]
        looks = [look - first if look >= 0.0 else -1.0 for look in looks]
        holds = [
            (law.sched[at + LAW_TORQUE], law.sched[at + LAW_SPAN], look) for at, look in zip(starts, looks, strict=True)
        ]
    return [hold for hold in holds if hold[1] > 0.0]


def _plan(body: Body, wall: Controller, law: Law | None) -> tuple[list[float], list[float], list[float]]:
    """Parts of an interval; with a lag the halves of each length that one has, and where those of each part are."""
    course: list[float] = []
    lags: list[float] = []
    places: list[float] = []
    known: dict[float, int] = {}
    plane = plane_of(body)
    for torque, span, look in holds_of(wall, law):
        n = parts_of_hold(span, plane)
        if n == 0:
            return [], [], []
        if body.lag > 0.0 and span / n not in known:
            known[span / n] = len(lags)
            lags += _halves(body, span / n)
        part = [torque, span / n, *coefficients(span / n, plane)]
        course += [*((n - 1) * [*part, -1.0]), *part, look]
        places += n * [float(known.get(span / n, 0))]
    return course, lags, places


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
    course, lags, places = _plan(body, wall, law)
    plane = plane_of(body)
    ready = {name: filled(value) for name, value in plane._asdict().items() if isinstance(value, list)}
    return FrictionRoom(
        course=filled(course),
        least=filled([LEAST]),
        sets=zeros((SET + looks) * (SETS_LOOKED if looks else SETS)),
        seen=zeros(looks),
        corners=zeros(2 * (4 * MOST + 2)),
        one=zeros(2 * MOST),
        other=zeros(2 * MOST),
        space=zeros(2 * (4 * MOST + 2)),
        line=zeros(3),
        z=zeros(body.order),
        ring=zeros(delay),
        torques=zeros(max(2, delay)),
        acts=zeros(ACTS),
        plane=plane._replace(**ready),
        lags=filled(lags) if lags else None,
        halves=filled(places),
        lag=zeros(LAGS),
        moved=zeros(body.order),
        pad=zeros(2 * body.order),
    )


def friction_drift(body: Body, wall: Controller, law: Law | None = None) -> Drift:
    """Bounds on the roundings of one interval, in lists: of a centre, and of the corners relative to it.

    Each part of an interval rounds position, velocity and pull a few times, and the time of a stop; what that moves is
    of the same size.
    """
    parts = len(_course(body, wall, law)) // LEG
    root = sqrt(body.beta)
    per = ROUNDED * EPSILON * parts
    late = []  # of the torque that acts: it moves the knob, and is rounded itself
    if body.lag > 0.0:
        late = [1.0 / body.lag]
    push = per * (1.0 + root)
    constant = push * (abs(body.drive) + body.friction)
    slow = [(push + per * unit) for unit in late]
    return Drift(
        powers=[0.0],
        once=[constant, push + sum(per * unit for unit in late), per * root + push * body.beta, push, *slow],
        units=[root, 1.0, *late],
        blur=ROUNDED * EPSILON * parts,
        coast=0.0,  # of arcs, which are not used
        bottom=deepest_level(wall) if law is None else -inf,
    )
