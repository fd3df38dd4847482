"""What goes with what: each part of a scene beside each engine, law and command. One table, which all others read.

Validation and its messages (`specs.refusals`), the choice of the engine (`engine_of`) and
docs/reference/capabilities.md (`specs.generated`) are made from it. `P`: the motion is exact, and what is found
is proven: limit cycles, and with sets of starts that their list is complete. `E`: the motion is exact, what is found is
not proven. `~`: estimated, by a formula, published numbers or a record. `-`: refused. A verdict is that of a scene with
this one part. Of several parts the lowest verdict counts; `EXCEPTIONS` has the pairs that are lower still.
"""

from collections.abc import Iterable, Sequence, Set
from typing import NamedTuple

from hknob_cli.specs.capability_parts import ESTIMATED as ESTIMATED
from hknob_cli.specs.capability_parts import EXACT as EXACT
from hknob_cli.specs.capability_parts import EXCEPTIONS as EXCEPTIONS
from hknob_cli.specs.capability_parts import LOWEST_FIRST as LOWEST_FIRST
from hknob_cli.specs.capability_parts import PROVEN as PROVEN
from hknob_cli.specs.capability_parts import REFUSED as REFUSED
from hknob_cli.specs.capability_parts import WORDS as WORDS
from hknob_cli.specs.capability_parts import parts_there
from hknob_cli.specs.capability_reasons import AT as AT
from hknob_cli.specs.capability_reasons import WHY as WHY
from hknob_cli.specs.plan import Scene


class Column(NamedTuple):
    """An engine, a law or a command.

    ``title``: its name in a text; ``why``: why it refuses what it does, where `WHY` has no other reason (``{what}`` is
    the part); ``when``: the end of a fault's demand, with its preposition; ``group``: an engine's compiled functions.
    """

    title: str
    why: str
    when: str = ""
    group: str = ""


class Part(NamedTuple):
    """A part of a scene, or what a scene amounts to.

    ``title``: its name in a text; ``path``: its key, by which a fault names its place; empty for what is no key.
    ``verb``: what a fault demands; ``when``: the end of the demand that something else must be absent beside it.
    ``of``: of what is no key, the numbers that it follows from. ``also``: further keys that give a scene the part.
    """

    title: str
    path: str = ""
    verb: str = "must be absent"
    when: str = ""
    of: tuple[str, ...] = ()
    also: tuple[str, ...] = ()


_SETS = "sets of its states are followed by another engine, or not at all"
COLUMNS = {
    "plain": Column("plain loop", "the plain loop has one body, held torques and counts", group="plain"),
    "bounces": Column(
        "bouncing ball", "it is of a knob that nothing damps or holds", "where 'growth' is given", "bounces"
    ),
    "general": Column("general loop", "{what} has an engine of its own", group="general"),
    "unsampled": Column(
        "without a clock", "{what} is not in a continuous controller", "where sampling is continuous", "unsampled"
    ),
    "laws": Column(
        "general loop, controllers", "{what} is not followed under a controller", "where a controller is given", "laws"
    ),
    "phases": Column("sets: all phases", _SETS, group="sets"),
    "ranges": Column("sets: ranges", _SETS, group="sets"),
    "anywhere": Column(
        "sets: anywhere",
        "no region is known that every motion comes into; give ranges",
        "where starts are anywhere",
        "sets",
    ),
    "general_sets": Column("sets: more state", _SETS, group="general sets"),
    "friction_sets": Column("sets: friction, controllers", _SETS, group="friction sets"),
    "law_sets": Column("sets: more state, controllers", _SETS, group="general sets"),
    "friction_arcs": Column("all phases: arcs", _SETS, group="friction arcs"),
    "cogging_sets": Column("ranges: cogging", _SETS, group="cogging sets"),
    "general_anywhere": Column(
        "sets: anywhere, other torques",
        "no region is known that every motion comes into; give ranges",
        "where starts are anywhere",
        "general sets",
    ),
    "basins": Column("basins", "a map is made with the plain loop, which has no such part", "where basins are mapped"),
    "record": Column("record", ""),
    "pulse": Column("pulse", ""),
    "perceive": Column("perceive", ""),
    "describing": Column(
        "dfa: dfN, tsypkin", "{what} is not in dfa, whose describing functions are of a plain wall, knob and hand"
    ),
    "relay": Column(
        "dfa: sampled",
        "{what} is not in dfa's method sampled, which is of a plain wall and a linear plant of second order",
    ),
    "formulas": Column("predict", "{what} is not in predict, none of whose formulas has it"),
    "bench": Column("bench", "bench has no rival with {what}"),
    "device": Column("hw-run", "the spec of a device has no such key"),
    "explore": Column("explore", "the engine of its page has no such part"),
}  # fmt: skip
ENGINES, ASKED, COMMANDS = tuple(COLUMNS)[:14], tuple(COLUMNS)[14:18], tuple(COLUMNS)[18:]

PARTS = {
    "bias": Part("a bias torque", "bias.torque"),
    "hand": Part("a hand", "hand"),
    "grip": Part("a hand by its grip", "hand.grip_n"),
    "people": Part("a population", "population"),
    "knob_damping": Part("damping of the knob", "knob.damping", also=("gear.motor_damping",)),
    "friction": Part("Coulomb friction", "knob.coulomb_torque", also=("gear.motor_coulomb_torque",)),
    "hand_damping": Part("damping of the hand", "hand.damping"),
    "hand_stiffness": Part("stiffness of the hand", "hand.stiffness"),
    "finger": Part("a finger apart from the knob", "hand.finger"),
    "virtual_damping": Part("virtual damping", "wall.damping"),
    "delay": Part("a delay", "actuator.delay_samples"),
    "lag": Part("actuator lag", "actuator.time_constant"),
    "torque_limit": Part("a torque limit", "actuator.torque_limit"),
    "torque_step": Part("a torque step", "actuator.torque_step"),
    "dead_band": Part("a dead band of torques that are not sent", "actuator.dead_band"),
    "rounding": Part("rounding other than floor", "encoder.rounding"),
    "offset": Part("an offset of the encoder", "encoder.offset_counts"),
    "hysteresis": Part("hysteresis of the encoder", "encoder.hysteresis_counts"),
    "backlash": Part("slack between knob and encoder", "encoder.backlash"),
    "bare": Part("a continuous sensor", "encoder", "must not be none", "where encoder is none"),
    "jitter": Part("a sample clock that jitters", "clock.jitter", when="where the sample clock jitters"),
    "unsampled": Part("no sample clock", "sampling", "must not be continuous", "where sampling is continuous"),
    "controller": Part("a controller", "controller", when="where a controller is given"),
    "speed_sensor": Part("a controller that reads a velocity sensor", "controller.velocity"),
    "estimated_speed": Part("a controller that estimates the velocity, or filters the angle", "controller.angle"),
    "kalman": Part("a controller with a Kalman filter", "controller.estimate"),
    "several_readings": Part("a controller that reads within an interval"),
    "pulses": Part("a controller whose torque changes within an interval"),
    "knob_model": Part("a controller with a model of knob and hand"),
    "by_counts": Part("a controller that is defined by counts"),
    "profile": Part("a profile of torque over the angle", "profile"),
    "detents": Part("a pattern of detents", "detents"),
    "end_stops": Part("a pair of end stops", "end_stops"),
    "dead_zone": Part("a dead zone", "dead_zone"),
    "motor": Part("a motor by its constants", "motor.torque_constant"),
    "coil": Part("a winding with inductance", "motor.inductance"),
    "current_loop": Part("a current loop", "motor.bandwidth"),
    "supply": Part("a supply voltage", "motor.supply_voltage"),
    "eddy_brake": Part("an eddy brake", "eddy_brake.flux_density"),
    "gear": Part("a gear", "gear.ratio"),
    "mesh": Part("a gear with compliance", "gear.stiffness"),
    "play": Part("backlash of a gear", "gear.backlash"),
    "cogging": Part("cogging torque", "cogging.torque"),
    "squeeze": Part("a grip that follows the push", "squeeze.friction"),
    "undamped": Part("nothing that damps the knob", of=("knob.damping", "hand.damping", "knob.coulomb_torque")),
    "unheld": Part("nothing that holds the knob", of=("hand.stiffness",)),
    "unpushed": Part(
        "no push into the wall", when="without a bias into the wall", of=("bias.torque", "wall.stiffness")
    ),
    "handless": Part("no hand", when="without a hand"),
}

# Verdicts in the order of COLUMNS: engines of trials, engines of sets, what a sweep is asked for, laws and commands.
_TABLE = {
    #                   plain, bounces, general, unsampled, laws
    #                   |      phases, ranges, anywhere, general, friction, laws, arcs, cogging, general anywhere
    #                   |      |      basins, record, pulse, perceive
    #                   |      |      |    describing, relay, formulas, bench, device
    "bias":            "PEPPP PPPPPPPPP PEE~ ~P~E~",
    "hand":            "PEPPP PPPPPPPPP PEE~ ~P~E~",
    "grip":            "PEPPP PPPPPPPPP PEE~ ~P~E~",
    "people":          "P-PPP PPPPPPPPP PEE~ -----",
    "knob_damping":    "P-PPP PPPPPPPPP PEE~ ~P~E~",
    "friction":        "--PPP ----P-PP- -EE~ ~-~E~",
    "hand_damping":    "P-PPP PPPPPPPPP PEE~ ~P~E~",
    "hand_stiffness":  "P-PPP PPPPPPPPP PEE~ ~P~E~",
    "finger":          "--P-P ---P-PP-- -EE~ ~--E-",
    "virtual_damping": "--P-P ---PPPPP- -EE~ --~E~",
    "delay":           "PEP-P P--PPPPP- -EE~ ~P~E~",
    "lag":             "--P-P ---PPPP-- -EE~ ~--E~",
    "torque_limit":    "--P-P ---PPPPPP -EE~ ---E~",
    "torque_step":     "--P-P ---PPPPPP -EE~ ---E~",
    "dead_band":       "--P-P ---PPPPPP -EE~ ----~",
    "rounding":        "PEPPP PPPPPPPPP PEE~ ~P~E~",
    "offset":          "PEPPP PPPPPPPPP PEE~ ~P~E~",
    "hysteresis":      "--P-P ---PPPP-- -EE~ ~----",
    "backlash":        "--P-P ---PPPP-- -EE~ ~----",
    "bare":            "--PPE --------- -EE~ ---E-",
    "jitter":          "--E-E --------- -EE- -----",
    "unsampled":       "---P- --------- -E-- ---E-",
    "controller":      "----P ----PPP-- -EE~ ----~",
    "speed_sensor":    "----P --------- -EE~ ----~",
    "estimated_speed": "----P ----PPP-- -EE~ ----~",
    "kalman":          "----P ----PPP-- -EE~ ----~",
    "several_readings": "----P ----P-P-- -EE~ ----~",
    "pulses":          "----P ----PPP-- -EE~ ----~",
    "knob_model":      "----P ----PPP-- -EE~ ----~",
    "by_counts":       "----P ----PPP-- -EE~ ----~",
    "profile":         "--P-P ---PPPPPP -EE~ ----~",
    "detents":         "--P-P ---PPPPPP -EE~ ----~",
    "end_stops":       "--P-P ---PPPPPP -EE~ ----~",
    "dead_zone":       "--P-P ---PPPPPP -EE~ ----~",
    "motor":           "P-PPP PPPPPPPPP PEE~ ~P~E~",
    "coil":            "--P-P ---P-PP-- -EE~ ----~",
    "current_loop":    "--P-P ---PPPP-- -EE~ ---E~",
    "supply":          "--P-P ---PPPPPP -EE~ ---E~",
    "eddy_brake":      "P-PPP PPPPPPPPP PEE~ ~P~E~",
    "gear":            "PEPPP PPPPPPPPP -EE~ ~P~--",
    "mesh":            "--P-P ---P-PP-- -EE~ -----",
    "play":            "--E-E --------- -EE~ -----",
    "cogging":         "--P-P ------PP- -EE~ -----",
    "squeeze":         "PEPPP PPPPPPPPP PEE~ ~P~--",
    "undamped":        "EEEEE --E-----E EEE~ ~E~E-",
    "unheld":          "EEEPE --E-----E EEE~ ~E~E-",
    "unpushed":        "P-PPE PEEEPEEEE EEE~ ~P~E~",
    "handless":        "EEEPE --------- -EE~ ~E~E-",
}  # fmt: skip

# Parts that the page of `hknob explore` follows; what is not named here it refuses.
_EXPLORED = frozenset(
    (
        *("bias", "hand", "grip", "people", "knob_damping", "friction", "hand_damping", "hand_stiffness"),
        *("virtual_damping", "delay", "torque_limit", "torque_step", "dead_band", "rounding", "offset"),
        *("controller", "knob_model", "by_counts", "motor", "supply", "eddy_brake"),
        *("undamped", "unheld", "unpushed", "handless"),
    )
)


def _rows() -> dict[tuple[str, str], str]:
    found: dict[tuple[str, str], str] = {}
    listed = [column for column in COLUMNS if column != "explore"]
    for part in PARTS:
        letters = _TABLE[part].replace(" ", "")
        if len(letters) != len(listed):
            raise ValueError(f"the row of {part} has {len(letters)} verdicts for {len(listed)} columns")
        found |= {(part, column): letter for column, letter in zip(listed, letters, strict=True)}
        found[part, "explore"] = EXACT if part in _EXPLORED else REFUSED
    return found


VERDICTS = _rows()

# What a sweep is asked for and does not go together: which, beside which starts or request, when, and why.
APART = (
    ("record", ("ranges", "anywhere"), "", "a recording begins at one start"),
    ("growth", ("ranges", "anywhere"), "", "bounces are collected from one start"),
    ("basins", ("phases", "one", "anywhere"), "where starts are not ranges", "a map is of every start in a box"),
    ("perceive", ("growth",), "where 'growth' is given", "what nothing damps has no cycle"),
    ("growth", ("population",), "where a population is given", "its hands damp"),
)

# Engines that may take a scene, by its starts; the first that takes all of its parts does.
TRIALS = ("bounces", "plain", "general", "unsampled", "laws")
PHASES = ("bounces", "phases", "general_sets", "friction_sets", "law_sets", "friction_arcs", *TRIALS[1:])
RANGES = ("bounces", "ranges", "general_sets", "friction_sets", "law_sets", "cogging_sets", "general", "laws")
ANYWHERE = ("bounces", "anywhere", "general_anywhere")
STARTS = {"phases": TRIALS, "one": PHASES, "ranges": RANGES, "anywhere": ANYWHERE}

_KEYS = {name: part.path for name, part in PARTS.items()}
_REFUSED = {column: frozenset(part for part in PARTS if VERDICTS[part, column] == REFUSED) for column in COLUMNS}
_PAIRS = {
    column: [
        (frozenset({one, other}), lower.unless)
        for (one, other, at), lower in EXCEPTIONS.items()
        if (at, lower.verdict) == (column, REFUSED)
    ]
    for column in COLUMNS
}


def parts_of(scene: Scene) -> frozenset[str]:
    """Which of `PARTS` a scene has, and what it amounts to."""
    return parts_there(scene, _KEYS)


def hindrances(column: str, parts: Set[str]) -> list[frozenset[str]]:
    """What of these parts an engine, law or command refuses: each by itself, and those that it refuses together."""
    alone = [frozenset({part}) for part in _REFUSED[column] & parts]
    return alone + [pair for pair, unless in _PAIRS[column] if pair <= parts and parts.isdisjoint(unless)]


def takes(column: str, parts: Set[str]) -> bool:
    """Whether an engine, law or command takes a scene with these parts."""
    return not hindrances(column, parts)


def deciding(*columns: str) -> frozenset[str]:
    """Paths of the numbers by which a scene has parts that one of these columns refuses."""
    refused = frozenset().union(*(_REFUSED[column] for column in columns))
    return frozenset(path for part in refused for path in (PARTS[part].path, *PARTS[part].of) if path)


def engine_of(scene: Scene, engines: Sequence[str]) -> str:
    """The first of ``engines`` that takes a scene. Raises `ValueError` where none does, which validation excludes."""
    parts = parts_of(scene)
    for engine in engines:
        if takes(engine, parts):
            return engine
    raise ValueError(f"no engine takes a scene with {', '.join(sorted(parts))}")


def verdict_of(parts: Iterable[str], column: str) -> tuple[str, str]:
    """What a column makes of a scene with these parts, the lowest verdict of all; and of which part or pair."""
    there = frozenset(parts)
    inherent_first = sorted((part for part in PARTS if part in there), key=lambda part: not PARTS[part].of)
    found = [(VERDICTS[part, column], PARTS[part].title) for part in inherent_first]
    found += [
        (lower.verdict, f"{PARTS[one].title} with {PARTS[other].title}")
        for (one, other, where), lower in EXCEPTIONS.items()
        if where == column and {one, other} <= there and there.isdisjoint(lower.unless)
    ]
    return min(found, key=lambda one: LOWEST_FIRST.index(one[0]), default=(PROVEN, ""))


def reason(part: str, column: str) -> str:
    """Why a column refuses a part, as the end of a sentence."""
    return WHY.get((part, column)) or COLUMNS[column].why.format(what=PARTS[part].title)
