"""docs/reference/controllers.md is enough to build each controller: its blocks in plain Python, against the engine.

The torques are compared. Each block is a class of its kind's file in `laws`, in SI units.
"""

from math import pi
from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past
from hknob_cli.specs.controller import KINDS
from hknob_cli.specs.scene import SceneSpec
from tests.conftest import ROOT
from tests.controllers.laws import LAWS
from tests.controllers.page_blocks import SCENE, K

CELLS = [(1000.0, 360, 0.0), (1000.0, 2650, -0.4), (3000.0, 1024, -1.0)]
SAMPLES = 400


@pytest.mark.parametrize("cell", CELLS, ids=str)
@pytest.mark.parametrize(
    "controller",
    [one for law in LAWS.values() for one in [*law.VARIANTS, *getattr(law, "LOOP_ONLY", {}).values()]],
    ids=lambda one: " ".join(map(str, one.values())),
)
def test_a_controller_built_from_the_page_gives_the_engines_torques(
    controller: dict[str, Any], cell: tuple[float, int, float]
) -> None:
    rate, counts, velocity = cell
    plan = SceneSpec.model_validate({**SCENE, "controller": controller}).plain()
    made = make_law(plan, sample_rate_hz=rate, counts_per_rev=counts)
    law, wall, body = made.law, made.knob.wall, made.knob.body
    page = LAWS[controller["kind"]].Block(
        counts, rate, **{name: one for name, one in controller.items() if name != "kind"}
    )
    count = 2.0 * pi / counts
    z, past = made.knob.start(0.002, velocity - 0.1), [0.0] * len(law.beside)
    begin_past(past, read(z[0], wall), law)
    acts = 0
    for k in range(SAMPLES):
        shown, pace = read(z[0], wall), z[1]
        theirs = page.sample(shown * count, pace * count * rate, [one * count for one in past[law.rows + 1 : law.line]])
        advance_with_law(z, past, body, wall, law, [0.0] * 4)
        ours = [one * K * count for one in law.out[: law.parts]]
        # A torque is a sum of at most a few dozen products, each rounded; the terms are at most as large as the wall's
        # torque and a count's, or as the velocity with the gain that acts on it. A filter's memory adds up some
        # rounding of each of its last samples: by 1/(1 - fade), below 100 here.
        gain = abs(getattr(page, "l2", 0.0)) + abs(controller.get("damping", 0.0)) + K / rate
        size = K * (abs(shown) + 2.0) * count * 40.0 + gain * (abs(page.v) + abs(pace) * count * rate + count * rate)
        assert len(ours) == len(theirs)
        for one, other in zip(ours, theirs, strict=True):
            assert abs(one - other) <= 1000 * np.finfo(float).eps * size, (k, one, other)
        acts += any(abs(one - page.w) > 1e-9 for one in theirs)
    assert acts > 10, "says little of a controller that never differs from the plain wall"


def test_the_page_has_a_block_for_every_kind() -> None:
    text = (ROOT / "docs" / "reference" / "controllers.md").read_text()
    assert set(LAWS) == set(KINDS)
    for kind, declared in KINDS.items():
        block = text.partition(f"### {kind}\n```text\n")[2].partition("```")[0]
        assert block, kind
        said = block.replace("velocity", "") + (" velocity" if " v" in block else "")
        for key in declared.keys:
            assert key in said, (kind, key)


def test_the_energy_sum_begins_anew_only_outside_and_with_no_count_moved() -> None:
    """What the page says in words, of the engine itself: debt is kept while the free knob moves, and damped there."""
    plan = SceneSpec.model_validate({**SCENE, "controller": {"kind": "passivity", "damping": 3.0e-4}}).plain()
    made = make_law(plan, sample_rate_hz=1000.0, counts_per_rev=1024)
    law = made.law

    def act(count: float, memory: list[float]) -> tuple[float, float]:
        past = [*memory, 0.0]
        law.act(count, 0.0, past, law.fixed, law.out)
        return law.out[0], past[2]

    owed = [1.0, 0.0, -0.5]  # at count 1, no torque held, half a step times a count owed
    torque, energy = act(2.0, owed)
    assert torque < 0.0  # against the motion, outside the wall
    assert energy == -0.5
    assert act(1.0, owed) == (0.0, 0.0)
    assert act(-2.0, [-2.0, 0.0, -0.5])[1] == -0.5
