"""What the loop knows of a controller: its function and numbers, what it remembers, and when its torques act."""

from typing import Any, NamedTuple

from hknob_cli.engine.general.controller import Controller

PIECE = 7  # numbers of a piece of an interval: time, S, G, F, where its torque stands, where a look goes, its matrix
SPAN, S, G, F, TORQUE, LOOK, MATRIX = range(PIECE)

# Numbers of a pair of rows that fades: the map of a sample, row by row; the norm in which it shrinks, two forms; and
# by how much that norm is larger than the size of a difference.
PAIR_NORM, PAIR_ACROSS, PAIR = 4, 8, 9
BLOCK = 256  # samples over which rounding is followed one by one
STOP = 16  # of them, from one place where it is summed up to the next
ROUNDINGS = 16.0  # of a torque, or of an update of what fades
AT_SWITCH = 8  # status of a proof: a guard of the law lies within the error bound

# Fates beside those of `general.follow`.
CYCLE_AT_SWITCH = 12
CYCLE_NOT_AFFINE = 13
REST_NOT_PROVEN = 14


class Law(NamedTuple):
    """A controller of one cell, with room to work in.

    ``past`` of a trial is one array: ``rows`` numbers that the law remembers, the last reading, those of ``looks``
    into the last interval, with hysteresis the count at the last turning point, and from ``line`` on the torques of
    ``ages`` samples, ``parts`` each, the newest last, as accelerations of the knob. The oldest of them no longer
    matters once the next sample has come.
    """

    act: Any  # the function of a controller, or its address
    unit: float  # acceleration by a torque of 1: a step of the wall
    fixed: Any
    first: Any  # (rows), memory before the first sample
    rows: int
    places: int  # the first rows, so many, begin at the place that the encoder shows
    looks: int
    line: int
    parts: int
    ages: int
    pieces: int
    sched: Any  # (pieces * PIECE), the pieces of an interval between changes of torque and looks
    fading: int  # the row that fades, the first of two if there is a ``pair``, or -1
    fade: float  # by which a difference in it shrinks in a sample; 0 without one
    weight: float  # acceleration by which a torque differs, by a difference in it
    coarse: float  # times that a torque's rounding may be larger than that of the wall's own
    guarded: bool  # whether the law's guards are of that row
    anchor: int  # a row that is 1 where the others have just begun anew, which a proof needs; or -1
    drifts: int  # a row that is a sum, and may grow for ever where the law no longer acts by it; or -1
    senses: bool  # whether the law reads the velocity
    provable: bool
    cuts: bool  # whether it may command nothing at all, and then returns its guard negative
    unproven: int  # fate of what repeats under a law that is not provable
    watch: Controller  # the wall, with virtual damping where readings outside matter: which edges change a command
    out: Any  # (2 * parts), torques, and their slopes by the speed
    room: Any  # (1), by how much the guards of the last orbit tried clear all errors
    beside: Any  # like ``past``, of a motion beside the trial
    periodic: Any  # like ``past``, of the periodic orbit
    affine: Any  # ((m + 1) * m), of a law that senses, m numbers in `laws.sensed`: an interval's map
    slopes: Any  # (BLOCK), by the speed, of the torques of a block of intervals
    noise: Any  # (4 * m), what rounding may come to: in an interval, up to a block, in work, and up to a stop in it
    pair: Any = ()  # numbers of two rows that fade together, or none
