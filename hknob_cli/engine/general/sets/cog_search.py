"""All starts in ranges of a cell beside cogging: its attractors, and whether the list is proven to be complete."""

from collections.abc import Callable
from math import inf
from typing import Any

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cogging import hold_stiffness, middle_of
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.sets import cog_box
from hknob_cli.engine.general.sets.cog_piece import Folds
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.friction_arc_search import make_rub_room, rub_drift
from hknob_cli.engine.general.sets.friction_search import FrictionSetEngine
from hknob_cli.engine.general.sets.piece import CORNERS


def can_follow_cogged(body: Body, wall: Controller) -> bool:
    """Whether sets of angle and speed can be followed from slope to slope of cogging: a knob alone, of plain counts.

    Springs hold it on every slope: on a top where it may stand, and from which all others move off, no set of states
    has one end.
    """
    plain = body.play == 0.0 and wall.analog == 0.0 and wall.hysteresis == 0.0 and body.damped and body.reach < inf
    if not plain or body.cogs is None or body.order != 2:
        return False
    return bool(hold_stiffness(body.cogs, middle_of(1.0, body.cogs), body) > 0.0)


class CogSetEngine(FrictionSetEngine):
    """Follows sets of states of a knob beside cogging; the group "cogging sets". One per thread."""

    def able(self, body: Body, wall: Controller) -> bool:
        """Whether this engine follows sets of states of a cell."""
        return can_follow_cogged(body, wall)

    def follower(self, body: Body, wall: Controller, delay_line: int) -> Callable[..., Any]:
        """What follows the pieces that wait, `cog_box.follow_cogged`."""
        rub = make_rub_room(self._zeros, self._filled, body, wall, delay_line, self.law)
        wide = 8 * CORNERS
        folds = Folds(self._zeros(wide), self._zeros(wide), self._zeros(2 * wide), self._zeros(wide))
        follow = self._function(cog_box, "follow_cogged")
        return lambda room, *rest: follow(room, rub, folds, *rest)

    def drift(self, body: Body, wall: Controller) -> Drift:
        """As that of `GeneralSetEngine`, of one step of a slide."""
        return rub_drift(body, wall, self.law)
