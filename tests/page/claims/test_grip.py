"""The check of the grip that a push asks for: against the balance of fingers, wall and hand."""

import pytest

from hknob_cli.page.claims.checks import compute
from hknob_cli.results.result_set import MissingError
from tests.page.claims.conftest import SCENE, Made, cell

FOLLOWS = {
    **SCENE,
    "hand": {"table": 1, "grip_n": 0.71},
    "bias": {"torque": 0.001},
    "squeeze": {"friction": 0.7, "radius": 8.9e-3},
}


def test_two_fingers_hold_the_wall_s_torque(made: Made) -> None:
    """The hand of 1.3 N holds 0.06 N·m/rad; beside it the wall holds what 1.3 N holds by friction."""
    evidence = made("follows", {"cells": [cell(1000.0, 1024, 1e-3, 70.0)]}, scene=FOLLOWS)
    torque = 2.0 * 0.7 * 8.9e-3 * 1.3
    push = torque * (1.0 + 0.06 / 0.27)
    arguments = {"result": "follows", "push_nm": push}
    assert compute("asked_grip", evidence, arguments) == pytest.approx(1.3, rel=1e-12)
    assert compute("asked_grip", evidence, {**arguments, "over_nm": 0.001}) == pytest.approx(1.3 / 0.71, rel=1e-12)
    held = made("held", {"cells": [cell(1000.0, 1024, 1e-3, 70.0)]})
    with pytest.raises(MissingError, match="'held' does not follow its push"):
        compute("asked_grip", held, {**arguments, "result": "held"})
