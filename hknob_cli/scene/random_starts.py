"""Starts drawn at random from a range of angles and velocities, where not all can be followed at once."""

import random

from hknob_cli.specs.plan import Starts


def random_starts(starts: Starts) -> list[tuple[float, float]]:
    """Angle (rad) and velocity (rad/s) of each, evenly spread over the range; the same ones at every call."""
    assert starts.span
    low, high, slowest, fastest = starts.span
    chance = random.Random(0)
    return [(chance.uniform(low, high), chance.uniform(slowest, fastest)) for _ in range(starts.random)]
