"""The target's controllers: the same torques as the engine's functions, to the last bit, and what CONTROL takes."""

import ctypes as c
import math
import random
from typing import Any

import numpy as np
import pytest

from hknob_cli.hardware.control import ControlledWall, begins_of, looks_of
from hknob_cli.hardware.port import Control
from hknob_cli.hardware.wire.answers import Ack, most_samples
from hknob_cli.hardware.wire.codes import Kind, Law, State, Status, Trip
from hknob_cli.hardware.wire.commands import Again, Alive, Configure, SetAct
from tests.hardware.controllers import CONTROLLERS, READING, readings, told, within
from tests.hardware.firmware import CControl, ScriptedTarget, events_of, library, samples_of
from tests.hardware.golden import LAG, PIECE, PULSE, SETTINGS, TABLE

NAMES = list(CONTROLLERS)
NATIVE = 640_000  # of the scripted board


def made(name: str) -> Control:
    control = told(name).control
    assert control is not None
    return control


def test_every_law_of_the_wire_is_tested() -> None:
    assert {made(name).law for name in NAMES} == set(Law)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", NAMES)
def test_torques_are_those_of_the_engine_to_the_last_bit(name: str) -> None:
    settings = told(name, wall_damping=1e-6)
    wall = ControlledWall(settings, made(name))
    control, past, parts = CControl.of(made(name)), (c.c_double * 129)(), (c.c_double * 64)()
    assert library().control_in_range(control)
    quantum = math.tau / settings.counts_per_rev
    before, seen = -2, set()
    begins, looks, rows = begins_of(made(name)), len(looks_of(made(name))), len(made(name).rows)
    rng = random.Random(name)
    assert library().law_looks(control) == looks
    assert (looks > 0) == (name in READING)
    assert library().law_parts(control, parts) == len(begins)
    assert tuple(parts[: len(begins)]) == begins
    library().law_begin(control, past, float(before))
    for count in readings(NAMES.index(name), 20_000):
        for which, read in enumerate(within(rng, before, count, looks) if wall.memory else []):
            past[rows + 1 + which] = read
            wall.look(which, read)
        assert library().law_act(control, past, float(count), parts) == parts[0]
        torques = [
            library().wall_controlled(depth, count, before, quantum, settings.interval_s, 0.27, 1e-6)
            for depth in parts[: len(begins)]
        ]
        assert torques == wall.torques(count, before)
        before = count
        seen.add(torques[0])
    assert len(seen) > 100
    assert [*past][: rows + 1 + looks] == wall.memory


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", NAMES)
def test_a_trial_is_that_of_the_law(name: str) -> None:
    """Armed, started, limited and recorded: what the loop sends is the law's, rounded as the wire does."""
    settings = told(name, 4000, wall_damping=1e-6, torque_limit_nm=0.2, speed_limit_rad_s=1e4)
    looks = looks_of(settings.control)
    settings = settings._replace(block_samples=min(5, most_samples(len(looks))))
    assert settings.control is not None
    target, wall = ScriptedTarget(), ControlledWall(settings, settings.control)
    assert target.command(Configure(1, settings._replace(control=None))).status == Status.DONE
    assert target.command(SetAct(2, settings.control)).said == settings.control
    target.plain(Kind.ARM)
    target.angle = -900  # before the wall is on: the knob stands there when the law begins
    for _ in range(3):
        target.sample()
    assert target.torque == 0.0
    before, expected, sent = -900 * 1024 // NATIVE, [], samples_of(target.tell(Alive(50, 0)))
    target.plain(Kind.START)
    begins, target.passed = begins_of(settings.control), 0.0
    told_looks, rng = [(0,) * len(looks)], random.Random(name)
    next_counts = [*list(readings(7, 1000))[1:], 0]
    for i, count in enumerate(readings(7, 1000)):
        target.angle = count * NATIVE // 1024
        coarse = target.angle * 1024 // NATIVE
        torques = [max(-0.2, min(0.2, one)) for one in wall.torques(coarse, before)]
        due = target.call_at
        target.sample()
        expected.append(torques[0])
        assert target.torque == expected[-1]
        assert target.passed == pytest.approx(i + 1, rel=1e-12)
        read = [one * NATIVE // 1024 + 200 for one in within(rng, coarse, next_counts[i], len(looks))]
        told_looks.append(tuple(read))
        later = [(begin, 1, part) for part, begin in enumerate(begins) if part] + [
            (at, 0, which) for which, at in enumerate(looks)
        ]
        for begin, is_torque, which in sorted(later):
            assert target.call_at == due + int(begin * settings.period_ns)
            if not is_torque:
                target.angle = read[which]
                wall.look(which, read[which] * 1024 // NATIVE)
            torque = torques[which] if is_torque else target.torque
            target.sample()
            assert target.torque == torque
            assert target.passed == pytest.approx(i + 1 + begin, rel=1e-12)
        assert target.call_at == due + settings.period_ns
        before = coarse
        target.nonce += 1
        sent += samples_of(target.tell(Alive(target.nonce, 0)))
    assert len(set(expected)) > 20
    told_of = np.concatenate([one.samples.torque_nm[one.samples.running] for one in sent])
    assert told_of.size > 990
    assert np.array_equal(told_of, np.array(expected[: told_of.size]).astype(np.float32))
    assert sent[-1].samples.overruns == 0
    if not looks:
        assert all(one.kind is Kind.BLOCK for one in sent)
        return
    found = np.concatenate([one.samples.looks for one in sent])
    armed = len(found) - told_of.size
    assert all(one.kind is Kind.READINGS for one in sent)
    assert found.tolist() == [[0] * len(looks)] * armed + [list(row) for row in told_looks[: told_of.size]]


def armed_with(name: str, rate: float, samples: int) -> Ack:
    settings = told(name, rate)._replace(block_samples=samples)
    assert settings.control is not None
    target = ScriptedTarget()
    target.command(Configure(1, settings.plain))
    assert target.command(SetAct(2, settings.control)).status == Status.DONE
    return target.plain(Kind.ARM)


def test_readings_that_a_block_or_the_record_has_no_room_for_are_not_armed() -> None:
    most = "long impulse that reads most often"
    assert most_samples(63) == 3
    assert armed_with(most, 4000, 3).status == Status.DONE
    assert armed_with(most, 4000, 4).status == Status.OUT_OF_RANGE
    assert armed_with("hold that reads", 4000, most_samples(3)).status == Status.DONE
    assert armed_with("hold that reads", 4000, most_samples(3) + 1).status == Status.OUT_OF_RANGE
    # 65,536 readings in all, and the record has room for 100 ms.
    assert armed_with(most, 10_000, 3).status == Status.DONE
    assert armed_with(most, 20_000, 3).status == Status.OUT_OF_RANGE


@pytest.mark.parametrize("frees", [True, False])
def test_readings_go_round_in_the_record(frees: bool) -> None:
    """With 63 readings a sample the record keeps 1024 samples; more come only where the host has taken the first."""
    settings = told("impulse as long as an interval", 4000)._replace(block_samples=3)
    assert settings.control is not None
    settings = settings._replace(control=settings.control._replace(numbers=(0.0, 1.0, 1.0, 63.0)))
    assert settings.control is not None
    target, sent = ScriptedTarget(), []
    target.command(Configure(1, settings.plain))
    target.command(SetAct(2, settings.control))
    target.plain(Kind.ARM)
    target.sample()
    target.plain(Kind.START)
    calls = 0
    while calls < 64 * 1300 and target.call_at < 2**64 - 1:
        target.angle = -(calls % 1000)  # the angle tells which call it was
        target.sample()
        calls += 1
        if calls % 640 == 0:
            sent += samples_of(target.tell(Alive(1000 + calls, sent[-1].block if frees and sent else 0)))
    if not frees:
        target.c.target_serve()
        said = target.said()
        assert [(one.fault, one.index) for one in events_of(said)] == [(Trip.NO_ROOM, 1023)]
        sent += samples_of(said)
        # Of what is kept the first is sent again as it was.
        again = samples_of(target.tell(Again(5000, 0, 2)))
        assert [one.samples.looks.tolist() for one in again] == [one.samples.looks.tolist() for one in sent[:2]]
    angles = np.concatenate([one.samples.angle_counts for one in sent])
    looks = np.concatenate([one.samples.looks for one in sent])
    assert len(angles) > (1200 if frees else 1000)
    expected = -(np.arange(64 * (len(angles) - 2)) % 1000).reshape(-1, 64)
    assert angles[1:-1].tolist() == expected[:, 0].tolist()
    assert looks[2:].tolist() == expected[:, 1:].tolist()


def test_a_pulse_or_a_torque_over_the_angle_reads_nothing_within() -> None:
    settings = told("hold that reads")._replace(block_samples=5)
    assert settings.control is not None
    for act in (PULSE, TABLE):
        target = ScriptedTarget()
        target.command(Configure(1, settings.plain))
        target.command(SetAct(2, settings.control))
        assert target.command(SetAct(3, act)).status == Status.DONE
        if act is TABLE:
            target.command(SetAct(4, PIECE))
        assert target.plain(Kind.ARM).status == Status.DONE
        target.sample()
        target.plain(Kind.START)
        for _ in range(30):
            due = target.call_at
            target.sample()
            assert target.call_at == due + settings.period_ns
        sent = samples_of(target.tell(Alive(99, 0)))
        assert sent
        assert all(one.kind is Kind.BLOCK for one in sent)


def test_a_reading_that_is_late_makes_its_sample_an_overrun() -> None:
    """By more than half the time between two readings; made all the same, and none is left out."""
    settings = told("hold that reads")._replace(block_samples=1)
    assert settings.control is not None
    target = ScriptedTarget()
    target.command(Configure(1, settings.plain))
    target.command(SetAct(2, settings.control))
    target.plain(Kind.ARM)
    target.sample()
    target.tell(Alive(98, 0))
    target.plain(Kind.START)
    target.sample()
    for late, overruns in ((124_000, 0), (126_000, 1), (0, 1), (2_600_000, 2)):
        for which in range(3):
            target.angle = -which
            target.sample(late if which == 0 else 0)
        target.sample()
        sent = samples_of(target.tell(Alive(99, 0)))
        assert sent[-1].samples.looks.tolist() == [[0, -1, -2]]
        assert sent[-1].samples.overruns == overruns
    # The next trial tells nothing that this one has read.
    target.plain(Kind.RELEASE)
    target.plain(Kind.ARM)
    target.sample()
    (first,) = samples_of(target.tell(Alive(99, 0)))
    assert (first.samples.looks.tolist(), first.samples.overruns) == ([[0, 0, 0]], 0)


def begun(state: State) -> ScriptedTarget:
    target = ScriptedTarget()
    assert target.command(Configure(1, SETTINGS)).status == Status.DONE
    target.bring_to(state)
    return target


@pytest.mark.parametrize("state", list(State))
def test_a_controller_is_taken_when_idle_only(state: State) -> None:
    target = begun(state)
    answer = target.command(SetAct(50, LAG))
    assert answer.status == (Status.DONE if state is State.IDLE else Status.NOT_NOW)
    assert answer.said == (LAG if state is State.IDLE else None)
    assert answer.state == state


def test_it_needs_settings() -> None:
    assert ScriptedTarget().command(SetAct(1, LAG)).status == Status.NOT_NOW


def torque_at_once(target: ScriptedTarget) -> float:
    """Torque of the first sample with the wall on, a count inside, where the knob was not before."""
    target.angle = 0
    target.plain(Kind.ARM)
    target.sample()
    target.plain(Kind.START)
    target.angle = -NATIVE // 1024
    target.sample()
    torque = target.torque
    target.plain(Kind.RELEASE)
    return torque


def test_settings_make_it_forget_and_nothing_else_does() -> None:
    target = begun(State.IDLE)
    plain = torque_at_once(target)
    target.command(SetAct(2, LAG))
    other = torque_at_once(target)
    assert other != plain
    target.plain(Kind.HELLO)
    assert torque_at_once(target) == other  # RELEASE came in between
    target.command(SetAct(3, LAG._replace(law=77)))  # refused: changes nothing
    assert torque_at_once(target) == other
    target.command(Configure(4, SETTINGS._replace(watchdog_us=1)))  # so is this
    assert torque_at_once(target) == other
    target.command(Configure(5, SETTINGS))
    assert torque_at_once(target) == plain


WRONG: list[tuple[str, dict[str, Any]]] = [
    ("lag", {"law": 0}),
    ("lag", {"law": 14}),
    ("half sample", {"numbers": (0.0, 0.5, 1.0, 0.9, 1.0)}),  # a sensor of the speed
    ("half sample", {"places": 0}),
    ("matched wall", {"numbers": (0.0, 1.0, 1.0, 1.0)}),  # a sensor of the speed
    ("hold in steps", {"numbers": (0.0, 1.0, 0.0, 65.0)}),
    ("hold in steps", {"numbers": (0.0, 1.0, 0.0, 0.0)}),
    ("hold in steps", {"numbers": (0.0, 1.0, 0.0, 2.5)}),
    ("impulse", {"numbers": (0.0, 0.0, 1.0, 0.0)}),
    ("impulse", {"numbers": (0.0, 1.5, 1.0, 0.0)}),
    ("impulse", {"numbers": (0.0, -0.5, 1.0, 0.0)}),
    ("lag", {"law": 255}),
    ("lag", {"numbers": (0.0, 0.1)}),
    ("lag", {"numbers": (0.0, 0.1, 0.2, 0.3)}),
    ("lag", {"rows": ()}),
    ("lag", {"rows": (0.0, 0.0)}),
    ("lag", {"places": 1}),
    *(("hold", {"numbers": (0.0, 1.0, looks, 1.0)}) for looks in (64.0, 2.5, -1.0, 1e300)),  # 63 at most
    ("passivity", {"places": 0}),
    ("damping", {"numbers": (0.0, -1.0, 1.0, 0.0, 1.0, 0.0, 9.0)}),  # a sensor of the speed
    ("damping", {"numbers": (0.0, -1.0, 0.0, 0.0, 2.0, 0.0, 9.0)}),  # a window that the rows do not have
    *(("damping", {"numbers": (0.0, -1.0, 0.0, 0.0, window, 0.0, 9.0)}) for window in (0.0, 1.5, -1.0, 65.0, 1e300)),
    ("adaptive", {"numbers": (0.0, -1.0, 0.0, 0.0, 9.0, 0.0, 6.0, 8.0)}),  # another place of the last reading
    ("adaptive", {"numbers": (0.0, -1.0, 0.0, 0.0, 9.0, 0.0, 1e9, 8.0)}),
    *(("timed", {"numbers": (0.0, -1.0, 0.0, 0.0, 9.0, 0.0, 2.0, all_of, 80.0)}) for all_of in (65.0, 0.0, 1.5)),
    *(("impulse as long as an interval", {"numbers": (0.0, 1.0, 1.0, looks)}) for looks in (64.0, 0.5, -1.0)),
]


@pytest.mark.parametrize(("name", "changes"), WRONG)
def test_what_no_target_runs_is_out_of_range(name: str, changes: dict[str, Any]) -> None:
    answer = begun(State.IDLE).command(SetAct(2, made(name)._replace(**changes)))
    assert (answer.status, answer.said) == (Status.OUT_OF_RANGE, None)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_numbers_must_be_numbers(bad: float) -> None:
    for changes in ({"numbers": (0.0, bad, 0.2)}, {"rows": (bad,)}):
        assert not library().control_in_range(CControl.of(LAG._replace(**changes)))


def test_a_torque_that_is_no_number_trips() -> None:
    target = begun(State.IDLE)
    target.command(SetAct(2, LAG._replace(numbers=(0.0, 1e308, 0.2), rows=(-1e308,))))
    target.plain(Kind.ARM)
    target.sample()
    target.plain(Kind.START)
    target.angle = -600
    for _ in range(3):
        if target.call_at < 2**64 - 1:
            target.sample()
    assert target.torque == 0.0
    target.c.target_serve()
    assert events_of(target.said())[0].fault == Trip.NOT_A_NUMBER
