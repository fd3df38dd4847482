"""What the functions of sets have in common: how far motions are followed, and the state that a set is told from."""

from typing import NamedTuple


class Scope(NamedTuple):
    """How far motions are followed.

    ``patience``: samples in no known attractor, after which one is looked for; ``budget``: samples of a motion;
    ``limit``: position past which it has diverged.
    """

    patience: int
    budget: int
    limit: float


class Start(NamedTuple):
    """Where the motions of all clock phases begin, at a torque of zero until the first sample.

    ``x``: position, counts; ``v``: velocity, counts per sample; ``delay``: commands under way.
    """

    x: float
    v: float
    delay: int


class Trial(NamedTuple):
    """The centre of a ball, which is a trial, and how long all states of the ball have acted alike.

    Attributes:
        x: Position, counts.
        v: Velocity, counts per sample.
        error: Bound on its rounding error, in the norm of `certificate.distance`.
        level: That acted at the sample before.
        run: Samples that it has acted.
        next_test: Samples after which rest is tried.
        head: Where the oldest of the commands under way is.
    """

    x: float
    v: float
    error: float
    level: float
    run: int
    next_test: int
    head: int


class Centre(NamedTuple):
    """The state that a polygon is told from, and what all of its states share.

    Attributes:
        x: Position, counts.
        v: Velocity, counts per sample.
        error: Bound on its rounding error, in the norm of `certificate.distance`.
        level: As which all states of the polygon act, or acted last.
        sample: Samples taken so far.
        weight: Measure of the starts that are in the polygon.
    """

    x: float
    v: float
    error: float
    level: float
    sample: float
    weight: float
