"""The columns of the sweep's files: name, type, unit and meaning, and by which a cell is judged.

Each file's field metadata says them. A cell is judged by its largest cycle; the mean stands beside it, where that is
another.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.specs.plan import BESIDE, COUNTS, PERSON, RATE, SweepPlan

_REAL, _WHOLE, _TEXT, _FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()
# Columns that need samples, or a period of them.
SAMPLED = (
    "period_samples",
    "margin_counts",
    "closure_rad",
    "wall_work_j",
    "damping_loss_j",
    "friction_loss_j",
    "late_entry_j",
    "late_exit_j",
    "staircase_j",
)


class Column(NamedTuple):
    """One column; ``unit`` is "1" for pure numbers, empty if there is none."""

    name: str
    type: pa.DataType
    unit: str
    meaning: str

    def field(self) -> pa.Field:
        """Arrow field with unit and meaning as metadata."""
        return pa.field(self.name, self.type, metadata={"unit": self.unit, "meaning": self.meaning})


CELLS = (
    Column("p2p_rad", _REAL, "rad", "mean peak minus mean trough, mean of the trials that cycle; null where none does"),
    Column("p2p_max_rad", _REAL, "rad", "p2p_rad of the largest attractor; 0 where all rest, null where unbounded"),
    Column("p2p_counts", _REAL, "count", "p2p_rad in encoder counts"),
    Column("frequency_hz", _REAL, "Hz", "cycles per second, mean of the trials that cycle; null where none does"),
    Column("frequency_at_max_hz", _REAL, "Hz", "frequency_hz of the largest attractor; null where none cycles"),
    Column("rms_rad", _REAL, "rad", "root mean square about the mean over time, mean of the trials that cycle"),
    Column("orbit_count", _WHOLE, "1", "distinct attractors found, cycles and rest points"),
    Column("certified_fraction", _REAL, "1", "part of the trials whose end is proven"),
    Column("at_rest_fraction", _REAL, "1", "part of the trials that come to rest"),
    Column("diverged_fraction", _REAL, "1", "part of the trials that diverge"),
    Column("undecided_fraction", _REAL, "1", "part of the trials without a decided end; orbits.parquet says why"),
)

ORBITS = (
    Column("orbit", _WHOLE, "1", "number of the attractor within its cell, the most frequent first"),
    Column("outcome", _TEXT, "", "cycle, rest, diverged or undecided"),
    Column("reason", _TEXT, "", "why it is not certified; empty where it is"),
    Column("period_samples", _WHOLE, "sample", "samples after which the motion repeats; 1 at rest"),
    Column("cycles_per_period", _WHOLE, "1", "local maxima of the angle in one period"),
    Column("p2p_rad", _REAL, "rad", "mean local maximum minus mean local minimum over the period"),
    Column("min_rad", _REAL, "rad", "least angle over the period, between samples included"),
    Column("max_rad", _REAL, "rad", "largest angle over the period, between samples included"),
    Column("rms_rad", _REAL, "rad", "root mean square about the orbit's mean, over continuous time"),
    Column("frequency_hz", _REAL, "Hz", "cycles_per_period / (period_samples * sample period)"),
    Column("basin_fraction", _REAL, "1", "part of the cell's trials that reach this attractor"),
    Column("certified", _FLAG, "", "whether the attractor, and that its trials reach it, is proven"),
    Column("margin_counts", _REAL, "count", "least distance of a sample to a count edge"),
    Column("closure_rad", _REAL, "rad", "distance between the orbit's start and its end, one period later"),
    Column("wall_work_j", _REAL, "J", "work of the wall torque over one period"),
    Column("damping_loss_j", _REAL, "J", "energy the damping dissipates over one period"),
    Column("late_entry_j", _REAL, "J", "work of the wall by acting late: inside, no torque yet; null with a lag"),
    Column("late_exit_j", _REAL, "J", "work of the wall by letting go late: outside, torque acts; null with a lag"),
    Column("staircase_j", _REAL, "J", "work of the wall inside, by the torque of an earlier angle; null with a lag"),
)

# Columns that only some scenes have: with friction; without damping, of the cells; without a sample clock.
FRICTION = (Column("friction_loss_j", _REAL, "J", "energy that friction dissipates over one period"),)
BEHIND = (
    Column(
        "knob_p2p_rad",
        _REAL,
        "rad",
        "behind a gear that yields: largest less smallest angle of the knob; p2p_rad is of the motor, over the ratio",
    ),
    Column(
        "mesh_least_nm", _REAL, "N*m", "least torque of the mesh on the knob, out of the wall; below 0 teeth would part"
    ),
    Column("mesh_most_nm", _REAL, "N*m", "largest torque of the mesh on the knob, out of the wall"),
)
RATTLE = (
    Column("rattle_max_rad", _REAL, "rad", "where trials with backlash or cogging do not repeat: the largest swing"),
)
JITTER_MAX = (
    Column(
        "jitter_max_rad", _REAL, "rad", "where the sample clock jitters: largest jitter_p2p_rad of trials that move"
    ),
    Column(
        "clock_bound_rad",
        _REAL,
        "rad",
        "there: proven bound on largest less smallest angle of a motion in the end, from these starts and whatever the "
        "intervals are; 0: all rest; null: no bound is found, or the scene has more than this is built for",
    ),
)
JITTER = (
    Column(
        "jitter_p2p_rad",
        _REAL,
        "rad",
        "where the sample clock jitters: mean local maximum less mean local minimum over 4096 samples of one trial, "
        "or 1024 where an interval has many parts",
    ),
    Column("jitter_range_rad", _REAL, "rad", "there: largest less smallest angle"),
    Column("jitter_frequency_hz", _REAL, "Hz", "there: local maxima over the time of these samples"),
)
PLAY = (
    Column(
        "rattle_p2p_rad",
        _REAL,
        "rad",
        "where trials with backlash or cogging do not repeat: largest less smallest angle of the knob, over 4096 "
        "samples of one",
    ),
    Column(
        "parting_per_s",
        _REAL,
        "1/s",
        "there: rate at which the distance of nearby motions grows (largest Lyapunov exponent); above 0: chaos",
    ),
)
EVERY_START = (
    Column("complete", _FLAG, "", "whether every start in question is proven to end in one of the listed attractors"),
    Column("piece_count", _WHOLE, "1", "sets of starts followed to their end; of one start, arcs of its clock phases"),
    Column("incomplete_reason", _TEXT, "", "why most starts without a proven end have none; empty where complete"),
)
RANGED = (
    Column("complete", _FLAG, "", "whether every start of the ranges is proven to end in a cycle that counts here"),
    Column("random_starts", _WHOLE, "1", "starts drawn from the ranges, and simulated; null where all were followed"),
    Column("p2p_one_start_rad", _REAL, "rad", "p2p_max_rad from one start, 20 mrad and at rest, at 16 clock phases"),
)
ONE_START = (
    Column("share_error", _REAL, "1", "bound on the rounding of a basin_fraction; null where phases are sampled"),
)
ANYWHERE = (
    Column("region_rad", _REAL, "rad", "largest angle, either way, of a region that every motion comes into"),
    Column("region_rad_s", _REAL, "rad/s", "largest speed of that region; both null where none was found"),
    Column("grows_rad", _REAL, "rad", "angle, either way, beyond which every motion is proven to grow without bound"),
    Column("grows_rad_s", _REAL, "rad/s", "speed beyond which every motion does; both null where that is not proven"),
)
GROWTH = (
    Column("growth_j_per_s2", _REAL, "J/s^2", "second-order coefficient of the energy at bounce peaks, mean of trials"),
    Column("growth_std_j_per_s2", _REAL, "J/s^2", "standard deviation of the coefficient over the trials"),
    Column("growth_residual", _REAL, "1", "what the parabola leaves, root mean square, in spreads of the energy"),
    Column("growth_fits", _WHOLE, "1", "trials with three bounces or more, which a parabola needs"),
    Column("bounces", _REAL, "1", "bounce peaks per trial"),
)
CONTACT = (
    Column("contact_s", _REAL, "s", "first contact with the wall, from the start"),
    Column("settling_s", _REAL, "s", "from the start until the motion stays within a count; 1 % without encoder"),
    Column("bounces", _WHOLE, "1", "times the knob left the wall until it had settled"),
    Column("energy_drift", _REAL, "1", "largest relative change of energy at a peak, without damping and friction"),
)
# Columns of trajectories.parquet, and those of a hand with a finger.
TRAJECTORY = (
    Column("trial", _WHOLE, "1", "number of the trial, by the phase of its sample clock"),
    Column("time_s", _REAL, "s", "time from the start of the trial"),
    Column("event", _TEXT, "", "sample, command, pulse ends or event (edge, turning point); empty between"),
    Column("angle_rad", _REAL, "rad", "angle of the knob"),
    Column("velocity_rad_s", _REAL, "rad/s", "velocity of the knob"),
    Column("torque_nm", _REAL, "N*m", "torque of the actuator just after this instant"),
    Column("energy_j", _REAL, "J", "energy of the masses, of the hand's springs and of the push; the wall has none"),
)
# Columns of basins.parquet.
BASINS = (
    Column("angle_rad", _REAL, "rad", "angle of the knob at a sample"),
    Column("velocity_rad_s", _REAL, "rad/s", "velocity of the knob at a sample"),
    Column(
        "orbit", _WHOLE, "1", "number, in orbits.parquet, of the attractor it ends in; null where that is not proven"
    ),
    Column("on_orbit", _FLAG, "", "whether this is a sample of that attractor itself, not a start"),
)
START = (Column("start_rad", _REAL, "rad", "angle at which the recording starts"),)
FINGER = (
    Column("finger_angle_rad", _REAL, "rad", "angle of the finger"),
    Column("finger_velocity_rad_s", _REAL, "rad/s", "velocity of the finger"),
)
# Columns of the knob, where a gear with compliance is between it and the motor, whose angle the encoder has.
AT_KNOB = (
    Column("knob_angle_rad", _REAL, "rad", "angle of the knob, where angle_rad is the motor's over the ratio"),
    Column("knob_velocity_rad_s", _REAL, "rad/s", "velocity of the knob"),
)
# Columns of the hand of a person, where the sweep is of a population.
PEOPLE = (
    Column("hand_inertia_kg_m2", _REAL, "kg*m^2", "inertia that the person's hand adds to the knob"),
    Column("hand_damping_nm_s_per_rad", _REAL, "N*m*s/rad", "damping of the person's hand"),
    Column("hand_stiffness_nm_per_rad", _REAL, "N*m/rad", "stiffness of the person's hand"),
)

_AXES = {
    RATE: Column(RATE, _REAL, "Hz", "sample rate of the controller"),
    COUNTS: Column(COUNTS, _WHOLE, "1/rev", "encoder counts per revolution"),
    PERSON: Column(PERSON, _WHOLE, "1", "number of the person, from 1; subjects in the order of their names"),
}


def axis_column(name: str, unit: str) -> Column:
    """Column of a grid axis; any value of the scene may be one."""
    return _AXES.get(name) or Column(name, _REAL, unit, f"grid axis: scene.{name}")


TOUCH_DB = Column("touch_db", _REAL, "dB", "above the threshold of touch, of the harmonics within its published range")
TOUCH_HZ = Column("touch_hz", _REAL, "Hz", "frequency of the harmonic that is felt best")
STEP_DB = Column("torque_step_db", _REAL, "dB", "torque step of a count over the least torque variation detected")
HEARING_HZ = Column("hearing_hz", _REAL, "Hz", "frequency of the harmonic that is most audible")
HEARING_DB = Column("hearing_db", _REAL, "dB", "above the threshold of hearing, of the most audible harmonic")
PHON = Column("hearing_phon", _REAL, "phon", "loudness level of the loudest harmonic; null outside ISO 226's range")
RELATIVE_DB = Column(
    "hearing_relative_db",
    _REAL,
    "dB",
    "peak speed re 1 rad/s over the threshold of hearing; only differences mean something, for want of a sound gain",
)
FELT = Column("felt_fraction", _REAL, "1", "part of the trials that end in a cycle above the threshold of touch")
HEARD = Column("heard_fraction", _REAL, "1", "part of the trials that end in a cycle above the threshold of hearing")

TOUCH, HEARING, UNGAINED = (TOUCH_DB, TOUCH_HZ), (HEARING_DB, HEARING_HZ, PHON), (RELATIVE_DB, HEARING_HZ)


def orbit_columns(*, gained: bool, counted: bool) -> tuple[Column, ...]:
    """Of an orbit; ``gained``: with a sound gain, ``counted``: with an encoder."""
    return (*TOUCH, *(HEARING if gained else UNGAINED), *([STEP_DB] if counted else []))


def cell_columns(*, gained: bool, counted: bool) -> tuple[Column, ...]:
    """Of a cell, whose levels are those of its most noticeable orbit."""
    sound = (HEARING_DB, HEARING_HZ, PHON, HEARD) if gained else UNGAINED
    return (*TOUCH, FELT, *sound, *([STEP_DB] if counted else []))


WORST = ("p2p_max_rad", "frequency_at_max_hz")  # columns of size and pitch that cells are judged by
ONE = ("p2p_rad", "frequency_hz")  # those of a law or method, which has one cycle a cell; of cells the means
MEANS = dict(zip(WORST, ONE, strict=True))
SAME = 5e-4  # a mean this near to the largest is not told: a table shows no more digits


def mean_beside(cell: Mapping[str, Any], column: str) -> float | None:
    """The mean over the trials that cycle, in the unit of the ``column``; None where it is that of the largest cycle.

    ``column``: one of `MEANS`; any other has no mean.
    """
    largest, mean = cell.get(column), cell.get(MEANS.get(column, ""))
    if not largest or mean is None or abs(mean / largest - 1.0) <= SAME:
        return None
    return float(mean)


def differs(cells: Sequence[Mapping[str, Any]]) -> bool:
    """Whether any cell has cycles of several sizes or pitches."""
    return any(mean_beside(cell, column) is not None for cell in cells for column in MEANS)


Row = dict[str, Any]


def one_start(sweep: SweepPlan) -> SweepPlan:
    """The sweep from one start in place of ranges, without levels."""
    return sweep._replace(starts=BESIDE if sweep.starts.span else sweep.starts, perceive=None)


def extent(cell: Row, sweep: SweepPlan) -> Row:
    """Whether all starts of the ranges were followed in a cell (its row of cells.parquet), and how many were drawn."""
    drawn = not cell["complete"] and cell["piece_count"] == 0
    return {"complete": cell["complete"], "random_starts": sweep.starts.random if drawn else None}


def together(rows: list[Row]) -> Row:
    """Columns `results.columns.RANGED` of several hands: all complete, the most drawn, the largest from one start."""
    drawn = [row["random_starts"] for row in rows if row["random_starts"] is not None]
    sizes = [row["p2p_one_start_rad"] for row in rows if row["p2p_one_start_rad"] is not None]
    return {
        "complete": all(row["complete"] for row in rows),
        "random_starts": max(drawn, default=None),
        "p2p_one_start_rad": max(sizes, default=None),
    }


def from_where(row: Row) -> str:
    """Of how many starts the largest cycle of a row is, in a word: all, or the number drawn."""
    return "all" if row["complete"] else str(row["random_starts"]) if row["random_starts"] else "not all"
