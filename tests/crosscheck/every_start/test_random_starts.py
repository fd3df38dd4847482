"""Random starts, simulated and named apart from the engine, end in orbits that the sweep lists; a small campaign."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.crosscheck.every_start.campaign import check_cell
from tests.crosscheck.every_start.listed import READINGS, Listed, sweep
from tests.crosscheck.every_start.plain_knob import PlainKnob
from tests.crosscheck.every_start.random_starts import Found, cycle_of, turned

FEW = ("grid.sample_rate_hz=[100, 1000]", "grid.counts_per_rev=[512, 2048]")


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Listed:
    """Four cells at half a count's bias, where orbits are many."""
    return Listed.read(sweep(tmp_path_factory.mktemp("few") / "out", *READINGS["0.04-half"], *FEW))


@pytest.mark.long
def test_every_end_is_listed(few: Listed) -> None:
    """Of 10,000 random starts of each of four cells; shares are as likely as chance has it."""
    for number in range(len(few.cells)):
        verdict = check_cell(few, number, 10_000, seed=1)
        assert not verdict.unlisted
        assert sum(verdict.hits) == 10_000
        assert few.complete[number]
        assert verdict.least_chance > 1e-6


@pytest.mark.long
def test_a_list_that_lacks_an_orbit_is_told(few: Listed) -> None:
    """The check can fail: an orbit is missing, or has another size, or another period."""
    rows = few.orbits[1]
    most = max(rows, key=lambda row: row["basin_fraction"])
    for spoilt in (
        [row for row in rows if row is not most],
        [{**row, "max_rad": row["max_rad"] * (1.0 + 1e-6)} if row is most else row for row in rows],
        [{**row, "period_samples": row["period_samples"] + 1} if row is most else row for row in rows],
    ):
        lists = list(few.orbits)
        lists[1] = spoilt
        verdict = check_cell(replace(few, orbits=lists), 1, 1000, seed=1)
        assert len(verdict.unlisted) == 1
        assert sum(verdict.hits) + verdict.unlisted[0][1] == 1000


def test_a_trial_that_is_captured_comes_to_the_cycle() -> None:
    """Followed on to the end, not only until it is near, a hundred starts come to the cycle that was said."""
    scene = {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3e-7, "damping": 3.45e-4, "stiffness": 0.08},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
    }
    knob = PlainKnob.of(scene, 464.2, 2048)  # some starts come to rest
    chance = np.random.default_rng(2)
    theta, omega = chance.uniform(-0.05, 0.05, 100), chance.uniform(-5.0, 5.0, 100)
    found = Found(knob)
    found.follow(theta, omega)
    expected = {turned(one.levels): ends for one, ends in zip(found.cycles, found.ends, strict=True)}
    assert len(expected) == len(found.cycles) > 1
    counted = dict.fromkeys(expected, 0)
    for a, w in zip(theta, omega, strict=True):
        levels = []
        for _ in range(3000):
            levels.append(min(int(np.floor(a / knob.quantum)), 0))
            a, w = knob.hold[:2] @ np.array([a, w, knob.torque(levels[-1])])
        end = levels[-500:]
        period = next(n for n in range(1, 250) if end[n:] == end[:-n])
        counted[turned(cycle_of(knob, end[:period]).levels)] += 1
    assert counted == expected


@pytest.mark.long
@pytest.mark.parametrize("reading", READINGS)
def test_whole_grid(reading: str, tmp_path: Path) -> None:
    """20,000 starts of each of 49 cells; a million by `campaign.py`."""
    listed = Listed.read(sweep(tmp_path / "out", *READINGS[reading]))
    assert len(listed.cells) == 49
    assert all(listed.complete)
    for number in range(49):
        assert not check_cell(listed, number, 20_000, seed=2).unlisted
