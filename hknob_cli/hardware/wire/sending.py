"""What a session waits for: a command sent until it is answered, and the blocks of a run put in order, none missing.

No clock and no port: the caller says what time it is, in seconds of any clock.

The target's clock against this computer's: when blocks arrived, and what time their last samples say it was.

A block may be late on its way, never early, so that the earliest arrivals tell the clocks apart from the delays.

It is sent again unchanged every 30 ms, and given up after five times more. A target whose clock is not this computer's
gets it every half second. What was sent and what the target says it took are compared value by value, bit by bit.
"""

import struct
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.control import pulse_of
from hknob_cli.hardware.port import Array, Block, Drift, Settings, Simulated, Sine
from hknob_cli.hardware.sample_clock import drift_fault
from hknob_cli.hardware.wire.answers import Ack, Samples
from hknob_cli.hardware.wire.codes import Act, Kind, State, Status, pieces_of
from hknob_cli.hardware.wire.commands import Command, Configure, SetAct, Simulate

LATENESS_S = 0.01  # by which the earliest arrivals at both ends of a trial may differ in delay
_LEAST_BLOCKS = 12
_FIRST_S, _THEN = 0.4, 1.25  # of the target's time: when to look first, and by how much later each time after

ASK_EVERY_S = 0.02
GAP_PATIENCE_S = 0.1
# What may be held while a gap is being filled; what is further ahead is asked for later.
MOST_AHEAD = 256


class HostClock:
    """Arrivals of the blocks of one trial."""

    def __init__(self) -> None:
        self._points: list[tuple[float, float]] = []
        self._next_s = _FIRST_S

    def note(self, *, arrived_s: float, told_s: float) -> None:
        """A block arrived for the first time, in its place; its last sample was taken at ``told_s`` by the target."""
        self._points.append((arrived_s, told_s))

    def drift(self) -> Drift | None:
        """By how much the target's clock is fast; None before there is enough to tell."""
        if len(self._points) < _LEAST_BLOCKS:
            return None
        arrived, told = np.array(self._points).T
        if arrived[-1] <= arrived[0]:
            return None
        late = arrived - told
        third = len(late) // 3
        (begin, least, spread), (end, last, more) = (
            _earliest(told[p], late[p]) for p in (slice(third), slice(-third, None))
        )
        if end <= begin:
            return None
        slower = (last - least) / (end - begin)  # seconds of this computer's beyond one of the target's
        if slower <= -1.0:
            return None
        return Drift(float(1.0 / (1.0 + slower) - 1.0), float((spread + more + LATENESS_S) / (end - begin)))

    def fault(self) -> str:
        """What is wrong with the target's clock, looked for now and then; empty if nothing is."""
        if not self._points or self._points[-1][1] - self._points[0][1] < self._next_s:
            return ""
        self._next_s = _THEN * (self._points[-1][1] - self._points[0][1])
        return drift_fault(self.drift())


def _earliest(told: Array, late: Array) -> tuple[float, float, float]:
    """When the least late block was taken, how late it was, and how much later than that the next tenth were."""
    i = int(np.argmin(late))
    return float(told[i]), float(late[i]), float(np.percentile(late, 10.0) - late[i])


class BlockOrder:
    """Order of the blocks of one run; ``expected`` is the next block to be handed on."""

    def __init__(self, *, boot: int, run: int, patience_s: float = GAP_PATIENCE_S) -> None:
        self.boot = boot
        self.run = run
        self.patience_s = patience_s
        self.expected = 0
        self.total: int | None = None
        self.dropped = 0
        self._ahead: dict[int, Block] = {}
        self._sample = 0
        self._time_us = 0
        self._gap_since: float | None = None
        self._asked = -ASK_EVERY_S

    @property
    def complete(self) -> bool:
        """Whether the run has ended and all its blocks were handed on."""
        return self.total is not None and self.expected >= self.total

    @property
    def gap(self) -> tuple[int, int] | None:
        """First block that is missing, and how many are up to the next one held, or to the last made."""
        if self._ahead:
            return self.expected, min(self._ahead) - self.expected
        if self.total is None or self.complete:
            return None
        return self.expected, self.total - self.expected

    def take(self, message: Samples, *, now: float) -> list[Block]:
        """Blocks that can be handed on now. Raises DeviceError if their samples do not follow on each other."""
        number = message.block
        other = (message.boot, message.run) != (self.boot, self.run)
        if other or self.is_beyond(message) or number < self.expected or number in self._ahead:
            self.dropped += 1
            return []
        if number < self.expected + MOST_AHEAD:
            self._ahead[number] = message.samples
        ordered = []
        while self.expected in self._ahead:
            block = self._ahead.pop(self.expected)
            self._follow(block)
            ordered.append(block)
            self.expected += 1
        self._time_gap(now, progress=bool(ordered))
        return ordered

    def is_beyond(self, message: Samples) -> bool:
        """Whether a block is of this run, and of more than the target said it had made when it ended."""
        ours = (message.boot, message.run) == (self.boot, self.run)
        return ours and self.total is not None and message.block >= self.total

    def end(self, total: int, *, now: float) -> None:
        """The target has made ``total`` blocks, and will make no more."""
        self.total = total
        self._time_gap(now, progress=False)

    def ask(self, now: float) -> tuple[int, int] | None:
        """First block and number of blocks to ask for again, or None if there is no need now."""
        gap = self.gap
        if gap is None or now - self._asked < ASK_EVERY_S:
            return None
        self._asked = now
        return gap[0], min(gap[1], MOST_AHEAD)

    def is_overdue(self, now: float) -> bool:
        """Whether a gap has stayed for so long that it will not be filled."""
        return self._gap_since is not None and now - self._gap_since > self.patience_s

    def _time_gap(self, now: float, *, progress: bool) -> None:
        if self.gap is None:
            self._gap_since = None
        elif self._gap_since is None or progress:
            self._gap_since = now

    def _follow(self, block: Block) -> None:
        if block.first != self._sample:
            raise DeviceError(f"a block begins with sample {block.first}, where sample {self._sample} follows")
        times = block.time_us
        if times[0] < self._time_us or (times[1:] < times[:-1]).any():
            raise DeviceError(f"the target's clock runs backwards near sample {block.first}")
        if (np.diff(times) == 0).any() or (self._sample and times[0] == self._time_us):
            raise DeviceError(
                f"two samples have the same time near sample {block.first}: the target must tell times to 1 us, and a "
                "clock of 1 ms is too coarse"
            )
        self._sample += len(times)
        self._time_us = int(times[-1])


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
