"""Backlash of a gear: against an integrator, 60 digits, its energy balance, and the gear without any."""

from math import pi
from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.search import GeneralEngine, as_arrays
from hknob_cli.engine.general.teeth import APART, pressing
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.general_orbit import RATTLE, GeneralMeasurer
from hknob_cli.scene.general_knob import GeneralKnob, Trial, sample_general, simulate
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.plan import Scene
from hknob_cli.specs.scene import SceneSpec
from tests import digits as mp

from .backlash_digits import Teeth
from .backlash_reference import Backlash

Array = np.ndarray[Any, Any]
IDRIVE: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 3e-4},
    "gear": {"ratio": 7.4, "motor_inertia": 1e-8, "stiffness": 10.0, "mesh_damping": 2e-4, "backlash": 0.3 * pi / 180},
}
EDGE = 1e-6  # counts; a sample nearer to an edge could be read as either
STEP = 1e-10  # rad, of a start beside another


def plain(scene: dict[str, Any]) -> Scene:
    found: Scene = reduced(SceneSpec.model_validate(scene).plain())
    return found


def random_scene(chance: Random) -> dict[str, Any]:
    """A geared knob, its mesh soft or stiff, hardly or well damped, whose teeth part or not."""
    return {
        "knob": {"inertia": chance.choice([1.9e-6, 2e-5]), "damping": chance.choice([0.0, 1e-4])},
        "hand": {
            "inertia": 3.0e-7,
            "damping": 10 ** chance.uniform(-3.5, -2.0),
            "stiffness": chance.choice([0.04, 0.5]),
        },
        "wall": {"stiffness": chance.uniform(0.1, 1.0)},
        "bias": {"torque": 10 ** chance.uniform(-4.0, -2.5)},
        "gear": {
            "ratio": 7.4,
            "motor_inertia": chance.choice([1e-7, 1e-6]) / 7.4**2,
            "motor_damping": chance.choice([0.0, 1e-7]),
            "stiffness": chance.choice([0.5, 5.0, 50.0]),
            "mesh_damping": chance.choice([0.0, 1e-4, 2e-3, 2e-2]),
            "backlash": chance.choice([0.02, 0.1, 0.3, 1.0]) * pi / 180,
        },
    }


def integrated(
    scene: dict[str, Any], *, rate_hz: float, counts: int, angle: float, samples: int, steps: int = 16
) -> tuple[Array, bool]:
    """States by DOP853 (samples + 1, 4), and whether teeth have parted; the first sample comes half a period late."""
    model = Backlash(scene, rate_hz=rate_hz, counts=counts, backlash=scene["gear"]["backlash"])
    model.steps = steps
    period, start = model.period, np.array([angle + model.h, 0.0, angle, 0.0])
    model.period = 0.5 * period
    pulled = scene["bias"]["torque"] + scene["hand"]["stiffness"] * angle > 0.0  # the knob, towards the wall's flank
    start, side, _, opened = model._hold(start, int(pulled), 0.0)
    model.period = period
    motion = model.run(start, samples, side=side)
    motion.states[:, 0] -= model.h
    return motion.states, opened or any(motion.parted)


def compared(seed: int, samples: int = 40) -> bool:
    """Whether teeth part in a random scene that could be compared with the integrator, sample by sample.

    Twice its steps tell by how much the integrator errs, mostly where it interpolates the end of a mode. Beside that
    there is its tolerance, 1e-12 of an angle, in each of some 20 steps of a sample. Where its error does not fall yet,
    eight times the steps tell (seed 63: by 4e-10 rad with 8, 16 and 32 steps a sample, 5e-12 with 512).
    """
    chance = Random(seed)
    scene, rate, counts = random_scene(chance), chance.choice([500.0, 1000.0, 3000.0]), chance.choice([100, 360])
    angle = chance.uniform(-0.01, 0.03)
    coarse, opened = integrated(scene, rate_hz=rate, counts=counts, angle=angle, samples=samples, steps=8)
    at = coarse[:, 0] / (2 * pi / counts / 7.4)
    if np.abs(at - np.rint(at)).min() < EDGE:
        return False
    got = trial(scene, rate_hz=rate, counts=counts, angle=angle, samples=samples)
    for steps in (16, 128, 1024):
        expected, _ = integrated(scene, rate_hz=rate, counts=counts, angle=angle, samples=samples, steps=steps)
        told = np.maximum.accumulate(np.abs(coarse - expected)[:, 0])
        bound = 1e-12 * 0.03 * 20 * np.arange(1, samples + 2) + told
        off = np.abs(got.angle_rad - expected[:, 0])
        if (off <= bound).all():
            return opened
        coarse = expected
    raise AssertionError(f"seed {seed} off by {off.max():.3g} rad, {(off / bound).max():.3g} of the bound")


def trial(scene: dict[str, Any], *, rate_hz: float, counts: int, angle: float, samples: int) -> Trial:
    return simulate(
        plain(scene), sample_rate_hz=rate_hz, counts_per_rev=counts, angle_rad=angle, phase=0.5, samples=samples
    )


@pytest.mark.long
def test_random_scenes_against_an_integrator() -> None:
    assert sum(compared(seed) for seed in range(12)) >= 8


@pytest.mark.long
def test_many_random_scenes_against_an_integrator() -> None:
    assert sum(compared(seed) for seed in range(12, 80)) >= 40


@pytest.mark.one_in(2)
@pytest.mark.parametrize("changes", [{}, {"mesh_damping": 0.0}])
def test_a_trial_at_60_digits(changes: dict[str, float]) -> None:
    """Some 64 roundings of an angle in a sample, which grow as two of the model's own motions part."""
    rate, counts = 1000.0, 360
    scene = {**IDRIVE, "gear": {**IDRIVE["gear"], **changes}}
    samples = 30
    model = Teeth(scene, rate_hz=rate, counts=counts)
    expected, other = model.run(0.012, samples), model.run(0.012 + STEP, samples)
    assert model.closest > EDGE
    assert model.events >= 20  # in both runs
    got = trial(scene, rate_hz=rate, counts=counts, angle=0.012, samples=samples)
    grown = 1.0
    for i, (one, near) in enumerate(zip(expected, other, strict=True)):
        grown = max(grown, abs(float(near.motor - one.motor)) / STEP)
        bound = 64 * (i + 1) * 2.0**-53 * 0.03 * grown
        assert abs(float(mp.mpf(float(got.angle_rad[i])) - one.motor)) <= bound


class Cell:
    """One cell, followed by the compiled engine."""

    def __init__(
        self, scene: dict[str, Any], *, rate_hz: float, counts: int, phases: int = 4, most: int = 16384
    ) -> None:
        self.scene, self.rate_hz, self.counts = scene, rate_hz, counts
        self.knob: GeneralKnob = sample_general(plain(scene), sample_rate_hz=rate_hz, counts_per_rev=counts)
        self.engine = GeneralEngine(compiled("general"))
        self.found = self.engine.search(
            self.knob.body,
            self.knob.wall,
            self.knob.start(0.02, 0.0),
            rate=self.knob.rate,
            phases=phases,
            delay_line=self.knob.delay_line,
            max_samples=most,
        ).attractors
        self.measures = [GeneralMeasurer(self.knob, self.engine).measure(one) for one in self.found]


@pytest.fixture(scope="module")
def cells() -> list[Cell]:
    found = []
    for seed in range(20):
        chance = Random(seed)
        scene, rate, counts = random_scene(chance), chance.choice([500.0, 1000.0, 3000.0]), chance.choice([100, 360])
        if chance.random() < 0.3:
            scene["actuator"] = {"delay_samples": chance.choice([1.0, 0.4])}
        if chance.random() < 0.3:
            scene["actuator"] = {**scene.get("actuator", {}), "time_constant": 2e-4}
        found.append(Cell(scene, rate_hz=rate, counts=counts))
    return found


@pytest.mark.long
def test_energy_of_cycles_through_the_play(cells: list[Cell]) -> None:
    """Work of the wall is what dampers take, and what springs of teeth lose that have parted while they overlapped.

    1e-9 of what is put in: some hundred pieces of a period, each of which rounds an energy of a hundred times the loss.
    """
    parted = 0
    for cell in cells:
        for one, measures in zip(cell.found, cell.measures, strict=True):
            if one.outcome is not Outcome.CYCLE or not measures.cycles:
                continue
            parted += one.reason is Reason.PARTS
            assert measures.wall_work_j == pytest.approx(measures.damping_loss_j, rel=1e-9)
            assert one.certified == (one.reason is Reason.NONE)
            assert one.reason is Reason.PARTS or measures.mesh_least_nm > 0.0
            assert one.certified or measures.mesh_least_nm <= 0.0
    assert parted >= 8


@pytest.mark.long
def test_cycles_through_the_play_by_the_integrator(cells: list[Cell]) -> None:
    """A cycle of the engine closes by DOP853, too, and by what its tolerance grows to over a period."""
    checked = 0
    for cell in cells:
        if "actuator" in cell.scene:
            continue
        for one in cell.found:
            if one.reason is not Reason.PARTS or one.period > 60:
                continue
            knob, model = (
                cell.knob,
                Backlash(cell.scene, rate_hz=cell.rate_hz, counts=cell.counts, backlash=cell.scene["gear"]["backlash"]),
            )
            scales = [knob.quantum_rad, knob.quantum_rad / knob.period_s]
            x, v, d, w = (float(value) * scales[i % 2] for i, value in enumerate([one.x, one.v, *one.state]))
            start = np.array([x + model.h, v, x - d, v - w])
            side = 1 if model.pressing(start, 1) > 0 else -1 if model.pressing(start, -1) > 0 else 0
            motion = model.run(start, one.period, side=side)
            assert any(motion.parted)
            off = np.abs(motion.states[-1] - start)
            assert off[[0, 2]].max() < 1e-12 * 20 * one.period * max(abs(x), 1.0)
            checked += 1
    assert checked >= 3


def test_teeth_on_one_flank_make_the_same_proven_cycles_with_any_backlash() -> None:
    steady = {**IDRIVE, "bias": {"torque": 1e-3}}
    found = []
    for backlash in (0.0, 1e-5, 0.005, 0.5):
        cell = Cell({**steady, "gear": {**IDRIVE["gear"], "backlash": backlash}}, rate_hz=1000.0, counts=360)
        assert all(one.certified for one in cell.found)
        found.append(
            sorted(
                (one.period, m.knob_p2p_rad, m.mesh_least_nm) for one, m in zip(cell.found, cell.measures, strict=True)
            )
        )
        assert all(least > 0.0 for _, _, least in found[-1])
    for other in found[1:]:
        assert [one[0] for one in other] == [one[0] for one in found[0]]
        assert np.array(other) == pytest.approx(np.array(found[0]), rel=1e-9)


def test_a_knob_pressed_into_the_wall_rests_on_one_flank() -> None:
    """Proven, with the knob a count's torque deep or none: a push that the wall holds in the middle of a count."""
    scene = {**IDRIVE, "wall": {"stiffness": 0.27}, "hand": {"inertia": 3e-7, "damping": 0.02, "stiffness": 0.5}}
    scene["bias"] = {"torque": 0.27 * 3 * 2 * pi / 360 / 7.4 + 0.5 * 2.5 * 2 * pi / 360 / 7.4}
    cell = Cell(scene, rate_hz=3000.0, counts=360)
    assert any(one.outcome is Outcome.REST and one.certified for one in cell.found)


@pytest.mark.long
def test_chaos_is_what_two_motions_do() -> None:
    """The exponent of the derivative against a neighbour, brought back to 1e-9 counts after every sample (Benettin).

    The last place of a difference of 1e-9 is 1e-6 of it, and its square 1e-9: they are nothing beside the directions in
    which both begin, which count a factor of e^10 at most, once in 4096 samples: 2.5 per second.
    """
    cell = Cell(IDRIVE, rate_hz=1000.0, counts=360, most=8192)
    (one,) = cell.found
    assert one.reason is Reason.NO_REPEAT
    advance, body, pad = compiled("general")["general.advance"], as_arrays(cell.knob.body), np.zeros(8)
    z, before, line = np.array([one.x, one.v, *one.state]), one.before, np.zeros(0)
    beside, small, total = z + 1e-9 * np.array([0.5, 0.5, 0.5, 0.5]), 1e-9, 0.0
    for _ in range(RATTLE):
        now = before
        before, _ = advance(z, now, line, 0, body, cell.knob.wall, pad)
        other, _ = advance(beside, now, line, 0, body, cell.knob.wall, pad)
        assert other == before
        off = float(np.linalg.norm(beside - z))
        total += np.log(off / small)
        beside = z + (beside - z) * (small / off)
    exponent = cell.measures[0].parting_per_s
    assert exponent > 100.0
    assert total / RATTLE * 1000.0 == pytest.approx(exponent, abs=2.5 + 0.01 * exponent)


def test_no_backlash_is_the_gear_without_to_the_last_bit() -> None:
    without = {**IDRIVE, "gear": {key: value for key, value in IDRIVE["gear"].items() if key != "backlash"}}
    zero = {**without, "gear": {**without["gear"], "backlash": 0.0}}
    one, other = (Cell(scene, rate_hz=1000.0, counts=360) for scene in (without, zero))
    assert one.found == other.found
    assert one.measures[0].knob_p2p_rad == other.measures[0].knob_p2p_rad > 0.0
    assert np.isnan(other.measures[0].rattle_p2p_rad)


@pytest.mark.long
def test_teeth_never_pull_and_leave_before_they_are_apart(cells: list[Cell]) -> None:
    """Of a cycle through the play: what its mesh carries presses, and a damped tooth is left while it overlaps."""
    for cell in cells:
        body = cell.knob.body
        for one in cell.found:
            if one.reason is not Reason.PARTS:
                continue
            chart = cell.engine.chart(body, cell.knob.wall, one)
            assert chart is not None
            size = float(np.abs(chart.states[:, 2]).max())
            for kind, side in ((1.0, 1), (3.0, -1)):
                these = np.flatnonzero(np.abs(chart.modes) == kind)
                for i in (*these, *(these + 1)):
                    state = chart.states[i]
                    assert pressing(state, 0, side, body) > -1e-9 * body.pad_stiffness * size
            left = np.flatnonzero((np.abs(chart.modes[:-1]) == 1.0) & (np.abs(chart.modes[1:]) == float(APART))) + 1
            assert (chart.states[left, 2] > 0.0).all() or body.pad_damping == 0.0
            if body.pad_damping > 0.0 and len(left):
                return
    pytest.fail("no damped tooth was left")
