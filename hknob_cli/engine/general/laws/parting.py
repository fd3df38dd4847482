"""How fast nearby motions under a law part: as `general.parting`, with its torques.

Nearby motions have the same readings, so that a law's torques do not tell them apart, unless it senses the velocity.
What fades of its memory decays by itself.
"""

from math import log

from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.columns import begin_columns
from hknob_cli.engine.general.controller import read_after
from hknob_cli.engine.general.laws.law import LOOK, PIECE, TORQUE
from hknob_cli.engine.general.laws.sensed import move_piece_columns
from hknob_cli.engine.general.laws.step import count_piece, decide
from hknob_cli.engine.general.parting import normalise


def slope_columns(slope, body, law, space, m):
    """Put the slope of the newest torque by the speed into the columns, whose oldest torque no longer counts."""
    n, width = body.order, space.width
    for c in range(m):
        for j in range(law.ages - 1):
            space.cols[c * width + n + j] = space.cols[c * width + n + j + 1]
        space.cols[c * width + n + law.ages - 1] = slope * space.cols[c * width + 1]


def parting_with_law(z, past, samples, body, wall, law, space):
    """Mean growth of the logarithm of a difference of motions with the same readings, per sample.

    Args:
        z: State at the start, left at the end.
        past: What is remembered there.
        samples: How long the motion is followed.
        body: What moves.
        wall: What commands.
        law: The controller.
        space: Work space of the general loop.
    """
    n, width = body.order, space.width
    m = n + law.ages if law.senses else n  # of the state, and of the torques of a law that senses the speed
    begin_columns(space, m)
    copy_to(space.state, z)
    total = 0.0
    for _ in range(samples):
        shown = read_after(space.state[0], past[law.line - 1], wall)
        decide(shown, space.state[1], past, wall, law)
        if wall.hysteresis > 0.0:
            past[law.line - 1] = shown
        if law.senses:
            slope_columns(law.out[law.parts], body, law, space, m)
        for piece in range(law.pieces):
            at = piece * PIECE
            if wall.hysteresis > 0.0:
                for i in range(n):
                    space.away[i] = space.state[i]
                count_piece(space.away, past, piece, body, wall, law, space.pad)
            for c in range(m):
                torque = n + int(law.sched[at + TORQUE]) - law.line
                space.cols[width * width + c] = space.cols[c * width + torque] if law.senses else 0.0
            move_piece_columns(past, at, body, law, space, m)
            look = int(law.sched[at + LOOK])
            if look >= 0:
                past[look] = read_after(space.state[0], past[law.line - 1], wall)
        size = normalise(space.cols, width, m)
        if not size > 0.0:
            return -float("inf")
        total += log(size)
    copy_to(z, space.state)
    return total / samples
