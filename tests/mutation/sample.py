"""A sample of changes of a folder group, drawn by a seed: how many of them do the group's tests find?

`python tests/mutation/sample.py proofs --count 1000 --seed 1` draws so many of all changes that `mutate.py` makes of
the group's files (`table.py`), and judges each by the quick tests of its file, as `campaign.py` does. Verdicts are
appended to a file under results/ as they come: the same command goes on from there. What `accepted.toml` has is not
tried. Without a group all are tried, one after the other. `--again TEST ...` judges those that no test has found once
more, by these tests. `--write` puts what is there into `scores.md`, with a line for each that survives; a group of
which nothing is there keeps what the page says of it.
"""

import argparse
import datetime
import hashlib
import json
import os
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.mutation.accepted import Accepted
from tests.mutation.campaign import NOT_CALLED, NOT_PLACED, OUT_OF_TIME, SURVIVES, Budget, run
from tests.mutation.mutate import Mutant, mutants
from tests.mutation.table import GROUPS, LEFT_OUT, PACKAGE, ROOT, files_of, watchers_of
from tests.mutation.whole import SCORES, section

BUDGET = Budget(slowest_s=4.0, in_all_s=4.0, whole=False)
FOLDER = ROOT / "results" / "mutation"
VERDICTS = (SURVIVES, OUT_OF_TIME, NOT_CALLED, NOT_PLACED)  # beside those that count as killed


def changes_of(group: str) -> list[tuple[str, Mutant]]:
    """All changes of a group's files, each with what tells it from others, in a fixed order."""
    found = []
    for path in files_of(group):
        seen: Counter[str] = Counter()
        for one in mutants(path):
            key = f"{path.relative_to(PACKAGE).as_posix()} {one.name} | {one.text} | {one.change}"
            seen[key] += 1
            found.append((f"{key} | {seen[key]}", one))
    return found


def drawn(group: str, count: int, seed: int) -> dict[str, Mutant]:
    """A sample of a group's changes; a larger one has the smaller one in it, and an edit changes little of it."""
    every = changes_of(group)
    every.sort(key=lambda one: hashlib.sha256(f"{seed} {one[0]}".encode()).digest())
    return dict(every[:count])


def place_of(group: str, seed: int) -> Path:
    """Where verdicts are kept."""
    return FOLDER / f"{group}-{seed}.jsonl"


def verdicts_in(path: Path) -> dict[str, dict[str, Any]]:
    """What has been judged so far; a torn last line is none."""
    found = {}
    for line in path.read_text().splitlines() if path.exists() else ():
        try:
            one = json.loads(line)
        except ValueError:
            continue
        found[one["key"]] = one
    return found


def judge(group: str, count: int, seed: int) -> None:
    """Judge what of a sample is left, the files that share their tests together."""
    path = place_of(group, seed)
    path.parent.mkdir(parents=True, exist_ok=True)
    there = verdicts_in(path)
    slow = FOLDER / f"{group}-slow.json"  # tests that are not waited for a second time
    left_out: list[str] = json.loads(slow.read_text()) if slow.exists() else []
    by_tests: dict[tuple[Path, ...], dict[str, Mutant]] = {}
    for key, one in drawn(group, count, seed).items():
        if key in there:
            continue
        if reason_of(one):
            note(path, key, one, SURVIVES)
        else:
            by_tests.setdefault(tuple(sorted(watchers_of(one.path))), {})[key] = one
    for tests, some in sorted(by_tests.items(), key=lambda pair: -len(pair[1])):
        print(f"{group}: {len(some)} changes by {', '.join(one.name for one in tests)}", flush=True)
        keys = {id(one): key for key, one in some.items()}

        def hear(mutant: Mutant, verdict: str, keys: dict[int, str] = keys) -> None:
            note(path, keys[id(mutant)], mutant, verdict)

        found = run(list(some.values()), hear, BUDGET, tests=tests, left_out=[*LEFT_OUT, *left_out])
        left_out += found.slow
        slow.write_text(json.dumps(left_out))
        for failure in found.failed:
            print(f"cannot be judged: {failure}", flush=True)


def judge_again(group: str, seed: int, tests: list[Path]) -> None:
    """Judge by other tests what no test has found, and keep what they find."""
    path = place_of(group, seed)
    there, every = verdicts_in(path), dict(changes_of(group))
    left = [key for key in every.keys() & there.keys() if there[key]["verdict"] in VERDICTS]
    keys = {id(every[key]): key for key in left if not reason_of(every[key])}

    def hear(mutant: Mutant, verdict: str) -> None:
        if verdict in VERDICTS:
            print(f"{verdict}: {mutant}", flush=True)
        else:
            note(path, keys[id(mutant)], mutant, verdict)

    run([every[key] for key in keys.values()], hear, BUDGET, tests=tests)


def note(path: Path, key: str, mutant: Mutant, verdict: str) -> None:
    """Keep a verdict; a later one of the same change counts."""
    with path.open("a") as stream:
        stream.write(json.dumps({"key": key, "verdict": verdict, "line": mutant.line}) + "\n")


def reason_of(mutant: Mutant) -> str:
    """Why a change may survive, as `accepted.toml` has it; empty if nobody has looked yet."""
    if mutant.change == "strict=True => strict=False":
        return "Says that both are of one length wherever the program is right."
    return _accepted(mutant.path).take(mutant) or ""


@cache
def _accepted(path: Path) -> Accepted:
    return Accepted(path)


def rows(seed: int) -> Iterator[tuple[str, Counter[str], int, list[tuple[Mutant, str, str]]]]:
    """Of each group: its counts, how many changes there are, and those that survive with verdict and reason."""
    for group in GROUPS:
        there = verdicts_in(place_of(group, seed))
        sample = dict(changes_of(group))
        counts: Counter[str] = Counter()
        survivors = []
        for key in sample.keys() & there.keys():
            verdict = there[key]["verdict"]
            reason = "" if verdict not in (SURVIVES, OUT_OF_TIME) else reason_of(sample[key])
            counts["explained" if reason else verdict if verdict in VERDICTS else "killed"] += 1
            if verdict in (SURVIVES, OUT_OF_TIME):
                survivors.append((sample[key], verdict, reason))
        yield group, counts, len(sample), sorted(survivors, key=lambda one: (str(one[0].path), one[0].line))


def in_order(group: str, seed: int) -> tuple[int, str]:
    """How many changes are judged from the draw's begin on, without a gap, and the score of these."""
    there, first, counts = verdicts_in(place_of(group, seed)), 0, Counter[str]()
    for key, one in drawn(group, len(changes_of(group)), seed).items():
        if key not in there:
            break
        verdict = there[key]["verdict"]
        counts[
            "explained" if verdict in VERDICTS and reason_of(one) else verdict if verdict in VERDICTS else "killed"
        ] += 1
        first += 1
    return first, score_of(counts)


def score_of(counts: Counter[str]) -> str:
    """Killed, of those that were called and not explained."""
    judged = counts["killed"] + counts[SURVIVES] + counts[OUT_OF_TIME]
    return f"{100 * counts['killed'] / judged:.1f} %" if judged else "-"


def said_of(group: str, page: str) -> tuple[str, list[str]]:
    """What a page says of a group: its row, and a line for each that survives."""
    row = next(line for line in page.splitlines() if line.startswith(f"| {group} |"))
    _, _, told = page.partition(f"### {group}\n")
    return row, [line for line in told.partition("\n#")[0].splitlines() if line]


def table(seed: int) -> str:
    """The page `scores.md`."""
    lines = [
        "# Which share of changes the tests find",
        "",
        "Made by `python tests/mutation/sample.py --write`. A sample of each folder group's changes, drawn by a seed.",
        "The files with proofs, and some more, are tried whole: the last table has them.",
        "",
        f"Seed {seed}, {datetime.date.today():%Y-%m-%d}. *Explained* ones are in `accepted.toml`. *Out of time*: no "
        f"test failed within {BUDGET.in_all_s:g} s. *Not called*: by no test of at most {BUDGET.slowest_s:g} s in this "
        "process; compiled code is tested elsewhere, and so are commands that a test starts anew. *Score*: "
        "killed, of those that were called and not explained. The files below that are tried whole were tried first: "
        "the last two columns are of as many changes as were tried in the order of the draw, without a gap. "
        "Changes that survived at first were given a test or a reason since: scores say what was done about this "
        "sample. How many are found at first sight another seed tells.",
        "",
        "| group | changes | tried | killed | explained | survived | out of time | not called | score "
        "| first | their score |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    listed = ["", "## What survives, and why", ""]
    page = SCORES.read_text()
    for group, counts, size, survivors in rows(seed):
        if not counts:
            row, told = said_of(group, page)
            lines.append(row)
            listed += [f"### {group}", "", *told, ""]
            continue
        tried, killed = counts.total(), counts["killed"]
        rest = (counts[one] for one in ("explained", SURVIVES, OUT_OF_TIME))
        away = counts[NOT_CALLED] + counts[NOT_PLACED]
        cells = (group, size, tried, killed, *rest, away, score_of(counts), *in_order(group, seed))
        lines.append(f"| {' | '.join(map(str, cells))} |")
        listed += [f"### {group}", ""]
        for one, verdict, reason in survivors:
            name = one.path.relative_to(PACKAGE).as_posix()
            listed.append(f"- {name}:{one.line} `{one.name}`: `{one.change}`: {reason or verdict + ', not looked at'}")
        listed.append("")
    return "\n".join([*lines, *listed]).rstrip() + "\n\n" + section()


def main() -> int:
    """Judge, or write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("groups", nargs="*", default=list(GROUPS), help="of %(default)s")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--again", nargs="+", type=Path, metavar="TEST")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    if options.write:
        SCORES.write_text(table(options.seed))
        return 0
    for group in options.groups:
        child = os.fork()  # what one group's tests have loaded and changed is not another's
        if child == 0:
            if options.again:
                judge_again(group, options.seed, options.again)
            else:
                judge(group, options.count, options.seed)
            os._exit(0)
        os.waitpid(child, 0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
