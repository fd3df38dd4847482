"""Remedies and designs that were cut short: what was found is kept, and the next run ends with the same bytes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hknob_cli.errors import RefusedError
from hknob_cli.specs.load import validate
from hknob_cli.specs.source import parse
from hknob_cli.stages import make as making
from hknob_cli.stages.design.designs import Evaluator
from hknob_cli.stages.job import Job, work_of
from hknob_cli.stages.make import make
from hknob_cli.stages.remedies import run as remedies
from tests.designs import DESIGN

REMEDIES = """\
kind: remedies
name: few
base:
  scene: {knob: {inertia: 1.9e-6}, wall: {stiffness: 0.27}, bias: {torque: 0.007}}
  grid: {sample_rate_hz: 455.0, counts_per_rev: 256}
  starts: {phases: 2}
hands: {pinch: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}}
remedies:
  plain wall: {}
  fast: {change: {grid: {sample_rate_hz: 900}}, source: own}
"""


class Cut:
    """A function that is interrupted at its call of a number; how often it was called."""

    def __init__(self, plain: Callable[..., Any], at: int) -> None:
        self.plain, self.at, self.calls = plain, at, 0

    def __call__(self, *args: Any) -> Any:
        self.calls += 1
        if self.calls == self.at:
            raise KeyboardInterrupt
        return self.plain(*args)


def job_of(text: str, out: Path, **options: Any) -> Job:
    plan = validate(parse(text, "spec.yaml"))
    return Job(kind=plan.values["kind"], plan=plan, out=out, jobs=1, quiet=True, **options)


def files(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in out.iterdir() if path.is_file() and path.suffix == ".parquet"}


@pytest.mark.parametrize("kind", ["remedies", "design"])
def test_what_was_found_is_not_found_again(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = REMEDIES if kind == "remedies" else DESIGN
    place: tuple[Any, str] = (remedies, "_rows") if kind == "remedies" else (Evaluator, "evaluate")
    plain = getattr(*place)

    def run(out: str, at: int, **options: Any) -> int:
        cut = Cut(plain, at)
        monkeypatch.setattr(*place, lambda *args: cut(*args))
        job = job_of(text, tmp_path / out, **options)
        make(job, work_of(kind))
        return cut.calls

    whole = run("whole", 0)
    assert whole > 1
    with pytest.raises(KeyboardInterrupt):
        run("out", whole)
    assert [path.name.startswith(f".hknob.partial-{kind}-") for path in (tmp_path / "out").glob(".hknob.p*")] == [True]
    assert work_of(kind).finished(job_of(text, tmp_path / "out")) == f"{whole - 1} finished tasks"
    other = job_of(text.replace("name: ", "name: other-"), tmp_path / "out")
    with pytest.raises(RefusedError, match=f"holds what a {kind} that was cut short has finished"):
        make(other._replace(kind="predict"), work_of(kind))
    assert run("out", 0) == 1
    assert files(tmp_path / "out") == files(tmp_path / "whole")
    assert not list((tmp_path / "out").glob(".hknob.p*"))
    with pytest.raises(KeyboardInterrupt):
        run("out", whole, force=True)
    assert run("out", 0, force=True) == whole


def test_it_is_written_while_it_goes_on_and_not_where_it_is_soon_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = job_of(REMEDIES, tmp_path / "out")
    (tmp_path / "out").mkdir()
    with making.keeping(job, work_of("remedies")) as some:
        some.put(0, [{"p2p_rad": 0.1, "note": None, "level": float("inf")}])
        some.put(1, [(1, 2)])  # not as JSON has it
    assert list((tmp_path / "out").iterdir()) == []
    monkeypatch.setattr(making, "EVERY_S", -1.0)
    with making.keeping(job, work_of("remedies")) as some:
        some.put(0, [{"p2p_rad": 0.1, "note": None, "level": float("inf")}])
    with making.keeping(job, work_of("remedies")) as some:
        assert some.get(0) == [{"p2p_rad": 0.1, "note": None, "level": float("inf")}]
        assert some.get(1) is None
