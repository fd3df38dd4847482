"""Every proven limit cycle of the whole scene, derived again at 60 digits from its period and one state.

Verified: that the orbit exists (the model's period map closes to 38 digits and visits the readings that the package's
orbit visits), that the package's positions are within its own bound of it at *every* sample, the margin, and the
measures as docs/reference/glossary.md defines them, integrals by quadrature. The work of the wall equals the loss in
dampers and friction, and late entry, late exit and staircase add up to it.

The accuracy promised is 1e-10 relative for measures and energies, 1e-9 counts for margins.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.search import GeneralEngine, as_compiled, as_list
from hknob_cli.engine.general.trace import Rows, run
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.measure.orbit import OrbitMeasures
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.scene import SceneSpec
from tests import digits as mp

from .general_orbits import leak, measure, solve
from .general_scenes import EVERYTHING, HALF, LIGHT, RUBBING, STIFF, TWO_PARTS, scene
from .scenes import RATES_HZ

RELATIVE = 1e-10
MARGIN = 1e-9  # counts
ROUNDINGS = 16.0 * 2.0**-53  # of a position, when one period is run from the orbit's state
LONGEST = 30  # samples of a period, for the time that 60 digits take

MEASURES = (
    "p2p_rad",
    "min_rad",
    "max_rad",
    "rms_rad",
    "frequency_hz",
    "wall_work_j",
    "damping_loss_j",
    "friction_loss_j",
)


@dataclass(frozen=True)
class Found:
    """A proven cycle as the package reports it."""

    scene: dict[str, Any]
    rate_hz: float
    counts: int | None
    knob: GeneralKnob
    orbit: Attractor
    measures: OrbitMeasures

    def __str__(self) -> str:
        """Enough to find it again."""
        return f"{self.rate_hz:.6g} Hz, {self.counts} counts, period {self.orbit.period}, {self.scene}"


@pytest.fixture(scope="module")
def general() -> GeneralEngine:
    """The general engine, compiled."""
    return GeneralEngine(compiled("general"))


def settle(
    engine: GeneralEngine, parts: dict[str, Any], rate_hz: float, counts: int | None, phases: int = 4
) -> Iterator[Found]:
    """Proven cycles of a cell."""
    plain = SceneSpec.model_validate(parts).plain()
    knob = sample_general(plain, sample_rate_hz=rate_hz, counts_per_rev=counts)
    search = engine.search(
        knob.body,
        knob.wall,
        knob.start(0.02, 0.0),
        rate=knob.rate,
        phases=phases,
        delay_line=knob.delay_line,
        max_samples=None,
    )
    measurer = GeneralMeasurer(knob, engine)
    for one in search.attractors:
        if one.outcome is Outcome.CYCLE and one.certified and one.period <= LONGEST:
            yield Found(parts, rate_hz, counts, knob, one, measurer.measure(one))


def positions(found: Found, *, in_code: bool = True) -> np.ndarray:
    """Positions of the package's orbit at its samples, counts, (period + 1,); ``in_code``: by a compiled loop."""
    through: Any = compiled("general")["general.run"] if in_code else run
    n, one = found.knob.body.order, found.orbit
    rows = Rows(np.zeros((one.period + 1) * n), np.zeros(one.period + 1))
    state, line = np.array([one.x, one.v, *one.state]), np.array(one.line, dtype=np.float64)
    knob = found.knob
    body, wall = as_compiled(knob.body, knob.wall) if in_code else (knob.body, as_list(knob.wall))
    through(state, one.before, line, 0, body, wall, np.zeros(2 * n), rows)
    return np.asarray(rows.states[::n])


def check(found: Found) -> dict[str, float]:
    """Confirm one proof and every measure; the largest errors, relative except for the margin."""
    one, knob = found.orbit, found.knob
    solved = solve(found.scene, found.rate_hz, found.counts, knob, one)
    assert solved.closes, f"does not close: {found}"
    unit = solved.control.quantum or mp.mpf(knob.quantum_rad)
    exact = [z[0] / unit - mp.mpf(knob.shift) for z in solved.run.states]
    seen = positions(found)
    worst = {"bound": 0.0}
    for x, y in zip(seen, exact, strict=True):
        off = float(abs(mp.mpf(float(x)) - y))
        allowed = one.bound + ROUNDINGS * one.period * float(np.ptp(seen) + np.abs(seen).max())
        assert off <= allowed, f"{off:.3g} counts off, bound {one.bound:.3g}: {found}"
        worst["bound"] = max(worst["bound"], off / one.bound)
        if found.counts is not None:
            same = solved.control.measured((mp.mpf(float(x)) + mp.mpf(knob.shift)) * unit)
            assert same == solved.control.measured((y + mp.mpf(knob.shift)) * unit), found
    margin = margin_of(found, exact)
    worst["margin"] = abs(one.margin - margin)
    assert worst["margin"] <= MARGIN, f"margin {one.margin!r}, is {margin!r}: {found}"
    expected = measure(solved)
    assert found.measures.cycles == expected["cycles"], found
    if not knob.body.lag:
        expected |= leak(solved)
        split = expected["late_entry_j"] + expected["late_exit_j"] + expected["staircase_j"]
        assert abs(split - expected["wall_work_j"]) <= 1e-20 * abs(expected["wall_work_j"]), found
    rub = expected["friction_loss_j"]
    lost = expected["damping_loss_j"] + rub
    assert abs(expected["wall_work_j"] - lost) <= 1e-20 * lost, found
    for name, value in expected.items():
        got = getattr(found.measures, name)
        if name == "friction_loss_j" and not rub:
            assert not got > 0.0
            continue
        size = abs(expected["wall_work_j"]) if name.endswith("_j") else abs(value)
        worst[name] = float(abs(got - value) / size)
        assert worst[name] <= RELATIVE, f"{name} off by {worst[name]:.3g} relative: {found}"
    own = found.measures.wall_work_j - found.measures.damping_loss_j - (found.measures.friction_loss_j if rub else 0.0)
    worst["balance"] = float(abs(own) / lost)
    assert worst["balance"] <= RELATIVE, found
    return worst


def margin_of(found: Found, exact: list[Any]) -> float:
    """Least distance of a sample to a change of the command, from the words of the glossary."""
    wall, ends = found.knob.wall, exact[:-1]
    if wall.analog:
        gaps = [abs(x) for x in ends]
        slope = wall.kappa + 2.0 * wall.damping
        for before, x in zip([ends[-1], *ends], ends, strict=False):
            if not x < 0:
                continue
            u = -wall.kappa * x - wall.damping * (x - before)
            if wall.limit < float("inf"):
                gaps.append(abs(abs(u) - wall.limit) / slope)
            if wall.band:
                gaps.append(abs(abs(u) - wall.band) / slope)
            if wall.step and abs(u) >= wall.band:
                halves = u / wall.step - mp.mpf(1) / 2
                gaps.append(abs(halves - mp.nint(halves)) * wall.step / slope)
        return float(min(gaps))
    first = 0 if wall.sense > 0 else -1  # the wall begins below it
    if wall.damping:
        inside = [abs(x - mp.nint(x)) if not (wall.truncate and -1 < x < 1) else min(x + 1, 1 - x) for x in ends]
    else:
        inside = [abs(x - mp.nint(x)) if x < first else x - first for x in ends]
    return float(min(inside))


GRID = [(RATES_HZ[i], counts) for i in (1, 3, 5) for counts in (256, 1024, 4096)]
FEW = [(RATES_HZ[0], 512), (RATES_HZ[1], 1024), (RATES_HZ[3], 512), (RATES_HZ[3], 1024)]
TWO = [FEW[0], FEW[3]]  # a finger's pad is quick, and long holds take many terms
SCENES: dict[str, tuple[dict[str, Any], Any]] = {
    "friction 0.01 mN m": (scene(knob={"coulomb_torque": 1e-5}), GRID),
    "friction 0.06 mN m": (scene(knob=LIGHT, bias=HALF), GRID),
    "friction 0.15 mN m": (scene(knob={"coulomb_torque": 1.5e-4}), GRID),
    "friction 0.56 mN m": (scene(knob=RUBBING), GRID),
    "finger": (scene(hand=TWO_PARTS), TWO),
    "stiff finger": (scene(hand=STIFF), TWO),
    "lag": (scene(actuator={"time_constant": 3.0e-4}), FEW),
    "limit": (scene(actuator={"torque_limit": 0.0021}), FEW),
    "torque step": (scene(actuator={"torque_step": 2.3e-4}), FEW),
    "virtual damping": (scene(wall={"damping": 4.0e-5}), FEW),
    "virtual damping, truncate": (scene(wall={"damping": 4.0e-5}, encoder={"rounding": "truncate"}), FEW),
    "delay": (scene(actuator={"delay_samples": 1.5}, encoder={"rounding": "ceil"}), FEW),
    "friction and finger": (scene(knob=LIGHT, hand=TWO_PARTS), TWO),
    "friction, lag, delay": (scene(knob=LIGHT, actuator={"time_constant": 3.0e-4, "delay_samples": 0.4}), FEW),
    "everything": (scene(**{**EVERYTHING, "knob": LIGHT}), TWO),
    "everything without friction": (scene(**{**EVERYTHING, "knob": {}}), FEW[2:]),
    "no encoder": (scene(encoder="none"), [(100.0, None), (RATES_HZ[1], None)]),
    "no encoder, delay": (scene(encoder="none", actuator={"delay_samples": 0.5}), [(100.0, None), (RATES_HZ[1], None)]),
    "no encoder, damping": (scene(encoder="none", wall={"damping": 2.0e-5}), [(100.0, None), (RATES_HZ[1], None)]),
    "no encoder, limit": (scene(encoder="none", actuator={"torque_limit": 0.002}), [(RATES_HZ[1], None)]),
    "no encoder, dead band": (
        scene(encoder="none", actuator={"dead_band": 2.0e-3}),
        [(300.0, None), (1000.0, None), (4000.0, None)],
    ),
    "no encoder, dead band, step": (
        scene(encoder="none", actuator={"dead_band": 3.0e-3, "torque_step": 1.0e-3}),
        [(300.0, None), (1000.0, None)],
    ),
    "no encoder, dead band, limit": (
        scene(encoder="none", actuator={"dead_band": 2.0e-3, "torque_limit": 2.2e-3}),
        [(1000.0, None), (4000.0, None)],
    ),
    "no encoder, step": (scene(encoder="none", actuator={"torque_step": 1.0e-3}), [(1000.0, None)]),
    "no encoder, finger": (scene(encoder="none", hand=TWO_PARTS), [(RATES_HZ[1], None)]),
}


@pytest.mark.one_in(18)
@pytest.mark.parametrize("name", SCENES)
def test_proven_cycles(general: GeneralEngine, name: str) -> None:
    parts, clocks = SCENES[name]
    cycles = [check(found) for rate, counts in clocks for found in settle(general, parts, rate, counts)]
    assert cycles, "no proven cycle: nothing was tested"
