"""The target's states: what docs/reference/wire.md says of it, sample by sample, in a time that the test tells."""

import itertools
import math
from typing import Any

import numpy as np
import pytest

from hknob_cli.hardware.port import Settings, Sine
from hknob_cli.hardware.wire.answers import About, Ack, Samples
from hknob_cli.hardware.wire.codes import Kind, State, Status, Trip
from hknob_cli.hardware.wire.commands import Again, Alive, Configure, Plain, Simulate, Zero
from tests.hardware.firmware import MS, ScriptedTarget, events_of, samples_of
from tests.hardware.golden import SETTINGS, WITH_SINES

# 4 kHz, 5 samples a block, watchdog 20 ms, 100 rad/s, a wall of 0.27 N·m/rad at 1024 counts.
TRIAL = SETTINGS._replace(block_samples=5, wall_damping=0.0)
PERIOD = TRIAL.period_ns
NATIVE = 640_000
NEVER = 2**64 - 1


@pytest.fixture
def target() -> ScriptedTarget:
    return ScriptedTarget()


def begun(target: ScriptedTarget, state: State, **settings: Any) -> ScriptedTarget:
    """The target brought to a state."""
    assert target.command(Configure(1, TRIAL._replace(**settings))).status == Status.DONE
    if state >= State.ARMED:
        assert target.plain(Kind.ARM).status == Status.DONE
    if state >= State.RUNNING:
        assert target.plain(Kind.START).status == Status.DONE
    if state == State.TRIPPED:
        target.emergency = 1
        target.sample()
        target.emergency = 0
        target.c.target_serve()
        target.said()
    return target


def take(target: ScriptedTarget, count: int) -> list[Samples]:
    """So many samples, the host alive all the time; the blocks that came."""
    said = []
    for _ in range(count):
        target.nonce += 1
        target.sample()
        said += target.tell(Alive(target.nonce, 0))
    return samples_of(said)


def test_who_it_is(target: ScriptedTarget) -> None:
    answer = target.plain(Kind.HELLO)
    knows = {f"knows_{what}": True for what in ("zero", "control", "pulses", "over_angle", "abilities")}
    assert answer.said == About(NATIVE, 40_000, simulated=True, name="scripted", **knows)
    assert answer[2:7] == (Status.DONE, State.IDLE, Trip.NONE, 7, 0)


def test_it_echoes_what_it_took(target: ScriptedTarget) -> None:
    assert target.command(Configure(1, TRIAL)).said == TRIAL
    assert target.command(Simulate(2, WITH_SINES)).said == WITH_SINES


OUT_OF_RANGE = {
    "period_ns": (39_999, 1_000_000_001),
    "counts_per_rev": (0, NATIVE + 1),
    "wall_stiffness": (-1e-9, 1000.1),
    "wall_damping": (-1e-9, 1000.1),
    "torque_limit_nm": (0.0, -1.0, 10.1),
    "speed_limit_rad_s": (0.0, -1.0, 10_001.0),
    "watchdog_us": (999, 50_001),
    "block_samples": (0, 49),
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, some in OUT_OF_RANGE.items() for value in some])
def test_settings_out_of_range_are_refused(target: ScriptedTarget, name: str, value: float) -> None:
    answer = target.command(Configure(1, TRIAL._replace(**{name: value})))
    assert answer.status == Status.OUT_OF_RANGE
    assert answer.said is None
    assert target.plain(Kind.ARM).status == Status.NOT_NOW


def test_edges_of_the_ranges_are_taken(target: ScriptedTarget) -> None:
    low = (40_000, 1, 0.0, 0.0, 5e-324, 5e-324, 1000, 1)
    high = (1_000_000_000, NATIVE, 1e3, 1e3, 10.0, 1e4, 50_000, 48)
    for nonce, edge in enumerate((low, high), start=1):
        assert target.command(Configure(nonce, Settings(*edge))).said == Settings(*edge)


IMPOSSIBLE: list[dict[str, Any]] = [
    {"inertia": 0.0},
    {"damping": -1.0},
    {"stiffness": -1.0},
    {"coulomb_nm": -1e-9},
    {"grip_rise_s": -0.1},
    {"angle_rad": 1e7},
    {"push_sines": (Sine(1e-3, 1e7, 0.0),)},
    {"grip_sines": (Sine(1e7, 1.0, 0.0),)},
]


@pytest.mark.parametrize("change", IMPOSSIBLE)
def test_an_impossible_knob_is_refused(target: ScriptedTarget, change: dict[str, Any]) -> None:
    assert target.command(Simulate(1, WITH_SINES._replace(**change))).status == Status.OUT_OF_RANGE


# What each state takes, and the state after it.
TAKEN = {
    State.IDLE: {"configure": State.IDLE, "simulate": State.IDLE, Kind.ARM: State.ARMED},
    State.ARMED: {Kind.START: State.RUNNING, Kind.STOP: State.IDLE},
    State.RUNNING: {Kind.STOP: State.IDLE},
    State.TRIPPED: {},
}
ALWAYS = {Kind.HELLO: None, Kind.RELEASE: State.IDLE}


@pytest.mark.parametrize("state", list(TAKEN))
@pytest.mark.parametrize(
    "what", ["configure", "simulate", Kind.ARM, Kind.START, Kind.STOP, Kind.RELEASE, Kind.HELLO], ids=str
)
def test_each_command_in_each_state(target: ScriptedTarget, state: State, what: Any) -> None:
    begun(target, state)
    commands = {"configure": Configure(50, TRIAL), "simulate": Simulate(50, WITH_SINES)}
    answer = target.command(commands[what] if what in commands else Plain(what, 50))
    allowed = TAKEN[state] | ALWAYS
    assert answer.status == (Status.DONE if what in allowed else Status.NOT_NOW)
    after = allowed.get(what, state)
    assert answer.state == (state if after is None else after)
    # The sample clock runs when it is armed or running, and then only.
    assert (target.call_at < NEVER) == (answer.state in (State.ARMED, State.RUNNING))


def test_arming_needs_settings(target: ScriptedTarget) -> None:
    assert target.plain(Kind.ARM).status == Status.NOT_NOW


def test_a_board_that_cannot_keep_the_settings_is_not_armed(target: ScriptedTarget) -> None:
    begun(target, State.IDLE)
    target.unable = 1
    answer = target.plain(Kind.ARM)
    assert (answer.status, answer.state) == (Status.OUT_OF_RANGE, State.IDLE)
    assert target.call_at == NEVER


def test_the_main_loop_is_told_when_not_to_sleep(target: ScriptedTarget) -> None:
    busy = [target.c.target_busy()]
    begun(target, State.TRIPPED)
    busy.append(target.c.target_busy())
    target.plain(Kind.RELEASE)
    assert [*busy, target.c.target_busy()] == [False, True, False]


@pytest.mark.parametrize("state", [State.ARMED, State.RUNNING, State.TRIPPED])
def test_release_forgets_the_run(target: ScriptedTarget, state: State) -> None:
    begun(target, state)
    target.angle = -3000
    answer = target.plain(Kind.RELEASE)
    assert answer[2:5] == (Status.DONE, State.IDLE, Trip.NONE)
    assert answer.blocks == 0
    assert target.torque == 0.0
    target.run(100 * MS)
    assert target.said() == []
    assert target.plain(Kind.ARM).status == Status.DONE


def test_a_repeated_nonce_is_answered_and_does_nothing_twice(target: ScriptedTarget) -> None:
    begun(target, State.IDLE)
    first = target.command(Plain(Kind.ARM, 60))
    take(target, 3)
    again = target.command(Plain(Kind.ARM, 60))
    assert target.trials == 1
    assert again == first
    start = target.command(Plain(Kind.START, 61))
    target.tell(Alive(62, 0))
    target.tell(Again(63, 0, 1))
    assert target.command(Plain(Kind.START, 61)) == start
    assert target.starts == 1
    assert target.command(Plain(Kind.START, 64)).status == Status.NOT_NOW
    # A refusal is repeated as well, even where the command would be taken by now.
    refused = target.command(Plain(Kind.ARM, 65))
    assert refused.status == Status.NOT_NOW
    target.sample()
    assert target.command(Plain(Kind.ARM, 65)).status == Status.NOT_NOW


def test_a_run_in_blocks(target: ScriptedTarget) -> None:
    begun(target, State.ARMED)
    target.grip = 0.5
    blocks = take(target, 12)
    target.angle = -NATIVE // 1024 * 3
    target.plain(Kind.START)
    blocks += take(target, 5)
    *last, answer = target.tell(Plain(Kind.STOP, 900))
    assert isinstance(answer, Ack)
    blocks += samples_of(last)
    assert [each.block for each in blocks] == [0, 1, 2, 3]
    assert [each.samples.first for each in blocks] == [0, 5, 10, 15]
    assert [len(each.samples.time_us) for each in blocks] == [5, 5, 5, 2]
    assert answer.blocks == 4
    assert {each.run for each in blocks} == {101}  # the nonce of ARM
    times, angles, torques, grips, running = (
        np.concatenate([getattr(each.samples, name) for each in blocks])
        for name in ("time_us", "angle_counts", "torque_nm", "grip_n", "running")
    )
    assert times.tolist() == [250 * i for i in range(17)]
    assert angles.tolist() == [0] * 12 + [-1875] * 5
    expected = np.float32(0.27 * (3 * math.tau / 1024))
    assert torques.tolist() == [0.0] * 12 + [float(expected)] * 5
    assert running.tolist() == [False] * 12 + [True] * 5
    assert set(grips.tolist()) == {0.5}
    assert target.torque == 0.0


def test_damping_acts_on_the_step_of_the_coarse_angle(target: ScriptedTarget) -> None:
    begun(target, State.RUNNING, wall_damping=1e-4, torque_limit_nm=10.0)
    coarse = [-(-count * NATIVE // 1024) for count in (-4, -4, -6, -5, 0)]
    torques = []
    for angle in coarse:
        target.angle = angle
        take(target, 1)
        torques.append(target.torque)
    quantum = math.tau / 1024
    wall = [0.27 * 4 * quantum, 0.27 * 4 * quantum, 0.27 * 6 * quantum, 0.27 * 5 * quantum, 0.0]
    damping = [0.0, 0.0, 2e-4 * quantum / 250e-6, -1e-4 * quantum / 250e-6, 0.0]
    assert torques == pytest.approx([w + d for w, d in zip(wall, damping, strict=True)], rel=4e-16)


def test_torque_is_cut_off(target: ScriptedTarget) -> None:
    begun(target, State.RUNNING, torque_limit_nm=0.003)
    target.angle = -10_000
    take(target, 1)
    assert target.torque == 0.003


def tripped(target: ScriptedTarget, fault: Trip, index: int, blocks: int) -> list[Samples]:
    """Check that it has tripped at this sample; what blocks it sends."""
    assert target.torque == 0.0
    assert target.call_at == NEVER
    target.c.target_serve()
    *sent, event = target.said()
    assert event is not None
    assert events_of([event])
    assert (event.fault, event.index, event.blocks) == (fault, index, blocks)
    assert target.plain(Kind.HELLO)[3:5] == (State.TRIPPED, fault)
    return samples_of(sent)


def test_too_fast_trips_within_the_sample(target: ScriptedTarget) -> None:
    """100 rad/s is 2546.48 counts in 250 us."""
    begun(target, State.RUNNING)
    target.angle = -5000
    take(target, 1)
    target.angle -= 2546
    take(target, 1)
    assert target.torque > 0.0
    target.angle += 2547
    target.sample()
    (last,) = tripped(target, Trip.SPEED, 2, 1)
    assert last.samples.torque_nm.tolist()[2] == 0.0
    assert last.samples.torque_nm.tolist()[1] > 0.0
    assert last.samples.running.tolist() == [True, True, False]


def test_speed_is_over_the_time_that_passed(target: ScriptedTarget) -> None:
    begun(target, State.RUNNING)
    take(target, 1)
    target.angle = -2 * 2546
    target.sample(late_ns=PERIOD)
    assert target.plain(Kind.HELLO).state == State.RUNNING


def test_the_first_sample_has_no_speed(target: ScriptedTarget) -> None:
    target.angle = 2**31 - 1
    begun(target, State.ARMED)
    take(target, 2)
    target.angle = -(2**31)
    target.sample()
    tripped(target, Trip.SPEED, 2, 1)


def test_emergency_stop_trips_within_the_sample(target: ScriptedTarget) -> None:
    begun(target, State.RUNNING)
    target.angle = -5000
    take(target, 7)
    target.emergency = 1
    target.sample()
    assert len(tripped(target, Trip.EMERGENCY_STOP, 7, 2)) == 1


@pytest.mark.parametrize("state", [State.ARMED, State.RUNNING])
@pytest.mark.parametrize("watchdog_us", [1000, 20_000, 50_000])
def test_a_cut_link_takes_the_torque_away_in_time(target: ScriptedTarget, state: State, watchdog_us: int) -> None:
    begun(target, state, watchdog_us=watchdog_us)
    target.angle = -5000
    heard = target.now
    while target.call_at < NEVER:
        target.sample()
    assert 0 <= target.now - heard - watchdog_us * 1000 < PERIOD
    assert target.now - heard <= 50 * MS
    tripped(target, Trip.WATCHDOG, watchdog_us * 1000 // PERIOD, watchdog_us * 1000 // PERIOD // 5 + 1)


def test_the_watchdog_does_not_wait_for_a_slow_sample_clock(target: ScriptedTarget) -> None:
    """One sample a second; the main loop is called once in a millisecond."""
    begun(target, State.RUNNING, period_ns=10**9, watchdog_us=50_000)
    target.sample()
    target.run(51 * MS)
    assert target.torque == 0.0
    assert events_of(target.said())[0].fault == Trip.WATCHDOG


def test_any_good_frame_keeps_it_going_and_no_bad_one(target: ScriptedTarget) -> None:
    begun(target, State.RUNNING)
    for kind in (Kind.HELLO, Kind.START, Kind.ARM):
        target.run(15 * MS)
        target.plain(kind)
    target.run(15 * MS)
    target.put(Alive(9, 0))
    target.in_count -= 2  # cut off
    target.run(6 * MS)
    assert events_of(target.said())[0].fault == Trip.WATCHDOG


def test_the_event_is_said_again_until_release(target: ScriptedTarget) -> None:
    begun(target, State.TRIPPED)
    target.run(100 * MS)
    said = target.said()
    assert len(events_of(said)) == len(said) == 5
    assert target.plain(Kind.STOP).status == Status.NOT_NOW
    target.plain(Kind.RELEASE)
    target.run(100 * MS)
    assert target.said() == []


def test_the_next_run_trips_with_an_event_of_its_own(target: ScriptedTarget) -> None:
    begun(target, State.TRIPPED)
    target.plain(Kind.RELEASE)
    begun(target, State.ARMED)
    target.emergency = 1
    target.sample()
    (event,) = events_of(target.tell(Alive(3, 0)))
    assert event.run == target.nonce


def test_blocks_wait_for_the_host_and_come_again(target: ScriptedTarget) -> None:
    begun(target, State.ARMED)
    first = take(target, 20)
    target.nonce += 1
    again = samples_of(target.tell(Again(target.nonce, 1, 2)))
    assert [each.block for each in again] == [1, 2]
    assert [each.samples.time_us.tolist() for each in again] == [each.samples.time_us.tolist() for each in first[1:3]]
    assert [each.block for each in samples_of(target.tell(Again(1, 3, 60_000)))] == [3]
    target.tell(Alive(2, 2))
    assert [each.block for each in samples_of(target.tell(Again(3, 0, 10)))] == [2, 3]
    # A number that has not been made says nothing.
    target.tell(Alive(4, 5))
    assert [each.block for each in samples_of(target.tell(Again(5, 0, 10)))] == [2, 3]
    assert samples_of(target.tell(Again(6, 2**32 - 1, 2))) == []


def test_blocks_can_be_had_after_stop_and_after_new_settings(target: ScriptedTarget) -> None:
    begun(target, State.RUNNING)
    blocks = take(target, 12)
    target.plain(Kind.STOP)
    target.command(Configure(70, TRIAL._replace(block_samples=48)))
    again = samples_of(target.tell(Again(71, 0, 9)))
    assert [len(each.samples.time_us) for each in again] == [5, 5, 2]
    assert again[0].samples.time_us.tolist() == blocks[0].samples.time_us.tolist()


@pytest.mark.parametrize("block_samples", [5, 16])
def test_no_room_trips_after_100_ms_at_least(target: ScriptedTarget, block_samples: int) -> None:
    """At the shortest period the ring of 4096 samples is full after 164 ms; no sample is lost."""
    begun(target, State.RUNNING, period_ns=40_000, block_samples=block_samples)
    target.angle = -5000
    blocks = []
    while target.call_at < NEVER:
        target.sample()
        blocks += samples_of(target.tell(Alive(3, 0)))
    assert target.now - 10**12 >= 100 * MS
    assert target.torque == 0.0
    answer = target.plain(Kind.HELLO)
    assert answer[3:5] == (State.TRIPPED, Trip.NO_ROOM)
    assert answer.blocks == len(blocks) == 4096 // block_samples
    (first,) = samples_of(target.tell(Again(5, 0, 1)))
    assert first.samples.time_us.tolist() == [40 * i for i in range(block_samples)]


def test_the_ring_goes_round(target: ScriptedTarget) -> None:
    begun(target, State.RUNNING, block_samples=7)
    times: list[int] = []
    for i in range(10_000):
        target.angle = -(i % 1000)
        target.sample()
        for each in samples_of(target.tell(Alive(3, len(times) // 7))):
            times += each.samples.time_us.tolist()
            assert each.samples.angle_counts.tolist() == [-((each.samples.first + k) % 1000) for k in range(7)]
    assert times == [250 * i for i in range(9996)]


def test_the_answer_to_stop_comes_after_the_last_block_however_slow_the_line(target: ScriptedTarget) -> None:
    begun(target, State.RUNNING)
    target.out_room = 40
    for _ in range(23):
        target.sample()
    target.put(Plain(Kind.STOP, 900))
    said = []
    for _ in range(200):
        target.c.target_serve()
        said += target.said()
        assert target.torque == 0.0
    assert [each.block for each in samples_of(said)] == [0, 1, 2, 3, 4]
    assert isinstance(said[-1], Ack)
    assert len(said) == 6


def test_late_samples_are_counted_and_not_made_up_for(target: ScriptedTarget) -> None:
    begun(target, State.ARMED)
    start = target.now
    late = [0, PERIOD // 2, 0, PERIOD // 2 + 1, 0, PERIOD, 0, 3 * PERIOD + PERIOD // 4, 0, 0]
    times, overruns = [], []
    for each in late:
        target.sample(late_ns=each)
        times.append(target.now - start)
    for block in samples_of(target.tell(Alive(3, 0))):
        assert block.samples.time_us.tolist() == [time // 1000 for time in times[block.samples.first :][:5]]
        overruns.append(block.samples.overruns)
    # On the timetable again at once: samples whose time has gone by are left out.
    ticks = [time // PERIOD for time in times]
    assert ticks == [0, 1, 2, 3, 4, 6, 7, 11, 12, 13]
    assert overruns == [1, 3]
    target.plain(Kind.RELEASE)
    begun(target, State.ARMED, block_samples=1)
    assert take(target, 1)[0].samples.overruns == 0


def test_a_restart_shows(target: ScriptedTarget) -> None:
    begun(target, State.RUNNING)
    target.boot = 8
    target.c.target_begin()
    answer = target.plain(Kind.HELLO)
    assert (answer.boot, answer.state, target.torque) == (8, State.IDLE, 0.0)


def test_the_lock_is_never_taken_twice_nor_kept(target: ScriptedTarget) -> None:
    begun(target, State.TRIPPED)
    target.run(50 * MS)
    target.plain(Kind.RELEASE)
    assert target.locks < 100_000_000
    assert target.locks % 2 == 0


def test_the_host_can_make_the_present_angle_zero(target: ScriptedTarget) -> None:
    target.angle = 5000
    answer = target.command(Zero(300, -7))
    assert (answer.status, answer.said) == (Status.DONE, -7)
    begun(target, State.ARMED)
    target.angle = 5010
    for _ in range(5):
        target.sample()
    found = samples_of(target.tell(Alive(3, 0)))
    assert found[0].samples.angle_counts.tolist()[-1] == 3
    assert target.command(Zero(301, 0)).status is Status.NOT_NOW
    target.plain(Kind.RELEASE)
    target.angle = 2**31 - 1  # beyond what can be told: its end is
    target.command(Zero(302, 2**31 - 1))
    begun(target, State.ARMED)
    target.angle = -(2**31)
    for _ in range(5):
        target.sample()
    assert samples_of(target.tell(Alive(4, 0)))[0].samples.angle_counts.tolist()[-1] == -(2**31)


def test_it_says_that_it_knows_zero(target: ScriptedTarget) -> None:
    about = target.plain(Kind.HELLO).said
    assert (about.simulated, about.knows_zero, about.no_grip_cell, about.own_time) == (True, True, False, False)


def test_times_rise_even_within_a_microsecond(target: ScriptedTarget) -> None:
    """A sample nearly a period late, and the next one at once."""
    begun(target, State.ARMED)
    target.sample(late_ns=PERIOD - 300)
    for _ in range(6):
        target.sample()
    times = [time for block in samples_of(target.tell(Alive(3, 0))) for time in block.samples.time_us.tolist()]
    assert all(later > before for before, later in itertools.pairwise(times))
    assert 1 in np.diff(times)
