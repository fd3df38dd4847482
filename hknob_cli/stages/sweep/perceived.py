"""What a hand feels and an ear hears of the orbits of a cell."""

from collections.abc import Sequence
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.measure.harmonics import Harmonics
from hknob_cli.perception import hearing, torque_step, touch
from hknob_cli.perception.level import decibels
from hknob_cli.specs.perception import Perceive

HIGHEST_HZ = 12500.0  # of harmonics: ISO 226 has none above


class Perceived(NamedTuple):
    """Levels of one orbit; NaN where it is no cycle, or nothing is published.

    ``hearing_db`` is relative without a sound gain; ``others_db``: of touch, by the other sets that are asked for.
    """

    touch_db: float = nan
    touch_hz: float = nan
    hearing_db: float = nan
    hearing_hz: float = nan
    hearing_phon: float = nan
    others_db: tuple[float, ...] = ()


def perceive(lines: Harmonics, how: Perceive) -> Perceived:
    """Levels of a cycle by its harmonics; none of a sense for which the highest of a very long period are missing."""
    if not lines.reach(touch.FELT_HZ[1] if how.extrapolate else touch.thresholds(how.thresholds).high_hz):
        return Perceived()
    skin = touch.skin_displacement(np.abs(lines.angle_rad), knob_radius_m=how.knob_radius)
    felt = touch.judge(lines.frequency_hz, skin, name=how.thresholds, how=how.combine, extrapolate=how.extrapolate)
    others = tuple(
        float(touch.judge(lines.frequency_hz, skin, name=name, how=how.combine, extrapolate=how.extrapolate).level_db)
        for name in how.others
    )
    one = Perceived(touch_db=float(felt.level_db), touch_hz=float(felt.frequency_hz), others_db=others)
    if not lines.reach(HIGHEST_HZ):
        return one
    speed = lines.speed_rad_s
    noise, masked = how.hearing.background, None
    if not how.gained:
        sound, phon = decibels(speed), nan
    else:
        sound = hearing.heard_level(speed, gain_pa_s_per_rad=_gains(lines.frequency_hz, how))
        # How loud a tone is in noise ISO 226 does not say.
        phon = nan if noise else _loudest(lines.frequency_hz, sound, how)
    if noise:
        masked = hearing.masked_threshold(lines.frequency_hz, noise, extrapolate=how.extrapolate)
    heard = hearing.judge(lines.frequency_hz, sound, edition=how.edition, masked_db=masked)
    return one._replace(
        hearing_db=float(heard.level_db),
        hearing_hz=float(heard.frequency_hz),
        hearing_phon=phon,
    )


def _gains(frequency: Any, how: Perceive) -> Any:
    """The device's gain at each harmonic, Pa/(rad/s); NaN where it was not measured."""
    if how.sound_gain is not None:
        return how.sound_gain
    return hearing.response(frequency, how.sound_response, extrapolate=how.extrapolate)


def _loudest(frequency: Any, sound: Any, how: Perceive) -> float:
    """Loudness level of the loudest harmonic; NaN where none is heard, or ISO 226 is not for it."""
    some = hearing.in_range(frequency)
    phon = hearing.loudness_level(frequency[some], sound[some], edition=how.edition, extrapolate=True)
    known = np.isfinite(phon)
    if not known.any():
        return nan
    at = int(np.where(known, phon, -np.inf).argmax())
    within = hearing.is_specified(frequency[some][at], phon[at])
    return float(phon[at]) if how.extrapolate or within else nan


def step_db(how: Perceive, *, stiffness: float, counts: float) -> float:
    """Level of the torque step of a count; NaN without a step, or outside the published range."""
    if not (how.extrapolate or torque_step.in_range(counts)):
        return nan
    level = float(torque_step.level(torque_step.torque_step(stiffness, counts), counts, extrapolate=True))
    return level if isfinite(level) else nan


def orbit_row(one: Perceived, how: Perceive, step: float) -> dict[str, Any]:
    """Row of an orbit."""
    numbers = one._replace(others_db=())._asdict()
    row = {name: value if isfinite(value) else None for name, value in numbers.items() if name != "others_db"}
    if not how.gained:
        row["hearing_relative_db"] = row.pop("hearing_db")
    return {**row, "torque_step_db": step}


def cell_row(found: Sequence[Perceived], shares: Sequence[float], how: Perceive, step: float) -> dict[str, Any]:
    """Row of a cell: its most noticeable orbits, and the share of trials that end in one above threshold."""
    felt = max(found, key=lambda one: _or_least(one.touch_db), default=Perceived())
    heard = max(found, key=lambda one: _or_least(one.hearing_db), default=Perceived())
    both = heard._replace(
        touch_db=felt.touch_db,
        touch_hz=felt.touch_hz,
        hearing_phon=max((one.hearing_phon for one in found if isfinite(one.hearing_phon)), default=nan),
    )
    return {
        **orbit_row(both, how, step),
        "felt_fraction": sum(share for one, share in zip(found, shares, strict=True) if one.touch_db > 0.0),
        "heard_fraction": sum(share for one, share in zip(found, shares, strict=True) if one.hearing_db > 0.0),
    }


def _or_least(value: float) -> float:
    return value if isfinite(value) else -np.inf
