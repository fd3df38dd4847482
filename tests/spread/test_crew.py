"""Gathering from workers of a seed: each item once, right, in its place, whatever they do; or a word why not."""

import hashlib
from collections import Counter
from itertools import pairwise
from random import Random

import pytest

from hknob_cli.errors import ComputationError
from hknob_cli.spread.gather import DEATHS, SAMPLED, Pace, Range, Ranges, Sample, gather
from tests.spread.crew import WEIGHTS, Crew, at_work

SEEDS = range(400)
MANY = range(1000, 20_000)


def work(start: int, stop: int) -> bytes:
    """Three bytes of each item, which tell it from the others."""
    return b"".join(hashlib.sha256(str(item).encode()).digest()[:3] for item in range(start, stop))


def part_of(one: Range, results: bytes, some: Range) -> str:
    """What results say of some of their items."""
    return results[3 * (some.start - one.start) : 3 * (some.stop - one.start)].hex()


SAMPLE = Sample(part_of, str.__eq__)


def play(seed: int) -> Crew:
    """A gathering of this seed, interrupted now and then and gone on with. Raises `AssertionError`."""
    dice = Random(f"gathering {seed}")
    part = dice.randint(1, 12)
    total = dice.randint(0, 70)
    cuts = sorted(dice.sample(range(total + 1), min(4, total)))
    done = [(a, b) for a, b in list(pairwise(cuts))[::2] if a // part == (b - 1) // part]
    at_first = list(done)
    while True:
        crew = Crew(work, f"{seed} {len(done)}")
        stop_after = dice.randint(1, 60)

        def tick() -> None:
            nonlocal stop_after
            stop_after -= 1
            if not stop_after:
                raise KeyboardInterrupt

        def take(start: int, stop: int, data: bytes) -> None:
            assert data == work(start, stop), "wrong results are taken"
            assert start // part == (stop - 1) // part, "a piece crosses the end of a part"
            done.append((start, stop))

        left = Ranges(total, done=done, part=part)
        try:
            with at_work(crew):
                gather(crew, left, take, tick=tick, pace=Pace(first=dice.randint(1, 9), most=20), sample=SAMPLE)
        except KeyboardInterrupt:
            assert crew.closed
            continue
        except ComputationError:  # which items are given up is said only of those that failed over and over
            assert max(crew.faults.values()) >= DEATHS
            continue
        break
    assert crew.closed
    assert done[: len(at_first)] == at_first
    items = [item for start, stop in sorted(done) for item in range(start, stop)]
    assert items == list(range(total)), "an item is missing, or there twice"
    return crew


@pytest.fixture
def many_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of nearly every piece, some is computed again."""
    monkeypatch.setattr("hknob_cli.spread.gather.SAMPLED", 2)


@pytest.mark.usefixtures("many_samples")
def test_each_item_once_where_much_is_computed_twice() -> None:
    for seed in SEEDS:
        play(seed)


def test_a_worker_that_computes_wrongly_is_found() -> None:
    """Whoever computes it, a quarter of the answers is wrong."""
    for seed in range(30):
        crew = Crew(work, seed, most_faults=20, lies=0.25)
        said = "was computed twice, and the results differ"
        with at_work(crew), pytest.raises(ComputationError, match=said):
            gather(crew, Ranges(8000), lambda *_: None, tick=lambda: None, sample=SAMPLE)
        assert crew.closed


def test_what_the_sample_costs() -> None:
    """No more than its share of the items, to within four deviations; without it nothing."""
    total, done = 20_000, [0, 0]
    for k, asked in enumerate((SAMPLE, None)):
        crew = Crew(work, 1, most_faults=0)
        with at_work(crew):
            gather(crew, Ranges(total), lambda *_: None, tick=lambda: None, sample=asked)
        done[k] = crew.done
    most = total / SAMPLED
    assert 0 < done[0] - done[1] <= most + 4 * most**0.5
    assert done[1] == total


def test_each_item_once_right_and_in_its_place() -> None:
    happened = sum((play(seed).happened for seed in SEEDS), start=Counter())
    assert {*WEIGHTS, "late"} <= set(happened)


@pytest.mark.long
def test_each_item_once_over_many_seeds() -> None:
    for seed in MANY:
        play(seed)


def test_the_same_seed_does_the_same_again() -> None:
    assert [play(seed).happened for seed in range(20)] == [play(seed).happened for seed in range(20)]
