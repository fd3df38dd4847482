"""Cells of the general loop that the tests of its sets share: with one thing more than the plain loop each."""

from math import pi
from typing import Any

from hypothesis import strategies as st

from hknob_cli.engine.general.search import make_space
from hknob_cli.engine.general.sets.cell import Centre
from hknob_cli.engine.general.sets.drift import Drift, make_drift
from hknob_cli.engine.general.sets.ends import Known, make_known
from hknob_cli.engine.general.sets.scope import Scope
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.scene.general_knob import GeneralKnob
from tests.engine.general.bodies import knob

FREE = {"inertia": 1.9e-6}
FINGER = {
    "finger": {"inertia": 3.0e-7, "damping": 2.9e-3, "stiffness": 0.4},
    "fingerpad": {"damping": 3.8e-4, "stiffness": 0.05},
}
STIFF = {
    "finger": {"inertia": 3.0e-7, "damping": 1.265e-2, "stiffness": 2.53},
    "fingerpad": {"damping": 1.265e-3, "stiffness": 0.253},
}
WHOLE = Scope(budget=100_000, skip=1000, patience=1000, limit=1e9, fine=True)
STEP = 0.27 * 2.0 * pi / 1024  # torque of one count

OVER_ANGLE: dict[str, dict[str, Any]] = {
    "detents": {"wall": {"stiffness": 0.0}, "detents": {"per_revolution": 48, "torque": 2e-3}},
    "end stops, late": {
        "end_stops": {"low": -0.01, "high": 0.013, "stiffness": 0.2},
        "wall": {"stiffness": 0.0},
        "actuator": {"delay_samples": 0.4},
    },
    "dead zone": {"dead_zone": {"width": 0.03, "stiffness": 0.2}, "encoder": {"rounding": "ceil"}},
    "profile": {
        "profile": {"points": [[-0.03, 3e-3], [-0.01, 1e-3], [0.012, -1e-3]], "interpolation": "stepped"},
        "encoder": {"rounding": "truncate"},
    },
    "spring detents, all else": {
        "wall": {"stiffness": 0.1, "damping": 2e-5},
        "detents": {"spacing": 0.05, "torque": 3e-3, "shape": "spring", "dead_zone": 0.02, "range": [-0.1, 0.1]},
        "actuator": {"delay_samples": 0.5, "torque_limit": 2e-3, "torque_step": 1e-4},
    },
    "finger on detents": {"hand": FINGER, "detents": {"per_revolution": 100, "torque": 1e-3, "shape": "triangle"}},
}

KINDS: dict[str, dict[str, Any]] = {
    "whole delay": {"actuator": {"delay_samples": 1.0}},
    "fractional delay": {"actuator": {"delay_samples": 1.4}},
    "limit": {"actuator": {"torque_limit": 2.5 * STEP}},
    "step": {"actuator": {"torque_step": 0.6 * STEP}, "encoder": {"rounding": "ceil", "offset_counts": 0.25}},
    "virtual damping": {"wall": {"stiffness": 0.27, "damping": 4e-5}},
    "truncated": {"wall": {"stiffness": 0.27, "damping": 2e-5}, "encoder": {"rounding": "truncate"}},
    "lag": {"actuator": {"time_constant": 4e-4}},
    "finger": {"hand": FINGER},
    "stiff finger, late": {"hand": STIFF, "actuator": {"delay_samples": 0.3, "time_constant": 2e-4}},
    "all of second order": {
        "wall": {"stiffness": 0.27, "damping": 2e-5},
        "actuator": {"delay_samples": 0.5, "torque_limit": 6.0 * STEP, "torque_step": 0.5 * STEP},
        "encoder": {"rounding": "nearest"},
    },
    "dead band": {"actuator": {"dead_band": 2.2 * STEP}},
    **OVER_ANGLE,
}
SECOND = [name for name in KINDS if name not in ("lag", "finger", "stiff finger, late", "finger on detents")]


def cell(kind: str, rate_hz: float = 464.2) -> GeneralKnob:
    """A cell of this kind, without friction."""
    return knob(rate_hz, knob=FREE, **KINDS[kind])


def bounds(cell: GeneralKnob) -> Drift:
    """Its bounds."""
    return make_drift(cell.body, cell.wall)


def zeros(count: int) -> list[float]:
    """Work space of the interpreter."""
    return [0.0] * count


def centre(z: Any, ring: Any, before: float = 0.0, **more: Any) -> Centre:
    """A state that a set is told from, as exact as it is given."""
    given = {"head": 0, "error": 0.0, "level": 0.0, "sample": 0.0, "weight": 1.0, **more}
    return Centre(z=z, before=before, ring=ring, **given)


def nothing_known(cell: GeneralKnob) -> Known:
    """Room for its attractors."""
    n = cell.body.order
    return make_known(zeros, n, cell.delay_line, make_space(n, cell.delay_line, zeros))


kinds = st.sampled_from(sorted(KINDS))
rates = st.sampled_from([100.0, 464.2, 2154.0, 10_000.0])


def all_phases(engine: GeneralSetEngine, cell: GeneralKnob, **limits: Any) -> Any:
    """What all clock phases of the start at 20 mrad, at rest, settle to."""
    return engine.search_phases(
        cell.body,
        cell.wall,
        cell.start(0.02, 0.0),
        rate=cell.rate,
        delay_line=cell.delay_line,
        **{"max_samples": None, **limits},
    )
