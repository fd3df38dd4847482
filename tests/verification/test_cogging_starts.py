"""All starts in ranges beside cogging, with friction and without: against single starts.

The plants are matrix exponentials in SI (`rubbing_starts`), which share no code with the package.
"""

from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.sets.cog_search import CogSetEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.sets.search import Box
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec

from .general_scenes import scene
from .test_friction_arcs import COGS, LATE, WEAK, rub, settle
from .test_law_states import orbit_states

RANGES = (-0.05, 0.05, -5.0, 5.0)
STARTS = 96
CASES: dict[str, tuple[dict[str, Any], float, int]] = {
    "nothing rubs": (rub(0.0, cogging=COGS), 1000.0, 512),
    "nothing rubs, weak": (rub(0.0, cogging=WEAK), 464.0, 1024),
    "nothing rubs, fast": (rub(0.0, cogging=COGS), 4642.0, 256),
    "nothing rubs, late": (rub(0.0, cogging=COGS, actuator=LATE), 1000.0, 512),
    "nothing rubs, limit": (rub(0.0, cogging=COGS, actuator={"torque_limit": 4e-3}), 1000.0, 512),
    "nothing rubs, detents": (rub(0.0, cogging=WEAK, detents={"per_revolution": 24, "torque": 3e-3}), 464.0, 512),
    "nothing rubs, virtual damping": (rub(0.0, cogging=COGS, wall={"damping": 2e-5}), 464.0, 512),
    "friction": (rub(1e-4, cogging=WEAK), 464.0, 512),
    "friction, rests": (rub(1e-4, cogging=COGS), 1000.0, 2048),
    "friction, late": (rub(1e-4, cogging=COGS, actuator=LATE), 464.0, 256),
    "much friction": (rub(5.6e-4, cogging=COGS), 1000.0, 1024),
}


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_starts_in_ranges_end_in_the_list(name: str) -> None:
    """Each of 96 at random lies, when it has settled, on an orbit that is listed, or rests in its reading."""
    more, rate, counts = CASES[name]
    parts = scene(**more)
    knob = sample_general(reduced(SceneSpec.model_validate(parts).plain()), sample_rate_hz=rate, counts_per_rev=counts)
    box = Box(*(knob.position(at) for at in RANGES[:2]), *(knob.speed(at) for at in RANGES[2:]))
    found = CogSetEngine(compiled("cogging sets")).search_box(
        knob.body, knob.wall, box, rate=knob.rate, delay_line=knob.delay_line, max_samples=None
    )
    assert found
    assert found.complete
    assert all(one.certified for one in found.attractors)
    chance = np.random.default_rng(len(name))
    starts = np.array([chance.uniform(*RANGES[:2], STARTS), chance.uniform(*RANGES[2:], STARTS)])
    theta, omega = settle(parts, rate, counts, int(20.0 / knob.rate) + 500, starts)
    x, v = theta / knob.quantum_rad, omega * knob.period_s / knob.quantum_rad
    ends = np.zeros(STARTS, dtype=bool)
    for one in found.attractors:
        if one.outcome is Outcome.REST:
            ends |= (
                (np.abs(v) < 1e-6)
                & (np.floor(x - 1e-9) <= np.floor(one.x + 1e-9))
                & (np.floor(one.x - 1e-9) <= np.floor(x + 1e-9))
            )
        else:
            for at_x, at_v, *_ in orbit_states(knob, None, one):
                ends |= (np.abs(x - at_x) < 1e-6) & (np.abs(v - at_v) < 1e-6)
    assert ends.all(), f"{np.count_nonzero(~ends)} end elsewhere, the first at {x[~ends][0]}, {v[~ends][0]}"
