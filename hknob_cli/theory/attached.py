"""What a scene attaches to the relay's plant of one body: a finger behind its pad, a lag of the torque, dry friction.

The text expects describing functions to take further linear components easily (Hasser, sec. 7.4). These are their
frequency responses, in the units of the loop: angles in counts, times in samples, torques as accelerations of the knob.
The describing function of friction F sign(v) is that of a relay on the velocity, 4 F/(pi V) of a velocity amplitude V
(Gelb & Vander Velde 1968, ch. 2): beside the wall's relay it is a torque 4 F/pi a quarter of a turn ahead of the angle,
whatever the amplitude.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.body import Body

Complex = NDArray[np.complexfloating[Any, Any]]


class Attached(NamedTuple):
    """Beside the body with its damping and stiffness; 0 for what is not there.

    ``ratio``: inertia of the knob over the finger's; ``pad_...``: per inertia of the knob; ``finger_...``: per inertia
    of the finger; ``lag``: sample period over the time constant; ``friction``: acceleration by dry friction.
    """

    ratio: float = 0.0
    pad_damping: float = 0.0
    pad_stiffness: float = 0.0
    finger_damping: float = 0.0
    finger_stiffness: float = 0.0
    lag: float = 0.0
    friction: float = 0.0

    @property
    def stiffness(self) -> float:
        """Of pad and finger in series, per inertia of the knob."""
        grounded = self.finger_stiffness / self.ratio if self.ratio else 0.0
        both = self.pad_stiffness + grounded
        return self.pad_stiffness * grounded / both if both > 0.0 else 0.0

    @property
    def inertia(self) -> float:
        """Of knob and finger together, over the knob's."""
        return 1.0 + (1.0 / self.ratio if self.ratio else 0.0)

    def held_by(self, s: Complex) -> Complex:
        """Torque by which pad and finger hold the knob, per angle."""
        if not self.ratio:
            return np.zeros_like(s)
        pad = self.pad_stiffness + self.pad_damping * s
        finger = self.finger_stiffness + (self.finger_damping + s) * s
        found: Complex = pad * finger / (finger + self.ratio * pad)
        return found

    def late(self, s: Complex) -> Complex:
        """The lag's response from commanded to actual torque."""
        found: Complex = self.lag / (self.lag + s) if self.lag else np.ones_like(s)
        return found


def attached_to(body: Body) -> Attached | None:
    """What a body of the general loop has beside its damping and stiffness; None for nothing."""
    found = Attached(
        ratio=body.ratio,
        pad_damping=body.pad_damping,
        pad_stiffness=body.pad_stiffness,
        finger_damping=body.finger_damping,
        finger_stiffness=body.finger_stiffness,
        lag=body.lag,
        friction=body.friction,
    )
    return found if any(found) else None
