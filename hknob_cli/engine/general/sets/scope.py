"""How far the motions of a cell are followed as sets, and whether they can be."""

from math import inf
from typing import NamedTuple

from hknob_cli.engine.budget import FINEST, sample_limit, settling_samples, trial_scale
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.laws.law import Law
from hknob_cli.engine.general.outlook import MOST_SAMPLES
from hknob_cli.engine.general.torque_range import torque_range

LONGEST = {2: 1_000_000_000, 3: 100_000_000}  # samples that a cell may take: some minutes; 3: of more states, too


class Scope(NamedTuple):
    """How far motions of a cell are followed.

    ``budget``: samples of each; ``skip``: of the transient; ``patience``: in no known attractor, before one is looked
    for; ``limit``: position past which a motion has diverged; ``fine``: whether a double tells positions apart.
    """

    budget: int
    skip: int
    patience: int
    limit: float
    fine: bool


def can_follow(body: Body, wall: Controller, law: Law | None = None) -> bool:
    """Whether sets of states of a cell can be followed: differences go by one matrix, decay, and have an energy.

    A law is proven, and reads its encoder at samples alone.
    """
    known = law is None or (law.provable and not law.senses and law.looks == 0)
    return body.friction == 0.0 and wall.analog == 0.0 and body.damped and body.reach < inf and known


def make_scope(body: Body, wall: Controller, x: float, v: float, rate: float, max_samples: int | None) -> Scope:
    """How far to follow motions from positions up to ``x`` and speeds up to ``v``.

    ``rate``: decay of the slowest mode, per sample; ``max_samples``: of a motion, None as many as settling wants.
    """
    budget = max_samples or min(sample_limit(rate, body.damped), MOST_SAMPLES[min(body.order, 3)])
    spring = body.beta if body.ratio == 0.0 else 1.0 / body.reach**2
    scale = max(trial_scale(x, v, body.push, wall.kappa, spring), torque_range(wall).span)
    skip = settling_samples(rate, budget)
    return Scope(budget, skip, max(64, skip // 2), 1e6 * scale, scale < FINEST)
