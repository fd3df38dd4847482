"""How far the trials of a cell are followed in the general loop, and what is known without any."""

from math import inf
from typing import NamedTuple

from hknob_cli.engine.budget import FINEST, sample_limit, settling_samples, trial_scale
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cogging import PEAK, cog_number
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.torque_range import TorqueRange
from hknob_cli.engine.outcome import Reason

MOST_SAMPLES = {2: 2**20, 3: 2**18}  # of a trial by default; more states take longer
PASSED = 256  # turns of a torque over the angle, after which a knob that nothing holds is said to spin


class Outlook(NamedTuple):
    """How far trials from a start are followed.

    ``ends``: why none is, and they end at once; ``budget``: samples of each; ``skip``: of the transient; ``far``:
    position past which a motion does not come back; ``held``: whether a spring holds the knob; ``grew``: why one that
    came so far has.
    """

    ends: Reason
    budget: int
    skip: int
    far: float
    held: bool
    grew: Reason


def make_outlook(
    body: Body, wall: Controller, torques: TorqueRange, start: list[float], rate: float, max_samples: int | None
) -> Outlook:
    """How far trials from a start are followed, and whether their end is known without one.

    ``torques``: that are commanded far out; ``rate``: decay of the slowest mode, per sample; ``max_samples``: of a
    motion, None as many as settling wants.
    """
    budget = max_samples or min(sample_limit(rate, body.damped), MOST_SAMPLES[min(body.order, 3)])
    spring = body.beta if body.ratio == 0.0 else (1.0 / body.reach**2 if body.reach < inf else 0.0)
    scale = trial_scale(start[0], start[1], body.push, wall.kappa + torques.spring, spring)
    scale = max(scale, torques.span)
    loose = spring == 0.0 and body.ratio == 0.0
    least = body.friction + cog_number(body.cogs, PEAK)  # that can hold the knob
    ends = Reason.NONE
    if not scale < FINEST:
        ends = Reason.TOO_FINE
    elif loose and (torques.most + least < body.push or body.push + least < torques.least):
        ends = Reason.LEAVES
    spins = loose and torques.turn > 0.0
    far = scale + PASSED * torques.turn + abs(start[1]) / body.alpha if spins and body.alpha > 0.0 else 1e6 * scale
    grew = Reason.SPINS if far < 1e6 * scale else Reason.GREW
    return Outlook(ends, budget, settling_samples(rate, budget), far, spring > 0.0, grew)
