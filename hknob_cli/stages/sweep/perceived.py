"""What a cell amounts to by its attractors: size and pitch, by which it is judged, and what is felt and heard of it."""

from collections.abc import Iterable, Sequence
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.orbit import Harmonics
from hknob_cli.perception import hearing, touch
from hknob_cli.perception.level import decibels
from hknob_cli.specs.perception import Perceive
from hknob_cli.stages.sweep.cell import CellResult


class Sizes(NamedTuple):
    """``p2p_rad``, ``frequency_hz``: means by trials over what moves, None where nothing does.

    ``p2p_max_rad``: of the largest attractor, 0 where all rest, None where nothing is bounded;
    ``frequency_at_max_hz``: its frequency, None where it is at rest.
    """

    p2p_rad: float | None
    frequency_hz: float | None
    p2p_max_rad: float | None
    frequency_at_max_hz: float | None


class End(NamedTuple):
    """An attractor: the weight of its trials, whether it is at rest, its peak to peak (rad) and frequency (Hz)."""

    weight: float
    rests: bool
    p2p_rad: float
    frequency_hz: float


def sizes_of(ends: Iterable[End]) -> Sizes:
    """Sizes of a cell from its attractors whose motion is bounded and measured."""
    every = list(ends)
    moving = [one for one in every if not one.rests]
    if not moving:
        return Sizes(None, None, 0.0 if every else None, None)
    weight = sum(one.weight for one in moving)
    largest = max(moving, key=lambda one: one.p2p_rad)  # the first of equal ones, which most trials reach
    return Sizes(
        p2p_rad=sum(one.weight * one.p2p_rad for one in moving) / weight,
        frequency_hz=sum(one.weight * one.frequency_hz for one in moving) / weight,
        p2p_max_rad=largest.p2p_rad,
        frequency_at_max_hz=largest.frequency_hz,
    )


def sizes_of_rows(orbits: Iterable[dict[str, Any]]) -> Sizes:
    """Sizes of a cell from its rows of orbits.parquet."""
    return sizes_of(
        End(row["basin_fraction"], row["outcome"] == "rest", row["p2p_rad"], row["frequency_hz"])
        for row in orbits
        if row["p2p_rad"] is not None
    )


def sizes_of_result(result: CellResult) -> Sizes:
    """Sizes of a cell as the engine found it."""
    return sizes_of(
        End(one.trials, one.outcome is Outcome.REST, measured.p2p_rad, measured.frequency_hz)
        for one, measured in zip(result.attractors, result.measures, strict=True)
        if measured.p2p_rad == measured.p2p_rad  # NaN where nothing is bounded or measured
    )


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
    if not (how.extrapolate or touch.step_in_range(counts)):
        return nan
    level = float(touch.step_level(touch.torque_step(stiffness, counts), counts, extrapolate=True))
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
