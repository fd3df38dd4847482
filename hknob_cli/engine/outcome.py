"""How a trial ends, and why it may not: the codes that the engine returns, and their words."""

from enum import IntEnum


class Outcome(IntEnum):
    """End of a trial, as ``orbits.parquet`` spells it (lower case)."""

    CYCLE = 0
    REST = 1
    DIVERGED = 2
    UNDECIDED = 3


class Reason(IntEnum):
    """Why an outcome is not proven; ``NONE`` where it is."""

    NONE = 0
    GREW = 1
    LEAVES = 2
    NO_DAMPING = 3
    NO_REPEAT = 4
    TOO_SLOW = 5
    ON_EDGE = 6
    CONTINUUM = 7
    TOO_FINE = 8
    TOO_MANY = 9
    REST_ON_EDGE = 10
    NO_STIFFNESS = 11
    AT_EVENT = 12
    EXPANDS = 13
    CONSERVATIVE = 14
    EVENT_LIMIT = 15
    TOO_LONG = 16
    NOT_AFFINE = 17
    AT_SWITCH = 18
    TIME_LIMIT = 19
    NO_REGION = 20
    WORK_LIMIT = 21
    SPINS = 22
    PARTS = 23
    JITTERS = 24
    COGS = 25
    RACES = 26
    PARTS_OR_COGS = 27


WORDS = {
    Reason.NONE: "",
    Reason.GREW: "grew beyond a million times its start and static depth",
    Reason.LEAVES: "leaves, and nothing brings it back",
    Reason.NO_DAMPING: "no damping: nothing makes the motion settle",
    Reason.NO_REPEAT: "no level sequence repeated within the sample limit (limits.max_samples)",
    Reason.TOO_SLOW: "the slowest mode needs more samples than the limit (limits.max_samples)",
    Reason.ON_EDGE: "a sample of the cycle lies on a count edge to within the error bound",
    Reason.CONTINUUM: "no hand stiffness: cycles form a continuum, drift per period zero only to rounding",
    Reason.SPINS: "turns on and on over a torque that repeats: no spring holds it, and it has not stopped so far",
    Reason.TOO_FINE: "the motion spans more counts than double precision resolves",
    Reason.TOO_MANY: "more distinct orbits than a cell keeps",
    Reason.NO_STIFFNESS: "no hand stiffness: nothing holds the knob's position, and no level sequence repeated",
    Reason.AT_EVENT: "a standstill in the cycle may, to within the error bound, slide on or stay",
    Reason.EXPANDS: "the period map is not shown to contract: nearby motions need not follow",
    Reason.CONSERVATIVE: "neither damping nor friction: the motion repeats, one of a continuum of its kind",
    Reason.PARTS: "teeth part in the cycle: it attracts to first order, but no bound on how far away is proven",
    Reason.COGS: "it passes corners of cogging, or stays where cogging does not hold the knob, with too little room "
    "for a proof: it attracts to first order",
    Reason.PARTS_OR_COGS: "teeth part, or no slope of cogging holds the knob all along: it attracts to first order, "
    "which is no proof",
    Reason.RACES: "grew beyond a thousand times its start and static depth, past 1024 corners of cogging a sample",
    Reason.JITTERS: "no two sample intervals are alike: no motion repeats, and rest is not proven",
    Reason.TOO_LONG: "it repeats, but its period has too many turning points to measure",
    Reason.NOT_AFFINE: "the controller is not piecewise affine: it repeats, and attracts to first order",
    Reason.AT_SWITCH: "a switch of the controller lies within the error bound: nearby motions may take it",
    Reason.EVENT_LIMIT: "not settled within the limit of events",
    Reason.TIME_LIMIT: "not settled within the time limit of a cell (limits.seconds_per_cell)",
    Reason.NO_REGION: "no region was found that every motion comes into from any distance",
    Reason.WORK_LIMIT: "sets of starts were still under way after all the work that a cell may take",
    Reason.REST_ON_EDGE: "the rest point lies on a count edge to within rounding",
}
