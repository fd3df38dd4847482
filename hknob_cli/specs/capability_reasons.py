"""Why a part of a scene is refused, where the column's own reason in `specs.capabilities` does not say it."""

from hknob_cli.specs.over_angle import OVER_ANGLE

_GENERAL_SETS = ("general_sets", "friction_sets", "law_sets", "friction_arcs", "cogging_sets")
_OF_ONE_START_OR_RANGES = ("phases", "ranges", *_GENERAL_SETS)
SETS = (*_OF_ONE_START_OR_RANGES, "anywhere", "general_anywhere")  # engines of sets of starts
_A_PERIOD_APART = ("plain", "bounces", "describing", "relay", "formulas", "bench")
_NOT_IN_A_MAP = {
    "a map tells starts by angle and velocity alone": ("finger", "coil", "mesh", "play"),
    "what is under way, or was read before, is not told by a map's starts": (
        *("virtual_damping", "delay", "lag", "current_loop", "hysteresis", "backlash"),
    ),
    "what it remembers is not told by a map's starts": ("controller",),
}
_NOT_A_BALL = {
    "its torque is held from sample to sample": ("lag", "current_loop"),
    "its torque is the plain wall's": ("torque_limit", "torque_step", "dead_band", "supply"),
    "its count has no memory": ("hysteresis", "backlash"),
    "it is of one body": ("mesh", "play"),
    "it is of a knob that nothing holds": ("cogging",),
}
_STATE_BY_STATE = (
    ("bare", "the torque differs within a set"),
    ("play", "teeth part at different times within a set"),
    ("cogging", "another engine goes from corner to corner"),
)
# Why a part is refused, where its column's own reason does not say it.
WHY = {
    ("virtual_damping", "unsampled"): "virtual damping needs samples to difference",
    ("delay", "unsampled"): "a delay in samples needs a sample clock",
    **{(name, "plain"): "its torque is that of a wall" for name in OVER_ANGLE},
    **{(name, "bounces"): "the ball bounces on a wall" for name in OVER_ANGLE},
    **{(name, "unsampled"): "its events are those of a wall" for name in OVER_ANGLE},
    ("unsampled", "bounces"): "energy does not grow",
    ("unsampled", "laws"): "it acts at samples",
    **{("jitter", column): "its samples are a period apart" for column in _A_PERIOD_APART},
    **{("jitter", column): "the next sample comes at another time in each motion" for column in SETS},
    ("jitter", "unsampled"): "there is no clock",
    ("jitter", "basins"): "where a start ends depends on the intervals that are drawn",
    ("jitter", "perceive"): "no motion repeats",
    ("jitter", "device"): "a device has the clock that it has",
    ("bare", "bounces"): "its engine reads counts",
    ("controller", "bounces"): "growth is of the plain wall",
    ("unsampled", "ranges"): "states in ranges are those at a sample",
    ("unsampled", "pulse"): "without a sample clock motions go from edge to edge, and do not stop where a pulse ends",
    ("unpushed", "bounces"): "nothing brings the knob back to it",
    ("handless", "anywhere"): "nothing draws the knob back",
    **{
        (part, column): why
        for part in ("hysteresis", "backlash")
        for column, why in (
            ("unsampled", "its events are edges without memory"),
            ("relay", "its relay has no memory"),
            ("formulas", "its formulas have no memory"),
        )
    },
    ("finger", "explore"): "the engine of its page has one body",
    ("bare", "explore"): "the engine of its page reads counts",
    ("unsampled", "explore"): "the engine of its page has a sample clock",
    **{(name, "explore"): "its torque is that of a wall" for name in OVER_ANGLE},
    ("unsampled", "perceive"): "no cycle is proven there",
    ("bare", "describing"): "dfa needs an encoder's counts",
    ("bare", "relay"): "dfa needs an encoder's counts",
    ("bare", "formulas"): "predict needs an encoder's counts",
    ("unsampled", "describing"): "dfa is about a sampled wall",
    ("unsampled", "relay"): "dfa is about a sampled wall",
    ("unsampled", "formulas"): "predict is about a sampled wall",
    **{(part, "basins"): why for why, parts in _NOT_IN_A_MAP.items() for part in parts},
    ("handless", "basins"): "nothing bounds how far motions part",
    ("unsampled", "basins"): "a map's starts are states at a sample",
    **{(part, "bounces"): why for why, parts in _NOT_A_BALL.items() for part in parts},
    ("gear", "basins"): "its map is of the counts of a knob without a gear",
    ("people", "bounces"): "its hands damp",
    ("people", "describing"): "its spec has no population",
    ("people", "relay"): "its spec has no population",
    ("people", "formulas"): "its spec has no population",
    ("people", "bench"): "its spec has no population",
    **{
        ("speed_sensor", column): "the torque depends on the velocity itself"
        for column in ("friction_sets", "law_sets", "friction_arcs")
    },
    ("several_readings", "law_sets"): "sets of more than angle and speed are cut at samples alone",
    ("lag", "device"): "that is an amplifier's own; a virtual device has it by nuisances.amplifier",
    **{(part, column): why for column in _GENERAL_SETS for part, why in _STATE_BY_STATE},
    **{("handless", column): "no energy bounds how far motions part" for column in _OF_ONE_START_OR_RANGES},
    ("hysteresis", "device"): "that is an encoder's own, and no simulated knob has it",
    ("backlash", "device"): "that is an encoder's own, and no simulated knob has it",
    ("people", "device"): "a campaign is of one subject",
    ("finger", "device"): "the hand turns with a simulated knob",
    ("bare", "device"): "a target counts, and has no continuous sensor",
    ("unsampled", "device"): "a target has a sample clock",
    ("gear", "device"): "a target counts turns of the knob, and a gear's encoder is on the motor; of a rigid gear give "
    "knob.inertia with n² times the motor's, and n times the counts",
    ("mesh", "device"): "a simulated knob is one body",
    ("play", "device"): "a simulated knob is one body",
    ("cogging", "device"): "a device has the cogging of its motor, and no simulated knob has it",
    **{(part, "device"): "somebody always holds the knob" for part in ("undamped", "unheld", "handless")},
    ("squeeze", "device"): "a simulated hand has the grip that the trial asks for",
    **{("undamped", column): "nothing contracts" for column in _OF_ONE_START_OR_RANGES},
    **{("unheld", column): "no energy bounds how far motions part" for column in _OF_ONE_START_OR_RANGES},
}  # fmt: skip
# Refusals whose fault stands at what is asked for, not at the part of the scene.
AT = {
    **{(part, "bounces"): ("growth",) for part in ("unsampled", "bare", "controller", "unpushed", "people")},
    ("unsampled", "pulse"): ("record", "pulse"),
    ("unsampled", "perceive"): ("perceive",),
    ("jitter", "perceive"): ("perceive",),
    ("handless", "anywhere"): ("starts",),
    ("handless", "basins"): ("basins",),
}  # fmt: skip
