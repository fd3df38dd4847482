"""Every start of a wall with a controller, against trials by a program that shares no code with the package."""

from itertools import islice
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.attractors import Patience, Search
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.sets.law_search import LawSetEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.sets.search import Box
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.laws import EVERY
from tests.controllers.reference import Rig, law_of
from tests.engine.general.law_runs import states_with_law
from tests.engine.general.sets.test_law_search import SCENE

SAME = 1e-6  # counts: of a trial that has settled for so long, and an orbit
ANGLE, VELOCITY = 0.02, -0.3  # of the start whose phases are followed
WIDE, FAST = 0.02, 1.0  # to either side, of the box
# Controller, rate, counts per revolution, samples until a trial has settled.
CELLS = [
    ("first-order hold, corrected", 1000.0, 1024, 400),
    ("bounded lag", 1000.0, 1024, 900),
    ("impulse, timed", 464.2, 360, 500),
    ("first-order hold, fitted", 464.2, 512, 500),
    ("damping, differenced", 1000.0, 360, 600),
    ("phase, both", 464.2, 1024, 2500),
    ("half sample", 215.4, 2048, 250),
    ("speed, timed, filtered", 464.2, 360, 600),
    ("speed, adaptive", 1000.0, 1024, 600),
    ("speed and angle, tracked", 1000.0, 360, 900),
    ("speed, Kalman", 464.2, 1024, 500),
    ("phase, Kalman", 464.2, 1024, 4000),
]
# Controllers whose memory is a function of the counts alone.
COUNTING = [name for name, one in EVERY.items() if one.get("velocity") != "sensor"]
Orbits = list[NDArray[np.float64]]


def followed(name: str, rate: float, counts: int, *, boxed: bool, quick: bool) -> tuple[Search, Orbits, Rig]:
    """What is found of the phases, or of the box; positions of each orbit at its samples, counts; and the reference.

    ``quick``: in the interpreter.
    """
    scene: dict[str, Any] = {**SCENE, "controller": EVERY[name]}
    made = make_law(SceneSpec.model_validate(scene).plain(), sample_rate_hz=rate, counts_per_rev=counts)
    functions = None if quick else compiled("friction sets")
    patience = Patience(samples=10**9, seconds=300.0)
    engine, knob = LawEngine(made.law, functions, patience=patience), made.knob
    sets = LawSetEngine(engine.law, functions, patience=patience)
    given: dict[str, Any] = {"rate": made.rate, "delay_line": engine.past_length, "max_samples": None}
    if boxed:
        box = Box(knob.position(-WIDE), knob.position(WIDE), knob.speed(-FAST), knob.speed(FAST))
        found = sets.search_box(knob.body, knob.wall, box, **given)
    else:
        found = sets.search_phases(knob.body, knob.wall, knob.start(ANGLE, VELOCITY), **given)
    assert found is not None
    law = LawEngine(made.law).law
    orbits = [
        np.sort(states_with_law(made.knob, law, [one.x, one.v], list(one.line), max(one.period, 1))[:-1, 0])
        for one in found.attractors
    ]
    return found, orbits, Rig(scene, rate, counts)


def number_of(orbits: Orbits, rig: Rig, name: str, start: tuple[float, float, float], samples: int) -> int:
    """Which of the orbits a motion is on after so many samples; -1 for none."""
    longest = max(map(len, orbits))
    trial = rig.trial(law_of(rig, EVERY[name]), *start)
    xs = np.array([theta for theta, _, _ in islice(trial, samples, samples + longest)]) / rig.quantum - rig.offset
    for k, orbit in enumerate(orbits):
        if np.abs(np.sort(xs[-len(orbit) :]) - orbit).max() < SAME:
            return k
    return -1


def counted(
    name: str, rate: float, counts: int, samples: int, trials: int, *, boxed: bool, quick: bool = False
) -> None:
    """That trials end in listed orbits alone, and as many in each as its share says, except for the cuts."""
    found, orbits, rig = followed(name, rate, counts, boxed=boxed, quick=quick)
    assert found.complete
    met = np.zeros(len(orbits))
    chance = np.random.default_rng(2)
    for i in range(trials):
        start = ANGLE, VELOCITY, (i + 0.5) / trials
        if boxed:
            start = chance.uniform(-WIDE, WIDE), chance.uniform(-FAST, FAST), 0.0  # at a sample instant
        one = number_of(orbits, rig, name, start, samples)
        assert one >= 0, start
        met[one] += 1.0
    shares = np.array([one.trials for one in found.attractors])
    assert shares.sum() == pytest.approx(1.0, abs=1e-6)
    # Phases evenly spread: one trial a cut may be on the wrong side. Random starts: five standard errors.
    bound = 5.0 * np.sqrt(0.25 / trials) if boxed else found.pieces / trials
    assert np.abs(met / trials - shares).max() <= bound


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("name", "rate", "counts", "samples"), [CELLS[0], CELLS[3], CELLS[4]])
def test_phases_end_as_their_intervals_do(name: str, rate: float, counts: int, samples: int) -> None:
    """150 phases of the start, from a plain loop."""
    counted(name, rate, counts, samples, 150, boxed=False, quick=True)


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize(("name", "rate", "counts", "samples"), CELLS)
def test_two_thousand_phases_end_as_their_intervals_do(name: str, rate: float, counts: int, samples: int) -> None:
    """So many that a length is told to a part in two thousand a cut."""
    counted(name, rate, counts, samples, 2000, boxed=False)


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize(("name", "rate", "counts", "samples"), [one for one in CELLS if one[0] != "impulse, timed"])
def test_many_random_starts_of_a_box_end_in_listed_orbits(name: str, rate: float, counts: int, samples: int) -> None:
    """1000 states of the box: areas are told to some parts in a hundred.

    The timed impulse looks twenty times in an interval, which cuts a box into too many parts: 300 s leave it open.
    """
    counted(name, rate, counts, samples, 1000, boxed=True)


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("name", COUNTING)
def test_all_phases_are_followed_to_an_end(name: str) -> None:
    """Shares add up to all, and each end is proven where the list is complete."""
    found, _, _ = followed(name, 1000.0, 360, boxed=False, quick=False)
    assert sum(one.trials for one in found.attractors) == pytest.approx(1.0, abs=1e-6)
    assert found.complete == all(one.certified for one in found.attractors if one.trials > 0.0)
