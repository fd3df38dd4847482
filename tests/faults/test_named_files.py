"""Files that a spec names: a device, a pipe or a folder in the place of one is told, and never read for ever."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.page.claims.ledger import load_ledger
from hknob_cli.pipeline.steps import chosen, jobs_of
from hknob_cli.specs.load import load, load_pipeline
from hknob_cli.specs.named_file import digest_of, open_named
from hknob_cli.stages.job import Job, work_of
from tests.conftest import SPEC

HAND = "hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}"
PREDICT = SPEC.replace("kind: sweep", "kind: predict").split("starts")[0]
# What is put where a file is meant, and what is said of it.
OTHERS = {
    "pipe": "pipe: is not a file",
    "/dev/zero": "/dev/zero: is not a file",
    "folder.d": "folder.d: is not a file",
    "nowhere": "nowhere: No such file or directory",
    "x" * 300: "File name too long",
    **({"/proc/self/mem": "/proc/self/mem: Input/output error"} if Path("/proc/self/mem").exists() else {}),
}


@pytest.fixture(autouse=True)
def in_time() -> Iterator[None]:
    """A file that is read for ever fails the test."""
    signal.alarm(60)
    yield
    signal.alarm(0)


@pytest.fixture(params=OTHERS)
def other(request, tmp_path: Path) -> tuple[str, str]:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder.d").mkdir()
    return request.param, OTHERS[request.param]


def test_a_file_and_its_digest(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"abc")
    with open_named(tmp_path / "a") as stream:
        assert stream.read() == b"abc"
    assert digest_of(tmp_path / "a").startswith("ba7816bf")


def test_in_the_place_of_presets(other, spec_file) -> None:
    name, said = other
    path = name if name.startswith("/") else f"./{name}"
    with pytest.raises(SpecError, match=rf"spec.yaml:3:15: scene.from: .*{said}"):
        load(spec_file(f"kind: sweep\nname: small\nscene: {{from: {path}}}\n"))


def test_in_the_place_of_hands(other, spec_file) -> None:
    name, said = other
    if name == "folder.d":
        said = "folder.d/conditions.parquet: No such file"
    with pytest.raises(SpecError, match=rf"spec.yaml:5:16: scene.hand.from: .*{said}"):
        load(spec_file(SPEC.replace(HAND, f"hand: {{from: {name}}}")))


def test_in_the_place_of_a_known_case(other, spec_file) -> None:
    name, said = other
    with pytest.raises(SpecError, match=rf"spec.yaml:11:18: constant.case: .*{said}"):
        load(spec_file(PREDICT + f"constant: {{case: {name}}}\n"))


def test_in_the_place_of_a_ledger(other, spec_file, tmp_path: Path) -> None:
    name, said = other
    with pytest.raises(UsageError, match=said):
        load_ledger(tmp_path / name)
    with pytest.raises(SpecError, match=rf"spec.yaml:4:9: claims: .*{said}"):
        load(spec_file(f"kind: report\nname: x\nresults: [a]\nclaims: {name}\n"))


def test_in_the_place_of_a_stage(other, spec_file, tmp_path: Path) -> None:
    name, said = other
    plan = load_pipeline(spec_file(f"kind: pipeline\nname: x\nstages:\n  one: {{spec: {name}}}\n"))
    with pytest.raises(SpecError, match=rf"spec.yaml:4:15: stages.one.spec: .*{said}"):
        jobs_of(chosen(plan), tmp_path)


@pytest.mark.parametrize(
    ("kind", "text", "said_before"),
    [
        ("sysid", "recordings: [{}]\n", "recordings: "),
        ("hw-run", "device: {{driver: replay, recordings: [{}]}}\n", "device.recordings: "),
    ],
)
def test_in_the_place_of_recordings(other, spec_file, tmp_path: Path, kind: str, text: str, said_before: str) -> None:
    name, said = other
    if name in ("folder.d", "nowhere"):  # it may be the folder of a campaign
        said = f"{name}/samples.parquet: No such file"
    if name == "nowhere" and kind == "hw-run":
        said = "nowhere: No such file"
    plan = load(spec_file(f"kind: {kind}\nname: x\n" + text.format(name)))
    with pytest.raises(UsageError, match=rf"{said_before}.*{said}"):
        work_of(kind).inputs(Job(kind=kind, plan=plan, out=tmp_path / "out"))
