"""A sample clock that jitters: how long each interval is, drawn evenly between two lengths, in the longest one.

A clock is a flat array: the state of its random numbers, the shortest interval, by how much the longest is longer, the
seed, the number of the first trial, and the interval that is meant, by which firmware has its numbers. The random
numbers are those of Park & Miller (1988, "minimal standard"), s -> 16807 s mod 2^31 - 1, whose products a double holds
exactly: compiled or not, they are the same.

The compiler makes code of its own for scenes without any part of this kind, in which nothing of this is left: a clock
that is None is known by its type. Beside other such parts it is empty (`search.as_compiled`).
"""

STATE, SHORTEST, SPREAD, SEED, TRIAL, MEANT = range(6)
FACTOR, MODULUS = 16807.0, 2147483647.0
FIRST = 8  # numbers that are passed over: those of neighbouring trials are alike at first


def jitters(clock):
    """Whether intervals differ."""
    if clock is None:
        return False
    return bool(len(clock))


def next_span(clock):
    """Length of the next interval, in the longest; 1 without jitter."""
    if clock is None or not len(clock):
        return 1.0
    clock[STATE] = (FACTOR * clock[STATE]) % MODULUS
    return clock[SHORTEST] + clock[SPREAD] * (clock[STATE] / MODULUS)


def meant_pace(speed, clock):
    """A speed in counts over the interval that is meant, from counts over the longest; the same without jitter."""
    if clock is None or not len(clock):
        return speed
    return clock[MEANT] * speed


def begin_clock(clock, trial):
    """Set a clock to the beginning of a trial, by its number."""
    if clock is None or not len(clock):
        return
    clock[STATE] = (65539.0 * clock[SEED] + 30269.0 * (trial + clock[TRIAL])) % (MODULUS - 1.0) + 1.0
    for _ in range(FIRST):
        clock[STATE] = (FACTOR * clock[STATE]) % MODULUS
