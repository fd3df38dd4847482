"""A command under way: sent again until it is answered, what the target took of it, and the state it leaves it in.

It is sent again unchanged every 30 ms, and given up after five times more. A target whose clock is not this computer's
gets it every half second. What was sent and what the target says it took are compared value by value, bit by bit.
"""

import struct
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from hknob_cli.hardware.grip_trigger import pulse_of
from hknob_cli.hardware.port import Block, Settings, Simulated, Sine
from hknob_cli.hardware.wire.acts import Act, pieces_of
from hknob_cli.hardware.wire.answers import Ack, Samples
from hknob_cli.hardware.wire.codes import Kind, State, Status
from hknob_cli.hardware.wire.commands import Command, Configure, SetAct, Simulate

Sent = Settings | Simulated | Act

NO_SENSORS = (None, None, True)  # as a person is who has none
AGAIN_AFTER_S = 0.03
# An emulator on a busy computer may need a multiple of that for a long message, and would have to read each copy too.
OWN_TIME_AGAIN_AFTER_S = 0.5
TIMES_AGAIN = 5

# After these a target that did as it was told is in this state. One that trips meanwhile, armed or running, says so.
_AFTER = {
    Kind.CONFIGURE: (State.IDLE,),
    Kind.SIMULATE: (State.IDLE,),
    Kind.ZERO: (State.IDLE,),
    Kind.CONTROL: (State.IDLE,),
    Kind.PULSE: (State.IDLE,),
    Kind.SQUEEZE: (State.IDLE,),
    Kind.OVER_ANGLE: (State.IDLE,),
    Kind.TORQUES: (State.IDLE,),
    Kind.CONVERTERS: (State.IDLE,),
    Kind.ARM: (State.ARMED, State.TRIPPED),
    Kind.START: (State.RUNNING, State.TRIPPED),
    Kind.STOP: (State.IDLE,),
    Kind.RELEASE: (State.IDLE,),
}


def told_of(settings: Settings, simulated: Simulated | None) -> Iterator[tuple[Sent, Callable[[int], Command]]]:
    """What a target is told of a trial, in its order, each with how it is sent; what it took is compared with each.

    CONFIGURE comes first, by which it forgets what acted before; SQUEEZE after SIMULATE, by which it forgets who did.
    """
    acts: list[Act] = [one for one in (settings.converters, settings.control) if one is not None]
    if settings.pulse is not None:
        acts.append(pulse_of(settings.pulse, settings.interval_s))
    if settings.over_angle is not None:
        table, pieces = pieces_of(settings.over_angle)
        acts += [table, *pieces]
    yield settings.plain, partial(Configure, settings=settings.plain)
    yield from ((act, partial(SetAct, act=act)) for act in acts)
    if simulated is not None:
        knob = simulated._replace(squeeze=())
        yield knob, partial(Simulate, simulated=knob)
        if simulated.squeeze:
            squeeze = simulated.squeeze._replace(sensors=NO_SENSORS)  # a target has no such sensors
            yield squeeze, partial(SetAct, act=squeeze)


class Sending:
    """A command that has no answer yet. The caller says what time it is, in seconds of any clock."""

    def __init__(self, *, nonce: int, kind: Kind, data: bytes, own_time: bool) -> None:
        self.nonce = nonce
        self.kind = kind
        self._again_after_s = OWN_TIME_AGAIN_AFTER_S if own_time else AGAIN_AFTER_S
        self._data = data
        self._sent = 0
        self._next = -float("inf")

    def due(self, now: float) -> bytes:
        """The frame, if it is to be sent now; else nothing."""
        if now < self._next or self._sent > TIMES_AGAIN:
            return b""
        self._sent += 1
        self._next = now + self._again_after_s
        return self._data

    def is_given_up(self, now: float) -> bool:
        """Whether the last sending has had its time too."""
        return self._sent > TIMES_AGAIN and now >= self._next


def wrong_state(ack: Ack) -> str:
    """What is wrong with the state in an answer; empty if nothing is."""
    told = Kind(ack.of)
    if ack.status is not Status.DONE or ack.state in _AFTER.get(told, tuple(State)):
        return ""
    wanted = _AFTER[told][0].name.lower()
    return f"the target acknowledged {told.name}, but says that it is {ack.state.name.lower()}, and not {wanted}"


def shows_torque(block: Block) -> bool:
    """Whether any sample of a block has the wall on, or a torque."""
    return bool(block.running.any() or (block.torque_nm != 0.0).any())


class AfterRelease:
    """What a target shows after it was told to release: ``seen`` is empty where nothing speaks against it."""

    def __init__(self, *, boot: int | None) -> None:
        self.seen = ""
        self.acknowledged = False
        self._boot = boot

    def answer(self, ack: Ack) -> None:
        """The answer to RELEASE."""
        self._boot = ack.boot
        if ack.status is not Status.DONE:
            self.seen = f"the target refused RELEASE, and says that it is {ack.state.name.lower()}"
        else:
            self.seen = wrong_state(ack)
        self.acknowledged = True

    def samples(self, samples: Samples) -> None:
        """A block that came; those from before the answer may have been under way."""
        if self.acknowledged and not self.seen and samples.boot == self._boot and shows_torque(samples.samples):
            what = "the wall on" if samples.samples.running.any() else "a torque"
            self.seen = f"the target acknowledged RELEASE, but goes on sending samples with {what}"


def differences(sent: Sent, taken: object) -> list[str]:
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
            for index, one in enumerate(value):
                parts = one._asdict() if isinstance(one, Sine) else _numbered(one)
                flat |= {f"{name}[{index}]{part and f'.{part}'}": number for part, number in parts.items()}
        else:
            flat[name] = value
    return flat


def _numbered(one: Any) -> dict[str, Any]:
    """A number by no name; those of a row, which has no names, by their places."""
    return {str(place): number for place, number in enumerate(one)} if isinstance(one, tuple) else {"": one}


def _bits(value: Any) -> bytes:
    return b"" if value is None else struct.pack("<d", value)


def _shown(value: Any) -> str:
    return "nothing" if value is None else repr(value)
