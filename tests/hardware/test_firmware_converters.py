"""The target's converters: counts, sent torques and delays as the engine has them, to the last bit."""

import ctypes as c
import math
import random
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.controller import send
from hknob_cli.hardware.control import begins_of
from hknob_cli.hardware.port import ROUNDINGS, Converters, Settings
from hknob_cli.hardware.trial_wall import MOST, Conversion, TorqueLine, TrialWall, converters_of, room_of, slots_of
from hknob_cli.hardware.wire.codes import Kind, Law, State, Status
from hknob_cli.hardware.wire.commands import Alive, Configure, Plain, SetAct
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.plan import Actuator, Encoder, Hand, Knob, Scene, Wall
from tests.hardware.controllers import CONTROLLERS, MODEL, readings, told
from tests.hardware.firmware import CConverters, CLine, ScriptedTarget, library, samples_of
from tests.hardware.golden import CONVERTERS, SETTINGS
from tests.hardware.trials import settings

NATIVE = 640_000  # of the scripted board
OFFSETS = (0.0, 0.25, 0.3, 1.0 - 2.0**-40)


def true_count(angle: int, counts: int, native: int, told: Converters) -> int:
    """The count just above the edge at which the target's own encoder shows ``angle``, in exact fractions."""
    place = Fraction(angle * counts - math.floor(told.offset_counts * native + 0.5), native)
    kind = ROUNDINGS[told.rounding]
    if kind == "nearest":
        return math.floor(place + Fraction(1, 2))
    return math.floor(place) + (1 if kind == "ceil" or (kind == "truncate" and place < 0) else 0)


@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("rounding", range(4))
@pytest.mark.parametrize(("counts", "native"), [(1024, NATIVE), (1000, NATIVE), (4096, 4096), (256, 16385), (3, 7)])
def test_counts_are_exact(rounding: int, offset: float, counts: int, native: int) -> None:
    one = Converters(offset_counts=offset, rounding=rounding)
    host = Conversion(settings(1000, counts)._replace(converters=one), native)
    rng = random.Random(rounding)
    near = [round(k * native / counts) + d for k in range(-20, 20) for d in range(-2, 3)]
    angles = [*near, *(rng.randrange(-(2**31), 2**31) for _ in range(500)), -(2**31), 2**31 - 1]
    found = [library().convert_count(CConverters(*one), angle, counts, native) for angle in angles]
    assert found == [host.count(angle) for angle in angles]
    assert host.counts(np.array(angles)).tolist() == found
    assert found == [true_count(angle, counts, native, one) for angle in angles]


@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("offset", [0.0, 0.25])
def test_counts_are_those_of_the_engine(rounding: Any, offset: float) -> None:
    """At angles that the target's own encoder tells from an edge: it has 640 counts to one of the wall's."""
    scene = Scene(
        knob=Knob(1.9e-6), wall=Wall(0.27), hand=Hand(), encoder=Encoder(rounding=rounding, offset_counts=offset)
    )
    knob = sample_general(scene, sample_rate_hz=1000.0, counts_per_rev=1000)
    from hknob_cli.engine.general.controller import read

    converters = converters_of(scene.encoder, None)
    host = Conversion(settings(1000, 1000)._replace(converters=converters), NATIVE)
    for angle in range(-3000, 3000, 7):
        middle = (angle + 0.5) * math.tau / NATIVE
        assert host.count(angle) == int(read(knob.position(middle), knob.wall))
    assert knob.wall.offset == (converters or Converters()).offset_counts


SENT = [
    Converters(),
    Converters(dead_band_nm=2e-3),
    Converters(step_nm=5e-4),
    Converters(limit_nm=4e-3),
    Converters(dead_band_nm=1.2e-3, step_nm=7e-4, limit_nm=5e-3),
]


@pytest.mark.parametrize("one", SENT)
def test_what_is_sent_is_that_of_the_engine_to_the_last_bit(one: Converters) -> None:
    host = Conversion(settings()._replace(converters=one), NATIVE)
    scene = Scene(
        knob=Knob(1.0),
        wall=Wall(0.27),
        encoder=Encoder(),
        actuator=Actuator(torque_limit=one.limit_nm or None, torque_step=one.step_nm, dead_band=one.dead_band_nm),
    )
    wall = sample_general(scene, sample_rate_hz=1.0, counts_per_rev=1024).wall  # its unit is a count, of 1 kg·m²
    own = wall._replace(step=one.step_nm, limit=one.limit_nm or math.inf, band=one.dead_band_nm)
    unit = math.tau / 1024
    rng, seen = random.Random(5), set()
    edges = [k * 0.5 * one.step_nm for k in range(-9, 10)] + [one.dead_band_nm, -one.dead_band_nm, 0.0, -0.0]
    for torque in [*edges, *(rng.uniform(-8e-3, 8e-3) for _ in range(5000))]:
        found = library().convert_send(CConverters(*one), torque)
        assert found == host.send(torque)
        assert found == send(torque, own)
        if torque not in edges:
            assert found == pytest.approx(send(torque / unit, wall) * unit, rel=1e-12)
        seen.add(found)
    assert len(seen) > 8


BEGINS = [(0.0,), (0.0, 0.025), (0.0, 0.5), (0.0, 1 / 3, 2 / 3), tuple(k / 64 for k in range(64))]


@pytest.mark.parametrize("delay", [0.0, 0.25, 0.5, 1.0, 1.75, 3.0, 7.3])
@pytest.mark.parametrize(
    "begins", [(0.0,), (0.0, 0.025), (0.0, 0.5), (0.0, 1 / 3, 2 / 3), tuple(k / 64 for k in range(64))]
)
def test_torques_go_out_when_they_should(begins: tuple[float, ...], delay: float) -> None:
    """Against the definition: at a time t the torque of the part that began last before t - delay acts."""
    line, host = CLine(), TorqueLine(begins, delay)
    numbers = (c.c_double * len(begins))(*begins)
    assert library().line_begin(line, len(begins), numbers, delay)
    slots = slots_of(begins, delay)
    assert [(s.begins, s.age, s.part) for s in line.slots[: line.slot_count]] == [tuple(one) for one in slots]
    assert slots[0].begins == 0.0
    assert all(a.begins < b.begins < 1.0 for a, b in pairwise(slots))
    rng = random.Random(3)
    rows: list[list[float]] = []
    for sample in range(20):
        rows.append([rng.uniform(-1.0, 1.0) for _ in begins])
        library().line_put(line, (c.c_double * len(begins))(*rows[-1]))
        out = host.put(rows[-1])
        assert [library().line_torque(line, i) for i in range(line.slot_count)] == out
        for slot, torque, end in zip(slots, out, [*(s.begins for s in slots[1:]), 1.0], strict=True):
            at = sample + 0.5 * (slot.begins + end) - delay
            born = math.floor(at)
            part = max(i for i, begin in enumerate(begins) if born + begin <= at)
            assert torque == (rows[born][part] if born >= 0 else 0.0)


def test_what_there_is_no_room_for_is_refused() -> None:
    line, begins = CLine(), (c.c_double * 64)(*(k / 64 for k in range(64)))
    for parts, delay in ((1, 1000.0), (1, 1022.0), (1, 1023.0), (64, 14.0), (64, 14.9), (64, 15.0)):
        assert library().line_begin(line, parts, begins, delay) == (room_of(parts, delay) <= MOST)


@dataclass
class Case:
    """What a trial has, by the names of `CONTROLLERS`; the plain wall without one."""

    name: str
    converters: Converters


CASES = [
    Case("", CONVERTERS),
    Case("", Converters(delay_samples=0.5)),
    Case("", Converters(delay_samples=2.0, rounding=2, offset_counts=0.3)),
    Case("half sample", Converters(offset_counts=0.25, rounding=1)),
    Case("impulse", Converters(delay_samples=1.25, step_nm=2e-4)),
    Case("hold in steps", Converters(delay_samples=0.7, limit_nm=0.02)),
    Case("matched wall", Converters(rounding=3, dead_band_nm=1e-3)),
]


def settings_of(case: Case) -> Settings:
    from hknob_cli.hardware.control import control_of

    plain = settings(4000, block_samples=5, wall_damping=1e-6, torque_limit_nm=0.2, speed_limit_rad_s=1e4)
    plain = plain._replace(converters=case.converters)
    return plain._replace(control=control_of(CONTROLLERS[case.name], plain, MODEL)) if case.name else plain


@pytest.mark.parametrize("case", CASES)
def test_a_trial_is_that_of_the_host(case: Case) -> None:
    """Every torque at its time, the first of an interval recorded as the wire rounds it."""
    own = settings_of(case)
    target, wall = ScriptedTarget(), TrialWall(own, NATIVE)
    assert target.command(Configure(1, own.plain)).status == Status.DONE
    answer = target.command(SetAct(2, case.converters))
    assert (answer.status, answer.said) == (Status.DONE, case.converters)
    if own.control is not None:
        assert target.command(SetAct(3, own.control)).said == own.control
    target.plain(Kind.ARM)
    target.angle = -900
    for _ in range(3):
        target.sample()
    target.plain(Kind.START)
    before, first, sent, every = wall.count(-900), [], [], set()
    for count in readings(11, 600):
        target.angle = count * NATIVE // 1024 + 100
        coarse, due = wall.count(target.angle), target.call_at
        expected = wall.torques(coarse, before)
        target.sample()
        assert target.torque == expected.torque_nm
        first.append(target.torque)
        for begins, torque in zip(wall.begins[1:], expected.later, strict=True):
            assert target.call_at == due + int(begins * own.period_ns)
            target.sample()
            assert target.torque == torque
            every.add(torque)
        assert target.call_at == due + own.period_ns
        before = coarse
        target.nonce += 1
        sent += samples_of(target.tell(Alive(target.nonce, 0)))
    assert len(set(first)) > 8
    assert (len(every) > 8) == (len(wall.begins) > 1)
    told_of = np.concatenate([one.samples.torque_nm[one.samples.running] for one in sent])
    assert np.array_equal(told_of, np.array(first[: told_of.size]).astype(np.float32))
    assert told_of.size > 590


def begun(state: State = State.IDLE) -> ScriptedTarget:
    target = ScriptedTarget()
    assert target.command(Configure(1, SETTINGS)).status == Status.DONE
    target.bring_to(state)
    return target


@pytest.mark.parametrize("state", list(State))
def test_converters_are_taken_when_idle_only(state: State) -> None:
    answer = begun(state).command(SetAct(50, CONVERTERS))
    assert answer.status == (Status.DONE if state is State.IDLE else Status.NOT_NOW)
    assert answer.state == state


def test_they_need_settings_and_are_forgotten_by_others() -> None:
    assert ScriptedTarget().command(SetAct(1, CONVERTERS)).status == Status.NOT_NOW

    def torque_at_once(target: ScriptedTarget) -> float:
        target.angle = 0
        target.plain(Kind.ARM)
        target.sample()
        target.plain(Kind.START)
        target.angle = -NATIVE // 1024 * 5
        target.sample()
        torque = target.torque
        target.plain(Kind.RELEASE)
        return torque

    target = begun()
    plain = torque_at_once(target)
    target.command(SetAct(2, Converters(delay_samples=1.0)))
    assert torque_at_once(target) == 0.0
    target.plain(Kind.HELLO)
    assert torque_at_once(target) == 0.0  # RELEASE came in between
    target.command(SetAct(3, Converters(rounding=4)))  # refused: changes nothing
    assert torque_at_once(target) == 0.0
    target.command(Configure(4, SETTINGS))
    assert torque_at_once(target) == plain


@pytest.mark.parametrize(
    "changes",
    [
        {"offset_counts": 1.0},
        {"offset_counts": -0.1},
        {"dead_band_nm": -1e-3},
        {"step_nm": 11.0},
        {"limit_nm": -1e-3},
        {"delay_samples": 1000.5},
        {"delay_samples": -0.5},
        {"rounding": 4},
        {"rounding": 255},
    ],
)
def test_what_is_out_of_range_is_refused(changes: dict[str, Any]) -> None:
    answer = begun().command(SetAct(2, CONVERTERS._replace(**changes)))
    assert (answer.status, answer.said) == (Status.OUT_OF_RANGE, None)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("name", Converters._fields[:-1])
def test_numbers_must_be_numbers(name: str, bad: float) -> None:
    assert not library().converters_in_range(CConverters(*CONVERTERS._replace(**{name: bad})))


def test_what_is_under_way_stops_with_the_trial() -> None:
    """A torque that is delayed goes out no more after STOP, RELEASE or a trip, and not in the next trial."""
    for end in (Kind.STOP, Kind.RELEASE, None):
        target = begun()
        target.command(SetAct(2, Converters(delay_samples=1.5)))
        target.angle = -5000
        target.plain(Kind.ARM)
        target.sample()
        target.plain(Kind.START)
        for _ in range(6):
            target.sample()
        assert target.torque > 0.0
        if end is None:
            target.emergency = 1
            target.run(2_000_000)
            assert target.plain(Kind.HELLO).state == State.TRIPPED
            target.emergency = 0
            target.plain(Kind.RELEASE)
        else:
            target.plain(end)
        assert (target.torque, target.call_at) == (0.0, 2**64 - 1)
        target.plain(Kind.ARM)
        target.sample()
        target.plain(Kind.START)
        target.sample()
        assert target.torque == 0.0
        assert target.call_at < 2**64 - 1


def test_a_trial_that_there_is_no_room_for_is_not_armed() -> None:
    own = told("hold in many steps without correction", 4000)
    assert own.control is not None
    assert own.control.law == Law.FIRST_ORDER_HOLD
    assert len(begins_of(own.control)) == 64
    target = ScriptedTarget()
    target.command(Configure(1, own.plain))
    target.command(SetAct(2, own.control))
    target.command(SetAct(3, Converters(delay_samples=20.0)))
    assert target.plain(Kind.ARM).status == Status.OUT_OF_RANGE
    target.command(SetAct(4, Converters(delay_samples=2.0)))
    assert target.plain(Kind.ARM).status == Status.DONE


def test_a_target_says_what_it_can_do() -> None:
    target = ScriptedTarget()
    answer = target.command(Plain(Kind.ABILITIES, 77))
    assert answer.status == Status.DONE
    assert answer.said == (sum(1 << law for law in Law), 7)
