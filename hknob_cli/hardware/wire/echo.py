"""What was sent and what the target says it took, compared value by value, bit by bit."""

import struct
from typing import Any

from hknob_cli.hardware.port import Settings
from hknob_cli.hardware.simulated import Simulated, Sine


def differences(sent: Settings | Simulated, taken: object) -> list[str]:
    """One text for each value that differs: its name, sent, taken."""
    if type(taken) is not type(sent):
        return ["the target did not say what it took"]
    ours, theirs = _flat(sent), _flat(taken)
    return [
        f"{name} sent {_shown(ours.get(name))}, taken {_shown(theirs.get(name))}"
        for name in sorted(ours.keys() | theirs.keys())
        if _bits(ours.get(name)) != _bits(theirs.get(name))
    ]


def _flat(values: Any) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in values._asdict().items():
        if isinstance(value, tuple):
            for index, sine in enumerate(value):
                flat |= {f"{name}[{index}].{part}": getattr(sine, part) for part in Sine._fields}
        else:
            flat[name] = value
    return flat


def _bits(value: Any) -> bytes:
    return b"" if value is None else struct.pack("<d", value)


def _shown(value: Any) -> str:
    return "nothing" if value is None else repr(value)
