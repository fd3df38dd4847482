"""A wall of the general loop as it looks from far out: a spring or none, and pushes between bounds.

A torque that is limited is a push between two bounds, whatever the angle. One that is not is that of the count, and
less or more by what the D/A converter rounds or the dead band holds back. Either is a loop of which `sets.absorbing`
finds the region that every motion comes into, or beyond which every one grows.
"""

from math import inf
from typing import NamedTuple

import numpy as np

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.torque_range import torque_range
from hknob_cli.engine.general.torque_table import HEAD
from hknob_cli.engine.loop import Loop, make_loop, upper_edge
from hknob_cli.engine.sets.absorbing import Limits, pushes

TABLE_ROUNDING = 1e-14  # of a table's largest torque: of sums of a few of them
ROUNDED = 1.0 + 1e-9  # of a step or a band, for the roundings of a torque up to a million times as large


class Afar(NamedTuple):
    """A loop, and between which limits it is pushed beside its springs."""

    loop: Loop
    limits: Limits


def look_from_afar(body: Body, wall: Controller) -> Afar:
    """The loop of a body of second order under a wall without memory."""
    drive, torques = float(body.drive), torque_range(wall)
    least, most = max(torques.least, -wall.limit), min(torques.most, wall.limit)
    if -inf < least and most < inf:
        loop = make_loop(body.alpha, body.beta, 0.0, -drive, wall.sense, wall.offset, 0.0)
        outside = (drive, drive) if wall.table is None else (drive + least, drive + most)
        return Afar(loop, Limits(upper_edge(-1.0, wall.sense), *outside, drive + least, drive + most))
    slack = ROUNDED * max(wall.band, 0.5 * wall.step)
    if wall.table is not None:
        return _beside_a_table(body, wall, slack)
    loop = make_loop(body.alpha, body.beta, wall.kappa, -drive, wall.sense, wall.offset, 0.0)
    return Afar(loop, pushes(loop, slack))


def _beside_a_table(body: Body, wall: Controller, slack: float) -> Afar:
    """The springs that a table goes on with, and pushes by all that its counts add; a count is within 1 of x."""
    table, drive = np.asarray(wall.table), float(body.drive)
    first, turn, below, above = (float(value) for value in table[:HEAD])
    inner, outer = -below / turn, -above / turn
    commands = table[HEAD : HEAD + (len(table) - HEAD) // 3]
    counts = first + np.arange(len(commands))
    slack += TABLE_ROUNDING * (max(inner, outer) * len(commands) + float(np.abs(commands).max()))
    inside = (commands + inner * counts)[counts <= 0.0]
    outside = (commands + outer * counts)[counts >= -1.0]
    limits = Limits(
        0.0,
        drive + float(outside.min()) - outer - slack,
        drive + float(outside.max()) + outer + slack,
        drive + float(inside.min()) - inner - slack,
        drive + float(inside.max()) + inner + slack,
        outer,
    )
    return Afar(make_loop(body.alpha, body.beta, inner, -drive, wall.sense, wall.offset, 0.0), limits)
