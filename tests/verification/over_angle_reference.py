"""Torque over the measured angle at 60 digits, from the words of its parts; nothing of the package is used.

Where a pattern goes round the knob, its place at a count is a fraction of whole numbers, exactly. A continuous sensor
has no counts: its place is the angle itself.
"""

from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests import digits as mp

NAMES = ("profile", "detents", "end_stops", "dead_zone")


def over_angle(scene: dict[str, Any], counts: int) -> Callable[[int], Any] | None:
    """The torque [N m] at a count of all parts but the wall; None where there is none."""
    encoder = scene.get("encoder") or {}
    offset = Fraction(encoder.get("offset_counts") or 0.0) if isinstance(encoder, dict) else Fraction(0)
    there = [(SHAPES[name], scene[name]) for name in NAMES if scene.get(name)]
    if not there:
        return None
    known: dict[int, Any] = {}

    def torque(count: int) -> Any:
        if count not in known:
            turn = (count + offset) / counts
            known[count] = mp.fsum(shape(part, turn) for shape, part in there)
        return known[count]

    return torque


def along_angle(scene: dict[str, Any]) -> Callable[[Any], Any] | None:
    """The same at an angle [rad] that a continuous sensor shows."""
    there = [(SHAPES[name], scene[name]) for name in NAMES if scene.get(name)]
    if not there:
        return None
    return lambda angle: mp.fsum(shape(part, angle / (2 * mp.pi)) for shape, part in there)


def jumps(scene: dict[str, Any]) -> Callable[[Any], float]:
    """How far an angle is from the nearest at which a torque jumps [rad], as a continuous sensor has it."""
    places: list[tuple[Any, Any]] = []  # an angle, and the distance after which it comes again; 0: never
    part = scene.get("profile")
    if part and part.get("interpolation") == "stepped":
        span = part["points"][-1][0] - part["points"][0][0] if part.get("periodic") else 0
        places += [(mp.mpf(angle), mp.mpf(span)) for angle, _ in part["points"]]
    part = scene.get("detents")
    if part:
        spacing = 2 * mp.pi / part["per_revolution"] if part.get("per_revolution") else mp.mpf(part["spacing"])
        places += [(mp.mpf(end), mp.zero) for end in part.get("range") or ()]
        if part.get("shape") == "spring":
            places.append((mp.mpf(part.get("centre") or 0.0) + spacing / 2, spacing))

    def distance(angle: Any) -> float:
        found = [float("inf")]
        for place, again in places:
            away = angle - place
            found.append(float(abs(away - mp.nint(away / again) * again if again else away)))
        return min(found)

    return distance


def torques(scene: dict[str, Any], counts: int) -> Callable[[NDArray[np.float64]], NDArray[np.float64]] | None:
    """The same of many counts at once, rounded to doubles."""
    exact = over_angle(scene, counts)

    def at(levels: NDArray[np.float64]) -> NDArray[np.float64]:
        found, where = np.unique(levels, return_inverse=True)
        return np.array([float(exact(int(level))) for level in found])[where]  # type: ignore[misc]

    return at if exact else None


def _real(turn: Any) -> Any:
    return mp.mpf(turn.numerator) / turn.denominator if isinstance(turn, Fraction) else turn


def _angle(turn: Any) -> Any:
    return 2 * mp.pi * _real(turn)


def _between(points: list[Any], angle: Any, kind: str) -> Any:
    """Torque at an angle between points, that of the nearest end beyond them."""
    if angle < points[0][0]:
        return mp.mpf(points[0][1])
    for (a, u), (b, v) in pairwise(points):
        if a <= angle < b:
            share = 0 if kind == "stepped" else (angle - a) / (mp.mpf(b) - a)
            return u + share * (mp.mpf(v) - u)
    return mp.mpf(points[-1][1])


def profile(part: dict[str, Any], turn: Any) -> Any:
    points, kind = part["points"], part.get("interpolation", "linear")
    angle, first = _angle(turn), mp.mpf(points[0][0])
    if part.get("periodic"):
        span = mp.mpf(points[-1][0]) - first
        # What is meant is a whole number of spans in a turn, or of turns in a span.
        ratio = 2 * mp.pi / span
        span = 2 * mp.pi / mp.nint(ratio) if ratio > 0.9 else 2 * mp.pi * mp.nint(1 / ratio)
        angle = first + (angle - first) - mp.floor((angle - first) / span) * span
    return _between(points, angle, kind)


def detents(part: dict[str, Any], turn: Any) -> Any:
    centre, most = part.get("centre") or 0.0, mp.mpf(part["torque"])
    if part.get("per_revolution"):
        number = part["per_revolution"]
        spacing = 2 * mp.pi / number
        place = turn * number if not centre else _real(turn) * number - mp.mpf(centre) / spacing
    else:
        spacing = mp.mpf(part["spacing"])
        place = (_angle(turn) - centre) / spacing
    if part.get("range") and not part["range"][0] <= _angle(turn) <= part["range"][1]:
        return mp.zero
    if isinstance(place, Fraction):
        away = _real(place - (place + Fraction(1, 2)).__floor__())
    else:
        away = place - mp.floor(place + mp.mpf(1) / 2)
    if part.get("shape", "sine") == "sine":
        return -most * mp.sin(2 * mp.pi * away)
    if part["shape"] == "triangle":
        quarter = mp.mpf(1) / 4
        return -most * (away if abs(away) <= quarter else mp.sign(away) * (1 - 2 * abs(away)) / 2) / quarter
    zone = mp.mpf(part.get("dead_zone") or 0.0) / 2
    over = max(mp.zero, abs(away) * spacing - zone) / (spacing / 2 - zone)
    return -most * mp.sign(away) * over


def end_stops(part: dict[str, Any], turn: Any) -> Any:
    angle, stiffness = _angle(turn), mp.mpf(part["stiffness"])
    for name, beyond in (("low", lambda stop: angle < stop), ("high", lambda stop: angle > stop)):
        if part.get(name) is not None and beyond(part[name]):
            return stiffness * (part[name] - angle)
    return mp.zero


def dead_zone(part: dict[str, Any], turn: Any) -> Any:
    away, half = _angle(turn) - (part.get("centre") or 0.0), mp.mpf(part["width"]) / 2
    if abs(away) <= half:
        return mp.zero
    torque = mp.mpf(part["stiffness"]) * (abs(away) - half)
    if part.get("torque") is not None:
        torque = min(torque, mp.mpf(part["torque"]))
    return -mp.sign(away) * torque


SHAPES: dict[str, Callable[[dict[str, Any], Any], Any]] = {
    "profile": profile,
    "detents": detents,
    "end_stops": end_stops,
    "dead_zone": dead_zone,
}
