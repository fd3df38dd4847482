"""A wire to try: what a host does and what it hears, line by line; frames are whole, what they say need not be so."""

from random import Random
from typing import NamedTuple

COMMANDS = ("hello", "configure", "simulate", "arm", "start", "stop", "release")
GOLDEN = (
    "hello",
    "configure",
    "arm",
    "alive",
    "again",
    "ack_of_hello",
    "ack_of_arm",
    "block_of_2",
    "block_of_48",
    "event",
)
WAITS = ("0", "1e-6", "0.001", "0.005", "0.01", "0.03", "0.11", "1.1", "2.5", "70", "-0.05", "1e9")


class FrameCase(NamedTuple):
    """Lines as bytes: ``command NAME``, ``wait SECONDS``, ``take``, and what comes in, with changes of its bytes.

    ``answer STATUS STATE FAULT BLOCKS`` to the last command, ``block AHEAD COUNT`` of those expected, ``event FAULT
    BLOCKS``, ``golden NAME``, ``body HEX``; after each a change: ``-``, ``set:AT:VALUE``, ``cut:COUNT``, ``add:HEX``.
    """

    kind: str
    data: bytes


def frame_case(dice: Random) -> FrameCase:
    """A trial that begins as it should, as a rule, and what may follow."""
    lines: list[str] = []
    if dice.random() < 0.8:
        for command in ("hello", "configure", "arm"):
            state = "1" if command == "arm" else "0"
            lines += [f"command {command}", f"answer 0 {state} 0 0 {_change(dice) if dice.random() < 0.05 else '-'}"]
    if dice.random() < 0.6:
        lines += ["command start", "answer 0 2 0 0 -"]
    lines += [_line(dice) for _ in range(dice.randint(1, 40))]
    return FrameCase("session", "\n".join(lines).encode())


def _line(dice: Random) -> str:
    match dice.randrange(12):
        case 0:
            return f"command {dice.choice(COMMANDS)}"
        case 1:
            return f"wait {dice.choice(WAITS)}"
        case 2:
            return "take"
        case 3 | 4:
            numbers = (dice.choice((0, 0, 0, 1, 2, 3, 4, 255)) for _ in range(3))
            return f"answer {' '.join(map(str, numbers))} {_number(dice)} {_change(dice)}"
        case 5:
            return f"event {dice.choice((0, 1, 2, 5, 6, 255))} {_number(dice)} {_change(dice)}"
        case 6:
            return f"golden {dice.choice(GOLDEN)} {_change(dice)}"
        case 7:
            return f"body {dice.randbytes(dice.choice((1, 2, 3, 30, 200))).hex()} -"
    ahead = dice.choice((0, 0, 0, 0, 0, 1, 1, 2, 3, -1, 255, 256, 257, 4_294_967_295))
    return f"block {ahead} {dice.choice((1, 2, 40, 48))} {_change(dice)}"


def _number(dice: Random) -> int:
    return dice.choice((0, 1, 2, 3, 10, 2**31, 2**32 - 1))


def _change(dice: Random) -> str:
    """What is done to the body of a frame before it is sealed."""
    match dice.randrange(6):
        case 0:
            return f"set:{dice.randrange(64)}:{dice.choice((0, 1, 127, 128, 255, dice.randrange(256)))}"
        case 1 if dice.random() < 0.5:
            return f"cut:{dice.choice((1, 2, 17))}"
        case 2 if dice.random() < 0.5:
            return f"add:{dice.randbytes(dice.choice((1, 17))).hex()}"
    return "-"
