"""Cogging: against 60 digits, an integrator of the triangle itself, long runs, its energy, and the scene without any.

The integrator shares nothing with the package but the numbers of the spec: its torque is a triangle wave by arcsine of
sine, and it begins anew where the cosine is 0.
"""

from functools import cache
from math import asin, cos, floor, pi, sin
from random import Random
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hknob_cli.engine.general.cogging import STABLE, UNSTABLE
from hknob_cli.engine.general.search import GeneralEngine, as_compiled
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.general_orbit import RATTLE, GeneralMeasurer
from hknob_cli.scene.general_knob import GeneralKnob, follow_knob, sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.plan import Record
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.stages.sweep.record import energy, record_trial
from tests import digits as mp

from . import general_reference as reference
from .general_orbits import solve
from .general_scenes import LIGHT, RUBBING, TWO_PARTS, scene
from .law_scenes import FOR_EVER

Array = np.ndarray[Any, Any]
SAMPLES = 40
TRIAL: dict[str, Any] = {"angle_rad": 0.02, "velocity_rad_s": -0.5, "phase": 0.37, "samples": SAMPLES}
CLEAR = 1e-6  # counts from an edge within which rounding may decide
WITHIN = 1e-9  # of a position, by the largest and a count
STEP = 1e-8  # rad, of a start beside another
BARE = {"inertia": 1.9e-6, "damping": 0.0}  # a knob without damping of its own
FEW = {"torque": 1e-3, "per_revolution": 84, "centre": 0.03}
STRONG = {"torque": 6e-3, "per_revolution": 132, "centre": -0.011}
DENSE = {"torque": 1e-3, "per_revolution": 2000, "centre": 1e-4}  # many corners in each sample
GEAR = {"ratio": 2.5, "motor_inertia": 1e-8, "stiffness": 20.0, "mesh_damping": 1e-3}
CASES: dict[str, dict[str, Any]] = {
    "alone": scene(cogging=FEW),
    "strong": scene(cogging=STRONG),
    "many corners": scene(cogging=DENSE),
    "friction": scene(knob=LIGHT, cogging=STRONG),
    "much friction, a delay by a part": scene(knob=RUBBING, cogging=DENSE, actuator={"delay_samples": 1.4}),
    "finger, friction, lag": scene(hand=TWO_PARTS, knob=LIGHT, actuator={"time_constant": 3e-4}, cogging=STRONG),
    "winding, no spring of a hand": scene(
        hand={"inertia": 3e-7, "damping": 3e-4, "stiffness": 0.0},
        motor={"torque_constant": 0.0234, "resistance": 2.32, "inductance": 2.38e-4, "winding": "shorted"},
        cogging=STRONG,
    ),
    "hysteresis, rounding, offset": scene(
        encoder={"hysteresis_counts": 0.7, "rounding": "nearest", "offset_counts": 0.3}, cogging=DENSE
    ),
    "slack, finger, friction": scene(encoder={"backlash": 2e-3}, hand=TWO_PARTS, knob=LIGHT, cogging=STRONG),
    "a gear that yields": scene(knob={"coulomb_torque": 0.0}, gear=GEAR, cogging=FEW),
    "detents, limit, virtual damping": scene(
        wall={"damping": 3e-5},
        detents={"per_revolution": 60, "torque": 2e-3},
        actuator={"torque_limit": 4e-3},
        cogging=STRONG,
    ),
}


def knob_of(parts: dict[str, Any], rate: float = 1000.0, counts: int = 1024) -> GeneralKnob:
    """The cell of a scene."""
    return sample_general(reduced(SceneSpec.model_validate(parts).plain()), sample_rate_hz=rate, counts_per_rev=counts)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", CASES)
def test_every_sample_at_60_digits(name: str) -> None:
    knob = knob_of(CASES[name])
    got = follow_knob(knob, **TRIAL)
    model = reference.simulate(
        CASES[name],
        sample_rate_hz=1000.0,
        counts_per_rev=1024,
        angle_rad=0.02,
        velocity_rad_s=-0.5,
        phase=0.37,
        samples=SAMPLES,
    )
    clear = min(model.edge / knob.quantum_rad, model.step / (0.27 * knob.quantum_rad))
    assert clear > CLEAR, "rounding may decide: choose another scene"
    assert model.friction.parted > 0  # corners were passed
    size = 1.0 + float(np.abs(got.angle_rad).max()) / knob.quantum_rad
    for angle, sample in zip(got.angle_rad, model.samples, strict=True):
        assert abs(float((sample.angle - mp.mpf(float(angle))) / mp.mpf(knob.quantum_rad))) <= WITHIN * size


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("name", CASES)
def test_compiled_to_the_last_bit(name: str) -> None:
    knob = knob_of(CASES[name])
    for one, other in zip(follow_knob(knob, **TRIAL), follow_knob(knob, **TRIAL, compiled=True), strict=True):
        assert np.array_equal(one, other)


def triangle(theta: float, cogging: dict[str, float]) -> float:
    """Torque of cogging at an angle [N m]."""
    turned = cogging["per_revolution"] * (theta - cogging["centre"])
    return -cogging["torque"] * 2.0 / pi * asin(sin(turned))


def integrated(parts: dict[str, Any], *, rate: float, counts: int, start: tuple[float, float], samples: int) -> Array:
    """Angles at samples by DOP853, begun anew at each corner; the first comes half a period late."""
    knob, hand, period, quantum = parts["knob"], parts["hand"], 1.0 / rate, 2.0 * pi / counts
    inertia, damping = knob["inertia"] + hand["inertia"], knob.get("damping", 0.0) + hand["damping"]
    z: Array = np.array(start)
    found = []
    for i in range(samples + 1):
        command = -parts["wall"]["stiffness"] * min(floor(z[0] / quantum), 0) * quantum if i else 0.0

        def rates(_: float, y: Array, u: float = command) -> list[float]:
            torque = u - parts["bias"]["torque"] - hand["stiffness"] * y[0] - damping * y[1]
            return [y[1], (torque + triangle(y[0], parts["cogging"])) / inertia]

        def corner(_: float, y: Array) -> float:
            return cos(parts["cogging"]["per_revolution"] * (y[0] - parts["cogging"]["centre"]))

        corner.terminal = True  # type: ignore[attr-defined]
        t, end = 0.0, period if i else 0.5 * period
        while t < end:
            short = min(1e-5 * period, 0.5 * (end - t))
            past = solve_ivp(rates, (t, t + short), z, "DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
            part = solve_ivp(
                rates, (t + short, end), past, "DOP853", events=corner, rtol=1e-12, atol=1e-15, max_step=period / 8
            )
            z, t = part.y[:, -1], float(part.t[-1])
        found.append(z[0])
    return np.array(found)


def compared(seed: int) -> bool:
    """Whether a random scene stays clear of edges; then every sample is the integrator's.

    Within 1e-11, ten times its tolerance, times what a difference of starts grows to by then.
    """
    chance = Random(seed)
    parts = scene(
        knob={"coulomb_torque": 0.0, "damping": chance.choice([0.0, 1e-4])},
        cogging={
            "torque": 10.0 ** chance.uniform(-3.5, -2.0),
            "per_revolution": chance.choice([24, 84, 400]),
            "centre": chance.uniform(-0.1, 0.1),
        },
    )
    rate, counts = chance.choice([500.0, 1000.0, 3000.0]), chance.choice([128, 1024])
    expected, other = (
        integrated(parts, rate=rate, counts=counts, start=(angle, -0.5), samples=60) for angle in (0.02, 0.02 + STEP)
    )
    at = np.array([expected, other]) / (2.0 * pi / counts)
    if np.abs(at - np.rint(at)).min() < 1e-4:
        return False
    grown = np.maximum.accumulate(np.maximum(np.abs(other - expected) / STEP, 1.0))
    got = follow_knob(knob_of(parts, rate, counts), angle_rad=0.02, velocity_rad_s=-0.5, phase=0.5, samples=60)
    assert (np.abs(got.angle_rad - expected) <= 1e-11 * grown).all(), seed
    return True


def test_random_scenes_against_an_integrator_of_the_triangle() -> None:
    assert sum(compared(seed) for seed in range(10)) >= 6


@pytest.mark.long
def test_many_random_scenes_against_an_integrator_of_the_triangle() -> None:
    assert sum(compared(seed) for seed in range(10, 60)) >= 30


class Cell:
    """One cell, followed by the engine; ``in_code``: by compiled code, which few trials do not repay."""

    def __init__(
        self,
        parts: dict[str, Any],
        *,
        rate: float = 1000.0,
        counts: int = 1024,
        phases: int = 4,
        in_code: bool = False,
    ) -> None:
        self.parts, self.rate, self.counts = parts, rate, counts
        self.knob = knob_of(parts, rate, counts)
        self.engine = GeneralEngine(compiled("general")) if in_code else GeneralEngine(patience=FOR_EVER)
        self.found = self.engine.search(
            self.knob.body,
            self.knob.wall,
            self.knob.start(0.02, 0.0),
            rate=self.knob.rate,
            phases=phases,
            delay_line=self.knob.delay_line,
            max_samples=16384,
        ).attractors
        self.measurer = GeneralMeasurer(self.knob, self.engine)


@cache
def cells(*, in_code: bool) -> tuple[Cell, ...]:
    """Cogging that holds the knob, that lets it buzz, and that keeps it moving, at eight places each."""
    torques = [(torque, 0.06545 * place / 7) for torque in (3e-4, 1e-3, 3e-3, 1e-2) for place in range(8)]
    return tuple(
        Cell(scene(knob=knob, cogging={"torque": torque, "per_revolution": 84, "centre": centre}), in_code=in_code)
        for torque, centre in torques
        for knob in (BARE, *([{**BARE, **LIGHT}] if torque == 3e-3 else []))
    )


def slopes_of(cell: Cell, end: Any) -> set[int]:
    """Kinds of slope that a cycle is on."""
    chart = cell.engine.chart(cell.knob.body, cell.knob.wall, end)
    assert chart is not None
    return {int(kind) for kind in np.abs(chart.modes)} & {STABLE, UNSTABLE}


def corners_passed(cell: Cell, end: Any) -> int:
    """How often a cycle passes a corner in a period, by its extremes alone."""
    cogs, measured = cell.parts["cogging"], GeneralMeasurer(cell.knob, cell.engine).measure(end)
    low, high = (
        floor((angle - cogs["centre"]) * cogs["per_revolution"] / pi + 0.5)
        for angle in (measured.min_rad, measured.max_rad)
    )
    return high - low


@pytest.mark.long
def test_cycles_are_proven_on_one_slope_and_over_corners() -> None:
    proven = over = 0
    for cell in cells(in_code=True):
        for end in cell.found:
            if end.outcome is Outcome.CYCLE:
                assert end.reason in (Reason.NONE, Reason.AT_EVENT)
                proven += end.certified
                over += end.certified and corners_passed(cell, end) > 0
    assert proven >= 12
    assert over >= 4


@pytest.mark.long
def test_proven_cycles_again_at_60_digits() -> None:
    """Within the bound that each was given; on one slope to many more digits than over corners."""
    checked = over = 0
    for cell in cells(in_code=True):
        for end in cell.found:
            if end.outcome is not Outcome.CYCLE or not end.certified or end.period > 30:
                continue
            solved = solve(cell.parts, cell.rate, cell.counts, cell.knob, end)
            assert solved.closes
            x = solved.run.states[0][0] / solved.control.quantum - mp.mpf(cell.knob.shift)
            assert abs(float(x - mp.mpf(end.x))) <= end.bound
            checked += 1
            over += solved.run.corners > 0
    assert checked >= 8
    assert over >= 2


@pytest.mark.long
@pytest.mark.parametrize("more", [{}, {"encoder": {"hysteresis_counts": 0.15}}])
def test_a_motion_that_grows_is_given_up(more: dict[str, Any]) -> None:
    """Each corner takes its steps, and a motion a million times as large as its start passes millions of them."""
    grows = {"dead_zone": {"width": 0.0115, "stiffness": 1.5}, "wall": {"stiffness": 0.0}}
    parts = scene(hand=TWO_PARTS, cogging={**STRONG, "torque": 4e-4}, **grows, **more)
    cell = Cell(parts, rate=464.0, counts=256, in_code=True)
    (end,) = cell.found
    assert (end.outcome, end.reason, end.trials) == (Outcome.DIVERGED, Reason.RACES, 4.0)


def test_energy_of_cycles_over_corners() -> None:
    """Cogging gives back what it takes: the wall's work is what damping takes, to 1e-9, over corners, too."""
    over = 0
    for cell in cells(in_code=False):
        for end in cell.found:
            if end.outcome is Outcome.CYCLE:
                measured = cell.measurer.measure(end)
                lost = measured.damping_loss_j + (measured.friction_loss_j if cell.knob.body.friction else 0.0)
                assert measured.wall_work_j == pytest.approx(lost, rel=1e-9)
                over += corners_passed(cell, end) > 0
    assert over >= 2


@pytest.mark.long
def test_trials_that_are_proven_to_rest_do_so_by_the_integrator() -> None:
    checked = 0
    for cell in cells(in_code=True):
        for end in cell.found:
            if end.outcome is not Outcome.REST or not end.certified or cell.knob.body.friction:
                continue
            if checked == 6:
                return
            last = integrated(cell.parts, rate=cell.rate, counts=cell.counts, start=(0.02, 0.0), samples=400)[-1]
            places = [cell.knob.angle_rad(one.x) for one in cell.found if one.outcome is Outcome.REST]
            assert min(abs(last - place) for place in places) < 1e-8
            checked += 1
    assert checked >= 4


@pytest.mark.long
def test_proven_cycles_draw_what_is_said_to_come_to_them() -> None:
    """From random states within the margin of a proven cycle's deepest sample, by the energy with cogging's spring.

    Over corners, or where the springs of its slope do not hold, the spring is that of a stable slope.
    """
    chance, checked = Random(1), 0
    advance = compiled("general")["general.advance"]
    for cell in cells(in_code=True):
        body, wall = as_compiled(cell.knob.body, cell.knob.wall)
        for end in cell.found:
            if end.outcome is not Outcome.CYCLE or not end.certified or end.period > 60 or checked == 40:
                continue
            one_slope = corners_passed(cell, end) == 0 and slopes_of(cell, end) == {UNSTABLE}
            hold = body.beta - body.cogs[0] if one_slope else body.beta + body.cogs[0]
            hold = hold if hold > 0.0 else body.beta + body.cogs[0]
            reach, pad, line = end.margin - end.bound, np.zeros(4), np.zeros(0)
            turn = chance.uniform(0.0, 2.0 * pi)
            off = np.array([reach * np.cos(turn), reach * np.sqrt(hold) * np.sin(turn)]) * 0.999
            z, before = np.array([end.x, end.v]) + off, end.before
            for _ in range(200 * end.period):
                before, _ = advance(z, before, line, 0, body, wall, pad)
            beside = np.array([end.x, end.v])
            if not body.friction:
                assert np.abs(z - beside).max() < 1e-3 * np.abs(off).max() + 1e-9
            else:
                assert np.abs(z - beside)[0] <= reach
            checked += 1
    assert checked >= 8


def test_a_cycle_is_proven_on_either_side_of_a_corner_and_with_less_room_than_there_is() -> None:
    """The corner is moved past the highest turn; no motion that turns beyond it may be said to come to the cycle."""
    quarter, sides = 0.5 * pi / 84, set()
    for corner in np.linspace(0.0, 0.009, 10):
        cogging = {"torque": 3e-4, "per_revolution": 84, "centre": corner + quarter}
        cell = Cell(scene(knob=BARE, cogging=cogging), phases=1)
        (end,) = cell.found
        assert end.outcome is Outcome.CYCLE
        assert end.certified
        beside = corner - GeneralMeasurer(cell.knob, cell.engine).measure(end).max_rad
        assert end.margin - end.bound <= abs(beside) / cell.knob.quantum_rad
        sides.add(beside > 0.0)
    assert sides == {True, False}


def test_an_unstable_slope_keeps_the_knob_moving_and_parts_motions_as_its_rates_say() -> None:
    """The exponent is the unstable root of J s² + b s + k less the slope, as no command tells neighbours apart."""
    cell = Cell(scene(knob={"coulomb_torque": 0.0}, cogging={**FEW, "centre": 0.0374}))
    (end,) = cell.found
    measured = GeneralMeasurer(cell.knob, GeneralEngine()).measure(end)
    assert (end.outcome, end.reason) == (Outcome.UNDECIDED, Reason.NO_REPEAT)
    inertia, damping = 1.98e-6 + 3e-7, 3.45e-4 + 1.1e-5
    spring = 0.04 - 2.0 * FEW["torque"] * FEW["per_revolution"] / pi
    fast = max(np.roots([inertia, damping, spring]).real)
    # The columns begin in all directions, and count e^2 at most, once in the 4096 samples.
    assert measured.parting_per_s == pytest.approx(fast, abs=2.0 * 1000.0 / RATTLE)
    assert 1e-3 < measured.rattle_p2p_rad < 0.02
    assert measured.cycles == 0


def test_energy_of_a_recording_falls_only_by_what_damps() -> None:
    """Without any damping, and outside the wall, energy is kept over hundreds of corners to 1e-12."""
    parts = scene(
        knob={"damping": 0.0},
        hand={"inertia": 3e-7, "damping": 0.0, "stiffness": 0.04},
        wall={"stiffness": 0.0},
        bias={"torque": 0.0},
        cogging={**DENSE, "torque": 2e-3},
        dead_zone={"width": 100.0, "stiffness": 0.1},
    )
    plain = reduced(SceneSpec.model_validate(parts).plain())
    rows = list(record_trial(knob_of(parts), Record(0.2, 1e-3, 1), angle=0.3, velocity=-0.5, phase=0.37))
    energies = np.array([energy(plain, 0.0, row) for row in rows])
    angles = np.array([row.angle for row in rows])
    assert np.ptp(angles) > 100 * pi / DENSE["per_revolution"]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-12)


def test_no_torque_is_no_cogging() -> None:
    """To the last bit: the numbers of the scene without."""
    without, zero = knob_of(scene()), knob_of(scene(cogging={"torque": 0.0, "per_revolution": 84}))
    assert zero.body.cogs is None
    assert zero == without


def test_a_rigid_gear_has_the_cogging_of_its_motor() -> None:
    """Behind 1:n the torque counts n times, and its places of rest are n times as many."""
    geared = knob_of(scene(gear={"ratio": 4.0, "motor_inertia": 0.0}, cogging=FEW), counts=256)
    direct = knob_of(
        scene(cogging={"torque": 4.0 * FEW["torque"], "per_revolution": 336, "centre": FEW["centre"] / 4.0}),
    )
    numbers: dict[str, Any] = {"angle_rad": 0.02, "velocity_rad_s": -0.5, "phase": 0.37, "samples": 60}
    assert np.array_equal(follow_knob(geared, **numbers).angle_rad, follow_knob(direct, **numbers).angle_rad)
