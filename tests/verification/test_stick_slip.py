"""Stick and slip in ten thousand random scenes, over many decades: no energy from friction, no creep, always an end.

Without a wall the mechanical energy J omega^2/2 + k theta^2/2 + g theta never rises from one sample to the next, but
for rounding: a step computes with angles and speeds up to those met inside it, and rounds each a few times for each of
the half cycles in it; ``ROUNDINGS`` of the energy of those are allowed. A knob at rest under a sum of torques within
the friction stays, to the last bit; under a greater one it leaves. Every scene takes a bounded time.
"""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf, pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from hknob_cli.scene.general_knob import Trial, simulate
from hknob_cli.specs.plan import Actuator, Bias, Encoder, Finger, Fingerpad, Hand, Knob, Scene, Wall

EPS = 2.0**-53
ROUNDINGS = 64
SAMPLES = 16
SCENES = 10_000
PARTS = 10
PATIENCE_S = 60.0  # a scene takes a millisecond or two, on an idle machine
EXAMPLES = 150


@contextmanager
def patience(what: Any) -> Iterator[None]:
    """Fail where the body does not end."""

    def give_up(*_: Any) -> None:
        raise TimeoutError(f"no end in {PATIENCE_S:g} s: {what}")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.setitimer(signal.ITIMER_REAL, PATIENCE_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def draw(numbers: np.random.Generator) -> tuple[Scene, dict[str, Any]]:
    """A scene, and how to run it: time scales against the sample period, torques against one another."""

    def decades(low: float, high: float) -> float:
        return float(10.0 ** numbers.uniform(low, high))

    def sometimes(share: float, value: float) -> float:
        return value if numbers.random() < share else 0.0

    period, inertia, angle = decades(-5, 0), decades(-9, 0), decades(-8, 1)
    kind = numbers.random()
    plain = kind > 0.3  # a closed form for each half cycle; more states cost steps for each of their time scales
    turning = decades(-4, 2.5 if plain else 0.5) / period  # rad/s
    stiffness = sometimes(0.8, inertia * turning**2)
    load = inertia * turning**2 * angle
    velocity = sometimes(0.8, angle * turning * decades(-3, 2))
    counts = int(decades(1, 5))
    wall = sometimes(0.4, inertia * (decades(-3, 0) / period) ** 2)
    hand = Hand(0.0, sometimes(0.5, 2.0 * inertia * turning * decades(-4, 2 if plain else 0.5)), stiffness)
    if kind < 0.2:
        own = inertia * decades(-1, 1)
        hand = Hand(
            finger=Finger(own, sometimes(0.7, own / period * decades(-4, 0)), sometimes(0.8, own * turning**2)),
            fingerpad=Fingerpad(sometimes(0.7, inertia / period * decades(-4, 0)), sometimes(0.8, stiffness)),
        )
    lag = period * decades(-2, 4) if 0.15 < kind < 0.3 else 0.0
    scene = Scene(
        knob=Knob(inertia, sometimes(0.3, inertia / period * decades(-6, 2 if plain else 0)), load * decades(-6, 3)),
        wall=Wall(wall, sometimes(0.2, inertia / period * decades(-3, -1))),
        hand=hand,
        bias=Bias(torque=sometimes(0.7, load * decades(-6, 2))),
        encoder=Encoder(
            str(numbers.choice(["floor", "nearest", "ceil", "truncate"])), sometimes(0.5, numbers.random())
        ),
        actuator=Actuator(delay_samples=sometimes(0.2, 3.0 * numbers.random()), time_constant=lag),
    )
    return scene, {
        "sample_rate_hz": 1.0 / period,
        "counts_per_rev": counts,
        "angle_rad": float(numbers.choice([-1.0, 1.0])) * angle,
        "velocity_rad_s": float(numbers.choice([-1.0, 1.0])) * velocity,
        "phase": float(1.0 - numbers.random()),
        "samples": SAMPLES if plain else SAMPLES // 3,
    }


def inside(scene: Scene, theta: np.ndarray, omega: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of angle and speed met in the interval after each sample without a wall, from undamped motion."""
    hand = scene.hand or Hand()
    inertia, k, g = scene.knob.inertia + hand.inertia, hand.stiffness, scene.bias.torque or 0.0 if scene.bias else 0.0
    fast = np.abs(omega) + period * (k * np.abs(theta) + g + scene.knob.coulomb_torque) / inertia
    if k > 0:
        fast = np.minimum(fast, np.sqrt(omega**2 + k / inertia * (np.abs(theta) + g / k) ** 2))
    far = np.abs(theta) + period * fast
    if k > 0:
        far = np.minimum(far, np.abs(theta) + 2 * (np.abs(theta) + g / k) + sqrt(inertia / k) * np.abs(omega))
    return far, fast


def check_energy(scene: Scene, run: Trial, period: float, quantum: float) -> None:
    """The energy does not rise."""
    hand = scene.hand or Hand()
    inertia, k, g = scene.knob.inertia + hand.inertia, hand.stiffness, (scene.bias or Bias()).torque or 0.0
    theta, omega = run.angle_rad, run.velocity_rad_s
    # The rise from sample to sample, as products: no difference of large energies.
    mean, step = (theta[1:] + theta[:-1]) / 2, np.diff(theta)
    rise = inertia * (omega[1:] + omega[:-1]) / 2 * np.diff(omega) + (k * mean + g) * step
    far, fast = inside(scene, theta[:-1], omega[:-1], period)
    far = far + quantum  # positions count from an edge of the encoder, and are rounded there
    half_cycles = 1 + period * sqrt(k / inertia) / pi
    allowed = ROUNDINGS * EPS * half_cycles * (inertia * fast**2 + k * far**2 + g * far)
    worst = int(np.argmax(rise - allowed))
    assert (rise <= allowed).all(), f"energy rises by {rise[worst]:.3g}, rounding {allowed[worst]:.3g}, sample {worst}"


def check_sticking(scene: Scene, run: Trial, period: float, quantum: float) -> tuple[int, int]:
    """At rest within the friction it stays, beyond it leaves; how often each was seen.

    For a second-order hand and a torque that is constant from sample to sample.
    """
    hand = scene.hand or Hand()
    inertia, k, g = scene.knob.inertia + hand.inertia, hand.stiffness, (scene.bias or Bias()).torque or 0.0
    theta, torque = run.angle_rad[:-1], run.torque_nm[:-1]
    # Positions count from an edge of the encoder: a small angle is known to within roundings of a count.
    near = np.abs(theta) + quantum
    total, sizes = torque - g - k * theta, np.abs(torque) + g + k * near
    rest = run.velocity_rad_s[:-1] == 0.0
    over = np.abs(total) - scene.knob.coulomb_torque
    stays = rest & (over < -16 * EPS * sizes)
    leaves = rest & (over > 16 * EPS * sizes)
    same = (np.diff(run.angle_rad) == 0.0) & (run.velocity_rad_s[1:] == 0.0)
    assert same[stays].all(), "left a standstill within the friction"
    # What moves less than the angle resolves need not show.
    way = np.minimum(over * period**2 / inertia, over / k if k > 0 else inf)
    assert not (same & leaves & (way > 1e-9 * near) & ringing(scene, period)).any(), "stuck beyond the friction"
    return int(stays.sum()), int(leaves.sum())


def ringing(scene: Scene, period: float) -> bool:
    """Whether the damping leaves motion that a sample interval shows."""
    hand = scene.hand or Hand()
    return (scene.knob.damping + hand.damping) * period / (scene.knob.inertia + hand.inertia) < 1e3


def check(scene: Scene, how: dict[str, Any]) -> tuple[int, int, int]:
    """Run a scene and hold it to all that applies; (standstills kept, left, intervals with an energy)."""
    with patience((scene, how)):
        run = simulate(scene, **how)
    period, quantum = 1.0 / how["sample_rate_hz"], 2 * pi / how["counts_per_rev"]
    assert all(np.isfinite(column).all() for column in run)
    if scene.hand is not None and scene.hand.finger is not None:
        return 0, 0, 0
    energies = 0
    actuator = scene.actuator or Actuator()
    if scene.wall.stiffness == 0.0 and scene.wall.damping == 0.0:
        assert not run.torque_nm.any()
        check_energy(scene, run, period, quantum)
        energies = len(run.angle_rad) - 1
    elif actuator.time_constant > 0.0 or actuator.delay_samples % 1.0 > 0.0:
        return 0, 0, 0
    return (*check_sticking(scene, run, period, quantum), energies)


@pytest.mark.one_in(10)
@pytest.mark.parametrize("part", range(PARTS))
def test_ten_thousand_scenes(part: int) -> None:
    """Seeded: the same scenes every time."""
    numbers = np.random.default_rng([20030101, part])
    kept = left = energies = 0
    for i in range(SCENES // PARTS):
        scene, how = draw(numbers)
        try:
            counted = check(scene, how)
        except AssertionError as error:
            raise AssertionError(f"scene {i}: {scene}, {how}: {error}") from None
        kept, left, energies = kept + counted[0], left + counted[1], energies + counted[2]
    assert kept > SCENES // PARTS
    assert left > 2
    assert energies > SCENES // PARTS


def decades(low: int, high: int) -> st.SearchStrategy[float]:
    """Zero, or a power of ten, whole or not."""
    return st.one_of(st.just(0.0), st.integers(low, high).map(lambda n: 10.0**n), st.floats(10.0**low, 10.0**high))


@settings(max_examples=EXAMPLES, deadline=None, derandomize=True, database=None, phases=[Phase.generate])
@given(
    inertia=st.sampled_from([1e-9, 2e-6, 1.0]),
    turning=decades(-4, 2),
    damping=decades(-4, 2),
    friction=decades(-9, 3),
    bias=decades(-6, 1),
    angle=decades(-8, 1),
    velocity=st.one_of(decades(-6, 2), decades(-6, 2).map(lambda v: -v)),
    period=st.sampled_from([1e-5, 1e-3, 1.0]),
    lag=st.sampled_from([0.0, 1e-3, 1.0, 50.0]),
)
def test_no_energy_from_friction(
    inertia: float,
    turning: float,
    damping: float,
    friction: float,
    bias: float,
    angle: float,
    velocity: float,
    period: float,
    lag: float,
) -> None:
    """Round numbers and zeros: ``turning``, ``damping``, ``velocity`` per sample period. A hang is not shrunk."""
    k = inertia * (turning / period) ** 2
    load = inertia / period**2 * max(turning, 1e-6) ** 2
    scene = Scene(
        knob=Knob(inertia, inertia / period * damping, friction * load),
        wall=Wall(0.0),
        hand=Hand(stiffness=k),
        bias=Bias(torque=bias * load),
        encoder=Encoder(),
        actuator=Actuator(time_constant=lag * period),
    )
    how = {"sample_rate_hz": 1.0 / period, "counts_per_rev": 1024, "samples": SAMPLES}
    check(scene, {**how, "angle_rad": angle, "velocity_rad_s": velocity / period})


HOLDING = {"finger": Finger(3e-7, 2.9e-3, 0.4), "fingerpad": Fingerpad(3.8e-4, 0.05)}


@pytest.mark.parametrize("lag", [0.0, 3e-4])
@pytest.mark.parametrize("hand", [None, Hand(**HOLDING)], ids=["no hand", "finger"])
@pytest.mark.parametrize(("bias", "friction"), [(0.0, 0.0), (0.0, 1e-3), (1e-3, 1e-3)])
def test_exact_balance_is_rest(lag: float, hand: Hand | None, bias: float, friction: float) -> None:
    """Torques that balance to the last bit, friction's own level among them, hold the knob and end the work."""
    actuator = Actuator(time_constant=lag)
    scene = Scene(Knob(1.98e-6, 0.0, friction), Wall(0.27), hand, Bias(torque=bias), Encoder(), actuator)
    with patience(scene):
        run = simulate(scene, sample_rate_hz=1e3, counts_per_rev=1024, angle_rad=0.0, velocity_rad_s=0.0, samples=20)
    assert not run.angle_rad.any()
    assert not run.velocity_rad_s.any()


def test_torque_that_grows_to_the_friction() -> None:
    """A lagging torque whose limit is the friction itself approaches it for ever: the knob stays."""
    actuator = Actuator(time_constant=3e-4, torque_limit=0.002)
    scene = Scene(Knob(1.98e-6, 0.0, 0.002), Wall(0.27), None, None, Encoder(), actuator)
    with patience(scene):
        run = simulate(scene, sample_rate_hz=1e3, counts_per_rev=1024, angle_rad=-0.5, velocity_rad_s=0.0, samples=60)
    assert np.abs(run.angle_rad + 0.5).max() < 1e-12


@pytest.mark.parametrize("friction", [0.0, 5e-324, 1e-300, 1e-9])
def test_ringing_before_the_first_sample(friction: float) -> None:
    """An undamped knob that turns a hundred times before its first sample, with next to no friction or none."""
    scene = Scene(Knob(1e-9, 0.0, friction), Wall(0.0), Hand(stiffness=0.1), None, Encoder(), None)
    how = {"sample_rate_hz": 10.0, "counts_per_rev": 1024, "angle_rad": 0.5, "velocity_rad_s": 100.0, "samples": 8}
    check(scene, how)


@pytest.mark.parametrize("lag", [1.0, 1e3, 1e6])
def test_creeping_release(lag: float) -> None:
    """A torque that creeps past the friction releases the knob once, in little work, and it follows the torque.

    The hand's spring holds all but 1e-15 of the friction; the lag adds to it. Undamped, the knob oscillates about a
    rest that the torque moves, so its angle never passes twice that.
    """
    friction, angle, stiffness = 1e-3, -0.025, 0.04
    actuator = Actuator(time_constant=lag)
    scene = Scene(
        Knob(1.98e-6, 0.0, friction * (1 + 1e-15)), Wall(0.27), Hand(stiffness=stiffness), None, Encoder(), actuator
    )
    with patience(scene):
        run = simulate(scene, sample_rate_hz=1e3, counts_per_rev=1024, angle_rad=angle, velocity_rad_s=0.0, samples=5)
    moved = run.angle_rad - angle
    assert (moved >= -4 * EPS).all()
    assert (moved <= 2.0 * run.torque_nm / stiffness + 64 * EPS).all()
