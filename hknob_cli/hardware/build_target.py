"""Building the reference target from the C sources beside this file: as a process of this machine, or for QEMU."""

import hashlib
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Literal, get_args

from hknob_cli.errors import DeviceError, UsageError

SOURCES = Path(__file__).parent / "firmware"
Target = Literal["host", "qemu"]

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow")
# The same arithmetic everywhere: no multiplication and addition in one rounding.
ARITHMETIC = ("-O2", "-ffp-contract=off")
PORTABLE = ("frame.c", "messages.c", "wall.c", "record.c", "loop.c", "target.c")
SIMULATED = ("plant.c", "simulated_knob.c")
CORTEX_M3 = ("-mcpu=cortex-m3", "-mthumb", "-ffunction-sections", "-fdata-sections", "-nostartfiles")

NEEDS = {
    "host": "a C compiler (Debian: apt install gcc libc6-dev; or set CC)",
    "qemu": "arm-none-eabi-gcc with newlib (Debian: apt install gcc-arm-none-eabi libnewlib-arm-none-eabi)",
}


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


def build_target(target: Target, folder: Path) -> Path:
    """The built target in a folder, which is made; built if its sources or the compiler have changed.

    The name holds a digest of all that it is made from. Built beside its place and renamed, so that two at once do not
    meet. Raises `UsageError` for an unknown target, `DeviceError` if there is no compiler, or it fails.
    """
    if target not in NEEDS:
        raise UsageError(f"unknown target '{target}'; there are {', '.join(NEEDS)}")
    command = [*compiler(target), *options(target)]
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
