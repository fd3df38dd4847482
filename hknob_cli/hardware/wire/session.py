"""A session with a target: what is sent when, and what is made of what comes. No thread, no port, no clock of its own.

The caller feeds bytes as they come and sends what is due, and says what time it is, in seconds of any clock.
"""

from collections import deque
from collections.abc import Callable

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Block
from hknob_cli.hardware.sample_clock import MOST_DRIFT
from hknob_cli.hardware.wire.answers import About, Ack, Event, Samples
from hknob_cli.hardware.wire.codes import TRIP_TEXT, VERSION, Kind, State, Status
from hknob_cli.hardware.wire.commands import Again, Alive, Command, Plain
from hknob_cli.hardware.wire.messages import Decoder, Unread, decode, encode, frame, not_a_number, unread_of
from hknob_cli.hardware.wire.sending import AfterRelease, BlockOrder, HostClock, Sending, shows_torque, wrong_state

ALIVE_EVERY_S = 0.01
SILENCE_S = 0.1
# A target without a knob shares a computer with other programs, and has no torque to fear for.
SIMULATED_SILENCE_S = 1.0
# Of the time from ARM to the answer to START the samples after that are told: by clocks that differ, and read late.
ON_LATE_S, ON_SLOWER = 0.02, 1.0 + MOST_DRIFT
# Without anybody who takes samples the torque is not left on: the program may hang. Armed, it is memory that is saved.
READER_PATIENCE_S = {State.ARMED: 60.0, State.RUNNING: 2.0}


class Session:
    """Commands and their answers, blocks in order in ``ready``, and what ended the trial in ``failure``."""

    def __init__(self, *, first_nonce: int) -> None:
        self.ready: deque[Block] = deque()
        self.boot: int | None = None
        self.answer: Ack | None = None
        self.failure: str | None = None
        self.state = State.IDLE
        self.silence_s = SILENCE_S
        self.versions: set[int] = set()
        self.echoed = False
        self.rejected = 0
        self.own_time = False
        self.clock = HostClock()
        self.released: AfterRelease | None = None
        self._arrived_at = 0.0
        self._unread = Unread(0, 0)
        self._arm_sent_at = 0.0
        self._off_once = False
        self._on_after: tuple[int, float] | None = None  # blocks and seconds of the run after which the wall is on
        self._decoder = Decoder()
        self._nonce = first_nonce
        self._sending: Sending | None = None
        self._order: BlockOrder | None = None
        self._event: Event | None = None
        self._now = 0.0
        self._alive_at = 0.0
        self._heard_at = 0.0
        self._taken_at = 0.0
        self._probe: int | None = None
        self._answered_probe = False

    @property
    def damaged(self) -> int:
        """Frames dropped so far: not decoded, or none of the protocol's."""
        return self._decoder.damaged + self.rejected

    @property
    def is_amid(self) -> bool:
        """Whether bytes came since the last zero byte: text has none."""
        return self._decoder.is_amid

    @property
    def unread(self) -> Unread:
        """What came so far and could not be read."""
        return unread_of(self._decoder, self.rejected)

    @property
    def is_stopped(self) -> bool:
        """Whether the target has said how many blocks there are, and why there are no more: it was told to stop."""
        return self._order is not None and self._order.total is not None and self._event is None

    @property
    def is_finished(self) -> bool:
        """Whether no more blocks will come: there was no run, or all of it was handed on."""
        return self._order is None or (self.is_stopped and self._order.complete)

    def command(self, make: Callable[[int], Command]) -> int:
        """Begin to send a command, made with the nonce given, in place of one still under way; returns the nonce."""
        nonce, kind = self._send(make)
        self.answer = None
        if kind is Kind.ARM:
            self.ready.clear()
            self.failure = self._event = self._probe = None
            self._order = BlockOrder(boot=self.boot or 0, run=nonce, patience_s=self.silence_s)
            self.clock, self._unread, self.released = HostClock(), self.unread, None
            self._arm_sent_at, self._on_after, self._off_once = self._arrived_at, None, False
            self._alive_at = self._heard_at = self._taken_at = self._now
        if kind is Kind.RELEASE:
            # No more ALIVE from here on: should RELEASE not arrive, the watchdog acts.
            self._order = self._event = None
        return nonce

    def is_waiting(self, nonce: int) -> bool:
        """Whether this command has neither an answer nor been given up."""
        return self._sending is not None and self._sending.nonce == nonce

    def take(self) -> Block | None:
        """The next block, if one is ready."""
        self._taken_at = self._now
        return self.ready.popleft() if self.ready else None

    def fail(self, why: str) -> None:
        """The trial cannot go on: RELEASE, and no more ALIVE, so that the watchdog acts if that does not arrive."""
        if self.failure is None:
            self.failure = why
            self._send(lambda nonce: Plain(Kind.RELEASE, nonce))

    def feed(self, data: bytes, *, now: float, arrived_s: float | None = None) -> None:
        """Bytes that came; never raises. ``arrived_s``: when they did, by a clock that never stops, as ``now`` may."""
        self._now = now
        self._arrived_at = now if arrived_s is None else arrived_s
        for body in self._decoder.feed(data):
            match decode(body):
                case Ack() as ack:
                    self._take_ack(ack)
                case Samples() as samples:
                    self._take_samples(samples)
                case Event() as event:
                    self._take_event(event)
                case None:
                    self.rejected += 1
                    self.versions |= {body[0]} - {VERSION}
                case _:
                    self.echoed = True

    def due(self, now: float) -> bytes:
        """Frames to send now."""
        self._now = now
        data = b""
        if self._order is not None and self.failure is None:
            self._watch(self._order)
        if self._sending is not None:
            data += self._sending.due(now)
            if self._sending.is_given_up(now):
                self._sending = None
        order = self._order
        if order is None or self.failure is not None or (self.is_stopped and order.complete):
            return data
        if now >= self._alive_at:
            # On a fixed beat, but never several at once after a pause.
            self._alive_at = max(self._alive_at + ALIVE_EVERY_S, now)
            data += self._unanswered(lambda nonce: Alive(nonce, order.expected))
        asked = order.ask(now)
        if asked is not None:
            data += self._unanswered(lambda nonce: Again(nonce, *asked))
        return data

    def _send(self, make: Callable[[int], Command]) -> tuple[int, Kind]:
        self._nonce = (self._nonce + 1) & 0xFFFFFFFF
        command = make(self._nonce)
        data = frame(encode(command))
        self._sending = Sending(nonce=self._nonce, kind=command.kind, data=data, own_time=self.own_time)
        if command.kind is Kind.RELEASE:
            self.released = AfterRelease(boot=self.boot)
        return self._nonce, command.kind

    def _unanswered(self, make: Callable[[int], Command]) -> bytes:
        self._nonce = (self._nonce + 1) & 0xFFFFFFFF
        return frame(encode(make(self._nonce)))

    def _take_ack(self, ack: Ack) -> None:
        sending = self._sending
        if sending is None or (ack.nonce, ack.of) != (sending.nonce, sending.kind):
            return
        self._sending = None
        if self.boot is not None and ack.boot != self.boot and sending.kind is not Kind.RELEASE:
            self.fail("the target has restarted in between; its torque is off. Start the command again")
            return
        if sending.nonce == self._probe:
            self._answered_probe = True
            return
        self.answer = ack
        if sending.kind is Kind.HELLO:
            self.boot = ack.boot
            if isinstance(ack.said, About):
                self.silence_s = SIMULATED_SILENCE_S if ack.said.simulated else SILENCE_S
                self.own_time = ack.said.own_time
        if sending.kind is Kind.RELEASE and self.released is not None:
            self.released.answer(ack)
        elif wrong := wrong_state(ack):
            self.fail(wrong)
            return
        if sending.kind is Kind.ARM and ack.status is not Status.DONE:
            self._order = None
        if ack.status is not Status.DONE:
            return
        if sending.kind is Kind.STOP and self._order is not None:
            self._order.end(ack.blocks, now=self._now)
        if sending.kind is Kind.RELEASE:
            self._order = self._event = None
        if sending.kind in (Kind.ARM, Kind.START, Kind.STOP, Kind.RELEASE):
            self.state = ack.state
            self._taken_at = self._now
        if sending.kind is Kind.ARM:
            self._heard_at = self._now
        if sending.kind is Kind.START:
            # The block of that number may have begun before; and a target that is behind takes what it has left out.
            self._on_after = ack.blocks, ON_LATE_S + ON_SLOWER * (self._arrived_at - self._arm_sent_at)

    def _take_samples(self, samples: Samples) -> None:
        if self.released is not None:
            self.released.samples(samples)
        order = self._order
        if order is None or self.failure is not None:
            return
        before, ordered = order.dropped, []
        try:
            ordered = order.take(samples, now=self._now)
        except DeviceError as error:
            self.fail(f"the samples do not hold together: {error}")
        for number, block in enumerate(ordered, order.expected - len(ordered)):
            if wrong := not_a_number(block) or self._off_after_start(number, block):
                self.fail(wrong)
                break
            self.ready.append(block)
        if len(ordered) == 1:  # more are those that waited until a gap was filled
            self.clock.note(arrived_s=self._arrived_at, told_s=float(ordered[0].time_us[-1]) * 1e-6)
        if order.dropped == before:
            self._heard_at = self._now
            self._unread = self.unread
            self._probe = None
        elif self.is_stopped and order.is_beyond(samples) and shows_torque(samples.samples):
            self.fail("the target acknowledged STOP, but goes on sampling with the wall on")

    def _off_after_start(self, number: int, block: Block) -> str:
        """What is wrong with a block that was begun after START was answered; empty if nothing is."""
        if block.running.any():
            self._on_after = None  # a wall that is lost after it was seen is another fault
        if self._on_after is None:
            return ""
        blocks, seconds = self._on_after
        if number <= blocks or (block.time_us[0] * 1e-6 <= seconds and not self.own_time):
            return ""
        if len(block.running) == 1 and not self._off_once:  # it may have tripped there: then nothing follows
            self._off_once = True
            return ""
        return f"the target acknowledged START, and does not say that the wall is on, at sample {block.first}"

    def _take_event(self, event: Event) -> None:
        order = self._order
        if order is None or (event.boot, event.run) != (order.boot, order.run):
            return
        if self._event is None:
            self._event = event
            self.state = State.TRIPPED
            order.end(event.blocks, now=self._now)

    def _watch(self, order: BlockOrder) -> None:
        """What ends a trial: a trip, a gap that stays, silence, or nobody who takes the samples."""
        overdue = order.is_overdue(self._now)
        if self._event is not None:
            if order.complete or overdue:
                self.failure = self._trip_text(self._event, order)
        elif overdue:
            first, count = order.gap or (order.expected, 1)
            what = self.unread.since(self._unread).text
            lost = f"blocks {first} to {first + count - 1} were lost, and did not come when asked for again"
            self.fail(f"{lost}; {what}" if what else lost)
        elif not self.is_stopped and self.state is not State.IDLE:
            if self._sending is None or self._sending.nonce == self._probe:
                self._watch_silence()
            if not self.own_time and (wrong := self.clock.fault()):
                self.fail(wrong)
            if self._now - self._taken_at > READER_PATIENCE_S.get(self.state, float("inf")):
                self.fail(f"nobody took the samples for {READER_PATIENCE_S[self.state]:g} s: the torque was released")

    def _watch_silence(self) -> None:
        silent = self._now - self._heard_at
        if silent > self.silence_s:
            answers = self._probe is not None and self._answered_probe
            told = "it answers, but is not sampling." if answers else "is it on, and is the cable in?"
            if what := self.unread.since(self._unread).text:
                told = f"but {what}"
            self.fail(f"no samples came for {silent * 1e3:.0f} ms: {told} The target's watchdog takes the torque off")
        elif silent > self.silence_s / 2 and self._probe is None:
            # Asked who it is, a target that has restarted shows itself by another boot.
            self._answered_probe = False
            self._probe, _ = self._send(lambda nonce: Plain(Kind.HELLO, nonce))

    def _trip_text(self, event: Event, order: BlockOrder) -> str:
        lost = "" if order.complete else f"; its samples from block {order.expected} on were lost"
        if lost and (what := self.unread.since(self._unread).text):
            lost += f": {what}"
        at = f"at sample {event.index}, {event.time_us * 1e-6:.4f} s after arming"
        return f"the target took its torque off {at}: {TRIP_TEXT[event.fault]}{lost}"
