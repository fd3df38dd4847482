"""``hknob new`` at a terminal: it asks what a spec should have, and takes what is in brackets for an empty answer."""

import os
import pty
import select
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from hknob_cli.cli import new
from hknob_cli.cli.new import Interview, _text, interview
from hknob_cli.errors import SpecError
from hknob_cli.specs.load import load, load_pipeline
from hknob_cli.specs.starter import own_starter, questions, refuse, starter
from hknob_cli.stage_table import SPECS
from tests.conftest import HKNOB, SPEC

Talk = Callable[..., Path]


class Person:
    """Answers questions in turn, and the rest with Enter; ``asked`` and ``said`` are what was on the screen."""

    def __init__(self, answers: dict[str, list[str] | str]) -> None:
        self.answers = {begin: [one] if isinstance(one, str) else list(one) for begin, one in answers.items()}
        self.asked: list[str] = []
        self.said: list[str] = []

    def __call__(self, question: str) -> str:
        self.asked.append(question)
        for begin, left in self.answers.items():
            if begin in question and left:
                return f"{left.pop(0)}\n"
        return "\n"


def talk(kind: str, person: Person, out: Path | None = None) -> tuple[str, Path]:
    """What comes of an interview."""
    return interview(kind, lambda origin: _text(kind, origin, out), out, Interview(person, person.said.append))


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("kind", SPECS)
def test_empty_answers_give_the_starter(kind: str) -> None:
    person = Person({})
    text, out = talk(kind, person)
    assert text == starter(kind)
    assert f"name: {out.stem} " in text
    assert 1 <= len(person.asked) <= 10
    every = Person({"": "."})
    assert talk(kind, every) == (text, out)
    assert len(every.asked) == 1


def test_answers_are_in_the_spec_and_its_comments_stay() -> None:
    text, out = talk(
        "sweep",
        Person({
            "Inertia": "60 g*cm^2", "Friction": "0.5 mN*m", "Stiffness": "0.5", "Push": "2 mN*m",
            "rate": "[1000, 2000]", "counts": "512", "Radius": "9 mm", "every way": "yes", "File": "heavy.yaml",
        }),
    )  # fmt: skip
    out.write_text(text)
    plan = load(out)
    assert (plan.name, plan.scene.wall.stiffness, plan.scene.bias.torque) == ("heavy", 0.5, 0.002)
    assert plan.scene.knob.inertia == pytest.approx(6e-6)
    assert plan.scene.knob.coulomb_torque == pytest.approx(5e-4)
    assert plan.axes == {"sample_rate_hz": [1000.0, 2000.0], "counts_per_rev": [512]}
    assert plan.perceive.knob_radius == pytest.approx(0.009)
    assert plan.starts.span == (-0.05, 0.05, -5.0, 5.0)
    same_column = [
        ("inertia: 60 g*cm^2", "# of knob"),
        ("coulomb_torque: 0.5 mN*m", "# friction"),
        ("name: heavy", "# names"),
    ]
    for value, comment in same_column:
        (new,), (old,) = ([line for line in one.splitlines() if comment in line] for one in (text, starter("sweep")))
        assert value in new
        assert new.index(comment) == old.index(comment)
    assert all(one.strip() in text for one in ("# of knob and motor", "# default: floor", "# the push into the wall"))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("kind", ["remedies", "design", "bench", "hw-run", "predict", "dfa"])
def test_other_numbers_are_in_proportion(kind: str) -> None:
    text, out = talk(kind, Person({"Stiffness": "0.8", "rate": "2 kHz", "counts": "500", "Inertia": "60 g*cm^2"}))
    out.write_text(text)
    plan = load(out)
    if kind == "remedies":
        softer = next(one for one in plan.remedies if one.name == "softer wall")
        assert softer.grid.scene.wall.stiffness == pytest.approx(0.4)
        assert "this knob: {sample_rate_hz: 2000, counts_per_rev: 500}" in text
    if kind == "design":
        assert plan.stiffness == pytest.approx(0.6)
        assert "- {value: 8000, cost: 1}" in text
        assert plan.present == {"sample_rate_hz": 2000.0, "counts_per_rev": 500}


def test_lists_are_shown_and_taken_as_they_are_written() -> None:
    person = Person({})
    talk("dfa", person)
    assert any(one.startswith("Sample rate, Hz [[500, 1000, 2000]]") for one in person.asked)
    text, _ = talk("remedies", Person({"rate": "[2000, 4000]", "counts": "512"}))
    assert "sample_rate_hz: [2000, 4000]" in text
    assert "this knob: {sample_rate_hz: 2000, counts_per_rev: 512}" in text


def test_other_numbers_of_a_preset_stay_its_own() -> None:
    person = Person({"Presets": "smartknob", "Sample rate": "4000"})
    text, _ = talk("design", person)
    assert text == starter("design", "smartknob").replace(
        "present: {sample_rate_hz: 1000", "present: {sample_rate_hz: 4000"
    )


def test_numbers_are_taken_to_the_last_digit_and_only_where_they_are_in_proportion() -> None:
    text = own_starter("remedies", {"wall": {"stiffness": 0.6}}, {"sample_rate_hz": 44100.123456789})
    assert "this knob: {sample_rate_hz: 44100.123456789, counts_per_rev: 1024}" in text
    assert "    sample_rate_hz: 1000 " in text
    assert "    wall: {stiffness: 0.27} " in text
    assert "change: {scene: {wall: {stiffness: 0.3}}} " in text


def test_a_comment_stays_apart_from_an_answer_that_is_long(tmp_path: Path) -> None:
    inertia = f"1.9{30 * '0'}e-6"
    text, _ = talk("sweep", Person({"Inertia": inertia}))
    assert f"inertia: {inertia} # of knob and motor" in text


def test_an_answer_that_is_neither_yes_nor_no_has_no_line() -> None:
    text = starter("sweep")
    (question,) = (one for one in questions("sweep", text) if one.comment == "starts")
    with pytest.raises(SpecError) as raised:
        refuse("sweep", text, {question: "often"}, Path())
    (fault,) = raised.value.faults
    assert (fault.line, fault.column, fault.message) == (0, 0, "must be yes or no")


def test_a_wrong_answer_is_asked_again(tmp_path: Path) -> None:
    (tmp_path / "there.yaml").write_text("mine")
    person = Person({
        "Presets": ["idrve", "-", "own"], "Inertia": ["-1", "1 m", "60 g*cm^2"], "Stiffness": ["{", "0.5"],
        "every way": "often", "File": ["there.yaml", "nowhere/a.yaml", "mine.yaml"],
    })  # fmt: skip
    text, out = talk("sweep", person)
    assert (out.name, "inertia: 60 g*cm^2" in text) == ("mine.yaml", True)
    said = "\n".join(person.said)
    for one in (
        "did you mean 'idrive'", "-: is standard input", "scene.knob.inertia: must be > 0", "starts: must be yes or no",
        "there.yaml: is there already; name another file", "nowhere/a.yaml: no such folder",
    ):  # fmt: skip
        assert one in said
    assert len(person.said) == 8


def test_a_preset_has_its_numbers_and_a_file_all(tmp_path: Path) -> None:
    person = Person({"Presets": "smartknob", "File": "trial.yaml"})
    text, _ = talk("remedies", person)
    assert text == starter("remedies", "smartknob").replace("name: my-smartknob", "name: trial       ")
    assert not any("Inertia" in one or "Stiffness" in one for one in person.asked)
    assert any("Push" in one for one in person.asked)
    (tmp_path / "own.yaml").write_text(SPEC)
    person = Person({"Presets": "own.yaml", "File": "laws.yaml"})
    text, out = talk("predict", person)
    out.write_text(text)
    assert load(out).scene.wall.stiffness == 0.27
    assert len(person.asked) == 2


def test_other_kinds_ask_for_their_own(tmp_path: Path) -> None:
    text, _ = talk("sysid", Person({"Recordings": "a.csv b.csv"}))
    assert '\nrecordings: ["a.csv", "b.csv"] ' in text
    assert "virtual:" not in text
    text, out = talk("report", Person({"results": "results/one results/two", "File": "page.yaml"}))
    out.write_text(text)
    assert list(load(out).results.values()) == ["results/one", "results/two"]
    (tmp_path / "hand.yaml").write_text(starter("sysid"))
    text, out = talk("pipeline", Person({"first": "hand.yaml", "page": "page.yaml", "File": "all.yaml"}))
    out.write_text(text)
    assert [one.spec.name for one in load_pipeline(out).stages.values()] == ["hand.yaml", "page.yaml"]


def test_a_file_that_is_there_has_another_name(tmp_path: Path) -> None:
    (tmp_path / "my-knob.yaml").write_text("mine")
    text, out = talk("sweep", Person({}))
    assert out == Path("my-knob-2.yaml")
    assert "name: my-knob-2 " in text


class Stream:
    """A stream that is a terminal, or not."""

    def __init__(self, tty: bool) -> None:
        self.isatty = lambda: tty


@pytest.mark.parametrize("lacks", [None, "stdin", "stdout", "stderr", "CI"])
def test_only_a_person_is_asked(lacks: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CI", "true" if lacks == "CI" else "")
    for name in ("stdin", "stdout", "stderr"):
        monkeypatch.setattr(sys, name, Stream(name != lacks))
    assert new.at_terminal() is (lacks is None)


def test_nothing_is_asked_elsewhere(hknob) -> None:
    for words in ((), ("--yes",), ("-q",)):
        done = hknob("new", "sweep", *words)
        assert (done.returncode, done.stdout, done.stderr) == (0, starter("sweep"), "")


def at_terminal(*words: str, answers: list[bytes], seconds: float = 60.0) -> tuple[int, str]:
    """Run the command at a terminal of its own: an answer for each question; its exit code, and the screen."""
    child, screen = pty.fork()
    if child == 0:
        os.environ["CI"] = ""
        os.execv(HKNOB, [str(HKNOB), *words])
    seen, left, end = b"", list(answers), time.monotonic() + seconds
    try:
        while time.monotonic() < end:
            if not select.select([screen], [], [], 0.5)[0]:
                continue
            try:
                part = os.read(screen, 4096)
            except OSError:  # nobody writes any more
                break
            if not part:
                break
            seen += part
            if left and seen.endswith(b"]: "):
                os.write(screen, left.pop(0))
        else:
            os.kill(child, signal.SIGKILL)
            pytest.fail(f"no end within {seconds:g} s: {seen!r}")
    finally:
        os.close(screen)
        _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), seen.decode().replace("\r\n", "\n")


def test_at_a_terminal(tmp_path: Path) -> None:
    for leave in (b"\x03", b"\x04"):  # Ctrl-C, Ctrl-D
        code, screen = at_terminal("new", "sweep", answers=[b"\n", leave])
        assert (code, "interrupted" in screen, "Traceback" in screen) == (130, False, False)
    assert not list(tmp_path.iterdir())
    code, screen = at_terminal("new", "sweep", answers=[b"\n", b"\n", b"\n", b"0.5\n", b".\n"])
    assert code == 0, screen
    assert "Stiffness of the wall, N*m/rad [0.27]: " in screen
    assert screen.endswith("wrote my-knob.yaml\n\nnext: hknob sweep my-knob.yaml\n")
    assert load(tmp_path / "my-knob.yaml").scene.wall.stiffness == 0.5
    code, screen = at_terminal("new", "sweep", "--out", "my-knob.yaml", answers=[])
    assert (code, "Presets" in screen) == (3, False)
    code, screen = at_terminal("new", "sweep", "--yes", answers=[])
    assert (code, screen) == (0, starter("sweep"))
