"""The entry point: starts light, parses, works, and leaves without tearing down."""

from hknob_cli import at_once

at_once.listen()  # before all else is loaded

# ruff: noqa: E402
import gc
import os
import sys
from typing import NoReturn

from hknob_cli.cli import handover


def _parse() -> NoReturn:
    """Run the command line in this process."""
    from hknob_cli.cli.app import app

    code: object = 0
    try:
        app()
    except SystemExit as leaving:
        code = leaving.code
    _leave(code if isinstance(code, int) else 0 if code is None else 1)


def _leave(code: int) -> NoReturn:
    """End the process; freeing every module first would take as long as a small sweep."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError as error:  # nobody reads on, or the disk behind it is full
            code = code or 1
            if stream is sys.stdout and not isinstance(error, BrokenPipeError):
                print(f"standard output cannot be written: {error.strerror}", file=sys.stderr)
    os._exit(code)


def _already_done(arguments: list[str]) -> bool:
    """Whether there is nothing to do, and that is said."""
    from hknob_cli.cli.run_done import already_done

    try:
        return already_done(arguments)
    except SystemExit as leaving:
        _leave(int(leaving.code or 0))


def main() -> NoReturn:
    """Run the command line."""
    # Start-up: the collector would walk the modules as they load, and pydantic would open the metadata of every
    # installed package to look for plugins.
    gc.disable()
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # The engine's largest matrix is 3 x 3: threads of a linear algebra library would only spin beside it.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by whoever started us
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115, PTH123
        getattr(sys, name).reconfigure(errors="backslashreplace")  # a terminal may not have every letter
    arguments = sys.argv[1:]
    if arguments[:1] == ["run"] and _already_done(arguments):
        _leave(0)
    if handover.pays(arguments):
        _leave(handover.parse_and_run(_parse, arguments[0]))
    _parse()
