"""The columns that ``perceive`` adds to a sweep's files."""

import pyarrow as pa

from hknob_cli.results.columns import Column

_REAL = pa.float64()

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
