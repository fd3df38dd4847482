"""Tests of `spread.forks`."""

import os
import time
from multiprocessing import active_children

import pytest

from hknob_cli.spread.forks import Forks


def half(number: int) -> tuple[float, int]:
    return number / 2, os.getpid()


def fails(number: int) -> int:
    if number == 3:
        raise ValueError("not three")
    return number


def is_soon(number: int) -> int:
    time.sleep(0.0 if number else 60.0)
    return number


@pytest.mark.parametrize("jobs", [1, 2])
def test_each_item_is_done_once_and_known_by_its_number(jobs: int) -> None:
    with Forks(jobs) as forks:
        assert forks.begun == (jobs > 1)
        found = dict(forks.each(half, range(20)))
    assert {number: one for number, (one, _) in found.items()} == {number: number / 2 for number in range(20)}
    assert all((process == os.getpid()) == (jobs == 1) for _, process in found.values())


def test_without_entering_tasks_are_done_here() -> None:
    forks = Forks(2)
    assert not forks.begun
    assert dict(forks.each(half, [4])) == {0: (2.0, os.getpid())}


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_failure_of_a_task_is_raised(jobs: int) -> None:
    with pytest.raises(ValueError, match="not three"), Forks(jobs) as forks:
        list(forks.each(fails, range(5)))
    assert not active_children()


def interrupted_after_the_first() -> None:
    with Forks(2) as forks:
        number, _ = next(forks.each(is_soon, [0, 1]))
        assert number == 1
        raise KeyboardInterrupt


def test_an_interruption_does_not_wait_for_what_is_being_done() -> None:
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        interrupted_after_the_first()
    assert time.monotonic() - begin < 30.0
    assert not active_children()
