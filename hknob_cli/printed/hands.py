"""Hand models from Tables 1-5: a row by its grip force, without the inertia of the apparatus (Table 10)."""

from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

from hknob_cli.errors import UsageError
from hknob_cli.printed.tables import printed

# Which apparatus of Table 10 each table was measured with: the 17.8 mm knob, or the 29.9 mm knob.
_SETUPS = {
    1: "small_experimental",
    2: "small_experimental",
    3: "medium_experimental",
    4: "medium_experimental",
    5: "medium_experimental",
}
_G_CM2 = Decimal("1e-7")  # kg m^2


class Grasp(NamedTuple):
    """Grip force (N) and what the grasp adds to the knob: inertia (kg·m²), damping (N·m·s/rad), stiffness (N·m/rad).

    The inertia is negative where the print has less for hand and apparatus than for the apparatus alone.
    """

    grip_n: float
    inertia: float
    damping: float
    stiffness: float


def apparatus_inertia(number: int, place: Path | None = None) -> float:
    """Moment of inertia (kg·m²) of the apparatus that one of Tables 1-5 includes. Raises `UsageError`."""
    return float(_apparatus(number, place))


def grasps(number: int, place: Path | None = None) -> tuple[Grasp, ...]:
    """The grasps of one of Tables 1-5, the lightest first; decimal differences are exact. Raises `UsageError`."""
    apparatus = _apparatus(number, place)
    return tuple(
        Grasp(
            grip_n=float(row["grip_n"]),
            inertia=float(Decimal(row["inertia_kg_m2"]) - apparatus),
            damping=float(row["damping_nm_s_per_rad"]),
            stiffness=float(row["stiffness_nm_per_rad"]),
        )
        for row in printed(number, place)
    )


def _apparatus(number: int, place: Path | None) -> Decimal:
    if number not in _SETUPS:
        raise UsageError(f"no grasps in table {number}; they are in tables {min(_SETUPS)} to {max(_SETUPS)}")
    estimates = next(row for row in printed(10, place) if row["quantity"] == "Empirical estimate")
    return Decimal(estimates[_SETUPS[number]]) * _G_CM2
