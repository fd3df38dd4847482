"""Recorded pulses beside the motion of models: of the same data, and of another block's (Hasser, Fig. 8)."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.identification import Pulsed, plan_of, plant_of, pulsed, rows_of
from hknob_cli.figures.recorded import rule_pulse, time_of
from hknob_cli.identify.second_order import Plant, respond
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

THIN = 3  # of the samples one in so many is drawn


@drawing
def models_beside_data(
    evidence: ResultSet,
    of: str,
    *,
    subject: str = "S1",
    experiment: str = "1",
    block: int = 1,
    other: int = 2,
    estimator: str = "output_error",
    to_s: float = 0.05,
) -> "Figure":
    """Angle (mrad) of an averaged condition, by its own model, and by that of block ``other``, a panel a grip force.

    Models know the friction and the lag that the identification knew. Raises `MissingError`.
    """
    result = evidence[of]
    known = plan_of(result)
    drawn_of = pulsed(result, smooth=False, after_s=to_s, subject=subject, experiment=experiment, block=block)
    drawn_of.sort(key=lambda one: one.of.condition.grip_target_n)
    rows = -(-len(drawn_of) // 3)
    drawn = theme.figure(0.9 + 1.6 * rows)
    panels = drawn.subplots(rows, min(3, len(drawn_of)), squeeze=False, sharex=True, sharey=True).ravel()
    wide: dict[str, Any] = {"color": "black", "linewidth": 3.5, "alpha": 0.3}
    for panel, one in zip(panels, drawn_of, strict=False):
        grip, time = one.of.condition.grip_target_n, time_of(one)[::THIN]
        rule_pulse(panel, one)
        panel.plot(time, 1e3 * one.motion.angle_rad[::THIN], label="recorded", **wide)
        for i, (number, label) in enumerate(((block, "model of these data"), (other, f"model of block {other}"))):
            asked = {"subject": subject, "experiment": experiment, "grip_target_n": grip, "block": number}
            plant = plant_of(rows_of(result, "trials", estimator=estimator, **asked)[0])
            angle = modelled(plant, one, coulomb_nm=known.coulomb_nm, lag_s=known.lag_s)
            panel.plot(time, 1e3 * angle[::THIN], label=label, **theme.series(i))
        panel.set_title(f"{grip:g} N", loc="left")
    for panel in panels[len(drawn_of) :]:
        panel.set_visible(False)
    drawn.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=3, handlelength=3.0)
    drawn.supxlabel("time from the onset of the pulse, ms", fontsize=9)
    drawn.supylabel("angle from rest, mrad", fontsize=9)
    return drawn


def modelled(plant: Plant, one: Pulsed, *, coulomb_nm: float = 0.0, lag_s: float = 0.0) -> np.ndarray:
    """Angle (rad) of a second-order model under a recorded torque, the friction known beside that fitted."""
    if plant.inertia <= 0.0:
        raise MissingError("a model without inertia does not move")
    if not plant.coulomb:
        plant = plant._replace(coulomb=coulomb_nm)
    return respond(plant, one.motion.torque_nm, one.motion.dt_s, lag_s=lag_s)
