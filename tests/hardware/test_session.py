"""A session against a made-up target, in made-up time: any loss is made good, or ends the trial with its reason."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.hardware.port import Block, Settings
from hknob_cli.hardware.wire.codes import Kind, State, Status, Trip
from hknob_cli.hardware.wire.commands import Command, Configure, Plain
from hknob_cli.hardware.wire.sending import AGAIN_AFTER_S, OWN_TIME_AGAIN_AFTER_S, TIMES_AGAIN, Sending
from hknob_cli.hardware.wire.session import READER_PATIENCE_S, Session
from tests.hardware.fake_target import FakeTarget, Manners, made_up, spoiler
from tests.hardware.golden import SETTINGS

STEP_S = 0.0025


class Wire:
    """A session and a target, joined by what may spoil frames to the target; the target's manners spoil the others."""

    def __init__(self, manners: Manners | None = None, *, back: Callable[[bytes], bytes] = lambda data: data) -> None:
        self.session = Session(first_nonce=0xFFFFFFF0)  # wraps round soon
        self.target = FakeTarget(manners)
        self.target.manners.simulated = False
        self.now = 0.0
        self.got: list[Block] = []
        self._back = back

    def go(self, seconds: float, *, reading: bool = True) -> None:
        end = self.now + seconds
        while self.now < end:
            self.step(reading=reading)

    def step(self, *, reading: bool = True) -> None:
        self.now += STEP_S
        self.session.feed(self.target.go_on(self.now), now=self.now)
        due = self.session.due(self.now)
        for piece in due.split(b"\0")[:-1]:
            self.session.feed(self.target.feed(self._back(piece + b"\0"), now=self.now), now=self.now)
        while reading and (block := self.session.take()) is not None:
            self.got.append(block)

    def ask(self, make: Callable[[int], Command]) -> Any:
        nonce = self.session.command(make)
        while self.session.is_waiting(nonce):
            self.step()
        answer = self.session.answer
        return answer if answer is not None and answer.nonce == nonce else None

    def do(self, kind: Kind) -> Any:
        return self.ask(lambda nonce: Plain(kind, nonce))

    def arm(self, told: Settings = SETTINGS) -> None:
        assert self.do(Kind.HELLO)
        assert self.ask(lambda nonce: Configure(nonce, told))
        assert self.do(Kind.ARM)


def assert_whole(blocks: list[Block], *, samples: int) -> None:
    """Every sample of the made-up signal, once."""
    assert [block.first for block in blocks] == list(np.cumsum([0, *(len(each.time_us) for each in blocks)])[:-1])
    if not blocks:
        assert samples == 0
        return
    expected = made_up(0, samples, SETTINGS.period_ns * 1e-3, started=None)
    for name in ("time_us", "angle_counts", "torque_nm", "grip_n"):
        joined = np.concatenate([getattr(each, name) for each in blocks])
        np.testing.assert_array_equal(joined, getattr(expected, name))


def samples_made(wire: Wire) -> int:
    return sum(len(each.samples.time_us) for each in wire.target.blocks)


def trial(wire: Wire) -> None:
    wire.go(0.1)
    assert wire.do(Kind.START).state is State.RUNNING
    wire.go(0.4)
    ack = wire.do(Kind.STOP)
    assert ack.status is Status.DONE
    while not wire.session.is_finished and wire.session.failure is None:
        wire.step()


def test_a_trial() -> None:
    wire = Wire()
    wire.arm()
    trial(wire)
    assert wire.session.failure is None
    assert_whole(wire.got, samples=samples_made(wire))
    assert len(wire.got) == len(wire.target.blocks)
    started = next(i for i, on in enumerate(np.concatenate([each.running for each in wire.got])) if on)
    assert started == pytest.approx(0.1 / SETTINGS.interval_s, abs=2 * STEP_S / SETTINGS.interval_s)


@pytest.mark.parametrize("seed", range(20))
def test_frames_lost_cut_changed_and_doubled_both_ways_cost_no_sample(seed: int) -> None:
    """Three frames in a hundred, the same ones each time the test is run."""
    wire = Wire(Manners(out=spoiler(seed, share=0.03)), back=spoiler(-seed - 1, share=0.03))
    wire.arm(SETTINGS._replace(watchdog_us=50_000))
    trial(wire)
    assert wire.session.failure is None
    assert_whole(wire.got, samples=samples_made(wire))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32), st.integers(0, 2**32), st.floats(0.0, 0.5))
def test_on_the_worst_of_wires_samples_are_whole_up_to_where_a_trial_fails(there: int, back: int, share: float) -> None:
    """So much is lost that the watchdog may trip, or a block never come; what is handed on has no hole."""
    wire = Wire()
    wire.arm()
    wire.target.manners.out, wire._back = spoiler(there, share=share), spoiler(back, share=share)
    wire.go(0.1)
    wire.do(Kind.START)
    wire.go(0.3)
    stopped = wire.do(Kind.STOP)
    wire.go(0.3)
    assert_whole(wire.got, samples=sum(len(each.time_us) for each in wire.got))
    assert wire.session.is_finished or wire.session.failure is not None
    if stopped is not None and stopped.status is Status.DONE and wire.session.failure is None:
        assert sum(len(each.time_us) for each in wire.got) == samples_made(wire)


def test_a_command_sent_again_is_carried_out_once() -> None:
    """The first ACK of each command is lost: the target answers the second time, and does nothing twice."""
    lost: set[bytes] = set()

    def lose_first(data: bytes) -> bytes:
        if data in lost or len(data) > 40:
            return data
        lost.add(data)
        return b""

    wire = Wire(Manners(out=lose_first))
    wire.arm()
    run = wire.target.run
    assert wire.target.heard.count(Kind.ARM) == 2
    assert wire.do(Kind.START).status is Status.DONE
    assert wire.target.run == run


@pytest.mark.parametrize(("own_time", "apart_s"), [(False, AGAIN_AFTER_S), (True, OWN_TIME_AGAIN_AFTER_S)])
def test_a_command_is_sent_six_times_and_given_up(own_time: bool, apart_s: float) -> None:
    sending = Sending(nonce=1, kind=Kind.HELLO, data=b"hello", own_time=own_time)
    times = [ms for ms in range(6000) if sending.due(ms * 1e-3)]
    assert times == [round(1e3 * apart_s) * count for count in range(TIMES_AGAIN + 1)]
    assert not sending.is_given_up(6 * apart_s - 0.001)
    assert sending.is_given_up(6 * apart_s + 0.001)


def test_a_target_in_its_own_time_is_waited_for() -> None:
    """From the answer on that says so; and one that answers late is not told again meanwhile."""
    wire = Wire(Manners(own_time=True))
    wire.do(Kind.HELLO)
    assert wire.session.own_time
    assert wire.session.due(wire.now) == b""
    wire.session.command(lambda nonce: Configure(nonce, SETTINGS))
    sent = [ms for ms in range(600) if wire.session.due(wire.now + 1e-3 * ms)]
    assert sent == [0, 500]


def test_alive_is_sent_every_10_ms_from_arming_to_the_end_and_not_otherwise() -> None:
    wire = Wire()
    wire.do(Kind.HELLO)
    wire.go(0.1)
    assert wire.target.heard.count(Kind.ALIVE) == 0
    wire.ask(lambda nonce: Configure(nonce, SETTINGS))
    wire.do(Kind.ARM)
    before = wire.target.heard.count(Kind.ALIVE)
    wire.go(1.0)
    assert wire.target.heard.count(Kind.ALIVE) - before in (99, 100, 101)
    wire.do(Kind.STOP)
    wire.go(0.05)
    after = wire.target.heard.count(Kind.ALIVE)
    wire.go(0.1)
    assert wire.target.heard.count(Kind.ALIVE) == after


@pytest.mark.parametrize("fault", [trip for trip in Trip if trip is not Trip.NONE])
def test_a_trip_hands_on_all_samples_then_says_why(fault: Trip) -> None:
    wire = Wire(Manners(trip=(17, fault), hide=set()))
    wire.arm()
    wire.go(0.5)
    assert_whole(wire.got, samples=17 * SETTINGS.block_samples)
    assert wire.session.failure is not None
    assert "took its torque off at sample 680" in wire.session.failure
    assert wire.do(Kind.RELEASE).state is State.IDLE


def test_blocks_lost_just_before_a_trip_are_asked_for_and_handed_on_too() -> None:
    wire = Wire(Manners(trip=(17, Trip.SPEED), hide={15}))
    wire.arm()
    while wire.target.state is not State.TRIPPED:
        wire.step()
    wire.go(0.03)
    assert wire.session.failure is None  # there is something to wait for
    wire.target.manners.hide.clear()
    wire.go(0.2)
    assert_whole(wire.got, samples=17 * SETTINGS.block_samples)
    assert wire.session.failure is not None
    assert "took its torque off at sample 680" in wire.session.failure
    assert "lost" not in wire.session.failure


def test_a_lost_block_that_never_comes_ends_the_trial_and_releases() -> None:
    wire = Wire(Manners(hide={5}))
    wire.arm()
    wire.do(Kind.START)
    wire.go(0.4)
    assert_whole(wire.got, samples=5 * SETTINGS.block_samples)
    assert wire.session.failure == "blocks 5 to 5 were lost, and did not come when asked for again"
    assert wire.target.state is State.IDLE
    assert wire.target.heard[-1] is Kind.RELEASE


def test_silence_ends_the_trial_within_200_ms() -> None:
    wire = Wire(Manners(silent_at=10))
    wire.arm()
    wire.go(0.1)
    wire.go(0.2)
    assert wire.session.failure is not None
    assert "no samples came for 10" in wire.session.failure
    assert "is it on, and is the cable in?" in wire.session.failure
    assert_whole(wire.got, samples=10 * SETTINGS.block_samples)


def test_a_target_that_simulates_may_be_silent_for_a_second() -> None:
    wire = Wire(Manners(silent_at=10))
    wire.target.manners.simulated = True
    wire.arm()
    wire.go(0.1)
    silent_since = wire.now
    while wire.session.failure is None and wire.now < silent_since + 2.0:
        wire.step()
    # From its last block on, which came 10 blocks after arming; told within a step or a few of the second.
    assert "no samples came for 100" in (wire.session.failure or "")
    assert 0.9 < wire.now - silent_since < 1.1


def test_a_target_that_restarted_is_recognised() -> None:
    wire = Wire(Manners(restart_at=10))
    wire.arm()
    wire.go(0.4)
    assert wire.session.failure is not None
    assert "has restarted" in wire.session.failure
    assert_whole(wire.got, samples=10 * SETTINGS.block_samples)


def test_a_target_that_answers_but_does_not_sample_is_told_apart() -> None:
    wire = Wire()
    wire.arm()
    wire.go(0.1)
    wire.target.state = State.IDLE
    wire.go(0.2)
    assert wire.session.failure is not None
    assert "it answers, but is not sampling" in wire.session.failure


def test_torque_is_not_left_on_when_nobody_takes_the_samples() -> None:
    wire = Wire()
    wire.arm()
    wire.do(Kind.START)
    wire.go(READER_PATIENCE_S[State.RUNNING] - 0.1, reading=False)
    assert wire.target.state is State.RUNNING
    wire.go(0.2, reading=False)
    assert wire.target.state is State.IDLE
    assert wire.session.failure is not None
    assert "nobody took the samples for 2 s" in wire.session.failure
    kept = len(wire.session.ready)
    wire.go(1.0, reading=False)
    assert len(wire.session.ready) == kept


def test_blocks_of_the_run_before_are_not_taken_for_this_one() -> None:
    wire = Wire()
    wire.arm()
    trial(wire)
    old = wire.target.blocks[0]
    wire.got.clear()
    assert wire.do(Kind.ARM)
    wire.session.feed(wire.target._send(old), now=wire.now)
    wire.go(0.1)
    assert wire.got
    assert_whole(wire.got, samples=sum(len(each.time_us) for each in wire.got))


@pytest.mark.parametrize(
    ("manners", "said"),
    [(Manners(backwards_at=3), "clock runs backwards near sample 120"), (Manners(shifted_at=3), "sample 121, where")],
)
def test_samples_that_cannot_be_end_the_trial(manners: Manners, said: str) -> None:
    wire = Wire(manners)
    wire.arm()
    wire.go(0.2)
    assert wire.session.failure is not None
    assert said in wire.session.failure
    assert_whole(wire.got, samples=3 * SETTINGS.block_samples)
    assert wire.target.state is State.IDLE


def test_after_release_the_watchdog_is_left_to_do_its_work() -> None:
    """The answer never comes, so that RELEASE is sent six times: no ALIVE in between or after."""
    wire = Wire()
    wire.arm()
    wire.do(Kind.START)
    wire.target.manners.mute = True
    wire.session.command(lambda nonce: Plain(Kind.RELEASE, nonce))
    before = len(wire.target.heard)
    wire.go(0.5)
    assert wire.target.heard[before:] == [Kind.RELEASE] * 6


def test_a_target_that_is_in_another_state_than_it_was_told_ends_the_trial() -> None:
    wire = Wire()
    wire.arm()
    wire.go(0.1)
    plain = wire.target._carry_out

    def lying(message: Any, now: float) -> Any:
        found = plain(message, now)
        wire.target.state = State.ARMED
        return found

    wire.target._carry_out = lying  # type: ignore[method-assign]
    wire.do(Kind.START)
    assert wire.session.failure == "the target acknowledged START, but says that it is armed, and not running"


def test_blocks_that_go_on_after_stop_end_the_trial() -> None:
    wire = Wire()
    wire.arm()
    trial(wire)
    made = wire.target.blocks[-1]
    wire.session.feed(wire.target._send(made), now=wire.now)
    assert wire.session.failure is None  # one that it has is no new one
    wire.session.feed(wire.target._send(made._replace(block=made.block + 1)), now=wire.now)
    assert wire.session.failure == "the target acknowledged STOP, but goes on sampling with the wall on"


def test_blocks_that_go_on_after_release_are_seen_and_those_under_way_are_let_pass() -> None:
    wire = Wire()
    wire.arm()
    wire.do(Kind.START)
    wire.go(0.1)
    made = wire.target.blocks[-1]
    wire.session.command(lambda nonce: Plain(Kind.RELEASE, nonce))
    wire.session.feed(wire.target._send(made), now=wire.now)
    wire.go(0.1)
    assert wire.session.released is not None
    assert (wire.session.released.acknowledged, wire.session.released.seen) == (True, "")
    wire.session.feed(wire.target._send(made._replace(boot=9)), now=wire.now)
    assert wire.session.released.seen == ""  # of somebody else
    wire.session.feed(wire.target._send(made), now=wire.now)
    assert wire.session.released.seen == "the target acknowledged RELEASE, but goes on sending samples with the wall on"


def test_what_is_no_number_is_called_so_and_nothing_of_it_is_handed_on() -> None:
    wire = Wire()
    wire.arm()
    wire.go(0.05)
    got = len(wire.got)
    made = wire.target.blocks[-1]
    grip = made.samples.grip_n.copy()
    grip[7] = np.nan
    number = made.block + 1
    first = made.samples.first + SETTINGS.block_samples
    times = made.samples.time_us + SETTINGS.block_samples * SETTINGS.period_ns // 1000
    spoilt = made.samples._replace(first=first, time_us=times, grip_n=grip)
    wire.session._take_samples(made._replace(block=number, samples=spoilt))
    assert wire.session.failure == f"the target sent a grip force that is not a number, at sample {first + 7}"
    wire.go(0.1)
    assert len(wire.got) == got


def test_frames_with_a_wrong_checksum_are_counted_and_named() -> None:
    wire = Wire()
    wire.arm()
    wire.go(0.05)
    plain = wire.target.manners.out
    wire.target.manners.out = lambda data: (
        plain(data[:-2] + bytes([data[-2] % 254 + 1, 0])) if len(data) > 100 else data
    )
    wire.go(0.3)
    assert wire.session.failure is not None
    said = "came with a wrong checksum: does the target make its CRC-32 as docs/reference/wire.md says"
    assert said in wire.session.failure


def test_a_clock_that_is_half_as_fast_ends_the_trial_unless_it_is_simulated() -> None:
    for own_time in (False, True):
        wire = Wire()
        wire.arm()
        wire.session.own_time = own_time
        plain = wire.target.go_on
        wire.target.go_on = lambda now, plain=plain: plain(now / 2.0)  # type: ignore[method-assign]
        wire.target._armed_at = wire.now / 2.0
        wire.target.slack = 1e9
        wire.go(1.0)
        said = wire.session.failure or ""
        assert ("the target's clock is 50.0% slow by this computer's" in said) != own_time


def test_a_wall_that_is_never_said_to_be_on_ends_the_trial() -> None:
    wire = Wire()
    wire.arm()
    wire.go(0.1)
    wire.do(Kind.START)
    wire.target._started = None
    wire.go(0.1)
    assert wire.session.failure is not None
    assert "the target acknowledged START, and does not say that the wall is on, at sample " in wire.session.failure
    assert wire.target.state is State.IDLE


def test_a_wall_that_is_on_from_the_next_sample_is_right_however_many_blocks_are_unread() -> None:
    wire = Wire()
    wire.arm()
    wire.go(3.0, reading=False)
    wire.do(Kind.START)
    wire.go(0.5)
    assert wire.session.failure is None


def test_a_trip_at_the_first_sample_after_start_is_told_as_a_trip() -> None:
    """That sample has no wall any more, and is alone in its block; were there another, it would be no trip."""
    wire = Wire()
    wire.arm()
    wire.go(0.1)
    wire.do(Kind.START)
    wire.target._started = None
    while wire.session._on_after is None:
        wire.step()
    made = wire.target.blocks[-1]
    last = made.samples
    later = 1_000_000  # us, after START by any clock
    alone = last._replace(
        first=last.first + len(last.time_us),
        time_us=last.time_us[-1:] + later,
        angle_counts=last.angle_counts[-1:],
        torque_nm=np.zeros(1),
        grip_n=last.grip_n[-1:],
        running=np.zeros(1, bool),
    )
    wire.session._on_after = (0, wire.session._on_after[1])
    wire.session._take_samples(made._replace(block=made.block + 1, samples=alone))
    assert wire.session.failure is None
    again = alone._replace(first=alone.first + 1, time_us=alone.time_us + 250)
    wire.session._take_samples(made._replace(block=made.block + 2, samples=again))
    assert "does not say that the wall is on" in (wire.session.failure or "")


def test_blocks_lost_just_before_stop_are_asked_for_after_it() -> None:
    """The torque is off, and the recording is to be whole."""
    wire = Wire()
    wire.arm()
    wire.go(0.1)
    assert wire.do(Kind.START).state is State.RUNNING
    wire.go(0.2)
    lost = len(wire.target.blocks)
    wire.target.manners.hide = {lost, lost + 1}
    while len(wire.target.blocks) < lost + 2:
        wire.step()
    assert wire.do(Kind.STOP).status is Status.DONE
    assert not wire.session.is_finished
    wire.target.manners.hide = set()
    wire.go(0.08)
    assert wire.session.is_finished
    assert wire.session.failure is None
    assert_whole(wire.got, samples=samples_made(wire))
