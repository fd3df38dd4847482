"""The columns of a search for a design: every design evaluated, whether it meets what is asked, and why not."""

from collections.abc import Sequence

import pyarrow as pa

from hknob_cli.results.columns import RANGED, Column, axis_column
from hknob_cli.results.perceived_columns import STEP_DB

_REAL, _WHOLE, _TEXT, _FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()

REMEDY = Column("remedy", _TEXT, "", "name of the remedy")
COST = Column("cost", _REAL, "1", "costs of the remedy and of what it leaves to choose, added, in the spec's own unit")
MOTION = (
    Column("p2p_max_rad", _REAL, "rad", "peak to peak of the largest cycle of anyone; 0 where all rest"),
    Column("frequency_at_max_hz", _REAL, "Hz", "cycles per second of that cycle; null where all rest"),
    Column("p2p_rad", _REAL, "rad", "peak to peak, mean over the people whose knob cycles; null where none does"),
    Column("frequency_hz", _REAL, "Hz", "cycles per second, likewise"),
    Column(
        "stiffness_nm_per_rad", _REAL, "N*m/rad", "static stiffness that the wall renders, of the person with least"
    ),
)
PEOPLE = (
    Column(
        "touch_db", _REAL, "dB", "above the threshold of touch; no more people than allowed have more; null at rest"
    ),
    Column("touch_above", _REAL, "1", "share of the people above what is allowed, or above threshold without a limit"),
    Column("touch_above_present_db", _REAL, "dB", "touch level over the present design's, person by person, likewise"),
    Column("hearing_above", _REAL, "1", "share of the people above what is allowed; null without a limit"),
    Column("hearing_above_present_db", _REAL, "dB", "sound over the present design's, person by person, likewise"),
    STEP_DB,
    Column("unknown", _REAL, "1", "share of the people for whom no level of touch is known; they count as above"),
    Column("at_rest_fraction", _REAL, "1", "part of the trials of all people that come to rest"),
    Column("certified_fraction", _REAL, "1", "part of the trials of all people whose end is proven"),
)
HEARING_DB = Column("hearing_db", _REAL, "dB", "above the threshold of hearing; as touch_db")
VERDICT = (
    Column("certified", _FLAG, "", "whether every end of every trial of every person is proven"),
    Column("feasible", _FLAG, "", "whether it meets every limit"),
    Column("fails", _TEXT, "", "limits that it does not meet, with by how much; empty where it meets all"),
    Column("margin_db", _REAL, "dB", "by how much the tightest limit of a level is met; below 0 where it is not"),
    Column("chosen", _FLAG, "", "the answer: the cheapest that meets every limit, of equal cost the least felt"),
    Column("present", _FLAG, "", "the design that others are compared with"),
    Column("next_cheaper", _FLAG, "", "of what is cheaper than the answer the dearest, of equal cost the least felt"),
    Column("front", _FLAG, "", "stiff enough, and nothing stiff enough is as cheap and less felt"),
    Column("relaxes", _TEXT, "", "choice in which it is the answer one step cheaper; empty where it is not"),
    Column("notional", _REAL, "1", "Hasser's Fig. 70: larger of log p2p and frequency, each from 0 to 1; plain walls"),
    Column("answer_if", _TEXT, "", "what would make it the answer: levels or thresholds that are others; ';' between"),
)
REDRAWN = Column("redrawn", _REAL, "1", "share of redraws of the people, with replacement, in which it is the answer")
DOMAIN = Column(
    "in_domain", _FLAG, "", "whether the controller is within its stated domain for everyone; null without one"
)


def design_columns(
    choices: Sequence[tuple[str, str]],
    *,
    gained: bool,
    drawn: bool = False,
    domain: bool = False,
    ranged: bool = False,
) -> tuple[Column, ...]:
    """All columns, with one for each choice (name, unit).

    ``gained``: with a sound gain; ``drawn``: people are drawn from a population; ``domain``: a controller has one;
    ``ranged``: starts are ranges.
    """
    axes = [axis_column(name, unit) for name, unit in choices]
    more = [*([REDRAWN] if drawn else []), *([DOMAIN] if domain else []), *(RANGED if ranged else [])]
    return (REMEDY, *axes, COST, *MOTION, *([HEARING_DB] if gained else []), *PEOPLE, *VERDICT, *more)
