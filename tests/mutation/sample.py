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
from typing import Any, NamedTuple

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.mutation.accepted import Accepted
from tests.mutation.campaign import NOT_CALLED, NOT_PLACED, OUT_OF_TIME, SURVIVES, Budget, run
from tests.mutation.mutate import Mutant, mutants
from tests.mutation.table import GROUPS, LEFT_OUT, PACKAGE, ROOT, files_of, watchers_of
from tests.mutation.whole import SCORES, section

BUDGET = Budget(slowest_s=4.0, in_all_s=4.0, whole=False)
FOLDER = ROOT / "results" / "mutation"
NEXT = "## Those that come next in the draw"
NEXT_HEAD = (
    "No test was written for these. What is killed *at first sight* says how well the tests find a change that nobody "
    "has thought of. Those that survived were then given a test or a reason: *now* counts these, too.",
    "",
    "| group | behind the first | tried | killed at first sight | score at first sight | killed now | explained "
    "| survived | not called | score now |",
    "|---|---|---|---|---|---|---|---|---|---|",
)
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


class Draw(NamedTuple):
    """Which sample: the seed that the order of changes comes from, and how many of that order are left out."""

    seed: int
    after: int

    def of(self, group: str, count: int) -> dict[str, Mutant]:
        """So many of a group's changes; a larger sample has the smaller one in it, and an edit changes little of it."""
        every = changes_of(group)
        every.sort(key=lambda one: hashlib.sha256(f"{self.seed} {one[0]}".encode()).digest())
        return dict(every[self.after : self.after + count])

    def place(self, group: str) -> Path:
        """Where its verdicts are kept."""
        return FOLDER / f"{group}-{self.seed}{f'-{self.after}' if self.after else ''}.jsonl"


def verdicts_in(path: Path) -> dict[str, dict[str, Any]]:
    """What has been judged so far, and how at first; a torn last line is left out."""
    found = {}
    for line in path.read_text().splitlines() if path.exists() else ():
        try:
            one = json.loads(line)
        except ValueError:
            continue
        found[one["key"]] = one | {"first": found.get(one["key"], one).get("first", one["verdict"])}
    return found


def judge(group: str, count: int, draw: Draw) -> None:
    """Judge what of a sample is left, the files that share their tests together."""
    path = draw.place(group)
    path.parent.mkdir(parents=True, exist_ok=True)
    there = verdicts_in(path)
    slow = FOLDER / f"{group}-slow.json"  # tests that are not waited for a second time
    left_out: list[str] = json.loads(slow.read_text()) if slow.exists() else []
    by_tests: dict[tuple[Path, ...], dict[str, Mutant]] = {}
    for key, one in draw.of(group, count).items():
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


def judge_again(group: str, draw: Draw, tests: list[Path]) -> None:
    """Judge by other tests what no test has found, and keep what they find."""
    path = draw.place(group)
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


def count_as(mutant: Mutant, verdict: str) -> str:
    """What a verdict is counted as: killed, explained, or as it is."""
    if verdict not in VERDICTS:
        return "killed"
    return "explained" if verdict in (SURVIVES, OUT_OF_TIME) and reason_of(mutant) else verdict


@cache
def _accepted(path: Path) -> Accepted:
    return Accepted(path)


def rows(seed: int) -> Iterator[tuple[str, Counter[str], int, list[tuple[Mutant, str, str]]]]:
    """Of each group: its counts, how many changes there are, and those that survive with verdict and reason."""
    for group in GROUPS:
        there = verdicts_in(Draw(seed, 0).place(group))
        sample = dict(changes_of(group))
        counts: Counter[str] = Counter()
        survivors = []
        for key in sample.keys() & there.keys():
            verdict = there[key]["verdict"]
            counts[count_as(sample[key], verdict)] += 1
            if verdict in (SURVIVES, OUT_OF_TIME):
                survivors.append((sample[key], verdict, reason_of(sample[key])))
        yield (
            group,
            counts,
            len(sample),
            sorted(survivors, key=lambda one: (str(one[0].path), one[0].line, one[0].change)),
        )


def in_order(group: str, seed: int) -> tuple[int, str]:
    """How many changes are judged from the draw's begin on, without a gap, and the score of these."""
    draw = Draw(seed, 0)
    there, first, counts = verdicts_in(draw.place(group)), 0, Counter[str]()
    for key, one in draw.of(group, len(changes_of(group))).items():
        if key not in there:
            break
        verdict = there[key]["verdict"]
        counts[count_as(one, verdict)] += 1
        first += 1
    return first, score_of(counts)


def score_of(counts: Counter[str]) -> str:
    """Killed, of those that were called and not explained."""
    judged = counts["killed"] + counts[SURVIVES] + counts[OUT_OF_TIME]
    return f"{100 * counts['killed'] / judged:.1f} %" if judged else "-"


def next_ones(seed: int) -> list[str]:
    """The part of the page about samples that come behind the first: by group, at first sight and now."""
    told = SCORES.read_text().partition(NEXT)[2].partition("\n## ")[0]
    rows = {line.split(" |")[0]: line for line in told.splitlines() if line.startswith("| ")}
    for path in sorted(FOLDER.glob(f"*-{seed}-*.jsonl")):
        group, _, after = path.stem.rsplit("-", 2)
        sample, there = dict(changes_of(group)), verdicts_in(path)
        keys = sample.keys() & there.keys()
        seen = Counter(count_as(sample[key], there[key]["first"]) for key in keys)
        now = Counter(count_as(sample[key], there[key]["verdict"]) for key in keys)
        left = now[SURVIVES] + now[OUT_OF_TIME]
        away = now[NOT_CALLED] + now[NOT_PLACED]
        cells = (len(keys), seen["killed"], score_of(seen), now["killed"], now["explained"], left, away, score_of(now))
        rows[f"| {group}"] = f"| {group} | {after} | {' | '.join(map(str, cells))} |"
    return [NEXT, "", *NEXT_HEAD, *(line for key, line in sorted(rows.items()) if key != "| group"), ""]


def said_of(group: str, page: str) -> tuple[str, list[str]]:
    """What a page says of a group: its row, and a line for each that survives."""
    row = next(line for line in page.splitlines() if line.startswith(f"| {group} |"))  # the first table's
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
        "sample. The next table tells how many are found at first sight.",
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
    return "\n".join([*lines, *listed, *next_ones(seed)]).rstrip() + "\n\n" + section()


def main() -> int:
    """Judge, or write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("groups", nargs="*", default=list(GROUPS), help="of %(default)s")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--after", type=int, default=0, metavar="COUNT")
    parser.add_argument("--again", nargs="+", type=Path, metavar="TEST")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    if options.write:
        SCORES.write_text(table(options.seed))
        return 0
    for group in options.groups:
        draw = Draw(options.seed, options.after)
        child = os.fork()  # what one group's tests have loaded and changed is not another's
        if child == 0:
            if options.again:
                judge_again(group, draw, options.again)
            else:
                judge(group, options.count, draw)
            os._exit(0)
        os.waitpid(child, 0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
