"""A gear against a 60-digit model of two shafts: the motor in its own turns and torques, the push on the knob.

The package reflects the motor to the knob, takes angles relative to each other, and moves the push into the hand's
spring. The model does none of this: it has the angle of the motor, and the matrix exponential of both shafts.
"""

from itertools import pairwise
from math import ceil
from random import Random
from typing import Any, NamedTuple

import numpy as np
import pytest

from hknob_cli.scene.general_knob import simulate
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import COUNTS, RATE, SweepPlan
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.specs.source import Source
from hknob_cli.stages.sweep.record import record_sweep
from hknob_cli.stages.sweep.run import SweepStage
from tests import digits as mp

from .backlash_reference import Backlash

EPSILON = 2.0**-53
FLOOR = 1e-9  # counts; a sample nearer to an edge of a count could be read as either
Matrix = list[list[Any]]


class Sample(NamedTuple):
    """Angles (rad) and velocities (rad/s) of the motor, over the ratio, and of the knob; torque at the knob (N·m)."""

    motor: Any
    motor_speed: Any
    knob: Any
    knob_speed: Any
    torque: Any


def exponential(a: Matrix, t: Any) -> Matrix:
    """exp(a t): the series of a part of t so short that 60 terms do, squared."""
    n = len(a)
    size = float(max(sum(abs(x) for x in row) for row in a) * t)
    squarings = max(0, ceil(size).bit_length() + 2)
    h = mp.ldexp(t, -squarings)
    total = [[mp.mpf(int(i == j)) for j in range(n)] for i in range(n)]
    term = [row[:] for row in total]
    for k in range(1, 60):
        term = [[value * h / k for value in row] for row in product(term, a)]
        total = [[x + y for x, y in zip(*rows, strict=True)] for rows in zip(total, term, strict=True)]
    for _ in range(squarings):
        total = product(total, total)
    return total


def product(a: Matrix, b: Matrix) -> Matrix:
    columns = list(zip(*b, strict=True))
    return [[mp.fsum(x * y for x, y in zip(row, column, strict=True)) for column in columns] for row in a]


class Shafts:
    """Two shafts and the amplifier: state (φ, φ', θ, θ', torque at the motor, 1, command)."""

    def __init__(self, scene: dict[str, Any], *, rate_hz: float, counts: int) -> None:
        self.scene, self.period = scene, 1 / mp.mpf(rate_hz)
        gear, hand, knob = scene["gear"], scene["hand"], scene["knob"]
        self.n = n = mp.mpf(gear["ratio"])
        stiffness, mesh = mp.mpf(gear["stiffness"]), mp.mpf(gear.get("mesh_damping", 0.0))
        motor, inertia = mp.mpf(gear["motor_inertia"]), mp.mpf(knob["inertia"]) + mp.mpf(hand["inertia"])
        damping = mp.mpf(gear.get("motor_damping", 0.0))
        if "motor" in scene:
            damping += mp.mpf(scene["motor"]["torque_constant"]) ** 2 / mp.mpf(scene["motor"]["resistance"])
        resisting = mp.mpf(knob.get("damping", 0.0)) + mp.mpf(hand["damping"])
        push = mp.mpf(scene["bias"]["torque"]) if "bias" in scene else mp.mpf(0)
        self.count = 2 * mp.pi / counts  # of the motor's turn
        carried = [stiffness / n, mesh / n, -stiffness, -mesh]  # torque of the mesh at the knob, by the state
        actuator = scene.get("actuator", {})
        self.lag = mp.mpf(actuator.get("time_constant", 0.0))
        zero = [mp.mpf(0)] * 7
        a = [zero[:] for _ in range(7)]
        a[0][1] = a[2][3] = mp.mpf(1)
        a[1][:4] = [-value / n / motor for value in carried]
        a[1][1] -= damping / motor
        a[1][4 if self.lag else 6] += 1 / motor
        a[3][:4] = [value / inertia for value in carried]
        a[3][2] -= mp.mpf(hand["stiffness"]) / inertia
        a[3][3] -= resisting / inertia
        a[3][5] = -push / inertia
        if self.lag:
            a[4][4], a[4][6] = -1 / self.lag, 1 / self.lag
        self.a = a
        delay = mp.mpf(actuator.get("delay_samples", 0.0))
        self.whole = int(delay)
        self.split = delay - self.whole
        self.parts = exponential(a, self.split * self.period), exponential(a, (1 - self.split) * self.period)
        self.closest = mp.mpf(1)

    def command(self, angle: Any) -> Any:
        """Torque at the motor, of the count that its angle is in."""
        at = angle / self.count
        count = mp.floor(at)
        self.closest = min(self.closest, at - count, count + 1 - at)
        if count >= 0:
            return mp.mpf(0)
        actuator = self.scene.get("actuator", {})
        torque = -mp.mpf(self.scene["wall"]["stiffness"]) * (count * self.count / self.n) / self.n
        if step := actuator.get("torque_step", 0.0):
            steps = torque / mp.mpf(step) + mp.mpf(0.5)
            self.closest = min(self.closest, steps - mp.floor(steps), mp.floor(steps) + 1 - steps)
            torque = mp.mpf(step) * mp.floor(steps)
        limit = actuator.get("torque_limit")
        return torque if limit is None else min(mp.mpf(limit), max(-mp.mpf(limit), torque))

    def run(self, *, angle: float, velocity: float, phase: float, samples: int) -> list[Sample]:
        n, state = self.n, [mp.mpf(0)] * 7
        state[0], state[1] = n * mp.mpf(angle), n * mp.mpf(velocity)
        state[2], state[3], state[5] = mp.mpf(angle), mp.mpf(velocity), mp.mpf(1)
        state = apply(exponential(self.a, mp.mpf(phase) * self.period), state)
        late = [mp.mpf(0)] * (self.whole + 1)  # commands, the newest first
        found = []
        for i in range(samples + 1):
            late = [self.command(state[0]), *late[: self.whole + 1]]
            older, newer = late[self.whole + 1], late[self.whole]
            acting = state[4] if self.lag else older if self.split else newer
            found.append(Sample(state[0] / n, state[1] / n, state[2], state[3], n * acting))
            if i < samples:
                if self.split:
                    state[6] = older
                    state = apply(self.parts[0], state)
                state[6] = newer
                state = apply(self.parts[1], state)
        return found


def apply(a: Matrix, state: list[Any]) -> list[Any]:
    return [mp.fsum(x * y for x, y in zip(row, state, strict=True)) for row in a]


def random_scene(chance: Random) -> dict[str, Any]:
    """A geared knob, light or heavy, its mesh soft or stiff, with some of what else there may be."""
    ratio = chance.choice([0.5, 2.5, 7.4, 20.0])
    scene: dict[str, Any] = {
        "knob": {"inertia": chance.choice([1.9e-6, 2e-5]), "damping": chance.choice([0.0, 1e-4])},
        "hand": {
            "inertia": 3.0e-7,
            "damping": chance.uniform(2e-4, 2e-3),
            "stiffness": chance.choice([0.004, 0.04, 0.5]),
        },
        "wall": {"stiffness": chance.uniform(0.1, 1.0)},
        "gear": {
            "ratio": ratio,
            "motor_inertia": chance.choice([1e-7, 1e-6, 1e-5]) / ratio**2,
            "motor_damping": chance.choice([0.0, 1e-5 / ratio**2]),
            "stiffness": chance.choice([0.5, 5.0, 50.0]),
            "mesh_damping": chance.choice([0.0, 1e-4, 2e-3]),
        },
    }
    if chance.random() < 0.8:
        scene["bias"] = {"torque": chance.uniform(2e-4, 3e-3)}
    actuator: dict[str, float] = {}
    if chance.random() < 0.4:
        actuator["delay_samples"] = chance.choice([1.0, 0.5, 1.25])
    if chance.random() < 0.3:
        actuator["time_constant"] = 2e-4
    if chance.random() < 0.3:
        actuator["torque_limit"] = 0.002 / ratio
    if chance.random() < 0.3:
        actuator["torque_step"] = 1e-4 / ratio
    if actuator:
        scene["actuator"] = actuator
    if chance.random() < 0.3:
        scene["motor"] = {"torque_constant": 0.01 / ratio, "resistance": 3.0, "winding": "shorted"}
    return scene


def compared(seed: int, samples: int = 100) -> bool:
    """Whether a random scene could be compared sample by sample; a sample too near to an edge is none."""
    chance = Random(seed)
    scene = random_scene(chance)
    rate, counts = chance.choice([500.0, 1000.0, 3000.0]), chance.choice([24, 100, 360])
    where = {"phase": chance.uniform(0.1, 0.9), "samples": samples}
    angle, velocity = chance.uniform(-0.05, 0.05), chance.uniform(-2.0, 2.0)
    model = Shafts(scene, rate_hz=rate, counts=counts)
    expected = model.run(angle=angle, velocity=velocity, **where)  # type: ignore[arg-type]
    if model.closest < FLOOR:
        return False
    made = reduced(SceneSpec.model_validate(scene).plain())
    got = simulate(
        made,
        sample_rate_hz=rate,
        counts_per_rev=counts,
        angle_rad=angle,
        velocity_rad_s=velocity,
        **where,  # type: ignore[arg-type]
    )
    # Roundings add up and do not grow, by energy; each is a few of the largest angle, or of where the hand is neutral.
    neutral = scene.get("bias", {"torque": 0.0})["torque"] / scene["hand"]["stiffness"]
    size = neutral + max(abs(float(one.knob)) + abs(float(one.motor)) for one in expected)
    speed = size * rate + max(abs(float(one.motor_speed)) for one in expected)
    pushed = max(float(abs(one.torque)) for one in expected)
    bounds = [64 * samples * EPSILON * value for value in (8 * size, 64 * speed, pushed + 1e-3 * size)]
    for name, part, bound in zip(
        ("angle_rad", "velocity_rad_s", "torque_nm"), ("motor", "motor_speed", "torque"), bounds, strict=True
    ):
        if name == "torque_nm" and model.lag:
            continue  # the package's is as an acceleration, at the time of the sample
        errors = [abs(mp.mpf(float(x)) - getattr(y, part)) for x, y in zip(getattr(got, name), expected, strict=True)]
        assert float(max(errors)) <= bound, f"{name} of seed {seed} off by {float(max(errors)):.3g}, bound {bound:.3g}"
    return True


def test_every_sample_of_random_scenes() -> None:
    assert sum(compared(seed) for seed in range(40)) >= 30


@pytest.mark.long
def test_every_sample_of_many_random_scenes() -> None:
    assert sum(compared(seed) for seed in range(40, 340)) >= 200


def planned(scene: dict[str, Any], rate: float, counts: int, **more: Any) -> SweepPlan:
    source = Source("spec.yaml")
    grid = {RATE: [rate], COUNTS: [counts]}
    source.value = {"kind": "sweep", "name": "gear", "scene": scene, "grid": grid, **more}
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    return plan


YIELDING = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
    "gear": {"ratio": 7.4, "motor_inertia": 1e-8, "stiffness": 5.0, "mesh_damping": 1e-4},
}
HEAVY = {**YIELDING, "knob": {"inertia": 2e-5, "damping": 1e-4}, "actuator": {"delay_samples": 1.0}}
ORBITS = [(YIELDING, 1000.0, 360), (YIELDING, 2000.0, 100), (HEAVY, 1000.0, 360)]


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("scene", "rate", "counts"), ORBITS)
def test_proven_cycles_are_the_models(scene: dict[str, Any], rate: float, counts: int) -> None:
    """The 60-digit model runs into a cycle of the list, with its period and the swings of motor and knob."""
    plan = planned(scene, rate, counts, starts={"angle": 0.02, "phases": 1})
    orbits = [row for row in SweepStage(plan, jobs=1).run().orbits.to_pylist() if row["outcome"] == "cycle"]
    assert len(orbits) == 1
    assert orbits[0]["certified"]
    assert orbits[0]["wall_work_j"] == pytest.approx(orbits[0]["damping_loss_j"], rel=1e-9)
    period = orbits[0]["period_samples"]
    model = Shafts(scene, rate_hz=rate, counts=counts)
    last = model.run(angle=0.02, velocity=0.0, phase=0.5, samples=3000)[-2 * period - 1 :]
    assert float(abs(last[0].knob - last[-1].knob)) < 1e-12
    fine = 64  # points of a sample: the extremes between them are missed by (w T / fine)^2 / 8 of a swing
    knob, mesh = finely(model, last, period, fine)
    swing, spread = max(knob) - min(knob), max(mesh) - min(mesh)
    assert 0.0 <= orbits[0]["knob_p2p_rad"] - swing * (1.0 - 1e-9) <= 2e-3 * swing
    assert 0.0 <= min(mesh) + 1e-9 * spread - orbits[0]["mesh_least_nm"] <= 2e-3 * spread
    assert 0.0 <= orbits[0]["mesh_most_nm"] - max(mesh) + 1e-9 * spread <= 2e-3 * spread


def finely(model: Shafts, last: list[Sample], period: int, fine: int) -> tuple[list[float], list[float]]:
    """Angles of the knob, and torques of the mesh on it, over a period, at ``fine`` points of each sample."""
    assert not model.split
    assert not model.lag
    step = exponential(model.a, model.period / fine)
    knob, mesh = [], []
    gear = model.scene["gear"]
    for one in last[:period]:
        state = [model.n * one.motor, model.n * one.motor_speed, one.knob, one.knob_speed, 0, 1, one.torque / model.n]
        for _ in range(fine):
            knob.append(float(state[2]))
            twist, rate = state[0] / model.n - state[2], state[1] / model.n - state[3]
            mesh.append(float(gear["stiffness"] * twist + gear["mesh_damping"] * rate))
            state = apply(step, [mp.mpf(value) for value in state])
    return knob, mesh


def test_a_stiff_mesh_tends_to_the_rigid_gear() -> None:
    """By 1/stiffness: the twist of the mesh under the wall's torque, and what it does to the motion."""
    more = {"starts": {"angle": 0.02, "phases": 1}, "record": {"duration": 0.02, "interval": 1e-3}}
    damped = {**YIELDING, "gear": {**YIELDING["gear"], "mesh_damping": 0.02}}  # type: ignore[dict-item]
    rigid = {**YIELDING, "gear": {"ratio": 7.4, "motor_inertia": 1e-8}}
    straight = record_sweep(planned(rigid, 1000.0, 36, **more)).to_pylist()
    off = []
    for stiffness in (2000.0, 20000.0):
        scene = {**damped, "gear": {**damped["gear"], "stiffness": stiffness}}  # type: ignore[dict-item]
        rows = record_sweep(planned(scene, 1000.0, 36, **more)).to_pylist()
        by_time = {round(row["time_s"] * 1e9): row["knob_angle_rad"] for row in rows}
        off.append(max(abs(by_time[round(row["time_s"] * 1e9)] - row["angle_rad"]) for row in straight))
    assert off[1] < 0.2 * off[0]
    assert off[1] < 1e-5


def test_energy_of_a_recording_falls_where_no_torque_acts() -> None:
    """Outside the wall only dampers act: masses, springs, mesh and the push on the knob lose, never gain."""
    more = {"starts": {"angle": 0.5, "velocity": 2.0, "phases": 1}, "record": {"duration": 0.05, "interval": 1e-4}}
    rows = record_sweep(planned(YIELDING, 1000.0, 360, **more)).to_pylist()
    energy = [row["energy_j"] for row in rows if row["angle_rad"] > 0.0 and row["torque_nm"] == 0.0]
    assert len(energy) > 50
    assert all(later <= before + 1e-15 for before, later in pairwise(energy))


def at_a_sample(scene: dict[str, Any], period: int, backlash: float) -> tuple[Backlash, Any, list[Sample]]:
    """A gear with backlash, its state on the cycle that the 60-digit model without any runs into, and that cycle."""
    model = Shafts(scene, rate_hz=1000.0, counts=360)
    last = model.run(angle=0.02, velocity=0.0, phase=0.5, samples=3000)[-2 * period - 1 :]
    teeth = Backlash(scene, rate_hz=1000.0, counts=360, backlash=backlash)
    first = [float(value) for value in (last[0].motor, last[0].motor_speed, last[0].knob, last[0].knob_speed)]
    return teeth, np.array([first[0] + teeth.h, *first[1:]]), last


def cycle_of(scene: dict[str, Any]) -> dict[str, Any]:
    (row,) = (
        SweepStage(planned(scene, 1000.0, 360, starts={"angle": 0.02, "phases": 1}), jobs=1).run().orbits.to_pylist()
    )
    assert row["certified"]
    return row


def test_teeth_that_never_part_make_the_same_cycle_with_any_backlash() -> None:
    """Where ``mesh_least_nm`` is above 0: a degree of backlash, by another integrator, changes nothing."""
    row = cycle_of(YIELDING)
    assert row["mesh_least_nm"] > 0.0
    period = row["period_samples"]
    teeth, z, last = at_a_sample(YIELDING, period, np.pi / 180.0)
    motion = teeth.run(z, 2 * period)
    assert not any(motion.parted)
    expected = np.array([[float(one.motor) + teeth.h, float(one.knob)] for one in last])
    assert np.abs(motion.states[:, [0, 2]] - expected).max() < 1e-10  # DOP853's 1e-12 of 0.02 rad, some hundred steps
    swing = motion.extremes[:, 1].max() - motion.extremes[:, 0].min()
    assert swing == pytest.approx(row["knob_p2p_rad"], rel=1e-3)


def test_teeth_part_where_the_mesh_would_pull() -> None:
    """Where ``mesh_least_nm`` is below 0, as under a light push: a backlash opens within a period."""
    light = {**YIELDING, "bias": {"torque": 1e-4}}
    row = cycle_of(light)
    assert row["mesh_least_nm"] < 0.0
    teeth, z, last = at_a_sample(light, row["period_samples"], 0.1 * np.pi / 180.0)
    motion = teeth.run(z, 2 * row["period_samples"])
    assert any(motion.parted)
    expected = np.array([float(one.knob) for one in last])
    assert np.abs(motion.states[:, 2] - expected).max() > 1e-5
