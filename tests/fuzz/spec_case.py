"""A spec to try: bytes of a file and overrides, made of a seed by a few changes."""

from collections.abc import Sequence
from random import Random
from typing import Any, NamedTuple

from tests.fuzz import nasty, text
from tests.fuzz.seeds import CASE, CLAIMS, seeds, trimmed
from tests.fuzz.shape import at, example, shape_of
from tests.fuzz.tree import mutate, spots
from tests.fuzz.yaml_text import write

STAGES = ("sweep", "dfa", "predict", "sysid", "remedies", "design", "hw-run", "bench", "report")
KINDS = (*STAGES, "pipeline", CLAIMS, CASE)


class SpecCase(NamedTuple):
    """A file's bytes, overrides, and the kind that it began as.

    ``run``: run its stage, too, where that is cheap, with these options.
    """

    kind: str
    data: bytes
    sets: tuple[str, ...]
    run: tuple[str, ...] | None = None


def spec_case(dice: Random, *, kinds: Sequence[str] | None = None, run_share: float = 0.0) -> SpecCase:
    """A spec of one of some kinds, of any if none is said, spoilt; of ``run_share`` of them the stage is to be run."""
    kind = kinds[0] if kinds and len(kinds) == 1 else dice.choice(kinds or KINDS)
    tree = trimmed(dice.choice(seeds()[kind]), dice)
    shape = shape_of(kind) if kind != CASE else {}
    run = dice.choice(((), (), ("--json",), ("--verbose",), ("--plot",))) if dice.random() < run_share else None
    changes = dice.choice((1, 1, 1, 1, 2, 2, 3)) if run is None else dice.choice((0, 1, 1, 1, 2))
    for _ in range(changes):
        tree = mutate(tree, shape, dice, gently=run is not None and dice.random() < 0.8)
    written = write(tree, dice)
    spoil = run is None and dice.random() < 0.2
    data = text.change(written, dice) if spoil else written.encode("utf-8", errors="surrogatepass")
    sets = tuple(_override(tree, shape, dice) for _ in range(dice.choice((0, 0, 0, 0, 0, 1, 1, 2))))
    return SpecCase(kind, data, sets, run)


def _override(tree: Any, shape: dict[str, Any], dice: Random) -> str:
    """``key.path=value`` for ``--set``: a path of the spec or near one, and a value of any kind."""
    paths = [".".join(map(str, one.path)) for one in spots(tree)] or ["kind"]
    path = dice.choice(paths)
    if dice.random() < 0.3:
        odd = ("", ".", "..", path + "[0]", f"{path}.{nasty.text(dice)}", nasty.text(dice))
        path = dice.choice((nasty.misspelt(path, dice), *odd))
    match dice.randrange(4):
        case 0:
            value = nasty.scalar(dice)
        case 1:
            value = nasty.quantity(dice)
        case 2:
            value = nasty.text(dice)
        case _:
            steps = tuple(path.split("."))
            value = write(example(shape, at(shape, steps), dice), dice).strip()
    sign = dice.choice(("=",) * 18 + ("", "=="))
    # An argument of a process has no NUL, and whatever else it has can be written in its bytes.
    text = f"{path}{sign}{value}".replace("\x00", "")
    return text.encode("utf-8", "replace" if _high(text) else "surrogateescape").decode("utf-8", "surrogateescape")


def _high(text: str) -> bool:
    return any("\ud800" <= letter <= "\udfff" and not "\udc80" <= letter <= "\udcff" for letter in text)
