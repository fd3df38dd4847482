"""What a torque pulse works against: inertia, damping and stiffness of hand and knob (as Hasser, Fig. 7)."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.panel import key, scale_of
from hknob_cli.figures.recording import At, Of, one_recording
from hknob_cli.figures.trajectory_picture import Scale
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.specs.plan import Hand

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@drawing
def pulse_terms(evidence: ResultSet, of: Of, *, at: At | None = None, to_s: float | None = None) -> "Figure":
    """Torques (mN·m) of inertia, damping and stiffness, J θ'' + B θ' + K θ, their sum, and the pulse commanded.

    J, B and K are the scene's, the motion is recorded; accelerations are means between rows. Up to ``to_s`` (s). Raises
    `MissingError` for a hand of fourth order, with a wall or friction, or without a pulse.
    """
    one = one_recording(evidence, of, at=at, to_s=to_s)
    scene, hand = one.scene, one.scene.hand or Hand()
    if one.pulse is None or scene.wall.stiffness > 0.0 or hand.finger or scene.knob.coulomb_torque > 0.0:
        raise MissingError(f"'{one.name}' is not a pulse on a hand of second order, without a wall and friction")
    spans = np.diff(one.time)
    middle = one.time[:-1] + 0.5 * spans
    velocity, angle = (0.5 * (of[:-1] + of[1:]) for of in (one.velocity, one.angle))
    terms = {
        "inertia": (scene.knob.inertia + hand.inertia) * np.diff(one.velocity) / spans,
        "damping": (scene.knob.damping + hand.damping) * velocity,
        "stiffness": hand.stiffness * angle,
    }
    time, unit = scale_of(one.time), Scale(abs(one.pulse.torque))
    drawn = theme.figure(3.4)
    panel = drawn.subplots()
    commanded = np.where(middle < one.pulse.duration, one.pulse.torque, 0.0)
    wide: dict[str, Any] = {"color": "black", "linewidth": 4.0, "alpha": 0.3}
    panel.plot(time.factor * middle, unit.factor * commanded, label="commanded", drawstyle="steps-mid", **wide)
    total = np.sum(list(terms.values()), axis=0)
    panel.plot(time.factor * middle, unit.factor * total, label="sum", color="black", linewidth=1.0, linestyle=":")
    for i, (name, values) in enumerate(terms.items()):
        panel.plot(time.factor * middle, unit.factor * values, label=name, **theme.series(i))
    panel.set_xlabel(f"time, {time.prefix}s")
    panel.set_ylabel(f"torque, {unit.prefix}N\u00b7m")
    panel.set_xlim(0.0, time.factor * float(one.time[-1]))
    key(panel)
    return drawn
