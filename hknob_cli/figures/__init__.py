"""Figures by name: each draws one kind of picture from finished results.

A drawing takes the `ResultSet`, the name ``of`` the result (or a list of names), and options of its own as keywords; it
returns a matplotlib Figure, made by `ink.figure`, without a title: the page has titles and captions. It raises
`MissingError` where a result lacks what it needs.
"""

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

from hknob_cli.figures.theme import styled
from hknob_cli.results.result_set import ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Drawing = Callable[..., "Figure"]

DRAWINGS: dict[str, Drawing] = {}

# The module here that registers each drawing, imported when it is first drawn.
MODULES: dict[str, str] = {
    "all_persons": "persons",
    "attractors": "attractors",
    "axis_lines": "axis_lines",
    "basins": "basins",
    "bias_curves": "bias",
    "block_diagram": "relay_loop",
    "campaign_lines": "campaign_lines",
    "campaign_thumbnails": "campaign",
    "campaign_trial": "campaign",
    "cases": "cases",
    "cell_dots": "cell_dots",
    "contact_energy": "contact",
    "cycle_spectra": "spectra",
    "design_costs": "design_costs",
    "equal_loudness": "senses",
    "error_time": "error_time",
    "fourth_beside_second": "fourth_fit",
    "grasp_parameters": "grasp",
    "grid_difference": "difference",
    "grid_lines": "lines",
    "grid_map": "maps",
    "grid_pair": "maps",
    "grip_cell": "bench_lines",
    "grip_forces": "grip",
    "hardware_grid": "hardware",
    "hidden_inertia": "hidden",
    "identified_terms": "contributions",
    "identified_values": "identified_values",
    "law_lines": "laws",
    "models_beside_data": "refit",
    "motor_calibration": "bench_lines",
    "nonlinearity": "relay_loop",
    "normalised_grasp": "grasp",
    "nyquist": "nyquist",
    "one_person": "persons",
    "phase_plane": "phase",
    "population": "population",
    "pulse_terms": "pulse",
    "pulse_vectors": "recorded",
    "remedy_dots": "remedies",
    "remedy_grid": "remedy_grid",
    "saturated_map": "saturated",
    "schematic": "schematic",
    "stability_table": "verdicts",
    "staircase": "staircase",
    "surface": "surface",
    "time_response": "motion",
    "torque_reach": "torque_reach",
    "touch_thresholds": "senses",
    "trial_thumbnails": "recorded",
    "what_explains": "what_explains",
    "what_matters": "what_matters",
}


def drawing(function: Drawing) -> Drawing:
    """Register a drawing under its name."""
    DRAWINGS[function.__name__] = styled(function)
    return DRAWINGS[function.__name__]


def drawing_of(name: str) -> Drawing:
    """The drawing of a name, its module loaded."""
    if name not in DRAWINGS:
        import_module(f"{__name__}.{MODULES[name]}")
    return DRAWINGS[name]


def draw(name: str, evidence: ResultSet, of: Any, options: dict[str, Any]) -> "Figure":
    """Draw a figure. Raises `MissingError`, and `TypeError` for options it does not take."""
    return drawing_of(name)(evidence, of, **options)
