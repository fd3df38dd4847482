"""A first guess of inertia, damping and stiffness without any derivative: the equation of motion, integrated twice."""

import numpy as np

from hknob_cli.identify.motion import Motion
from hknob_cli.identify.second_order import Plant


def integrated_start(motion: Motion) -> Plant:
    """Least squares of J x + B int x + K int int x = int int T: no derivative, so little noise. From rest.

    Torque is integrated exactly (it is held), the angle by the trapezoidal rule. Inertia at least what a free body
    would need to have moved so far; all zero if there is no torque or no motion.
    """
    dt, torque, angle = motion.dt_s, motion.torque_nm, motion.angle_rad
    impulse = np.concatenate(([0.0], np.cumsum(torque)[:-1])) * dt
    pushed = np.concatenate(([0.0], np.cumsum(impulse[:-1] * dt + 0.5 * dt * dt * torque[:-1])))
    once = np.concatenate(([0.0], np.cumsum(0.5 * dt * (angle[1:] + angle[:-1]))))
    twice = np.concatenate(([0.0], np.cumsum(0.5 * dt * (once[1:] + once[:-1]))))
    columns = np.stack([angle, once, twice], axis=1)
    lengths = np.sqrt(np.sum(columns * columns, axis=0))
    if not np.any(torque) or not np.all(lengths > 0.0):
        return Plant(0.0, 0.0, 0.0)
    solved = np.linalg.lstsq(columns / lengths, pushed, rcond=None)[0] / lengths
    floor = 0.02 * float(np.max(np.abs(pushed[: 1 + int(np.argmax(np.abs(angle)))]))) / float(np.max(np.abs(angle)))
    return Plant(max(float(solved[0]), floor), max(float(solved[1]), 0.0), max(float(solved[2]), 0.0))
