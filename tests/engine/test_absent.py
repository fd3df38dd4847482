"""Tests of `hknob_cli.engine.absent`: what a scene lacks is not compiled, and all else is as in Python."""

import importlib
import inspect
import re
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
import pytest

from hknob_cli.engine.absent import HAS
from hknob_cli.engine.jit import FRICTION_SETS, GENERAL, compiled
from hknob_cli.engine.kept_code import load_numba
from hknob_cli.engine.linking import kinds


class Part(NamedTuple):
    """A part of a scene that may lack another."""

    size: float
    inner: Any


class Scene(NamedTuple):
    """With a part."""

    part: Part
    law: Any


def without(x):
    """What is done where something is absent."""
    return x + 1.0


def beside(x):
    """What is done where it is there."""
    return x - 1.0


def by_argument(law, x):
    if law is None:
        return without(x)
    return beside(x)


def by_field(scene, x):
    if scene.law is None:
        return without(x)
    return beside(x)


def by_field_of_a_field(scene, x):
    if scene.part.inner is not None:
        return beside(x)
    return without(x)


def by_a_name_for_it(scene, x):
    part = scene.part
    law = part.inner
    found = without(x) if law is None else beside(x)
    return 2.0 * found


def by_one_of_several_names(scene, x):
    size, other, law, again = scene.part.size, scene.part.size, scene.law, x
    found = without(x) if law is None else beside(again)
    return size * found + other


def compiled_with_its_parts(function: Any) -> tuple[Any, dict[str, Any]]:
    """A function as an entry, and the parts that it calls."""
    load_numba()
    parts = {one.__name__: kinds().part(one) for one in (without, beside)}
    entry = kinds().entry(type(function)(function.__code__, {**function.__globals__, **parts}, function.__name__))
    return entry, parts


@pytest.mark.parametrize("there", [None, 0.0, np.zeros(0), np.ones(3)])
@pytest.mark.parametrize(
    "function", [by_argument, by_field, by_field_of_a_field, by_a_name_for_it, by_one_of_several_names]
)
def test_only_one_side_is_compiled(function: Any, there: Any) -> None:
    """And its answer is Python's; 0 and an empty array are there, as `is None` has it."""
    entry, parts = compiled_with_its_parts(function)
    first = there if function is by_argument else Scene(Part(0.5, there), there)
    assert entry(first, 0.25) == function(first, 0.25)
    sides = {name: len(part.signatures) for name, part in parts.items()}
    assert sides == {"without": int(there is None), "beside": int(there is not None)}


def test_each_type_of_an_argument_decides_for_itself() -> None:
    entry, parts = compiled_with_its_parts(by_argument)
    assert [entry(law, 0.25) for law in (None, 0.5, None, (1.0, 2.0))] == [1.25, -0.75, 1.25, -0.75]
    assert [len(part.signatures) for part in parts.values()] == [1, 1]


def changed(law, x):
    scale = law
    if x > 0.5:
        scale = None
    if scale is None:
        return without(x)
    return beside(x)


@pytest.mark.parametrize("x", [0.25, 0.75])
def test_a_name_that_stands_for_two_things_is_not_decided(x: float) -> None:
    entry, _ = compiled_with_its_parts(changed)
    assert entry(1.5, x) == changed(1.5, x)


def kept(law, x):
    absent = law is None
    if x > 0.5:
        absent = x > 0.7
    if absent:
        return without(x)
    return beside(x)


@pytest.mark.parametrize("law", [None, 1.5])
@pytest.mark.parametrize("x", [0.25, 0.6, 0.75])
def test_an_answer_that_is_given_a_second_time_is_not_decided_by_the_first(law: float | None, x: float) -> None:
    entry, _ = compiled_with_its_parts(kept)
    assert entry(law, x) == kept(law, x)


def either(law, x):
    both = x > 0.5 or law is not None
    if both:
        return beside(x)
    return without(x)


@pytest.mark.parametrize("law", [None, 1.5])
@pytest.mark.parametrize("x", [0.25, 0.75])
def test_half_of_an_answer_is_not_decided_by_the_other(law: float | None, x: float) -> None:
    entry, _ = compiled_with_its_parts(either)
    assert entry(law, x) == either(law, x)


def compared(law, x):
    found = 0.0
    if law is law:
        found += x
    if x is not None:
        found += 2.0 * x
    return found


def test_other_questions_are_left_as_they_are() -> None:
    entry, _ = compiled_with_its_parts(compared)
    assert entry(1.5, 0.25) == compared(1.5, 0.25)


def test_all_that_is_asked_for_a_part_is_known() -> None:
    """Functions of the engine that take one argument, and say of None that there is nothing."""
    modules = [importlib.import_module(f"hknob_cli.engine.{one}") for one in FRICTION_SETS]
    functions = [one for module in modules for one in vars(module).values() if isinstance(one, FunctionType)]
    asks = re.compile(r"if (\w+) is None:\s+return False\s+return")
    alone = {one.__name__ for one in functions if one.__code__.co_argcount == 1 and asks.search(inspect.getsource(one))}
    assert alone == set(HAS)


@pytest.mark.parametrize("name", HAS)
def test_what_is_asked_for_a_part_is_false_of_none(name: str) -> None:
    """In the engine itself, interpreted and compiled; of an empty array, too, and true of another one."""
    modules = [importlib.import_module(f"hknob_cli.engine.{one}") for one in GENERAL]
    (plain,) = {vars(one)[name] for one in modules if name in vars(one)}
    entry = compiled("general")[f"general.{name}"]
    for has in (plain, entry):
        assert [has(None), has(np.zeros(0)), has(np.ones(3))] == [False, False, True]


@pytest.mark.parametrize("name", HAS)
def test_what_follows_such_a_question_is_not_compiled_without_the_part(name: str) -> None:
    def has(cogs):
        return cogs is not None and len(cogs) > 0

    has.__name__ = name
    load_numba()
    asked, left, right = (kinds().part(one) for one in (has, without, beside))

    def choose(scene, x):
        if x > 0.0 and asked(scene.part.inner):
            return left(x)
        return right(x)

    entry = kinds().entry(choose)
    assert entry(Scene(Part(0.5, None), None), 0.25) == beside(0.25)
    assert [len(part.signatures) for part in (asked, left, right)] == [0, 0, 1]
    for there in (np.zeros(0), np.ones(3)):
        assert entry(Scene(Part(0.5, there), None), 0.25) == (without(0.25) if len(there) else beside(0.25))
    assert [len(part.signatures) for part in (asked, left, right)] == [1, 1, 1]
