"""Four readers of what others write, each fed bytes: specs, sessions on a wire, ledgers of claims, recordings.

Each raises what must not be: anything but the program's own errors, a message that would steer a terminal, a sample
that is no number. They load what they need, so that who looks at the code that they reach can prepare it first.
"""

import base64
import contextlib
from collections.abc import Callable
from pathlib import Path

GUIDED = Path(__file__).parent / "corpus" / "guided"
MOST_BYTES = {"spec": 2000, "session": 400, "claims": 2000, "recording": 1500}  # of an input
MOST_KEPT = 150  # inputs of a target
WAITS = ("0", "0.001", "0.03", "0.11", "1.1", "70", "-0.05", "1e9")
FOLDER = Path.cwd()  # where files are written that are read at once; whoever feeds them chooses it


class RuleError(Exception):
    """What must not be."""


def said(error: Exception) -> None:
    """What is said of a fault, which must be fit to be read."""
    text = str(error)
    if not text.strip() or any(not line.isprintable() for line in text.split("\n")):
        raise RuleError(f"not to be read: {text[:200]!r}")


def spec(data: bytes) -> None:
    """A spec of any kind, from text to a plan."""
    from hknob_cli.errors import HknobError
    from hknob_cli.specs.load import validate
    from hknob_cli.specs.source import parse

    try:
        plan = validate(parse(data.decode("utf-8", "replace"), "spec.yaml"))
    except HknobError as error:
        said(error)
        return
    if not isinstance(plan.name, str) or not plan.values:
        raise RuleError(f"a plan of nothing: {plan!r}"[:200])


def claims(data: bytes) -> None:
    """A ledger of claims, with the arguments of their checks."""
    from hknob_cli.errors import HknobError
    from hknob_cli.page.claims.ledger import load_ledger

    path = FOLDER / "claims.yaml"
    path.write_bytes(data)
    try:
        ledger = load_ledger(path)
    except HknobError as error:
        said(error)
        return
    for claim in ledger.claims:
        for bounds in (claim.holds, claim.near):
            if bounds and (claim.printed is not None or not bounds.relative):
                bounds.hold(0.0, claim.printed)


def session(data: bytes) -> None:
    """A session: what the host does and what it hears, a few bytes each."""
    from tests.fuzz.frame_attempt import Wire
    from tests.fuzz.frame_case import COMMANDS, GOLDEN

    wire, left = Wire(), bytearray(data)

    def number() -> int:
        return left.pop(0) if left else 0

    def change() -> str:
        match number() % 8:
            case 0:
                return f"set:{number()}:{number()}"
            case 1:
                return f"cut:{1 + number() % 17}"
            case 2:
                return f"add:{bytes((number(), number())).hex()}"
        return "-"

    while left:
        match number() % 10:
            case 0:
                wire.do(["command", COMMANDS[number() % len(COMMANDS)]])
            case 1:
                wire.do(["wait", WAITS[number() % len(WAITS)]])
            case 2:
                wire.do(["take"])
            case 3:
                wire.do(["answer", *(str(number()) for _ in range(4)), change()])
            case 4 | 5:
                wire.do(["block", str(number()), str(1 + number() % 48), change()])
            case 6:
                wire.do(["event", str(number()), str(number()), change()])
            case 7:
                wire.do(["golden", GOLDEN[number() % len(GOLDEN)], change()])
            case _:
                size = 1 + number()
                body, left[:size] = bytes(left[:size]), b""
                wire.do(["body", body.hex(), "-"])
        for rule, detail in wire.wrong():
            raise RuleError(f"{rule}: {detail}")


def recording(data: bytes) -> None:
    """A recording: rows of text; or, by the first byte, the journal of a trial, whose records are as they are said."""
    (journal if data[:1] == b"\0" else rows)(data)


def rows(data: bytes) -> None:
    """Rows of text."""
    import numpy as np

    from hknob_cli.errors import HknobError
    from hknob_cli.recordings.read import read

    path = FOLDER / "recording.csv"
    path.write_bytes(data)
    try:
        found = read([path])
    except HknobError as error:
        said(error)
        return
    for trial in found:
        if not all(np.isfinite(one).all() for one in (trial.time_s, trial.torque_nm, trial.angle_rad)):
            raise RuleError("a sample is no number")
        if not (np.diff(trial.time_s) > 0.0).all():
            raise RuleError("the time does not rise")


def journal(data: bytes) -> None:
    """Records of a journal, each whole, and what of them is kept when a trial was broken off."""
    import zlib

    from hknob_cli.hardware.archive import _broken_off
    from hknob_cli.hardware.journal import _HEAD, MAGIC, read_journal
    from hknob_cli.hardware.order import Trial

    left, content = data[1:], MAGIC
    while left:
        size, record = left[0], left[1 : 1 + left[0]]
        content += _HEAD.pack(len(record), zlib.crc32(record)) + record
        left = left[1 + size :]
    path = FOLDER / "trial.part"
    path.write_bytes(content)
    found = read_journal(path)
    if found is not None and found.blocks:
        _broken_off(found, Trial(1, 1, 1000.0, 512))


TARGETS: dict[str, Callable[[bytes], None]] = {
    "spec": spec,
    "session": session,
    "claims": claims,
    "recording": recording,
}


def quietly(target: Callable[[bytes], None], data: bytes) -> Exception | None:
    """What a target raises."""
    with contextlib.redirect_stdout(None), contextlib.redirect_stderr(None):
        try:
            target(data)
        except Exception as error:
            return error
    return None


def kept(name: str) -> list[bytes]:
    """The inputs of a target that are kept."""
    path = GUIDED / f"{name}.txt"
    return [base64.b64decode(line) for line in path.read_text().split()] if path.exists() else []
