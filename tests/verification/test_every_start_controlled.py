"""Every start of a wall with a controller, against trials by a program that shares no code with the package."""

from itertools import islice

import numpy as np
import pytest

from hknob_cli.controllers.search import Settled
from hknob_cli.controllers.sets.follow import Ends
from hknob_cli.controllers.sets.starts import follow_starts
from hknob_cli.engine.outcome import Outcome
from hknob_cli.specs.plan import Starts
from tests.controllers.laws import CONTROLLERS
from tests.controllers.reference import Rig, law_of
from tests.controllers.sets.cells import BOX, COUNTING, PHASES, make_cell

SAME = 1e-6  # counts: of a trial that has settled for so long, and an orbit
# Controller, rate, counts per revolution, samples until a trial has settled.
CELLS = [
    ("first-order hold, corrected", 1000.0, 1024, 400),
    ("bounded lag", 1000.0, 1024, 900),
    ("impulse, timed", 464.2, 360, 500),
    ("damping, differenced", 1000.0, 360, 600),
    ("phase, both", 464.2, 1024, 2500),
    ("half sample", 215.4, 2048, 250),
]


def ends_of(name: str, starts: Starts, rate: float, counts: int) -> tuple[Ends, Rig]:
    remedy, batch, scene = make_cell(name, starts, rate=rate, counts=counts)
    ends = follow_starts(remedy, batch.lanes, batch.knobs, starts)[0]
    return ends, Rig(scene, rate, counts)


def number_of(ends: list[Settled], xs: np.ndarray, parts: int) -> int:
    """Which of the orbits a motion's last samples are on; -1 for none."""
    for k, one in enumerate(ends):
        if one.outcome is not Outcome.CYCLE and one.outcome is not Outcome.REST:
            continue
        orbit = np.sort(one.x[:-1:parts])
        if len(orbit) <= len(xs) and np.abs(np.sort(xs[-len(orbit) :]) - orbit).max() < SAME:
            return k
    return -1


def tail(rig: Rig, name: str, angle: float, speed: float, phase: float, samples: int, period: int) -> np.ndarray:
    """Positions at the last samples of a trial, counts."""
    trial = rig.trial(law_of(rig, CONTROLLERS[name]), angle, speed, phase)
    return np.array([theta for theta, _, _ in islice(trial, samples, samples + period)]) / rig.quantum - rig.offset


def counted(name: str, starts: Starts, rate: float, counts: int, samples: int, trials: int) -> None:
    """That trials end in listed orbits alone, and as many in each as its share says, except for the cuts."""
    ends, rig = ends_of(name, starts, rate, counts)
    assert ends.undecided == 0.0
    parts = 2 if name.startswith("impulse") else 1
    period = max(one.period for one in ends.ends)
    found = np.zeros(len(ends.ends))
    chance = np.random.default_rng(2)
    for i in range(trials):
        angle, speed, phase = starts.angle, starts.velocity, (i + 0.5) / trials
        if starts.span:
            low, high, slowest, fastest = starts.span
            # At a sample instant: a phase of 0.
            angle, speed, phase = chance.uniform(low, high), chance.uniform(slowest, fastest), 0.0
        one = number_of(ends.ends, tail(rig, name, angle, speed, phase, samples, period), parts)
        assert one >= 0, (angle, speed, phase)
        found[one] += 1.0
    shares = np.array([one.trials for one in ends.ends])
    # Phases evenly spread: one trial a cut may be on the wrong side. Random starts: five standard errors.
    bound = ends.pieces / trials if starts.span is None else 5.0 * np.sqrt(0.25 / trials)
    assert np.abs(found / trials - shares).max() <= bound


@pytest.mark.parametrize(("name", "rate", "counts", "samples"), CELLS[:3])
def test_phases_end_as_their_arcs_do(name: str, rate: float, counts: int, samples: int) -> None:
    """150 phases of the start, from a plain loop."""
    counted(name, PHASES, rate, counts, samples, 150)


@pytest.mark.parametrize(("name", "rate", "counts", "samples"), CELLS[:2])
def test_random_starts_of_a_box_end_in_listed_orbits(name: str, rate: float, counts: int, samples: int) -> None:
    """100 states of the box, from a plain loop."""
    counted(name, BOX, rate, counts, samples, 100)


@pytest.mark.long
@pytest.mark.parametrize(("name", "rate", "counts", "samples"), CELLS)
def test_ten_thousand_phases_end_as_their_arcs_do(name: str, rate: float, counts: int, samples: int) -> None:
    """So many that a length is told to a part in ten thousand a cut."""
    counted(name, PHASES, rate, counts, samples, 10_000)


@pytest.mark.long
@pytest.mark.parametrize(("name", "rate", "counts", "samples"), CELLS)
def test_many_random_starts_of_a_box_end_in_listed_orbits(name: str, rate: float, counts: int, samples: int) -> None:
    """3000 states of the box."""
    counted(name, BOX, rate, counts, samples, 3000)


@pytest.mark.parametrize("name", COUNTING)
def test_all_phases_are_followed_to_an_end(name: str) -> None:
    """Shares add up to all, and what is called undecided is what has no proof."""
    ends, _ = ends_of(name, PHASES, 1000.0, 360)
    assert sum(one.trials for one in ends.ends) == pytest.approx(1.0, abs=1e-12)
    unproven = sum(one.trials for one in ends.ends if one.reason)
    assert unproven == pytest.approx(ends.undecided, abs=1e-9)
