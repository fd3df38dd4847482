"""Running a built target: a process of this machine, or a Cortex-M3 under QEMU, behind a pseudo-terminal."""

import contextlib
import os
import select
import shutil
import signal
import subprocess
import sys
import time
import zlib
from collections.abc import Iterator
from pathlib import Path

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.build_target import Target, build_target

QEMU = "qemu-system-arm"
NEEDS_QEMU = f"{QEMU} (Debian: apt install qemu-system-arm)"
BOOT_WORD = 0x203FFFF0  # see firmware/board_qemu.c
# 8 ns an instruction, asleep by this machine's clock: a sample takes the same time whether this machine is busy or not.
EMULATED_SPEED = "shift=3"
READY_WITHIN_S = 10.0
PRIORITY = 20


@contextlib.contextmanager
def run_target(target: Target, folder: Path) -> Iterator[str]:
    """Build a target into a folder if need be, run it, and give the path of its serial line; ended afterwards.

    It ends with this process too, however that ends. To be used from a thread that lives as long. Raises `DeviceError`
    if it cannot be built or does not start; `UsageError` for an unknown target.
    """
    if sys.platform == "win32":
        raise DeviceError(f"the target '{target}' cannot be run: it needs a pseudo-terminal, which Windows has not")
    with contextlib.ExitStack() as stack:
        if target == "qemu" and shutil.which(QEMU) is None:
            raise DeviceError(f"the target 'qemu' cannot be run: it needs {NEEDS_QEMU}")
        program = build_target(target, folder)
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
