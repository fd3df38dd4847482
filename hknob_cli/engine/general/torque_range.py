"""What a torque over the angle amounts to, far out: by it a trial is told that leaves, or that spins for ever."""

from math import inf
from typing import NamedTuple

import numpy as np

from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.torque_curve import (
    DETENT,
    HALF,
    HIGH,
    HIGHEST,
    LOW,
    LOWEST,
    MIDDLE,
    MOST,
    POINTS,
    SPACING,
    SPAN,
    SPRING,
    STOP,
)
from hknob_cli.engine.general.torque_curve import HEAD as HEAD_OF_CURVE
from hknob_cli.engine.general.torque_table import HEAD


class TorqueRange(NamedTuple):
    """What a torque over the angle amounts to, far out.

    ``least``, ``most``: commands, infinite where a spring grows with the angle; ``turn``: counts after which it repeats
    for ever, on a side without a spring, 0 where there is none; ``span``: counts out to which it is of another kind.
    ``spring``: stiffness of a curve's springs below, which are not in the wall's.
    """

    least: float
    most: float
    turn: float
    span: float
    spring: float = 0.0


def torque_range(wall: Controller) -> TorqueRange:
    """The range of a controller's commands over all angles."""
    if wall.curve is not None:
        return _of_curve(wall)
    if wall.table is None:
        return TorqueRange(0.0, inf if wall.kappa > 0.0 or wall.damping > 0.0 else 0.0, 0.0, 0.0)
    table = np.asarray(wall.table)
    size = (len(table) - HEAD) // 3
    first, turn, below, above = (float(value) for value in table[:HEAD])
    commands = table[HEAD : HEAD + size]
    commands = np.where(np.abs(commands) < wall.band, 0.0, commands)
    if wall.step > 0.0:
        commands = wall.step * np.floor(commands / wall.step + 0.5)
    commands = np.clip(commands, -wall.limit, wall.limit)
    return TorqueRange(
        least=-inf if above < 0.0 or wall.damping > 0.0 else float(commands.min()),
        most=inf if below < 0.0 or wall.damping > 0.0 else float(commands.max()),
        turn=0.0 if turn == 1.0 or (below < 0.0 and above < 0.0) else turn,
        span=max(abs(first), abs(first + size)),
    )


def _of_curve(wall: Controller) -> TorqueRange:
    """The same of a torque over the angle of a continuous sensor: the sum of what its parts command at the most."""
    curve = np.asarray(wall.curve, dtype=np.float64)
    count = int(curve[POINTS])
    angles, torques = curve[HEAD_OF_CURVE : HEAD_OF_CURVE + count], curve[HEAD_OF_CURVE + count :]
    least, most, turn, span = 0.0, 0.0, 0.0, 0.0
    if count:
        least, most = float(torques.min()), float(torques.max())
        turn = float(curve[SPAN])
        span = 0.0 if turn else float(np.abs(angles).max())
    if curve[DETENT] > 0.0:
        least, most = least - float(curve[DETENT]), most + float(curve[DETENT])
        ends = [abs(float(end)) for end in curve[[LOW, HIGH]] if abs(end) < inf]
        turn, span = (turn, max(span, *ends)) if ends else (max(turn, float(curve[SPACING])), span)
    if curve[SPRING] > 0.0:
        least, most = least - float(curve[MOST]), most + float(curve[MOST])
        far = 0.0 if curve[MOST] == inf else float(curve[MOST] / curve[SPRING])
        span = max(span, abs(float(curve[MIDDLE])) + float(curve[HALF]) + far)
    below = wall.kappa > 0.0 or curve[MOST] == inf
    above = curve[MOST] == inf
    if curve[STOP] > 0.0:
        ends = [float(curve[end]) for end in (LOWEST, HIGHEST)]
        below, above = below or ends[0] > -inf, above or ends[1] < inf
        span = max(span, *(abs(end) for end in ends if abs(end) < inf))
    least, most = max(least - 0.5 * wall.step, -wall.limit), min(most + 0.5 * wall.step, wall.limit)
    return TorqueRange(
        least=-inf if above or wall.damping > 0.0 else least,
        most=inf if below or wall.damping > 0.0 else most,
        turn=0.0 if below and above else turn,
        span=span,
        spring=float((curve[STOP] if curve[LOWEST] > -inf else 0.0) + (curve[SPRING] if curve[MOST] == inf else 0.0)),
    )
