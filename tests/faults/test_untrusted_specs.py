"""Specs that someone hostile wrote: they are read in bounded time and memory, run nothing, and steer no terminal."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from hknob_cli.errors import MOST_FAULTS, SpecError, UsageError
from hknob_cli.recordings.files import NotReadableError, RecordingFile, read_columns
from hknob_cli.results.files import digest
from hknob_cli.results.parted import read_result, result_schema
from hknob_cli.specs import named_file
from hknob_cli.specs.quantity import to_si
from hknob_cli.specs.source import parse, read
from tests.conftest import SPEC, faults_of


@pytest.fixture(autouse=True)
def _no_waiting() -> Iterator[None]:
    """A hang fails the test instead of the run: long before it, what is tested here is over."""

    def give_up(_signal: int, _frame: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize(
    "tagged",
    [
        "!!python/object/apply:os.system [ls]",
        "!!python/object:os.system {inertia: 1}",
        "!!python/name:os.system ls",
        "!!set {inertia}",
        "!!omap {inertia: 1}",
        "!!binary aGVsbG8=",
        "!mine {inertia: 1}",
        "!mine [1]",
    ],
)
def test_tags_make_nothing(tagged: str) -> None:
    message = faults_of(SPEC.replace("{inertia: 1.9e-6}", tagged))
    assert message.startswith("spec.yaml:4:9: scene.knob: tag ")
    assert "is not allowed here" in message


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("0.27", "0x" + "f" * 100_000, "6:21: scene.wall.stiffness: "),
        ("phases: 8", "phases: 0x" + "f" * 100_000, "11:31: starts.phases: "),
        ("phases: 8", "phases: " + "9" * 4000, "11:31: starts.phases: "),
        ("[1000]", "[0o" + "7" * 9000 + "]", "9:20: grid.sample_rate_hz[0]: "),
        ("0.27", "9" * 100_000, "6:21: scene.wall.stiffness: "),
        ("0.27", "1e999999999", "6:21: scene.wall.stiffness: "),
        ("0.27", "0." + "1" * 500_000 + "e400", "6:21: scene.wall.stiffness: "),
    ],
)
def test_huge_numbers(old: str, new: str, place: str) -> None:
    message = faults_of(SPEC.replace(old, new))
    assert message.startswith(f"spec.yaml:{place}")
    assert len(message) < 300


@pytest.mark.parametrize(
    "unit",
    [
        "m^9^9^9^9",
        "m**99**99**99",
        "m^99³³³³",
        "m²²²²²²²²",
        "m^9 ^9 ^9",
        "m squared squared squared squared squared squared",
        "m² squared ^99",
        "square square square square square square square m",
    ],
)
def test_powers_of_powers_of_units(unit: str) -> None:
    with pytest.raises(ValueError, match="is not a number with a unit"):
        to_si(f"1 {unit}", "N*m")


@pytest.mark.parametrize("unit", ["g*cm^2", "g*cm²", "kg m ** 2", "g*(cm)^2", "kg*square m", "kg*m squared"])
def test_ordinary_powers_of_units(unit: str) -> None:
    assert to_si(f"1 {unit}", "kg*m^2") == pytest.approx(1.0 if "kg" in unit else 1e-7, rel=1e-15)


def test_keys_steer_no_terminal(hknob, spec_file) -> None:
    hostile = '"kn\\e[31m\\e]0;title\\aob\\u202e"'
    done = hknob("sweep", spec_file(SPEC.replace("  knob:", f"  {hostile}:")))
    assert done.returncode == 2
    assert "scene.kn?[31m?]0;title?ob?: unknown key" in done.stderr
    assert all(letter.isprintable() or letter == "\n" for letter in done.stderr)
    message = faults_of(SPEC.replace("kind: sweep", 'kind: "\\e[2J' + "x" * 100_000 + '"'))
    assert message.isprintable()
    assert len(message) < 300


def test_huge_keys_are_cut() -> None:
    message = faults_of(SPEC.replace("  knob:", f"  ? {'k' * 400_000}\n  :"))
    assert f"scene.{'k' * 57}...: unknown key" in message
    assert len(message) < 500


def test_faults_without_number_are_not_all_said() -> None:
    message = faults_of(SPEC + "".join(f"key{i}: 1\n" for i in range(MOST_FAULTS + 50)))
    lines = message.splitlines()
    assert len(lines) == MOST_FAULTS + 1
    assert lines[-1] == "... and 50 more faults"


def test_a_larger_file_needs_a_word_from_the_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    large = tmp_path / "large.yaml"
    large.write_text(f"{SPEC}# {'x' * 1_000_000}\n")
    with pytest.raises(UsageError, match=r"large\.yaml: larger than 1 MB; HKNOB_SPEC_LIMIT=10 in the environment"):
        read(large)
    ones, tens, thousands = (", ".join([what] * count) for what, count in (("1", 10), ("*a", 100), ("*b", 120)))
    bomb = f"a: &a [{ones}]\nb: &b [{tens}]\nc: [{thousands}]"
    with pytest.raises(
        SpecError, match="more than 100000 keys and values, aliases expanded; HKNOB_SPEC_LIMIT=10 in the"
    ):
        parse(bomb, "bomb.yaml")
    monkeypatch.setenv("HKNOB_SPEC_LIMIT", "2")
    assert read(large).value["name"] == "small"
    assert len(parse(bomb, "bomb.yaml").value["c"]) == 120
    for wrong in ("0", "-1", "1.5", "many", "1001", "9" * 5000):
        monkeypatch.setenv("HKNOB_SPEC_LIMIT", wrong)
        with pytest.raises(UsageError, match="HKNOB_SPEC_LIMIT: must be a whole number from 1 to 1000, got"):
            read(large)


@pytest.mark.parametrize("piece", ["1", "[]", "a: 1"])
def test_too_much_is_given_up_where_it_begins(piece: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """To read a megabyte of small values to its end takes half a minute: what is behind the limit is not looked at."""
    monkeypatch.setattr(named_file, "_VALUES", 200)
    with pytest.raises(SpecError, match=r"large\.yaml:1:\d+: more than 200 keys and values, aliases expanded") as error:
        parse(f"a: [{f'{piece}, ' * 1000} {'}' * 3}", "large.yaml")
    assert error.value.faults[0].column < 201 * (len(piece) + 2)


def test_what_has_no_end_is_not_read(tmp_path: Path) -> None:
    pipe = tmp_path / "cells.parquet"
    os.mkfifo(pipe)
    for endless in (pipe, Path("/dev/zero")):
        with pytest.raises(NotReadableError, match="is not a file"):
            RecordingFile(endless)
        with pytest.raises(UsageError, match="is not a file"):
            read_columns([endless], ("force_n",))
        for reader in (read_result, result_schema):
            with pytest.raises(FileNotFoundError):
                reader(endless)
        assert digest(endless) is None


@pytest.mark.parametrize(
    "url", ["spy:///dev/null?file=/tmp/x", "alt:///dev/null?class=Serial", "hwgrep://x", "file:///x"]
)
def test_a_port_is_no_way_to_a_file(url: str) -> None:
    spec = f"kind: hw-run\nname: x\ndevice: {{driver: serial, url: '{url}'}}\n"
    assert "3:31: device.url: must be a port's name, or begin with socket://, rfc2217://, loop://" in faults_of(spec)
