"""The installed command without its start: one process loads the program, and forks another for each run.

Loading takes longer than most runs. A run is a process of its own, with its own arguments, folder, environment, output
and exit code. It differs from the installed command in what is loaded before it begins, and in what a library reads
only when it is loaded: a test about these starts the command itself.
"""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterable
from importlib import import_module
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryFile

HKNOB = Path(sys.executable).with_name("hknob")
# What the command sets before it loads anything.
FIRST = {"PYDANTIC_DISABLE_PLUGINS": "__all__", "OPENBLAS_NUM_THREADS": "1"}
MOST = 1 << 20  # bytes of a request
OFTEN = (
    "hknob_cli.cli.app",
    "hknob_cli.cli.main",
    "hknob_cli.cli.run_done",
    "hknob_cli.cli.stage_run",
    "hknob_cli.figures.plot",
    "hknob_cli.perception.level",
    "hknob_cli.pipeline.build",
    "hknob_cli.pipeline.side_by_side",
    "hknob_cli.pipeline.steps",
    "hknob_cli.specs.load",
    "hknob_cli.specs.remarks",
    "hknob_cli.specs.scene_paths",
    "hknob_cli.specs.pipeline",
    "hknob_cli.specs.remedies",
    "hknob_cli.specs.report",
    "hknob_cli.specs.starter",
    "hknob_cli.specs.sysid",
    "hknob_cli.stages.begin_from",
    "hknob_cli.stages.explain",
    "filelock",
    "jinja2",
    "matplotlib.backends.backend_agg",
    "multiprocessing.popen_fork",
    "pandas",  # which pyarrow looks for
    "pytask",
    "rich._emoji_codes",
    "scipy.optimize",
    "sqlalchemy.dialects.sqlite",
    "tomli_w",
    "typer._adapters",
)


class Forks:
    """Runs the command in forks of a process that has loaded it, one after the other.

    ``loader``: a program that loads it and then serves the socket whose number it is given.
    """

    def __init__(self, loader: str | Path = __file__) -> None:
        self._ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._loaded = subprocess.Popen(
                [sys.executable, str(loader), str(theirs.fileno())],
                env={**os.environ, **FIRST},
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                start_new_session=True,
            )

    def run(
        self, words: Iterable[str], *, cwd: Path, env: dict[str, str], timeout: float, given: bytes = b""
    ) -> tuple[int, str, str]:
        """Exit code, standard output and standard error, where ``given`` is on standard input.

        Raises `subprocess.TimeoutExpired`.
        """
        words = list(words)
        request = json.dumps([words, os.fspath(cwd), env]).encode()
        with (
            TemporaryFile() as into,
            TemporaryFile("w+", encoding="utf-8") as out,
            TemporaryFile("w+", encoding="utf-8") as err,
        ):
            into.write(given)
            into.seek(0)
            socket.send_fds(self._ours, [request], [into.fileno(), out.fileno(), err.fileno()])
            self._ours.settimeout(timeout)
            try:
                status = int(self._ours.recv(MOST))
            except TimeoutError:
                self.end()
                raise subprocess.TimeoutExpired(words, timeout) from None
            texts = []
            for file in (out, err):
                file.seek(0)
                texts.append(file.read())
        return os.waitstatus_to_exitcode(status), texts[0], texts[1]

    def end(self) -> None:
        """End the process, and whatever it runs."""
        self._ours.close()
        os.killpg(self._loaded.pid, signal.SIGKILL)
        self._loaded.wait()


def load() -> None:
    """Load what commands load."""
    from hknob_cli.engine.jit import GROUPS, compiled, is_kept, load_numba
    from hknob_cli.figures.theme import figure, library_defaults
    from hknob_cli.stage_table import STAGES

    for name in (*OFTEN, *(stage.work.partition(":")[0] for stage in STAGES.values())):
        import_module(name)
    load_numba()
    with library_defaults():
        one = figure(3.0)
        panel = one.subplots()
        panel.plot([1.0, 2.0], label="one")
        panel.set(title="$1$", xlabel="x", xscale="log")  # with text in fonts of its own
        one.legend(loc="outside lower center")
        for kind in ("png", "svg"):
            one.savefig(BytesIO(), format=kind)
    build()
    for group in GROUPS:
        if is_kept(group):  # what each run would load again
            compiled(group)


def build() -> None:
    """Make what is put off until it is needed, and each run would make again.

    Models of specs, the commands, the table of units, and digests of the source: it must not change while tests run.
    """
    import typer.main
    from PIL import Image
    from pydantic import BaseModel

    from hknob_cli.cli.app import app
    from hknob_cli.results.versions import showing_versions
    from hknob_cli.specs.quantity import to_si

    models = [BaseModel]
    for model in models:  # grows
        models += model.__subclasses__()
        if model.__module__.startswith("hknob_cli.") and not model.__pydantic_complete__:
            model.model_rebuild()
    command = typer.main.get_command(app)
    typer.main.get_command = lambda _app: command
    to_si("1 ms", "s")
    showing_versions()
    Image.init()


def serve(ours: socket.socket) -> None:
    """Run what is asked for until nobody asks."""
    while True:
        request, files, _, _ = socket.recv_fds(ours, MOST, 3)
        if not request:
            return
        child = os.fork()
        if child == 0:
            ours.close()
            become(*json.loads(request), *files)
        for file in files:
            os.close(file)
        ours.send(str(os.waitpid(child, 0)[1]).encode())


def become(words: list[str], folder: str, environment: dict[str, str], *files: int) -> None:
    """Be the installed command; does not return."""
    from hknob_cli import at_once
    from hknob_cli.cli.main import main

    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv, sys.path[0] = [str(HKNOB), *words], str(HKNOB.parent)
    own = sys.modules["__main__"]
    own.__file__, own.__spec__ = str(HKNOB), None
    at_once.listen()
    main()


if __name__ == "__main__":
    load()
    serve(socket.socket(fileno=int(sys.argv[1])))
