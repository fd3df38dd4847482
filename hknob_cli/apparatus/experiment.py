"""What is recorded of the apparatus: its five experiments as in Chapters 4 and 5, and the rigs of Appendices A-C.

The rigs: a dynamometer for the motor, weights on the grip cell, pulses on knobs that nobody holds.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import tau
from typing import Any, Literal, NamedTuple

import numpy as np

from hknob_cli.apparatus.hand import Hand, SecondOrder, split
from hknob_cli.apparatus.hand_recording import PEAK_RAD, Pulse, Rig, record_trial, scaled_input, scaled_pulse
from hknob_cli.apparatus.people import EXPERIMENTS, Place, Variation, grips, mean_hand, numbers, trial_hand
from hknob_cli.errors import UsageError
from hknob_cli.printed import table
from hknob_cli.recordings.trial import Array, Key, Purpose, Trial, stream
from hknob_cli.specs.identification import InputPlan

_MOTOR, _CELL, _KNOB = range(3)  # first number of each bench's stream

# Appendix A.1: torque constant (N·m/A) and largest torque (N·m) of a range.
SMALL_RANGE, WORKING_RANGE = (26.4e-3, 2e-3), (28.4e-3, 30e-3)

# Appendix B: where the force acts, from the end of the knob (m); the first and the last are the "deviant" cases.
POSITIONS_M = (3.18e-3, 6.35e-3, 9.53e-3)
POSITION_FACTOR = 1.9  # "nearly twice", coefficient at 9.53 mm over that at 3.18 mm
NOMINAL_V_PER_N = 0.1  # assumed: 10 V for the cell's 100 N

# Appendix C: damping more than ten times, stiffness more than a hundred times below the lightest grasp's; their values
# are assumed.
BEARING_DAMPING, BEARING_STIFFNESS = 1e-5, 1e-4
SHAFT = "shaft"


class MotorCalibration(NamedTuple):
    """Rows of a dynamometer run, all of one length.

    ``range_index``: 0 small torques, 1 working range; ``current_a`` of the motor; ``direction``: +1 clockwise, -1
    counter-clockwise; ``time_s`` since that direction began; ``angle_rad`` of the shaft; ``torque_nm`` at the sensor,
    against which the dynamometer turns the shaft.
    """

    range_index: np.ndarray[Any, np.dtype[np.int64]]
    current_a: Array
    direction: Array
    time_s: Array
    angle_rad: Array
    torque_nm: Array


class GripCell(NamedTuple):
    """Rows of a grip cell's calibration: ``position_m`` from the end of the knob, ``force_n`` on it, ``voltage_v``."""

    position_m: Array
    force_n: Array
    voltage_v: Array


def record_motor_calibration(
    rig: Rig,
    *,
    currents: int = 11,
    turns: float = 3.0,
    turn_s: float = 4.0,
    noise_nm: float = 2e-5,
    ripple_nm: float = 0.0,
    seed: int = 0,
) -> MotorCalibration:
    """Torque against drive current: per range, and current from 0 to the largest, ``turns`` each way, every 100 ms.

    The sensor reads Kt·i + direction·Tc: half the difference of the two means is the friction, Tc = ``rig.coulomb_nm``.
    ``noise_nm``: rms of the sensor (assumed); ``ripple_nm``: amplitude of a ripple that comes nine times a turn
    (assumed, off). Source: Appendix A.1. Raises `UsageError` for fewer than two currents.
    """
    if currents < 2:
        raise UsageError(f"currents must be >= 2, got {currents}")
    rows: list[tuple[Any, ...]] = []
    for index, (constant, most) in enumerate((SMALL_RANGE, WORKING_RANGE)):
        for step, current in enumerate(np.linspace(0.0, most / constant, currents)):
            rng = stream(seed, Purpose.BENCH, _MOTOR, index, step)
            for direction in (1.0, -1.0):
                time = 0.1 * np.arange(round(turns * turn_s / 0.1))
                turned = time / turn_s * tau
                angle = turned if direction > 0.0 else turns * tau - turned
                torque = (1.0 + rig.torque_error) * constant * current + direction * rig.coulomb_nm
                reading = torque + ripple_nm * np.sin(9.0 * angle) + noise_nm * rng.standard_normal(len(time))
                same = np.ones(len(time))
                rows.append((index * same, current * same, direction * same, time, angle, reading))
    index_column, *columns = (np.concatenate(column) for column in zip(*rows, strict=True))
    return MotorCalibration(index_column.astype(np.int64), *columns)


def cell_sensitivity(position_m: float) -> float:
    """Voltage per force (V/N) of a grip cell under a force at a distance from the end of the knob.

    Linear between the printed cases: the nearer the flexure that the shell hinges on, the less the cell feels.
    """
    reach = POSITIONS_M[-1] - POSITIONS_M[0]
    drop = 2.0 * (POSITION_FACTOR - 1.0) / (POSITION_FACTOR + 1.0) / reach
    return NOMINAL_V_PER_N * (1.0 - drop * (position_m - 0.5 * (POSITIONS_M[0] + POSITIONS_M[-1])))


def record_grip_cell(
    *,
    forces_n: Sequence[float] = (0.0, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 15.0),
    positions_m: Sequence[float] = POSITIONS_M,
    repeats: int = 3,
    noise_v: float = 1e-3,
    zero_v: float = 0.0,
    seed: int = 0,
) -> GripCell:
    """Voltage of the grip cell under test forces, those on the knob: twice the weights, by the lever.

    ``noise_v``: rms of a reading, ``zero_v``: its value without force (both assumed). Source: Appendix B. Raises
    `UsageError` for a position at which the cell would feel nothing.
    """
    rows = []
    for place, position in enumerate(positions_m):
        sensitivity = cell_sensitivity(position)
        if sensitivity <= 0.0:
            raise UsageError(f"a force at {position:g} m from the end is not on the grip cell's shell")
        for step, force in enumerate(forces_n):
            rng = stream(seed, Purpose.BENCH, _CELL, place, step)
            for _ in range(repeats):
                rows.append((position, force, zero_v + sensitivity * force + noise_v * float(rng.standard_normal())))
    return GripCell(*np.array(rows).T.copy())


def setups() -> dict[str, float]:
    """Inertia (kg·m²) of the apparatus by setup: the bare shaft, and the columns of Table 10 with a knob on it."""
    rows = {row["quantity"]: row for row in table(10)}
    whole = rows["Empirical estimate"]
    shaft = next(row for name, row in rows.items() if str(name).startswith("minus empirical estimate"))
    found = {SHAFT: -1e-7 * float(shaft["small_experimental"] or 0.0)}
    return found | {name: 1e-7 * value for name, value in whole.items() if isinstance(value, float)}


def record_apparatus(
    rig: Rig,
    *,
    chosen: Sequence[str] = (SHAFT, "small_experimental", "medium_experimental"),
    trials: int = 3,
    damping: float = BEARING_DAMPING,
    stiffness: float = BEARING_STIFFNESS,
    seed: int = 0,
) -> list[Trial]:
    """Pulses of the six magnitudes of the first experiment on knobs that nobody holds: nobody's grip, target 0.

    ``chosen``: of `setups`, which is the subject of a trial's key; its block is the magnitude's number, the lightest
    first; its experiment is "apparatus". ``damping`` (N·m·s/rad) and ``stiffness`` (N·m/rad) of the bearings. Source:
    Appendix C. Raises `UsageError` for an unknown setup.
    """
    known = setups()
    found = []
    for setup in chosen:
        if setup not in known:
            raise UsageError(f"no setup '{setup}'; there are: {', '.join(known)}")
        body = SecondOrder(known[setup], damping, stiffness)
        for block, grip in enumerate(grips(1), 1):
            pulse = Pulse(scaled_pulse(1, grip).torque_nm)
            for trial in range(1, trials + 1):
                rng = stream(seed, Purpose.BENCH, _KNOB, list(known).index(setup), block, trial)
                found.append(record_trial(rig, body, pulse, Key(setup, "apparatus", 0.0, block, trial), rng))
    return found


Subjects = int | Sequence[int] | None


class Schedule(NamedTuple):
    """Which trials are recorded: by default those of the dissertation.

    ``subjects``: how many in every experiment, or their numbers from 1; None: as printed, 9 in the first and 5 in the
    others. ``grips`` (N): of those in the tables; None: all six.
    """

    experiments: Sequence[int] = (1, 2, 3, 4, 5)
    subjects: Subjects = None
    blocks: int = 3
    trials: int = 3
    grips: Sequence[float] | None = None


EVERY = Schedule()


def record_experiments(
    rig: Rig,
    schedule: Schedule = EVERY,
    *,
    seed: int = 0,
    variation: Variation | None = None,
    model: Literal["second", "fourth"] = "second",
    torque: InputPlan | None = None,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> list[Trial]:
    """Record trials, ordered by experiment, subject, block, grip (the lightest first) and trial, as they were run.

    What is left out of a schedule changes nothing of the rest.

    Args:
        rig: what records them.
        schedule: which trials.
        seed: of all that is random.
        variation: how hands differ between people, blocks and trials; None: as printed.
        model: "fourth" gives the hand finger and fingerpad of its own (`split`).
        torque: an input in place of the pulse, recorded to its end.
        progress: is told of the trials recorded, and of how many.

    Raises:
        UsageError: for what is not in the tables, or numbers below 1.
    """
    every = list(places(schedule))
    recorded: list[Trial] = []
    for place in every:
        progress(len(recorded), len(every))
        hand = _held(trial_hand(place, seed=seed, variation=variation), place, rig, model)
        chance = stream(seed, Purpose.RECORDING, *numbers(place))
        push = scaled_pulse(place.experiment, place.grip_n) if torque is None else _input(torque, place, rig)
        until = rig if torque is None else replace(rig, after_s=torque.duration_s)
        recorded.append(record_trial(until, hand, push, key_of(place), chance))
    return recorded


def _input(torque: InputPlan, place: Place, rig: Rig) -> Array:
    return scaled_input(torque, mean_hand(place.experiment, place.grip_n), rig.interval_s, PEAK_RAD)


def key_of(place: Place) -> Key:
    """Key of the trial at a place: subject "S1", "S2", ..., experiment "1" to "5"."""
    return Key(f"S{place.subject}", str(place.experiment), place.grip_n, place.block, place.trial)


def places(schedule: Schedule) -> Iterator[Place]:
    """Every trial's place, in the order in which they are run. Raises `UsageError` for numbers below 1."""
    experiments, subjects, blocks, trials, chosen = schedule
    if blocks < 1 or trials < 1:
        raise UsageError(f"blocks and trials must be >= 1, got {blocks} and {trials}")
    for experiment in experiments:
        forces = grips(experiment) if chosen is None else tuple(sorted(chosen))
        for subject in _subjects(experiment, subjects):
            for block in range(1, blocks + 1):
                for grip in forces:
                    for trial in range(1, trials + 1):
                        yield Place(experiment, subject, grip, block, trial)


def _subjects(experiment: int, subjects: Subjects) -> Sequence[int]:
    if subjects is None:
        subjects = EXPERIMENTS[experiment].subjects
    if isinstance(subjects, int):
        subjects = range(1, subjects + 1)
    if not subjects or min(subjects) < 1:
        raise UsageError(f"subjects must be numbers from 1, at least one, got {list(subjects)}")
    return subjects


def _held(hand: SecondOrder, place: Place, rig: Rig, model: str) -> Hand:
    if model == "second":
        return hand
    small = EXPERIMENTS[place.experiment].knob_mm < 20.0
    return split(hand, knob_kg_m2=rig.small_knob_kg_m2 if small else rig.medium_knob_kg_m2)
