"""The entry point: starts light, parses, works, and leaves without tearing down."""

import gc
import os
import signal
import sys
from types import FrameType
from typing import NoReturn

from hknob_cli.cli import handover


def _interrupt(_signal: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt


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
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def main() -> NoReturn:
    """Run the command line."""
    # Start-up: the collector would walk the modules as they load, and pydantic would open the metadata of every
    # installed package to look for plugins.
    gc.disable()
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # The engine's largest matrix is 3 x 3: threads of a linear algebra library would only spin beside it.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    signal.signal(signal.SIGTERM, _interrupt)
    arguments = sys.argv[1:]
    if handover.pays(arguments):
        _leave(handover.parse_and_run(_parse, arguments[0]))
    _parse()
