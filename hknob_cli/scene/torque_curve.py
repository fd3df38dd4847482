"""Torque over the angle of a continuous sensor: profile, detents, end stops and dead zone as the engine's curve.

Nothing is summed up in a table: a continuous sensor has no counts, so that each part is a function of the angle.
"""

from math import inf, isfinite, pi

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.torque_curve import (
    CENTRE,
    DETENT,
    FAR,
    HALF,
    HEAD,
    HIGH,
    HIGHEST,
    LOW,
    LOWEST,
    MIDDLE,
    MOST,
    POINTS,
    SHAPE,
    SINE,
    SPACING,
    SPAN,
    SPRING,
    SPRUNG,
    STEPPED,
    STOP,
    TRIANGLE,
    ZONE,
)
from hknob_cli.scene.torque_over_angle import Parts
from hknob_cli.specs.over_angle import DeadZone, Detents, EndStops, Profile, ways_round

Array = NDArray[np.float64]

SHAPES = {"sine": SINE, "triangle": TRIANGLE, "spring": SPRUNG}


def curve_of(scene: Parts, *, quantum_rad: float, unit_nm: float) -> Array:
    """The curve of parts of which there is one, as `engine.general.torque_curve` has it.

    ``quantum_rad``: angle of a count; ``unit_nm``: torque of a unit acceleration.
    """
    points = len(scene.profile.points) if scene.profile else 0
    curve = np.zeros(HEAD + 2 * points)
    curve[[SPACING, HIGH, HIGHEST]] = 1.0, inf, inf
    curve[[LOW, LOWEST]] = -inf
    if scene.profile:
        _add_profile(curve, scene.profile, quantum_rad, unit_nm)
    if scene.detents:
        _add_detents(curve, scene.detents, quantum_rad, unit_nm)
    if scene.end_stops:
        _add_stops(curve, scene.end_stops, quantum_rad, unit_nm)
    if scene.dead_zone:
        _add_zone(curve, scene.dead_zone, quantum_rad, unit_nm)
    places = [*curve[[CENTRE, LOW, HIGH, LOWEST, HIGHEST, MIDDLE, HALF]], *curve[HEAD : HEAD + points]]
    curve[FAR] = max(abs(float(place)) for place in places if isfinite(place))
    return curve


def _add_profile(curve: Array, part: Profile, quantum: float, unit: float) -> None:
    count = len(part.points)
    angles, torques = np.array(part.points, dtype=np.float64).T
    curve[HEAD : HEAD + count], curve[HEAD + count :] = angles / quantum, torques / unit
    curve[POINTS], curve[STEPPED] = count, part.interpolation == "stepped"
    if part.periodic:
        times, turns = ways_round(float(angles[-1] - angles[0])) or (1, 1)
        curve[SPAN] = 2.0 * pi * turns / times / quantum


def _add_detents(curve: Array, part: Detents, quantum: float, unit: float) -> None:
    spacing = part.spacing or 2.0 * pi / (part.per_revolution or 1)
    curve[DETENT], curve[SHAPE] = part.torque / unit, SHAPES[part.shape]
    curve[SPACING], curve[CENTRE], curve[ZONE] = spacing / quantum, part.centre / quantum, part.dead_zone / quantum
    if part.range is not None:
        curve[[LOW, HIGH]] = part.range[0] / quantum, part.range[1] / quantum


def _add_stops(curve: Array, part: EndStops, quantum: float, unit: float) -> None:
    curve[STOP] = part.stiffness * quantum / unit
    curve[LOWEST] = -inf if part.low is None else part.low / quantum
    curve[HIGHEST] = inf if part.high is None else part.high / quantum


def _add_zone(curve: Array, part: DeadZone, quantum: float, unit: float) -> None:
    curve[SPRING], curve[MIDDLE] = part.stiffness * quantum / unit, part.centre / quantum
    curve[HALF], curve[MOST] = 0.5 * part.width / quantum, inf if part.torque is None else part.torque / unit
