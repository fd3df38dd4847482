"""``hknob new``: write a commented spec to begin from, and ask at a terminal what it should say.

Questions go to standard error, so that standard output has nothing but results.
"""

import os
import re
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from hknob_cli.cli.options import Sets
from hknob_cli.errors import ExitCode, RefusedError, SpecError, UsageError, unwritable
from hknob_cli.specs.named_file import STDIN
from hknob_cli.stage_table import PIPELINE, SPECS
from hknob_cli.terminal import plain, reporting, say, tell

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


Kind = Annotated[
    str | None,
    typer.Argument(
        help=f"{', '.join(SPECS)}. Without one, they are listed.",
        show_default=False,
        metavar="[KIND]",
        autocompletion=lambda incomplete: [kind for kind in SPECS if kind.startswith(incomplete)],
    ),
]


def _presets(incomplete: str) -> list[str]:
    from hknob_cli.specs.preset import names

    return [name for name in names() if name.startswith(incomplete)]


def new(
    kind: Kind = None,
    preset: Annotated[
        str,
        typer.Option(
            "--from",
            metavar="PRESET|SPEC",
            help="A knob to begin from: a preset's name, the path of its file from the spec's folder, or a spec of a"
            " sweep or of remedies; - is a spec on standard input.",
            show_default=False,
            autocompletion=_presets,
        ),
    ] = "",
    remedy: Annotated[
        str | None,
        typer.Option(
            "--remedy",
            metavar="NAME",
            help="Of the spec of remedies that is named by --from: the remedy that the knob has.",
            show_default=False,
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="File to write, which must not exist.  [default: standard output]",
            show_default=False,
        ),
    ] = None,
    sets: Sets = None,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Ask nothing; take what a starter has.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Ask nothing and say nothing, except errors.")] = False,
) -> None:
    """Write a short commented spec to begin from; at a terminal, ask what it should have."""
    with reporting():
        from hknob_cli.specs.messages import unknown
        from hknob_cli.specs.starter import about

        if kind is None:
            wide = max(map(len, SPECS)) + 2
            said = "\n".join(f"{one:{wide}}{about(one)}" for one in SPECS)
            if preset or out or not sys.stdout.isatty():
                raise UsageError(f"KIND is missing: hknob new KIND. Kinds are\n{said}")
            tell(f"{said}\n\nnext: hknob new sweep")
            return
        if kind not in SPECS:
            raise UsageError(unknown("kind", kind, list(SPECS)))
        asks = not (yes or quiet or preset or sets or remedy) and at_terminal()
        if asks:
            text, out = _asked(kind, out)
        else:
            text = _text(kind, preset, out, tuple(sets or ()), remedy)
        if out is None:
            sys.stdout.write(text)
            return
        _write(out, text)
        if not quiet:
            say(f"wrote {out}")
        if asks:
            tell(f"\nnext: {shlex.join(['hknob', 'run' if kind == PIPELINE else kind, str(out)])}")


def _text(kind: str, preset: str, out: Path | None, sets: tuple[str, ...] = (), remedy: str | None = None) -> str:
    """The text of a spec. Raises `UsageError`."""
    from hknob_cli.specs.starter import starter

    beside = out.parent if out else Path()
    if (spec := _spec(preset)) is not None:
        from hknob_cli.stages.begin_from import begin_from

        return begin_from(kind, spec, out.stem if out else "", beside, sets, remedy)
    if remedy is not None:
        raise UsageError("--remedy: is one of a spec of remedies; name that by --from")
    if sets:
        raise UsageError("--set: changes a spec that another begins from; name it by --from")
    return starter(kind, preset, beside)


def _asked(kind: str, out: Path | None) -> tuple[str, Path]:
    """The text as a person at the terminal wants it, and its file. Raises `RefusedError` if the file is there."""
    if out is not None and (out.exists() or out.is_symlink()):
        raise _there(out)
    say("Enter takes what is in brackets; a dot takes it for all that is left.")
    try:
        return interview(kind, lambda origin: _text(kind, origin, out), out, Interview(at_keyboard, say))
    except (EOFError, KeyboardInterrupt):  # nothing is lost, so nothing is said
        say("")
        sys.exit(ExitCode.INTERRUPTED)


def _there(path: Path) -> RefusedError:
    return RefusedError(f"{path}: is there already, and stays as it is; name another file")


def _spec(given: str) -> Path | None:
    """The path of a spec that was given in place of a preset, if it is one."""
    if given == "-":
        return Path(STDIN)
    path = Path(given)
    if path.suffix not in (".yaml", ".yml") or not path.is_file():
        return None
    from hknob_cli.specs.load import kind_of

    return path if kind_of(path) is not None else None


def _write(path: Path, text: str) -> None:
    """Write a file that is not there yet, for good. Raises `RefusedError` if it is, else `ComputationError`."""
    from hknob_cli.results.files import sync_folder

    try:
        with path.open("x", encoding="utf-8") as file:
            try:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
                sync_folder(path.parent)
            except OSError:
                path.unlink(missing_ok=True)
                raise
    except FileExistsError:
        raise _there(path) from None
    except OSError as error:
        raise unwritable(path, error) from None
