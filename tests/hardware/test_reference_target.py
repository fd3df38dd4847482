"""The reference target without a compiler: what is said where there is none or it fails, and how it is greeted."""

import socket
import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware import reference_target
from hknob_cli.hardware.reference_target import _first_error, _greeting, _wait_for_answer, build_target, compiler
from hknob_cli.hardware.wire.codes import Kind
from hknob_cli.hardware.wire.messages import Decoder


def test_a_compiler_is_one_that_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of those that are tried; that of $CC with its options."""
    there = {"gcc": "/usr/bin/gcc", "clang": "/usr/bin/clang", "mine": "/opt/mine"}
    monkeypatch.setattr(reference_target.shutil, "which", there.get)
    monkeypatch.delenv("CC", raising=False)
    assert compiler("host") == ["gcc"]
    monkeypatch.setenv("CC", "mine -m32 'a b'")
    assert compiler("host") == ["mine", "-m32", "a b"]
    for missing in ("yours", " "):
        monkeypatch.setenv("CC", missing)
        with pytest.raises(DeviceError, match="it needs a C compiler"):
            compiler("host")


def test_the_first_error_is_told() -> None:
    assert _first_error("") == "no message"
    assert _first_error("\n  something\n else\n") == "something"
    assert _first_error("a warning\n  x.c:3: error: here\n y.c: error: there\n") == "x.c:3: error: here"


@pytest.mark.parametrize("code", [0, 1])
def test_a_target_is_built_beside_its_place(code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And put there once it is whole; nothing is left of one that could not be built."""
    program = tmp_path / "compiler"
    program.write_text("")
    monkeypatch.setattr(reference_target, "compiler", lambda _target: [str(program)])
    built: list[Path] = []

    def run(command: list[str], **_options: Any) -> Any:
        place = Path(command[command.index("-o") + 1])
        built.append(place)
        place.write_text("whole" if code == 0 else "part")
        return SimpleNamespace(returncode=code, stderr="x.c:3: error: here\n")

    monkeypatch.setattr(subprocess, "run", run)
    folder = tmp_path / "built"
    if code:
        with pytest.raises(DeviceError, match=r"cannot be built by .*: x\.c:3: error: here"):
            build_target("host", folder)
        assert list(folder.iterdir()) == []
        return
    place = build_target("host", folder)
    assert place.read_text() == "whole"
    assert list(folder.iterdir()) == [place]
    assert (built[0].name, built[0].parent.parent) == (place.name, folder)
    assert build_target("host", folder) == place  # which is there
    assert len(built) == 1


def test_a_target_is_greeted_until_it_answers() -> None:
    """By a frame with a HELLO, after a byte that ends whatever came before; what it says is read away."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(b"an answer")
        process: Any = SimpleNamespace(poll=lambda: None)
        _wait_for_answer(ours.fileno(), process)
        heard = theirs.recv(4096)
        assert heard == b"\0" + _greeting()
        ours.setblocking(False)
        with pytest.raises(BlockingIOError):
            ours.recv(1)
    (body,) = Decoder().feed(b"\1\2" + heard)[-1:]
    assert body[1] == Kind.HELLO
