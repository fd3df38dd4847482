"""A cell of a grid, or many at once: the scene with or without a sample clock, reduced to the numbers of the engine.

Angles become counts, times sample periods, and the position is measured from the encoder edge that bounds level 0, so
that the wall's levels are whole numbers. Hand and knob move as one body: their inertias and dampings add.

Of many cells the numbers are arrays, with one entry a cell. The arithmetic is that of `reduce_scene`, element by
element, so that they are those of each cell alone. Starts may be drawn at random from a range of angles and velocities.

Without a sample clock angles become counts from the wall's outermost edge, or radians where the sensor is continuous;
times become periods of the knob against the wall, over 2 pi.
"""

import random
from collections.abc import Mapping
from math import isfinite, pi, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.loop import Loop, make_loop
from hknob_cli.errors import ComputationError
from hknob_cli.specs.plan import (
    COUNTS,
    GRIP,
    PERSON,
    RATE,
    Actuator,
    Bias,
    Encoder,
    Hand,
    Scene,
    Starts,
    gripped,
    placed,
    scene_at,
)
from hknob_cli.specs.squeeze import squeezed

if TYPE_CHECKING:
    from hknob_cli.engine.unsampled.state_machine import Unsampled


def random_starts(starts: Starts) -> list[tuple[float, float]]:
    """Angle (rad) and velocity (rad/s) of each, evenly spread over the range; the same ones at every call."""
    assert starts.span
    low, high, slowest, fastest = starts.span
    chance = random.Random(0)
    return [(chance.uniform(low, high), chance.uniform(slowest, fastest)) for _ in range(starts.random)]


GIVEN = Loop._fields.index("s1")  # numbers of a loop that the rest follows from


class SampledKnob(NamedTuple):
    """A scene sampled: its dimensionless loop, and the scales back to SI.

    ``quantum_rad``: angle of one count; ``period_s``: sample period; ``inertia_kg_m2``: of hand and knob; ``shift``:
    angle in counts = x + shift; ``delay_line``: number of commands that are under way.
    """

    loop: Loop
    quantum_rad: float
    period_s: float
    inertia_kg_m2: float
    shift: float
    delay_line: int

    def angle_rad(self, x: float) -> float:
        """Angle of a position ``x`` of the loop."""
        return (x + self.shift) * self.quantum_rad

    def position(self, angle_rad: float) -> float:
        """Position of the loop, in counts, at an angle."""
        return angle_rad / self.quantum_rad - self.shift

    def speed(self, velocity_rad_s: float) -> float:
        """Velocity in counts per sample."""
        return velocity_rad_s * self.period_s / self.quantum_rad

    @property
    def energy_j(self) -> float:
        """One unit of the loop's energy, J (counts per sample)², in joules."""
        speed = self.quantum_rad / self.period_s
        return self.inertia_kg_m2 * (speed * speed)  # not a power: over arrays its rounding may differ


def sample_knob(scene: Scene, *, sample_rate_hz: float, counts_per_rev: int) -> SampledKnob:
    """Reduce a scene to one cell. Raises `ComputationError` if its numbers overflow."""
    knob, size = reduce_scene(scene, sample_rate_hz=sample_rate_hz, counts_per_rev=counts_per_rev)
    if not isfinite(size):
        raise overflows(sample_rate_hz, counts_per_rev)
    return knob._replace(loop=make_loop(*knob.loop[:GIVEN]), delay_line=int(knob.delay_line))


def overflows(sample_rate_hz: float, counts_per_rev: int) -> ComputationError:
    """What is wrong with a cell whose numbers overflow."""
    return ComputationError(f"at {sample_rate_hz:g} Hz and {counts_per_rev} counts the scene's numbers overflow")


def reduce_scene(scene: Scene, *, sample_rate_hz: float, counts_per_rev: float) -> tuple[SampledKnob, float]:
    """The arithmetic of `sample_knob`, which serves one cell and, with arrays in the place of numbers, many.

    Returns the knob, in whose loop the response over the holds is left at 0, and a number that is finite where those of
    the loop are not too large to be squared.
    """
    hand = scene.hand or Hand()
    bias = scene.bias or Bias(torque=0.0)
    actuator = scene.actuator or Actuator()
    encoder = scene.encoder or Encoder()
    inertia = scene.knob.inertia + hand.inertia
    period = 1.0 / sample_rate_hz
    quantum = 2.0 * pi / (counts_per_rev * scene.turns)
    square = period * period / inertia
    alpha = (scene.knob.damping + hand.damping) * period / inertia
    beta = hand.stiffness * square
    kappa = scene.wall.stiffness * square
    torque = 0.0 if bias.torque is None else bias.torque
    push = 0.5 * kappa if bias.half_quantum else torque * square / quantum
    nearest = encoder.rounding == "nearest"
    shift = encoder.offset_counts - (0.5 if nearest else 0.0)
    # Level 0 of `truncate` also holds the count above the edge of `ceil`'s, where the wall is off all the same.
    upper = encoder.rounding in ("ceil", "truncate")
    delay = actuator.delay_samples
    whole = delay // 1.0
    gamma, sense = push + beta * shift, -1.0 if upper else 1.0
    knob = SampledKnob(
        loop=Loop(alpha, beta, kappa, gamma, sense, encoder.offset_counts, delay - whole, *[0.0] * 6),
        quantum_rad=quantum,
        period_s=period,
        inertia_kg_m2=inertia,
        shift=shift,
        delay_line=(whole + 1.0) * (delay > 0.0),  # type: ignore[arg-type]  # whole, and made an int where it is one
    )
    return knob, alpha * alpha + beta * beta + kappa * kappa + push * push


Columns = Mapping[str, NDArray[Any]]


def sample_cells(scene: Scene, columns: Columns) -> SampledKnob:
    """Reduce a scene to the cells whose axis values are ``columns``, (n,) each.

    Numbers that vary are arrays (n,), also those of samples under way; the response over the holds is left at 0. Raises
    `ComputationError` for the first cell whose numbers overflow.
    """
    rates, counts = columns[RATE], columns[COUNTS]
    with np.errstate(all="ignore"):
        knob, size = reduce_scene(scene_along(scene, columns), sample_rate_hz=_any(rates), counts_per_rev=_any(counts))
    wild = np.flatnonzero(~np.isfinite(np.broadcast_to(size, rates.shape)))
    if wild.size:
        raise overflows(float(rates[wild[0]]), int(counts[wild[0]]))
    return knob


def scene_along(scene: Scene, columns: Columns) -> Scene:
    """The scene with columns of values in place, as `scene_at` puts those of one cell."""
    if scene.squeeze:
        return _squeezed_along(scene, columns)
    if scene.hand and GRIP in columns:
        grips, which = np.unique(columns[GRIP], return_inverse=True)
        hands = [gripped(scene.hand, float(grip)) for grip in grips]
        inertia, damping, stiffness = np.array([hand[:3] for hand in hands]).T[:, which]
        scene = scene._replace(hand=Hand(inertia=_any(inertia), damping=_any(damping), stiffness=_any(stiffness)))
    if scene.hand and PERSON in columns:
        inertia, damping, stiffness = hands_of(scene.hand, columns[PERSON])
        scene = scene._replace(hand=Hand(inertia=_any(inertia), damping=_any(damping), stiffness=_any(stiffness)))
    return scene_at(scene, {name: _any(values) for name, values in columns.items() if name not in (GRIP, PERSON)})


def _squeezed_along(scene: Scene, columns: Columns) -> Scene:
    """The same where the grip follows the push, and with it the hand of every cell."""
    names = [name for name in columns if name not in (RATE, COUNTS)]
    if not names:
        return scene_along(squeezed(scene), columns)
    different, which = np.unique(np.array([columns[name] for name in names]).T, axis=0, return_inverse=True)
    cells = [dict(zip(names, row, strict=True)) for row in different.tolist()]
    hands = [(squeezed(placed(scene, cell)).hand or Hand())[:3] for cell in cells]
    inertia, damping, stiffness = np.array(hands).T[:, which.ravel()]
    made = scene._replace(
        hand=Hand(inertia=_any(inertia), damping=_any(damping), stiffness=_any(stiffness)), squeeze=None
    )
    kept = {name: values for name, values in columns.items() if name != GRIP and not name.startswith("squeeze.")}
    return scene_along(made, kept)


def hands_of(hand: Hand, persons: NDArray[Any]) -> NDArray[np.float64]:
    """Inertia, damping and stiffness of people's hands, of those of a population, (3, n) for their numbers (n,)."""
    numbers, which = np.unique(persons, return_inverse=True)
    found: NDArray[np.float64] = np.array([hand.by_person[int(one) - 1][:3] for one in numbers], dtype=np.float64)
    return found.T[:, which]


def _any(values: NDArray[Any]) -> Any:
    """An array in the place of a number."""
    return values


class UnsampledKnob(NamedTuple):
    """A scene with a continuous controller: its dimensionless form, and the scales back to SI.

    ``unit_rad``: angle of one unit of position, a count where there are counts; ``unit_s``: unit of time;
    ``inertia_kg_m2``: of hand and knob; ``shift``: angle in units = x + shift.
    """

    loop: "Unsampled"
    unit_rad: float
    unit_s: float
    inertia_kg_m2: float
    shift: float

    def angle_rad(self, x: float) -> float:
        """Angle of a position ``x``."""
        return (x + self.shift) * self.unit_rad

    def position(self, angle_rad: float) -> float:
        """Position at an angle."""
        return angle_rad / self.unit_rad - self.shift

    def speed(self, velocity_rad_s: float) -> float:
        """Velocity in units of position and time."""
        return velocity_rad_s * self.unit_s / self.unit_rad

    @property
    def torque_nm(self) -> float:
        """One unit of acceleration, as a torque on the knob."""
        return self.inertia_kg_m2 * self.unit_rad / self.unit_s**2

    @property
    def energy_j(self) -> float:
        """One unit of energy in joules."""
        return self.inertia_kg_m2 * (self.unit_rad / self.unit_s) ** 2


def reduce_unsampled(scene: Scene, *, counts_per_rev: int | None) -> UnsampledKnob:
    """Reduce a scene whose controller is continuous; ``counts_per_rev`` may be None where nothing is counted.

    Raises `ComputationError` if counts are missing, or if the numbers overflow.
    """
    from hknob_cli.engine.unsampled.state_machine import Unsampled

    hand = scene.hand or Hand()
    bias = scene.bias or Bias(torque=0.0)
    if counts_per_rev is None and (scene.encoder or bias.half_quantum):
        raise ComputationError("an encoder, and a bias of half a count, need counts_per_rev")
    quantum = 2.0 * pi / (counts_per_rev * scene.turns) if counts_per_rev else 1.0
    unit = quantum if scene.encoder else 1.0
    inertia = scene.knob.inertia + hand.inertia
    damping = scene.knob.damping + hand.damping
    spring = scene.wall.stiffness + hand.stiffness
    slowing = inertia / damping if damping > 0.0 else 1.0
    time = sqrt(inertia / spring) if spring > 0.0 else slowing
    square = time * time / inertia
    push = 0.5 * scene.wall.stiffness * quantum if bias.half_quantum else (bias.torque or 0.0)
    shift, offset = 0.0, 0.0
    if scene.encoder:
        offset = scene.encoder.offset_counts
        # Position 0 is the edge below which the wall acts: half a count, or a whole one, below the encoder's own.
        shift = offset - {"floor": 0.0, "nearest": 0.5}.get(scene.encoder.rounding, 1.0)
    beta = hand.stiffness * square
    numbers = (
        damping * time / inertia,
        beta,
        scene.wall.stiffness * square,
        push * square / unit + beta * shift,
        scene.knob.coulomb_torque * square / unit,
    )
    if not all(isfinite(number * number) for number in numbers):
        raise ComputationError("the scene's numbers overflow")
    loop = Unsampled(*numbers, offset=offset, counted=1.0 if scene.encoder else 0.0)
    return UnsampledKnob(loop=loop, unit_rad=unit, unit_s=time, inertia_kg_m2=inertia, shift=shift)
