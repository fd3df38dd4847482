"""Teeth that stay on their flank: how far apart motions may be until they part, and rest with a motor that is held.

On one flank the mesh is a spring and a damper, and the energy of a difference never grows.
"""

from math import sqrt

from hknob_cli.engine.general.body import CONSTANT_HELD, CONSTANT_STUCK, coil_at
from hknob_cli.engine.general.cogging import hold_stiffness, own_stiffness
from hknob_cli.engine.general.teeth import flank, overlap


def flank_room(torque, body):
    """How far apart motions may be, by `body.distance`, until teeth may part that carry ``torque`` in one of them."""
    if torque <= 0.0:
        return 0.0
    return body.reach * torque / (sqrt(body.pad_stiffness) + body.pad_damping * (1.0 + sqrt(body.ratio)))


def flank_room_on(cogs, torque, x, body):
    """As `flank_room`, by `cogging.far_apart` of motions on the slope at ``x``.

    The energy without the slope's spring is at most that with a stable one, and with an unstable one, which all springs
    together hold by ``hold``, that times own / hold: it is at most max(own, hold) times the square of the distance.
    """
    room = flank_room(torque, body)
    if cogs is None or not len(cogs):
        return room
    own, hold = own_stiffness(body), hold_stiffness(cogs, x, body)
    if not hold > 0.0:
        return 0.0
    return room * sqrt(own / max(own, hold))


def held_in_teeth(z, u, body, pull=0.0):
    """Whether friction holds the motor for ever, and the knob settles on the flank, or on none, on which it is now.

    The energy of the knob's motion about where it would settle never grows. It bounds how far the mesh's torque ever
    gets from what it is there, so that teeth which press there do not part; in the gap it bounds the way. ``pull``: of
    cogging, which does not change.
    """
    n = body.order
    late = abs(z[n - 1] - u) if body.lag > 0.0 else 0.0
    if body.coil > 0.0:
        late += body.coil * abs(z[coil_at(body)])
    side = flank(z, body)
    drive = body.vectors[CONSTANT_STUCK * n + 3] + body.finger_stiffness * z[0]
    torque, swing = 0.0, 0.0
    if side == 0:
        if body.finger_damping == 0.0 or body.finger_stiffness == 0.0:
            return False
        rest = drive / body.finger_stiffness
        away = z[2] - rest
        far = sqrt(z[3] * z[3] / body.finger_stiffness + away * away)
        if not (rest + far < 0.0 and rest - far > -body.play):
            return False
    else:
        stiff = body.ratio * body.pad_stiffness + body.finger_stiffness
        if body.finger_damping + body.pad_damping == 0.0 or stiff == 0.0:
            return False
        if side < 0:
            drive -= body.ratio * body.pad_stiffness * body.play
        rest = drive / stiff
        away = z[2] - rest
        energy = sqrt(z[3] * z[3] / body.ratio + stiff / body.ratio * away * away)
        swing = (body.pad_damping * sqrt(body.ratio) + body.pad_stiffness * sqrt(body.ratio / stiff)) * energy
        torque = side * body.pad_stiffness * overlap(rest, side, body)
        if not side * torque > swing:
            return False
    return abs(u + pull + body.vectors[CONSTANT_HELD * n + 1] - torque) + swing + late <= body.friction
