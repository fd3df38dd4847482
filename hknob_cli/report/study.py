"""Studies of the estimators on the terminal: bias and spread by cause, and what a second-order fit does not see."""

from typing import Any

from hknob_cli.report.matrix import short
from hknob_cli.report.table import table

Row = dict[str, Any]
# What is varied, in words; and the scale and unit in which a level is shown.
NUISANCES = {
    "noise_rad": ("noise of the angle, mrad rms", 1e3),
    "coulomb_nm": ("Coulomb friction, mN*m", 1e3),
    "lag_s": ("lag of the amplifier, ms", 1e3),
    "counts_per_rev": ("encoder, counts per revolution", 1.0),
    "decimation": ("smoothing, factor of decimation", 1.0),
}
PARAMETERS = ("inertia", "damping", "stiffness", "coulomb")


def study_text(summary: dict[str, Any]) -> str:
    """One table a grip force and nuisance; and one of the finger behind its pad."""
    lines = [f"{summary['name']}: estimators compared with the truth"]
    rows = summary.get("bias", [])
    for grip, nuisance in dict.fromkeys((row["grip_n"], row["nuisance"]) for row in rows):
        chosen = [row for row in rows if (row["grip_n"], row["nuisance"]) == (grip, nuisance)]
        lines += ["", f"{NUISANCES[nuisance][0]}, grip {short(grip)} N: bias ± standard deviation, %"]
        lines += _biases(chosen, NUISANCES[nuisance][1])
    if hidden := summary.get("hidden_inertia"):
        lines += ["", "second-order fits of finger, pad and knob: inertia beyond the knob's own, g*cm^2"]
        lines += _hidden(hidden)
    return "\n".join(lines)


def _biases(rows: list[Row], scale: float) -> list[str]:
    found = {(row["level"], row["estimator"], row["parameter"]): row for row in rows}
    estimators = list(dict.fromkeys(row["estimator"] for row in rows))
    parameters = [name for name in PARAMETERS if any(row["parameter"] == name for row in rows)]
    body = [
        [short(scale * level, 3), estimator, *(_spread(found.get((level, estimator, name))) for name in parameters)]
        for level in dict.fromkeys(row["level"] for row in rows)
        for estimator in estimators
    ]
    return table(["level", "", *parameters], body, keys=2)


def _spread(row: Row | None) -> str:
    if row is None:
        return "-"
    return f"{row['bias_percent']:+.2f} ± {row['std_percent']:.2f}"


def _hidden(rows: list[Row]) -> list[str]:
    estimators = list(dict.fromkeys(row["estimator"] for row in rows))
    found = {(row["ratio"], row["estimator"]): row for row in rows}
    knob, finger = 1e7 * rows[0]["knob_inertia_kg_m2"], 1e7 * rows[0]["finger_inertia_kg_m2"]
    lines = [f"knob {short(knob)}, finger {short(finger)}; K1/K2 = B1/B2 is the ratio of finger to pad"]
    body = [
        [short(ratio, 3), *(short(1e7 * found[ratio, name]["inertia_kg_m2"] - knob, 3) for name in estimators)]
        for ratio in dict.fromkeys(row["ratio"] for row in rows)
    ]
    return [*lines, *table(["ratio", *estimators], body)]
