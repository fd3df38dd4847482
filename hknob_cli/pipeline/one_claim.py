"""One claim of the text that a pipeline's page checks: the stages that it needs, and its verdict when they are done.

A claim names results among the arguments of its check. In a pipeline these are stages.
"""

from collections.abc import Iterator
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import known
from hknob_cli.page.claims.ledger import Claim, Ledger, load_ledger, places
from hknob_cli.page.claims.text import claim_text
from hknob_cli.page.claims.verdict import judge_claim
from hknob_cli.pipeline.steps import plan_of
from hknob_cli.results.result_set import ResultSet
from hknob_cli.specs.load import kind_of
from hknob_cli.specs.messages import closest, shown
from hknob_cli.specs.stage_plans import PipelinePlan, ReportPlan

_MANY = 40  # claims that a message lists
_LONGEST = 90  # letters of a sentence in it
_NO_RESULTS = ("file",)  # arguments whose value is never a result, whatever it is called


class OneClaim(NamedTuple):
    """A claim, and the ``folders`` by name of all results that its page has."""

    claim: Claim
    folders: dict[str, Path]

    @property
    def results(self) -> tuple[str, ...]:
        """Names of the results that its check reads, in any reading: those that the print does not allow, too."""
        return tuple(dict.fromkeys(name for name in _words(_arguments(self.claim)) if name in self.folders))

    def stages(self, plan: PipelinePlan) -> list[str]:
        """Those of the results that the pipeline makes."""
        return [name for name in self.results if name in plan.stages]

    def judge(self) -> tuple[dict[str, Any], str]:
        """The row of ``claims.parquet``, and the same in words. Raises `UsageError` for arguments its check lacks."""
        row = judge_claim(self.claim, ResultSet(self.folders))
        return row, claim_text(row)


def claims_of(plan: PipelinePlan, root: Path) -> list[OneClaim]:
    """All claims of the pipeline's pages. Raises as `load_ledger`."""
    return [OneClaim(claim, folders) for ledger, folders in _pages(plan, root) for claim in ledger.claims]


def find_claim(plan: PipelinePlan, root: Path, asked: str) -> OneClaim:
    """The claim of this id, or the only one from this place or with these words.

    ``root`` is the folder of the pipeline's results. Raises `UsageError` if there is none, or there are several.
    """
    everywhere = claims_of(plan, root)
    if not everywhere:
        raise UsageError(f"--claim: no stage of '{plan.name}' is a report that names a ledger under claims")
    found = [one for one in everywhere if one.claim.id == asked]
    found = found or [one for one in everywhere if asked in places(one.claim.place)]
    found = found or _with_words(everywhere, asked)
    if len(found) == 1:
        return found[0]
    if not found:
        close = closest(asked, [one.claim.id for one in everywhere])
        hint = f" did you mean '{close}'?" if close else ""
        raise UsageError(
            f"--claim: no claim has the id {shown(asked)}, is from such a place, or has these words;{hint} "
            f"allowed: an id, a place such as 6.4.2 or 'Figure 35', or words of one of the {len(everywhere)} claims"
        )
    lines = [f"  {one.claim.id} ({one.claim.place}): {_short(one.claim.says)}" for one in found[:_MANY]]
    more = [f"  and {len(found) - _MANY} more"] if len(found) > _MANY else []
    raise UsageError("\n".join([f"--claim: {len(found)} claims answer to {shown(asked)}; choose one:", *lines, *more]))


def _short(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def _with_words(claims: list[OneClaim], asked: str) -> list[OneClaim]:
    """Those with the most of the words in their id, place or sentence, if these are more than half of them."""
    words = asked.casefold().split()
    texts = [f"{one.claim.id} {one.claim.place} {one.claim.says}".casefold() for one in claims]
    counts = [sum(word in text for word in words) for text in texts]
    most = max(counts, default=0)
    return [one for one, count in zip(claims, counts, strict=True) if count == most] if 2 * most > len(words) else []


def _pages(plan: PipelinePlan, root: Path) -> Iterator[tuple[Ledger, dict[str, Path]]]:
    """Ledgers of the pipeline's pages, and where the results of each page lie."""
    where = {stage.name: stage.folder or root / stage.name for stage in plan.stages.values()}
    shown_here = [stage for stage in plan.stages.values() if "results" in stage.inputs]
    for stage in shown_here or plan.stages.values():
        if stage.spec is None or kind_of(stage.spec) != "report":
            continue
        page = plan_of(stage, where, frozenset())
        assert isinstance(page, ReportPlan)
        if page.claims:
            yield load_ledger(Path(page.claims)), {name: Path(folder) for name, folder in page.results.items()}


def _arguments(claim: Claim) -> list[Any]:
    """Values of the arguments of its check in all readings, and those that the check has if none is given."""
    if claim.check is None:
        return []
    defaults = {
        one.name: one.default
        for one in signature(known()[claim.check]).parameters.values()
        if one.default is not Parameter.empty
    }
    given = [{**defaults, **claim.arguments, **reading.arguments} for reading in claim.all_readings]
    return [value for one in given for name, value in one.items() if name not in _NO_RESULTS]


def _words(value: Any) -> Iterator[str]:
    """Every text in a value."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for one in value.values():
            yield from _words(one)
    elif isinstance(value, list | tuple):
        for one in value:
            yield from _words(one)
