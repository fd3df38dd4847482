"""How designs are ranked, and how sure the answer of a search is.

That is what the answer would be with other levels, other thresholds, other people.
"""

from collections.abc import Callable, Mapping
from math import inf

import numpy as np

from hknob_cli.perception.published import REDRAWS, Doubt
from hknob_cli.stages.design.people import SENSES, Judged, exceeded_by
from hknob_cli.stages.design.space import Design


def meets(one: Judged, doubt: Doubt) -> bool:
    """Whether a design meets every limit if ``doubt`` is right."""
    if set(one.fails) - set(SENSES):
        return False
    for sense, (limit, levels) in one.asked.items():
        judged = one.others[doubt.thresholds] if sense == "touch" and doubt.thresholds else levels
        # A level that is exactly the present one's is of the same cycle, and differs from it by nothing.
        same = limit.above_present
        shifted = [level if same and level == 0.0 else level + doubt.shift_db for level in judged]
        if exceeded_by(shifted, limit.people) > limit.most_db:
            return False
    return True


def rank(done: Mapping[Design, Judged], order: Mapping[Design, int]) -> Callable[[Design], tuple[float, float, int]]:
    """What designs are ranked by: cost; of equal cost what is felt of them; then their ``order`` in the spec."""
    return lambda one: (one.cost, done[one].felt_db, order[one])


def answer_if(done: Mapping[Design, Judged], order: Mapping[Design, int], doubt: Doubt, most: float) -> Design | None:
    """The cheapest that is good if ``doubt`` is right; None where it costs more than ``most``, or there is none."""
    good = [design for design, one in done.items() if design.cost <= most and meets(one, doubt)]
    return min(good, key=rank(done, order), default=None)


def redrawn(
    done: Mapping[Design, Judged], order: Mapping[Design, int], most: float = inf, *, seed: int = 1
) -> dict[Design, float]:
    """Share of redraws of the people, with replacement, in which a design is the answer; the rest cost more.

    Only those that cost at most ``most`` are compared: all of them have been evaluated.
    """
    designs = sorted((one for one in done if one.cost <= most), key=rank(done, order))
    people = max((len(levels) for one in done.values() for _, levels in one.asked.values()), default=0)
    if not people:
        return {}
    drawn = np.random.default_rng(seed).multinomial(people, np.full(people, 1.0 / people), REDRAWS)
    left = np.ones(REDRAWS, dtype=bool)
    found: dict[Design, float] = {}
    for design in designs:
        one = done[design]
        if set(one.fails) - set(SENSES):
            continue
        good = left.copy()
        for limit, levels in one.asked.values():
            over = np.array(levels) > limit.most_db
            good &= drawn @ over <= int(limit.people * people + 1e-9)
        if good.any():
            found[design] = float(good.sum()) / REDRAWS
        left &= ~good
    return found
