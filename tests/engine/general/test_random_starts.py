"""Starts drawn from a range: both ways to follow them end where the complete list of a plain wall says."""

import numpy as np

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.sets.search import Box, SetEngine
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.scene.plain_knob import random_starts, sample_knob
from hknob_cli.specs.plan import COUNTS, RATE, Controller, Starts
from hknob_cli.specs.scene import SceneSpec

SCENE = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"half_quantum": True},
}
STARTS = Starts(angle=0.0, velocity=0.0, phases=60, sampled=False, span=(-0.05, 0.05, -5.0, 5.0), random=60)
CELL = {RATE: 1000.0, COUNTS: 128}


def expected() -> dict[int, int]:
    """Starts of `STARTS` by the period of the cycle that they end in, by the engine of sets."""
    knob = sample_knob(SceneSpec.model_validate(SCENE).plain(), sample_rate_hz=CELL[RATE], counts_per_rev=CELL[COUNTS])
    sets = SetEngine(compiled("sets"))
    low, high, slowest, fastest = STARTS.span or (0.0, 0.0, 0.0, 0.0)
    box = Box(knob.position(low), knob.position(high), knob.speed(slowest), knob.speed(fastest))
    found = sets.search_box(knob.loop, box, max_samples=None)
    assert found.complete
    starts = np.array([(knob.position(x), knob.speed(v)) for x, v in random_starts(STARTS)])
    ends = sets.map_starts(knob.loop, starts, found.attractors, max_samples=None)
    assert (ends >= 0).all()
    periods = [found.attractors[int(one)].period for one in ends]
    assert len(set(periods)) > 2  # so that it matters where a start is
    return {period: periods.count(period) for period in set(periods)}


def test_the_same_starts_are_drawn_again_and_lie_in_the_range() -> None:
    drawn = random_starts(STARTS)
    assert drawn == random_starts(STARTS)
    assert len(set(drawn)) == 60
    assert all(-0.05 <= x <= 0.05 and -5.0 <= v <= 5.0 for x, v in drawn)
    assert {(x > 0.0, v > 0.0) for x, v in drawn} == {(a, b) for a in (False, True) for b in (False, True)}


def test_the_general_loop_follows_each_from_its_state_at_a_sample() -> None:
    knob = sample_general(
        SceneSpec.model_validate(SCENE).plain(), sample_rate_hz=CELL[RATE], counts_per_rev=CELL[COUNTS]
    )
    several = [knob.start(*one) for one in random_starts(STARTS)]
    found = GeneralEngine().search(
        knob.body,
        knob.wall,
        [max(map(abs, values)) for values in zip(*several, strict=True)],
        several=several,
        rate=knob.rate,
        phases=len(several),
        delay_line=knob.delay_line,
        max_samples=None,
    )
    assert all(one.certified for one in found.attractors)
    assert {one.period: one.trials for one in found.attractors} == expected()


def test_controllers_follow_each_from_its_state_at_a_sample() -> None:
    """A bounded lag that keeps all of the wall is the wall."""
    wall = Controller(kind="bounded_lag", keep=1.0, time_constant=0.05)
    plan = SceneSpec.model_validate(SCENE).plain()._replace(controller=wall)
    made = make_law(plan, sample_rate_hz=CELL[RATE], counts_per_rev=int(CELL[COUNTS]))
    engine = LawEngine(made.law, compiled("laws"))
    several = [made.knob.start(*one) for one in random_starts(STARTS)]
    found = engine.search(
        made.knob.body,
        made.knob.wall,
        [max(map(abs, values)) for values in zip(*several, strict=True)],
        several=several,
        rate=made.rate,
        phases=len(several),
        delay_line=engine.past_length,
        max_samples=None,
    )
    assert {one.period: one.trials for one in found.attractors} == expected()
