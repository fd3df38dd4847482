"""Converters of a trial: how the wall reads the encoder, and what is sent of its torque.

Counts are found in whole numbers. The torque goes through the engine's own function, here in N·m; `firmware/convert.c`
has the same operations in the same order.
"""

from math import floor, inf, isfinite

import numpy as np

from hknob_cli.engine.general.controller import Controller, send
from hknob_cli.hardware.port import ROUNDINGS, Converters, Counts, Settings
from hknob_cli.specs.parts import Actuator, Encoder

NONE = Converters()


def converters_of(encoder: Encoder | None, actuator: Actuator | None) -> Converters | None:
    """Those of a spec; None where they do nothing."""
    encoder, actuator = encoder or Encoder(), actuator or Actuator()
    found = Converters(
        offset_counts=encoder.offset_counts,
        dead_band_nm=actuator.dead_band,
        step_nm=actuator.torque_step,
        limit_nm=actuator.torque_limit or 0.0,
        delay_samples=actuator.delay_samples,
        rounding=ROUNDINGS.index(encoder.rounding),
    )
    return None if found == NONE else found


def words_of(told: Converters) -> str:
    """What they do, in SI units; empty where that is nothing."""
    said = {**told._asdict(), "rounding": ROUNDINGS[told.rounding]}
    usual = {**NONE._asdict(), "rounding": ROUNDINGS[NONE.rounding]}
    shown = {name: value for name, value in said.items() if value != usual[name]}
    shown = {name: f"{value:.6g}" if isinstance(value, float) else value for name, value in shown.items()}
    return ", ".join(f"{name} {value}" for name, value in shown.items())


class Conversion:
    """The converters of a trial, between an encoder of ``native`` counts per revolution and its motor."""

    def __init__(self, settings: Settings, native: int) -> None:
        told = settings.converters or NONE
        self._counts, self._native, self._rounding = settings.counts_per_rev, native, ROUNDINGS[told.rounding]
        self._shift = floor(told.offset_counts * native + 0.5)
        self._half = native // 2 if self._rounding == "nearest" else 0
        self._wall = Controller(
            *(0.0, 0.0, 1.0, 0.0, told.offset_counts, 0.0),
            step=told.step_nm,
            limit=told.limit_nm or inf,
            split=0.0,
            band=told.dead_band_nm,
        )
        self.steps = told.step_nm > 0.0 or told.dead_band_nm > 0.0

    def count(self, angle: int) -> int:
        """The wall's count at an angle in counts of the device's own encoder; exact."""
        count = (angle * self._counts - self._shift + self._half) // self._native
        # The knob is above the edge at which the device's own encoder shows what it does: up means the next count.
        up = self._rounding == "ceil" or (self._rounding == "truncate" and count < 0)
        return count + 1 if up else count

    def counts(self, angles: Counts) -> Counts:
        """The wall's counts at angles (n,)."""
        found = np.floor_divide(angles * self._counts - self._shift + self._half, self._native)
        if self._rounding == "ceil":
            return found + 1
        return np.where(found < 0, found + 1, found) if self._rounding == "truncate" else found

    def send(self, torque_nm: float) -> float:
        """What is sent of a torque; what is not a number stays what it is."""
        return float(send(torque_nm, self._wall)) if isfinite(torque_nm) else torque_nm
