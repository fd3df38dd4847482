"""Changes of a spec's values that know its structure: each takes the tree, changes it in place or gives another."""

from collections.abc import Callable
from copy import deepcopy
from random import Random
from typing import Any, NamedTuple

from tests.fuzz import nasty
from tests.fuzz.seeds import seeds
from tests.fuzz.shape import Schema, arms, at, example, keys
from tests.fuzz.yaml_text import Anchored, Raw, Twice

Steps = tuple[str | int, ...]


class Spot(NamedTuple):
    """A value in a tree: the mapping or list it is in, its key or number there, and the path to it."""

    inside: Any
    step: Any
    path: Steps

    @property
    def value(self) -> Any:
        return self.inside[self.step]

    def put(self, value: Any) -> None:
        self.inside[self.step] = value


def spots(tree: Any, path: Steps = ()) -> list[Spot]:
    """Every value of a tree below its root."""
    found: list[Spot] = []
    inner = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for step, value in list(inner):
        found.append(Spot(tree, step, (*path, step)))
        found += spots(value, (*path, step))
    return found


def mutate(tree: dict[str, Any], shape: Schema, dice: Random, *, gently: bool = False) -> dict[str, Any]:
    """The tree with one change; ``gently``: one that is as likely good as not."""
    found = spots(tree)
    if not found:
        return {"kind": tree}
    dice.choice(GENTLE if gently else CHANGES)(tree, dice.choice(found), shape, dice)
    return tree


def _leaf(tree: Any, spot: Spot, shape: Schema, dice: Random) -> None:
    """Another scalar in the place of a scalar."""
    leaves = [one for one in spots(tree) if not isinstance(one.value, dict | list)]
    if leaves:
        spot = dice.choice(leaves)
    kind = dice.random()
    if kind < 0.4:
        spot.put(Raw(nasty.scalar(dice)))
    elif kind < 0.6:
        spot.put(Raw(nasty.quantity(dice)))
    elif kind < 0.8:
        spot.put(nasty.text(dice))
    else:
        spot.put(example(shape, at(shape, spot.path), dice))


def _gentle(tree: Any, spot: Spot, shape: Schema, dice: Random) -> None:
    """A value that is as likely good as not: a number nearby, another of the values that are allowed."""
    leaves = [one for one in spots(tree) if isinstance(one.value, str | int | float | None)]
    if not leaves:
        return
    spot = dice.choice(leaves)
    if isinstance(spot.value, bool):
        spot.put(not spot.value)
    elif isinstance(spot.value, int):
        spot.put(spot.value + dice.choice((-1, 1, 1, spot.value, 7)))
    elif isinstance(spot.value, float):
        spot.put(spot.value * dice.choice((0.5, 0.9, 1.0, 1.1, 2.0, 10.0)))
    elif allowed := [arm["enum"] for arm in arms(shape, at(shape, spot.path)) if "enum" in arm]:
        spot.put(dice.choice(dice.choice(allowed)))


def _scaled(tree: Any, spot: Spot, _shape: Schema, dice: Random) -> None:
    """A number of another size or sign."""
    numbers = [one for one in spots(tree) if isinstance(one.value, int | float) and not isinstance(one.value, bool)]
    if numbers:
        spot = dice.choice(numbers)
        factor = dice.choice((-1.0, 0.0, 0.5, 2.0, 10.0, 1e-3, 1e3, 1e-6, 1e6, 1e-12, 1e12, 1e-300, 1e300))
        value = spot.value * factor
        whole = isinstance(spot.value, int) and abs(value) < 1e18 and value == int(value)
        spot.put(int(value) if whole else value)


def _as_the_schema_says(_tree: Any, spot: Spot, shape: Schema, dice: Random) -> None:
    spot.put(example(shape, at(shape, spot.path), dice))


def _more(tree: Any, spot: Spot, shape: Schema, dice: Random) -> None:
    """A key that may stand there, beside what it may contradict."""
    places = [(tree, ()), *((one.value, one.path) for one in spots(tree) if isinstance(one.value, dict))]
    inside, path = dice.choice(places)
    known = [name for name in keys(shape, at(shape, path)) if name not in inside]
    if known:
        name = dice.choice(known)
        inside[name] = example(shape, at(shape, (*path, name)), dice)


def _less(_tree: Any, spot: Spot, _shape: Schema, _dice: Random) -> None:
    del spot.inside[spot.step]


def _renamed(_tree: Any, spot: Spot, _shape: Schema, dice: Random) -> None:
    """A key one letter off, or another altogether."""
    if isinstance(spot.inside, dict):
        name = nasty.misspelt(str(spot.step), dice) if dice.random() < 0.7 else nasty.text(dice)
        entries = [(name if key == spot.step else key, value) for key, value in spot.inside.items()]
        spot.inside.clear()
        spot.inside.update(entries)


def _repeated(_tree: Any, spot: Spot, shape: Schema, dice: Random) -> None:
    """A key, or an item, that is there twice, or very often."""
    if isinstance(spot.inside, list):
        spot.inside.extend([deepcopy(spot.value)] * dice.choice((1, 1, 2, 20, 2000)))
    else:
        spot.put(Twice(spot.value, example(shape, at(shape, spot.path), dice)))


def _wrapped(_tree: Any, spot: Spot, _shape: Schema, dice: Random) -> None:
    """A value one level deeper or many, or one level less deep."""
    value = spot.value
    if isinstance(value, dict | list) and value and dice.random() < 0.5:
        spot.put(next(iter(value.values() if isinstance(value, dict) else value)))
        return
    levels = dice.choice((1, 1, 1, 2, 45, 60))
    for _ in range(levels):
        value = [value] if dice.random() < 0.5 else {nasty.misspelt("a", dice) or "a": value}
    spot.put(value)


def _swapped(tree: Any, spot: Spot, _shape: Schema, dice: Random) -> None:
    """Two values in each other's place."""
    other = dice.choice(spots(tree))
    one, two = deepcopy(spot.value), deepcopy(other.value)
    other.put(one)
    if spot.path != other.path[: len(spot.path)]:
        spot.put(two)


def _transplanted(_tree: Any, spot: Spot, _shape: Schema, dice: Random) -> None:
    """A part of another spec, where possible from under the same key."""
    other = dice.choice(seeds()[dice.choice(sorted(seeds()))])
    donors = [one for one in spots(other) if one.step == spot.step] or spots(other)
    spot.put(deepcopy(dice.choice(donors).value))


def _emptied(_tree: Any, spot: Spot, _shape: Schema, dice: Random) -> None:
    spot.put(dice.choice(({}, [], None, "", Raw(""))))


def _anchored(tree: Any, spot: Spot, _shape: Schema, dice: Random) -> None:
    """A value said once and meant again, by an alias or a merge key; or an alias of nothing, or of itself."""
    others = [one for one in spots(tree) if one.path[: len(spot.path)] != spot.path]
    inner = [one for one in spots(tree) if one.path[: len(spot.path)] == spot.path and one.path != spot.path]
    again = dice.choice(inner if inner and dice.random() < 0.2 else others or [spot])
    again.put(Anchored("a", merged=dice.random() < 0.5))
    if again.path != spot.path and dice.random() < 0.9:
        spot.put(Anchored("a", spot.value))


def _of_another_kind(tree: Any, _spot: Spot, _shape: Schema, dice: Random) -> None:
    if isinstance(tree, dict):
        tree["kind"] = dice.choice((*sorted(seeds()), nasty.text(dice)))


Change = Callable[[Any, Spot, Schema, Random], None]
GENTLE: tuple[Change, ...] = (*(_gentle,) * 6, *(_scaled,) * 2, _as_the_schema_says, _more, _less)
CHANGES: tuple[Change, ...] = (
    *(_gentle,) * 12, *(_leaf,) * 5, *(_scaled,) * 3, *(_as_the_schema_says,) * 3, *(_more,) * 4, *(_less,) * 2,
    *(_renamed,) * 2, _repeated, _wrapped, _swapped, *(_transplanted,) * 2, _emptied, _anchored, _of_another_kind,
)  # fmt: skip
