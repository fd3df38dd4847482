"""How long a trial may take, and which trials are decided before they begin."""

from math import sqrt
from typing import NamedTuple

from hknob_cli.engine.follow import LEFT, UNSETTLED
from hknob_cli.engine.propagator import slowest_rate

FINEST = 2.0**45  # counts; beyond it a double leaves a count less than 8 bits of fraction
SETTLE = 10.0  # transient skipped before detection, in time constants of the slowest mode
UNDAMPED_SAMPLES = 65_536
FEWEST_SAMPLES, MOST_SAMPLES = 65_536, 2**24

OPEN = -1  # not decided yet
# Ends of a cell's trials beside those of `follow` and `general.follow`.
TOO_SLOW = 16
UNHELD = 17
TOO_FINE = 18
TOO_MANY = 19


class TrialBudget(NamedTuple):
    """How long a trial is followed.

    ``skip``: samples that pass before anything is looked for; ``samples``: at most, in all; ``final``: whether what is
    unsettled then stays so, as in `follow`; ``limit``: counts from the wall beyond which a trial has left.
    """

    skip: int
    samples: int
    final: bool
    limit: float


def sample_limit(rate, damped):
    """Samples a trial may take: 600 time constants of the slowest mode, of decay ``rate``, within bounds."""
    if not damped:
        return UNDAMPED_SAMPLES
    wanted = 600.0 / rate if rate > 0.0 else float("inf")
    return int(min(max(wanted, float(FEWEST_SAMPLES)), float(MOST_SAMPLES)))


def settling_samples(rate, limit):
    """Samples to pass before detection begins, at most an eighth of ``limit``."""
    if rate == 0.0:
        return 0
    return int(min(SETTLE / rate, float(limit // 8)))


def trial_scale(x, v, push, wall, spring):
    """Counts that a trial from (``x``, ``v``) spans at most, roughly: its start, its static depth, how far it coasts.

    ``push``, ``wall`` and ``spring`` are the bias and the stiffness of wall and hand, per inertia.
    """
    static = push / (wall + spring) if wall + spring > 0.0 else 0.0
    coast = abs(v) * min(1000.0, 1.0 / sqrt(spring) if spring > 0.0 else float("inf"))
    return max(1.0, abs(x), abs(static), coast)


def prospect(x, v, max_samples, loop):
    """What awaits trials from (``x``, ``v``): ``(fate, budget, skip, limit)``.

    ``fate`` is `OPEN`, or how they end without being run; ``budget``: samples each may take (``max_samples``, if it is
    above 0); ``skip``: those that pass before detection begins; ``limit``: the position past which it has diverged.
    """
    rate = slowest_rate(loop.alpha, loop.beta)
    budget = max_samples if max_samples > 0 else sample_limit(rate, loop.alpha > 0.0)
    scale = trial_scale(x, v, loop.gamma, loop.kappa, loop.beta)
    fate = OPEN
    if not scale < FINEST:
        fate = TOO_FINE
    elif loop.kappa == 0.0 and loop.beta == 0.0 and loop.gamma > 0.0:
        fate = LEFT
    return fate, budget, settling_samples(rate, budget), 1e6 * scale


def unrepeated(rate, budget, held):
    """Why a trial found no repeating levels within ``budget`` samples; ``held``: whether a spring holds the knob."""
    if not held:
        return UNHELD
    return TOO_SLOW if 0.0 < rate * budget < SETTLE else UNSETTLED
