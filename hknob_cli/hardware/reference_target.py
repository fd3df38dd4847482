"""The reference target: built from the C sources beside this file, and run as a process or under QEMU.

Building the reference target from the C sources beside this file: as a process of this machine, or for QEMU.
"""

import contextlib
import hashlib
import os
import select
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Literal, get_args

from hknob_cli.errors import DeviceError, UsageError

SOURCES = Path(__file__).parent / "firmware"
Target = Literal["host", "qemu"]

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow")
# The same arithmetic everywhere: no multiplication and addition in one rounding.
ARITHMETIC = ("-O2", "-ffp-contract=off")
PORTABLE = (
    *("frame.c", "messages.c", "acts.c", "ranges.c", "wall.c", "law.c", "law_speeds.c", "pulse.c"),
    *("over_angle.c", "convert.c", "line.c", "record.c", "loop.c", "target.c"),
)
SIMULATED = ("plant.c", "squeeze.c", "simulated_knob.c")
CORTEX_M3 = ("-mcpu=cortex-m3", "-mthumb", "-ffunction-sections", "-fdata-sections", "-nostartfiles")

NEEDS = {
    "host": "a C compiler (Debian: apt install gcc libc6-dev; or set CC)",
    "qemu": "arm-none-eabi-gcc with newlib (Debian: apt install gcc-arm-none-eabi libnewlib-arm-none-eabi)",
}

QEMU = "qemu-system-arm"
NEEDS_QEMU = f"{QEMU} (Debian: apt install qemu-system-arm)"
BOOT_WORD = 0x203FFFF0  # see firmware/board_qemu.c
# 8 ns an instruction, asleep by this machine's clock: a sample takes the same time whether this machine is busy or not.
EMULATED_SPEED = "shift=3"
READY_WITHIN_S = 10.0
PRIORITY = 20


def compiler(target: Target) -> list[str]:
    """The compiler of a target and the options in ``$CC``, if any. Raises `DeviceError` that names what to install."""
    if target == "qemu":
        names = ["arm-none-eabi-gcc"]
    else:
        names = [os.environ["CC"]] if os.environ.get("CC") else ["cc", "gcc", "clang"]
    for name in names:
        command = shlex.split(name)
        if command and shutil.which(command[0]):
            return command
    raise DeviceError(f"the target '{target}' cannot be built: it needs {NEEDS[target]}; tried {', '.join(names)}")


def build_target(target: Target, folder: Path, *, slower: int = 1) -> Path:
    """The built target in a folder, which is made; built if its sources or the compiler have changed.

    The name holds a digest of all that it is made from. Built beside its place and renamed, so that two at once do not
    meet. ``slower``: how many times the clock of the target ``host`` is slower than this computer's. Raises
    `UsageError` for an unknown target, `DeviceError` if there is no compiler, or it fails.
    """
    if target not in NEEDS:
        raise UsageError(f"unknown target '{target}'; there are {', '.join(NEEDS)}")
    command = [*compiler(target), *options(target)]
    if target == "host" and slower > 1:
        command.append(f"-DSLOWER={slower}u")
    place = folder.absolute() / f"hknob-target-{target}-{_digest(command)}"
    if place.exists():
        return place
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".building-", dir=place.parent) as beside:
            made = Path(beside) / place.name
            command += ["-o", str(made), *libraries(target)]
            done = subprocess.run(command, capture_output=True, text=True, cwd=SOURCES)
            if done.returncode != 0:
                raise DeviceError(f"the target '{target}' cannot be built by {command[0]}: {_first_error(done.stderr)}")
            made.replace(place)
    except OSError as error:
        raise DeviceError(f"the target '{target}' cannot be built in {folder}: {error.strerror}") from error
    return place


def options(target: Target) -> list[str]:
    """How a target is compiled, and its sources by their names in `SOURCES`."""
    board = ["board_host.c"] if target == "host" else ["board_qemu.c", "startup_qemu.c"]
    machine = ["-pthread"] if target == "host" else [*CORTEX_M3, "-Wl,--gc-sections", "-T", "qemu.ld"]
    return [*STRICT, *ARITHMETIC, *machine, *PORTABLE, *SIMULATED, *board]


def libraries(target: Target) -> list[str]:
    """What it is linked with, after its sources."""
    return ["-lm"] if target == "host" else ["--specs=nosys.specs", "-lm"]


def _digest(command: list[str]) -> str:
    """Of the sources and of how they are compiled; the compiler by its path, size and date, which change with it."""
    digest = hashlib.sha256()
    program = Path(shutil.which(command[0]) or command[0]).resolve()
    status = program.stat()
    digest.update(repr((command, str(program), status.st_size, status.st_mtime_ns)).encode())
    for path in sorted(SOURCES.iterdir()):
        if path.suffix in (".c", ".h", ".ld"):
            digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]


def _first_error(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if "error" in line] or text.strip().splitlines()
    return lines[0] if lines else "no message"


@contextlib.contextmanager
def run_target(target: Target, folder: Path, *, slower: int = 1) -> Iterator[str]:
    """Build a target into a folder if need be, run it, and give the path of its serial line; ended afterwards.

    It ends with this process too, however that ends. To be used from a thread that lives as long. ``slower``: see
    `build_target`. Raises `DeviceError` if it cannot be built or does not start; `UsageError` for an unknown target.
    """
    if sys.platform == "win32":
        raise DeviceError(f"the target '{target}' cannot be run: it needs a pseudo-terminal, which Windows has not")
    with contextlib.ExitStack() as stack:
        if target == "qemu" and shutil.which(QEMU) is None:
            raise DeviceError(f"the target 'qemu' cannot be run: it needs {NEEDS_QEMU}")
        program = build_target(target, folder, slower=slower)
        yield _run_host(program, stack) if target == "host" else _run_qemu(program, stack)


def _run_host(program: Path, stack: contextlib.ExitStack) -> str:
    """A process that says the path of its own pseudo-terminal; it ends when its standard input does."""
    process = _start([str(program)], stack, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdout is not None
    readable, _, _ = select.select([process.stdout], [], [], READY_WITHIN_S)
    line = process.stdout.readline().decode().strip() if readable else ""
    if not line:
        raise DeviceError(f"the target 'host' did not start: {_last_words(process)}")
    return line


def _run_qemu(image: Path, stack: contextlib.ExitStack) -> str:
    """A Cortex-M3 whose UART is a pseudo-terminal that is opened here.

    Both its ends stay open here while it runs: QEMU gives up a terminal that nobody has open, and asks only once a
    second whether somebody has again.
    """
    import pty
    import termios
    import tty

    ours, theirs = pty.openpty()
    stack.callback(os.close, ours)
    stack.callback(os.close, theirs)
    tty.setraw(theirs)
    # QEMU switches output processing on again; without a flag it does nothing.
    attributes = termios.tcgetattr(theirs)
    attributes[1] = 0
    termios.tcsetattr(theirs, termios.TCSANOW, attributes)
    process = _start(
        [
            *(QEMU, "-machine", "mps2-an385", "-nodefaults", "-no-user-config", "-display", "none", "-monitor", "none"),
            *("-chardev", "stdio,id=uart,signal=off", "-serial", "chardev:uart", "-kernel", str(image)),
            *("-icount", EMULATED_SPEED),
            *("-device", f"loader,addr={BOOT_WORD:#x},data={int.from_bytes(os.urandom(4)):#x},data-len=4"),
        ],
        stack,
        stdin=ours,
        stdout=ours,
    )
    _wait_for_answer(theirs, process)
    return os.ttyname(theirs)


def _wait_for_answer(line: int, process: subprocess.Popen[bytes]) -> None:
    """Greet a target until it answers, then wait until it is silent: what comes later is for the host."""
    end = time.monotonic() + READY_WITHIN_S
    greeting = _greeting()
    while time.monotonic() < end and process.poll() is None:
        os.write(line, b"\0" + greeting)
        if select.select([line], [], [], 0.2)[0]:
            while select.select([line], [], [], 0.05)[0]:
                os.read(line, 4096)
            return
    raise DeviceError(f"the target 'qemu' did not start: {_last_words(process)}")


def _greeting() -> bytes:
    """A HELLO whose body and CRC have no zero byte, so that stuffing only puts their length before them."""
    body = b"\x01\x01hknb"
    checked = body + zlib.crc32(body).to_bytes(4, "little")
    assert 0 not in checked
    return bytes([len(checked) + 1]) + checked + b"\0"


def _start(command: list[str], stack: contextlib.ExitStack, *, stdin: int, stdout: int) -> "subprocess.Popen[bytes]":
    """Start a process that the kernel ends with its parent, in a session of its own: Ctrl-C is for the host alone."""
    try:
        process = subprocess.Popen(
            command,
            stdin=stdin,
            stdout=stdout,
            stderr=subprocess.PIPE,
            start_new_session=True,
            preexec_fn=_settle if sys.platform == "linux" else None,
        )
    except OSError as error:
        raise DeviceError(f"the target {command[0]} cannot be run: {error.strerror}") from error
    stack.callback(_end, process)
    return process


def _settle() -> None:
    """Ask Linux for a signal when the parent has ended, and for real-time priority; called in the child."""
    import ctypes

    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))


def _end(process: "subprocess.Popen[bytes]") -> None:
    process.terminate()
    try:
        process.wait(2.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    for stream in (process.stdin, process.stdout, process.stderr):
        if stream is not None:
            stream.close()


def _last_words(process: "subprocess.Popen[bytes]") -> str:
    """What it wrote to its standard error, or how it ended, or that it is silent."""
    try:
        code = process.wait(0.5)
    except subprocess.TimeoutExpired:
        return f"no answer within {READY_WITHIN_S:g} s"
    assert process.stderr is not None
    lines = process.stderr.read().decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else f"it ended with {code}"


def main(folder: str) -> None:
    """Build every target into a folder, and say where it is or what it needs; ends with 1 if one cannot be built."""
    missing = False
    for target in get_args(Target):
        try:
            print(f"{target}: {build_target(target, Path(folder))}")
        except DeviceError as error:
            print(f"{target}: {error}", file=sys.stderr)
            missing = True
    sys.exit(missing)


if __name__ == "__main__":
    main(*sys.argv[1:])
