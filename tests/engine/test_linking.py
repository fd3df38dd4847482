"""Functions linked into the one that Python calls: each once, in any order of calls, and nothing is left behind."""

import gc
import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from hknob_cli.engine import linking
from hknob_cli.engine.jit import GROUPS, compiled
from hknob_cli.engine.kept_code import load_numba
from hknob_cli.engine.linking import ALONE, INLINED, kinds, likeness
from tests.conftest import ROOT


def test_functions_that_share_one_are_linked_with_it() -> None:
    load_numba()

    def lowest(x, n):
        return x * n

    def left(x):
        return lowest(x, 2) + 1.0

    def right(x):
        return left(x) - lowest(x, 3)

    def top(x):
        return 2.0 * right(x)  # calls neither of the others

    expected = top(0.7)
    lowest = kinds().part(lowest)
    left = kinds().part(left)
    right = kinds().part(right)
    entry = kinds().entry(top)
    assert entry(0.7) == expected
    assert [len(one.signatures) for one in (lowest, left, right, entry)] == [1, 1, 1, 1]  # whatever numbers are written


def test_a_part_is_no_code_of_its_own() -> None:
    load_numba()

    def half(x):
        return 0.5 * x

    part = kinds().part(half)
    part.compile((load_numba().float64,))
    (made,) = part.overloads.values()
    assert made.library.get_pointer_to_function(made.fndesc.llvm_func_name) == 0


def test_a_part_is_handed_only_what_it_uses() -> None:
    load_numba()
    step = "    x = 0.5 * x + 1.5 if x < {k}.0 + many[7] else x - many[11] / (1.0 + x * x)"
    steps = [step.format(k=k) for k in range(40)]  # too many to be written out at both calls
    made: dict[str, Any] = {}
    exec("\n".join(["def climb(x, many):", *steps, "    return x"]), made)
    climb = made["climb"]

    def top(x, many):
        return climb(x, many) + climb(x + 1.0, many)

    many = tuple(0.5 * k for k in range(60))
    expected = top(0.3, many)
    climb = kinds().part(climb)
    entry = kinds().entry(top)
    assert entry(0.3, many) == expected
    code = entry.inspect_llvm(entry.signatures[0])
    (taken,) = [line.count(" double ") for line in code.splitlines() if line.startswith("define") and "climb" in line]
    assert taken == 3  # x, and two of the sixty


def test_what_every_sample_goes_through_becomes_a_part_of_its_callers() -> None:
    """By its name, however long it is; a branch that is rarely taken is left alone, however short."""
    load_numba()
    steps = [f"    x = 0.5 * x + 1.5 if x < {k}.0 else x - 3.0 / (1.0 + x * x)" for k in range(40)]
    made: dict[str, Any] = {}
    for name in ("climb", INLINED[0]):
        exec("\n".join([f"def {name}(x):", *steps, "    return x"]), made)
    exec(f"def {ALONE[0]}(x):\n    return 1.0 / x", made)
    climb, inlined, alone = (kinds().part(made[name]) for name in ("climb", INLINED[0], ALONE[0]))

    def top(x):
        rare = alone(x) if x > 0.0 else x
        return climb(x) + climb(x + 1.0) + inlined(x + 2.0) + inlined(x + 3.0) + rare

    entry = kinds().entry(top)
    assert entry(0.3) == sum(made["climb"](0.3 + k) for k in range(4)) + 1.0 / 0.3
    code = entry.inspect_llvm(entry.signatures[0])
    defined = [line for line in code.splitlines() if line.startswith("define")]
    assert [sum(name in line for line in defined) for name in ("climb", INLINED[0], ALONE[0])] == [1, 0, 1]


@pytest.mark.parametrize("name", [*INLINED, *ALONE])
def test_what_is_inlined_or_not_is_a_function_of_the_engine(name: str) -> None:
    modules, _ = GROUPS["laws"]
    paths = [ROOT / f"hknob_cli/engine/{one.replace('.', '/')}.py" for one in modules]
    assert sum(f"\ndef {name}(" in path.read_text() for path in paths) == 1


class Pair(NamedTuple):
    one: Any
    other: Any


class Couple(NamedTuple):
    one: Any
    other: Any


ARGUMENTS: list[Any] = [
    *(0.5, 1, 2**62, True, None, np.float64(0.5), np.int32(7)),
    *(np.zeros(3), np.zeros(0), np.zeros(3, dtype=np.int64), np.zeros(3, dtype=bool)),
    *(np.zeros((2, 3)), np.zeros((2, 3)).T, np.zeros((4, 6))[::2, ::2], np.broadcast_to(0.0, (3,))),
    *((), (0.5,), (0.5, 1), (0.5, (1, 0.5)), ((0.5, 1), 0.5)),
]


def test_arguments_that_are_alike_have_one_type_and_only_those() -> None:
    """Numba's own `typeof` says which type a value has."""
    values = [*ARGUMENTS, *(kind(value, 0.5) for kind in (Pair, Couple) for value in ARGUMENTS), Pair(0.5, Pair(1, 2))]
    typeof = load_numba().typeof
    for one in values:
        for other in values:
            assert (likeness(one) != likeness(other)) or typeof(one) == typeof(other), (one, other)
    assert likeness(Pair(0.5, np.zeros(3))) == likeness(Pair(7.25, np.ones(8)))


def test_a_tuple_of_other_types_is_taken_as_what_it_is() -> None:
    load_numba()
    entry = kinds().entry(lambda pair: pair.one / 2 + pair.other)
    for _ in range(2):
        assert [entry(Pair(1, 0.5)), entry(Pair(1, 2)), entry(Couple(3.0, 1.0))] == [1.0, 2.5, 2.5]
    assert len(entry.signatures) == 3


def test_references_are_counted_only_where_arrays_are_made() -> None:
    functions: dict[str, Any] = compiled("general")
    counts = {name: function.targetoptions["_nrt"] for name, function in functions.items()}
    assert counts["copy_line"]
    assert counts["forced_response"]  # calls it
    assert counts["follow"]  # calls what calls it
    assert not counts["level_of"]
    assert not any(count for name, count in counts.items() if name.startswith("general."))


def test_what_cannot_be_compiled_leaves_the_collector_on_and_numba_as_it_was() -> None:
    load_numba()
    from numba.core.types.functions import BaseFunction

    entry, finds = kinds().entry(lambda x: x.nothing_like_it), BaseFunction.get_call_type
    assert gc.isenabled()
    with pytest.raises(Exception, match="nothing_like_it"):
        entry(1.0)
    assert gc.isenabled()
    assert BaseFunction.get_call_type is finds


def test_what_an_operator_returns_is_found_out_once_and_is_numbas_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of numbers that the engine does not have, some sums twice; the results are those of Python and of plain numba."""
    numba = load_numba()
    from numba.core.types.functions import BaseFunction

    find, asked = BaseFunction.get_call_type, []

    def told(self: Any, context: Any, args: Any, kws: Any) -> Any:
        asked.append((self, args))
        return find(self, context, args, kws)

    def sums(x: Any, n: Any) -> tuple[Any, ...]:
        return x + x, n + n, x + n, x * 2 + (x + x), n // 2 + (n + n), min(x, n) + abs(-x)

    plain = numba.njit(sums)
    monkeypatch.setattr(BaseFunction, "get_call_type", told)
    entry = kinds().entry(sums)
    numbers = [(np.float32(0.25), np.int16(3)), (np.float32(7.0), np.int16(-2))]
    assert [entry(*pair) for pair in numbers] == [sums(*pair) for pair in numbers]
    here = [one for one in asked if len(one[1]) == 2]
    assert len(here) >= 5
    assert len(here) == len(set(here))
    monkeypatch.setattr(BaseFunction, "get_call_type", find)
    assert [plain(*pair) for pair in numbers] == [entry(*pair) for pair in numbers]


@pytest.mark.parametrize("many", [None, np.linspace(-1.0, 1.0, 12)])
def test_steps_that_are_left_out_change_no_instruction(many: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of loops, tuples, and a branch that is there for one type of argument."""
    load_numba()
    from numba.core import typed_passes, untyped_passes

    def first(many, x):
        if many is None or not len(many):
            return x
        return many[0] * x

    def walk(many, pair):
        total = first(many, pair.one)
        for k in range(len(pair.other)):
            low, high = pair.other[k], abs(pair.other[k])
            total += max(low, -high) * total if k % 2 else min(low, 3.0)
        return total

    pair, makers = Pair(0.3, np.linspace(-2.0, 5.0, 9)), kinds()
    expected = walk(many, pair)
    first = makers.part(first)

    def instructions() -> list[str]:
        entry = makers.entry(walk)
        assert entry(many, pair) == expected
        lines = entry.inspect_llvm(entry.signatures[0]).splitlines()
        return [re.sub(r"^%\S+ = ", "", line.strip()).partition(" ")[0] for line in lines if line.startswith("  ")]

    less = instructions()
    assert len(less) > 50
    assert all(hasattr(typed_passes, step) or hasattr(untyped_passes, step) for step in linking.NEEDLESS)
    monkeypatch.setattr(linking, "NEEDLESS", ())
    assert instructions() == less


@pytest.mark.parametrize("module", ["hknob_cli.engine.ensemble", "hknob_cli.engine.sets.box", linking.SCALAR])
def test_loops_are_vectorised_where_they_gain_by_it(module: str) -> None:
    """In the plain loop and its sets, not in the general one; the numbers are the same."""
    load_numba()

    def scale(x, k):
        for j in range(len(x)):
            x[j] = k * x[j] + 0.5
        return len(x)

    scale.__module__ = module
    ones = [np.linspace(-1.0, 1.0, 37) for _ in range(2)]
    entry = kinds().entry(scale)
    assert entry(ones[0], 0.3) == scale(ones[1], 0.3)
    assert np.array_equal(*ones)
    wide = re.search(r"<\d+ x double>", entry.inspect_llvm(entry.signatures[0]))
    assert (wide is None) == (module == linking.SCALAR)


@pytest.mark.parametrize("group", GROUPS)
def test_a_group_is_known_on_the_disk_by_functions_that_it_has(group: str) -> None:
    modules, entries = GROUPS[group]
    for entry in entries:
        module, _, function = entry.partition(".")
        paths = [Path(f"hknob_cli/engine/{one.replace('.', '/')}.py") for one in modules if one.endswith(module)]
        assert any(f"\ndef {function}(" in (ROOT / path).read_text() for path in paths), entry
