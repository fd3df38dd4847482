"""How a column of a result is written in a table of the page: its name, its unit, the factor from its file's values."""

import re
from typing import NamedTuple

import pyarrow as pa

from hknob_cli.figures.grid import axis_name

_NAMES = {
    "p2p_rad": "peak to peak",
    "p2p_max_rad": "peak to peak, largest cycle",
    "p2p_counts": "peak to peak",
    "frequency_hz": "frequency",
    "frequency_at_max_hz": "frequency, largest cycle",
    "rms_rad": "RMS",
    "rms_sine_rad": "RMS of a sine",
    "amplitude_rad": "amplitude (half of peak to peak)",
    "orbit": "number",
    "period_samples": "period",
    "orbit_count": "attractors",
    "basin_fraction": "trials that reach it",
    "certified_fraction": "proven",
    "certified": "proven",
    "at_rest_fraction": "at rest",
    "diverged_fraction": "diverged",
    "undecided_fraction": "undecided",
    "felt_fraction": "felt",
    "heard_fraction": "heard",
    "touch_db": "touch, above threshold",
    "touch_hz": "pitch that is felt best",
    "hearing_db": "sound, above threshold",
    "hearing_hz": "pitch that is heard best",
    "hearing_relative_db": "sound, relative",
    "torque_step_db": "torque step, above threshold",
    "touch_change_db": "touch, over the reference",
    "hearing_change_db": "sound, over the reference",
    "growth_j_per_s2": "growth of energy",
    "growth_std_j_per_s2": "± growth of energy",
    "growth_residual": "what the parabola leaves",
    "growth_fits": "trials with a parabola",
    "in_domain": "in domain",
    "p2p_ratio": "times smaller than the reference",
    "stiffness_kept": "static stiffness, of the reference's",
    "knock_ratio": "depth of a knock, of the reference's",
    "sweep_p2p_rad": "peak to peak of the sweep",
    "sweep_frequency_hz": "frequency of the sweep",
    "sweep_p2p_max_rad": "peak to peak of the sweep's largest cycle",
    "p2p_max_difference": "peak to peak, difference from the largest cycle",
    "p2p_mean_ratio": "means, times smaller than the reference",
    "p2p_difference": "peak to peak, difference",
    "amplitude_difference": "amplitude from peak to peak, difference",
    "frequency_difference": "frequency, difference",
    "binding_limb": "limit that binds",
    "seconds": "time",
    "vaf": "variance accounted for",
    "trials_differ": "difference of the trials",
    "ratio": "finger over pad",
    "bias_percent": "bias",
    "std_percent": "standard deviation",
}
# The unit of a file, the unit that is read more easily, and the factor to it.
_UNITS = {
    "rad": ("mrad", 1e3),
    "N*m": ("mN·m", 1e3),
    "kg*m^2": ("g·cm²", 1e7),
    "N*m*s/rad": ("mN·m·s/rad", 1e3),
    "J": ("µJ", 1e6),
    "J/s^2": ("mJ/s²", 1e3),
    "1/rev": ("per revolution", 1.0),
    "count": ("counts", 1.0),
    "sample": ("samples", 1.0),
    "1": ("", 1.0),
}
_SHARES = ("_fraction", "_difference", "_above")
_PERCENT = {"vaf", "r_squared", "unknown", "trials_differ", "mean", "std", "least", "largest"}
# What a name ends in that says its unit, which stands beside it in a table.
_ENDING = re.compile(
    r"_(rad|hz|db|kg_m2|nm_s_per_rad|nm_per_rad|n_s_per_m|n_per_m|nm|kg|counts_per_rev|j|n|s|percent|fraction)$"
)
_PER_AXIS = re.compile(r", (?=[^,]*$)")


class Shown(NamedTuple):
    """A column as a table has it: head, unit (empty where there is none), factor, meaning, and whether it is text."""

    head: str
    unit: str
    factor: float
    meaning: str
    is_text: bool


def shown_as(field: pa.Field, *, is_axis: bool) -> Shown:
    """How a column is written, from the unit and meaning that its file says. Axes keep the SI units of their spec."""
    said = field.metadata or {}
    unit, meaning = said.get(b"unit", b"").decode(), said.get(b"meaning", b"").decode()
    is_text = pa.types.is_string(field.type) or pa.types.is_boolean(field.type) or pa.types.is_dictionary(field.type)
    if is_axis:
        name = axis_name(field.name)
        if name != field.name and ", " in name:
            head, spoken = _PER_AXIS.split(name)
            return Shown(head, spoken, 1.0, meaning, is_text)
        return Shown(_plain(field.name), _written(unit), 1.0, meaning, is_text)
    text, factor = _UNITS.get(unit, (_written(unit), 1.0))
    if unit == "1" and (field.name.endswith(_SHARES) or field.name in _PERCENT):
        text, factor = "%", 100.0
    return Shown(_head(field.name), text, factor, meaning, is_text)


def _head(name: str) -> str:
    if name in _NAMES:
        return _NAMES[name]
    if name.endswith("_std"):
        return f"± {_head(name.removesuffix('_std'))}"
    return _plain(_ENDING.sub("", name))


def _plain(name: str) -> str:
    return name.replace("_", " ").replace(".", " ")


def _written(unit: str) -> str:
    """A unit with points and powers as they are printed."""
    return "" if unit == "1" else unit.replace("*", "·").replace("^2", "²")
