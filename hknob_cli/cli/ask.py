"""What ``hknob new`` asks at a terminal. Enter takes what stands in brackets; a dot takes it for all that is left.

Questions go to standard error, so that standard output has nothing but results.
"""

import os
import re
import sys
from collections.abc import Callable
from pathlib import Path

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.terminal import plain

Ask = Callable[[str], str]  # a question with its default; the answer as typed. Raises `EOFError` at the end
ALL = "."


def at_terminal() -> bool:
    """Whether a person is there to answer: at the keyboard and in front of what is printed, and not in CI."""
    streams = (sys.stdin, sys.stdout, sys.stderr)
    return os.environ.get("CI", "") in ("", "0", "false") and all(one is not None and one.isatty() for one in streams)


def at_keyboard(question: str) -> str:
    """Ask at the terminal. Raises `EOFError` for Ctrl-D, `KeyboardInterrupt` for Ctrl-C."""
    print(plain(question), end="", file=sys.stderr, flush=True)
    line = sys.stdin.readline()
    if not line:
        raise EOFError
    return line


class Interview:
    """Asks one question after the other, and again after an answer that is refused."""

    def __init__(self, ask: Ask, say: Callable[[str], object]) -> None:
        self._ask, self._say, self._all = ask, say, False

    def answer(self, asked: str, default: str, refuse: Callable[[str], object]) -> str:
        """The answer, or the default. ``refuse`` raises `UsageError` for one that is not good; a default is good."""
        while not self._all:
            answer = self._ask(f"{asked} [{default}]: ").strip()
            self._all = answer == ALL
            if answer in ("", ALL, default):
                break
            try:
                refuse(answer)
            except SpecError as error:
                self._say("; ".join(f"{fault.key}: {fault.message}" for fault in error.faults[:3]))
            except UsageError as error:
                self._say(str(error))
            else:
                return answer
        return default


def interview(kind: str, begin: Callable[[str], str], out: Path | None, talk: Interview) -> tuple[str, Path]:
    """The text of a spec as a person wants it, and its file.

    ``begin`` gives the text that begins from a preset or a spec; of an empty word that with a knob of one's own.
    """
    from hknob_cli.specs.preset import names
    from hknob_cli.specs.source import span_of
    from hknob_cli.specs.starter import WITH_SCENE, Question, answered, put, questions, refuse

    own, beside = "own", out.parent if out else Path()
    origin = own
    if kind in WITH_SCENE:

        def no_stream(given: str) -> None:
            if given == "-":
                raise UsageError("-: is standard input, which has the answers; name a file")
            begin(given)

        asked = f"Presets: {', '.join(names())}\nA knob of your own, a preset, or the file of a sweep"
        origin = talk.answer(asked, own, no_stream)
    text = begin("" if origin == own else origin)
    answers: dict[Question, str] = {}
    for one in questions(kind, text) if origin in (own, *names()) else ():  # a file has its answers

        def refuse_this(given: str, one: Question = one) -> None:
            refuse(kind, text, {**answers, one: given}, beside)

        answers[one] = talk.answer(one.asked, one.default, refuse_this)
    text = answered(kind, text, answers)
    if out is not None:
        return text, out
    begin_name, end_name = span_of(text, ("name",))
    out = Path(talk.answer("File to write", free(text[begin_name:end_name]), _refuse_taken))
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9._-]*", out.stem):  # the folder of the results has the file's name
        text = put(text, ("name",), out.stem)
    return text, out


def free(stem: str) -> str:
    """The name of a file that is not there yet."""
    count = 1
    while Path(name := f"{stem}.yaml" if count == 1 else f"{stem}-{count}.yaml").exists():
        count += 1
    return name


def _refuse_taken(name: str) -> None:
    if Path(name).exists():
        raise UsageError(f"{name}: is there already; name another file")
    if not Path(name).parent.is_dir():
        raise UsageError(f"{name}: no such folder")
