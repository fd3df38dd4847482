"""The sampled loop around a method with a fixed step, as plain loops for numba.

Encoder, wall and delay are those of `controller`, written out over floats, so that a trial is compiled as a whole.
"""

from math import floor
from typing import NamedTuple

from hknob_cli.baselines.kernels import rk4

method = rk4  # which one, where it is compiled


class Law(NamedTuple):
    """The controller in numbers; every field is a float, in SI units.

    ``sense``: 0 continuous, 1 floor, 2 nearest, 3 ceil, 4 truncate. ``limit`` infinite: none; ``step`` 0: none.
    """

    sense: float
    quantum: float
    offset: float
    stiffness: float
    damping: float
    period: float
    limit: float
    step: float


def measured(angle, law):
    """Angle that the sensor reports."""
    if law.sense == 0.0:
        return angle
    x = angle / law.quantum - law.offset
    if law.sense == 2.0:
        level = floor(x + 0.5)
    elif law.sense == 3.0 or (law.sense == 4.0 and x < 0.0):
        level = -floor(-x)
    else:
        level = floor(x)
    return (level + law.offset) * law.quantum


def command(now, before, law):
    """Torque commanded at a sample, from the measured angles at it and at the one before."""
    torque = 0.0
    if now < 0.0:
        torque = -law.stiffness * now - law.damping * (now - before) / law.period
    if law.step > 0.0:
        torque = law.step * floor(torque / law.step + 0.5)
    return min(max(torque, -law.limit), law.limit)


def samples(a, b, rest, d, y, law, memory, early, late, angles):
    """Run one sample interval for every entry of ``angles``, and put the angle at its end there.

    ``b``, ``rest``: input of the command, and constant input; ``early``, ``late``: duration of the steps, number of
    them, and matrices, while the older and the newer command act. ``memory``: the measured angle at the sample before
    (NaN at the first), then the commands under way, oldest first. Ends early at an angle that is not a number.
    """
    pending = len(memory) - 1
    r = rest.copy()
    for k in range(len(angles)):
        now = measured(y[0], law)
        before = now if memory[0] != memory[0] else memory[0]
        memory[0] = now
        newest = command(now, before, law)
        older = memory[1] if pending > 0 else newest
        for i in range(1, pending):
            memory[i] = memory[i + 1]
        if pending > 0:
            memory[pending] = newest
        if early[1] > 0:
            for i in range(len(r)):
                r[i] = rest[i] + b[i] * older
            method(a, r, d, y, early[0], early[1], early[2])
            older = memory[1]
        for i in range(len(r)):
            r[i] = rest[i] + b[i] * older
        method(a, r, d, y, late[0], late[1], late[2])
        angles[k] = y[0]
        if not abs(y[0]) < 1e300:
            break
