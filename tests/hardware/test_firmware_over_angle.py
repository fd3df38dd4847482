"""The target's torque over the angle: the engine's commands to the last bit, the wire's pieces, and what is taken."""

import math
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.torque_table import command_at
from hknob_cli.errors import DeviceError
from hknob_cli.hardware.control import ShapedWall, over_angle_of
from hknob_cli.hardware.order import MOST_OVER_ANGLE, faults_of_settings
from hknob_cli.hardware.port import Block, OverAngle, Settings
from hknob_cli.hardware.safety import LimitMonitor
from hknob_cli.hardware.serial_device import SerialDevice
from hknob_cli.hardware.virtual import IDENTITY
from hknob_cli.hardware.wire.codes import MOST_TORQUES, Kind, Piece, State, Status, pieces_of
from hknob_cli.hardware.wire.commands import Alive, Configure, SetAct
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.over_angle import DeadZone, Detents, Effects, EndStops, Profile
from hknob_cli.specs.plan import Knob, Scene, Wall
from tests.hardware.fake_target import PtyTarget
from tests.hardware.firmware import COverAngle, CPiece, CTable, ScriptedTarget, library, samples_of
from tests.hardware.golden import PIECE, SETTINGS, TABLE

NATIVE = 640_000  # of the scripted board
POINTS = ((-0.3, -0.01), (0.1, 0.02), (0.4, 0.005))
AROUND = Profile(points=((0.0, 0.01), (0.7, -0.01), (math.tau, 0.01)), periodic=True)
CASES: dict[str, tuple[Effects, dict[str, float]]] = {
    "profile": (Effects(profile=Profile(points=POINTS)), {}),
    "stepped": (Effects(profile=Profile(points=POINTS, interpolation="stepped")), {}),
    "profile all round": (Effects(profile=AROUND), {}),
    "detents": (Effects(detents=Detents(torque=0.006, per_revolution=12, shape="spring", dead_zone=0.05)), {}),
    "detents, odd number": (Effects(detents=Detents(torque=0.006, per_revolution=7)), {"wall_stiffness": 0.27}),
    "detents in a range": (
        Effects(detents=Detents(torque=0.006, spacing=0.2, range=(-0.5, 0.9), shape="triangle")),
        {},
    ),
    "stops": (Effects(end_stops=EndStops(stiffness=0.3, low=-0.5, high=0.8)), {}),
    "dead zone": (Effects(dead_zone=DeadZone(width=0.2, stiffness=0.1, torque=0.03)), {}),
    "all, and a damped wall": (
        Effects(
            profile=Profile(points=POINTS),
            detents=Detents(torque=0.006, per_revolution=12),
            end_stops=EndStops(stiffness=0.3, high=1.0),
            dead_zone=DeadZone(width=0.2, stiffness=0.1, centre=0.1),
        ),
        {"wall_stiffness": 0.27, "wall_damping": 1e-4},
    ),
}


def told(name: str, counts: int = 1024, **changes: float) -> Settings:
    """Settings of a trial with the torque of a case, whose wall has no stiffness where it says none."""
    effects, walls = CASES[name]
    plain = SETTINGS._replace(
        **{"wall_stiffness": 0.0, "wall_damping": 0.0, "counts_per_rev": counts} | walls | changes
    )
    return plain._replace(over_angle=over_angle_of(effects, plain))


def over(name: str, counts: int = 1024) -> OverAngle:
    found = told(name, counts).over_angle
    assert found is not None
    return found


def filled(one: OverAngle) -> COverAngle:
    """The target's table after all its pieces have come."""
    table = COverAngle()
    head, pieces = pieces_of(one)
    assert library().over_angle_begin(table, CTable(*head))
    for piece in pieces:
        assert table.filled == piece.at
        assert library().over_angle_take(table, CPiece.of(piece))
    assert table.filled == head.size
    return table


@pytest.mark.one_in(5)
@pytest.mark.parametrize("counts", [256, 1000, 1024, 2048])
@pytest.mark.parametrize("name", CASES)
def test_torques_are_those_of_the_engine_to_the_last_bit(name: str, counts: int) -> None:
    settings = told(name, counts)
    one = over(name, counts)
    table, wall = filled(one), ShapedWall(settings, one)
    quantum, seen = math.tau / counts, set()
    rng = np.random.default_rng(counts)
    far = rng.integers(-(10**6), 10**6, 2000).tolist()
    before = 3
    for count in [*range(-2 * counts, 2 * counts), *far, -(2**31), 2**31 - 1]:
        brake = library().wall_brake(count, before, quantum, settings.interval_s, settings.wall_damping)
        torque = library().over_angle_torque(table, count) - brake
        assert torque == wall.torque(count, before)
        before = count
        seen.add(torque)
    assert len(seen) >= 3


@pytest.mark.parametrize("counts", [256, 1024])
@pytest.mark.parametrize("name", CASES)
def test_the_table_is_that_of_a_simulated_scene(name: str, counts: int) -> None:
    """A sweep's table is in units of the knob's acceleration: each of its parts is rounded a few times more."""
    effects, walls = CASES[name]
    scene = Scene(knob=Knob(2e-6), wall=Wall(walls.get("wall_stiffness", 0.0)), **effects._asdict())
    knob = sample_general(scene, sample_rate_hz=4000.0, counts_per_rev=counts)
    one, unit = over(name, counts), knob.torque_nm
    largest = max(map(abs, one.torques))
    table = filled(one)
    for count in range(-2 * counts, 2 * counts):
        torque = library().over_angle_torque(table, count)
        # The sum of the parts, and the turns beyond the ends: each part is at most some ten times the largest here.
        bound = 16 * 2.3e-16 * (10 * largest + abs(torque))
        assert abs(command_at(float(count), knob.wall.table) * unit - torque) <= bound


@pytest.mark.parametrize("name", CASES)
def test_a_trial_is_that_of_the_table(name: str) -> None:
    settings = told(name, block_samples=5, torque_limit_nm=0.02, speed_limit_rad_s=1e4)
    one = over(name)
    target, wall = ScriptedTarget(), ShapedWall(settings, one)
    load(target, settings)
    target.plain(Kind.ARM)
    target.angle = -900
    for _ in range(3):
        target.sample()
    assert target.torque == 0.0
    target.plain(Kind.START)
    before, expected, sent = -900 * 1024 // NATIVE, [], []
    for turned in np.cumsum(np.random.default_rng(3).integers(-40, 41, 800)).tolist():
        target.angle = turned * 300
        coarse = target.angle * 1024 // NATIVE
        target.sample()
        expected.append(max(-0.02, min(0.02, wall.torque(coarse, before))))
        assert target.torque == expected[-1]
        before = coarse
        target.nonce += 1
        sent += samples_of(target.tell(Alive(target.nonce, 0)))
    assert len(set(expected)) >= 3
    told_of = np.concatenate([each.samples.torque_nm[each.samples.running] for each in sent])
    assert np.array_equal(told_of, np.array(expected[: told_of.size]).astype(np.float32))


def load(target: ScriptedTarget, settings: Settings) -> None:
    """Configure, and hand over the table: every piece is told back from where it was put."""
    assert settings.over_angle is not None
    assert target.command(Configure(1, settings.plain)).status == Status.DONE
    head, pieces = pieces_of(settings.over_angle)
    assert target.command(SetAct(2, head)).said == head
    for number, piece in enumerate(pieces):
        assert target.command(SetAct(3 + number, piece)).said == piece
    target.nonce = 3 + len(pieces)


def begun() -> ScriptedTarget:
    target = ScriptedTarget()
    assert target.command(Configure(1, SETTINGS)).status == Status.DONE
    return target


def test_it_is_not_armed_before_all_torques_have_come() -> None:
    target = begun()
    assert target.command(SetAct(2, TABLE)).status == Status.DONE
    assert target.plain(Kind.ARM).status == Status.NOT_NOW
    assert target.command(SetAct(3, PIECE._replace(torques=PIECE.torques[:4]))).status == Status.DONE
    assert target.plain(Kind.ARM).status == Status.NOT_NOW
    assert target.command(SetAct(4, Piece(4, (0.0, 0.0)))).status == Status.DONE
    assert target.plain(Kind.ARM).status == Status.DONE


def test_a_piece_that_comes_twice_is_taken_once() -> None:
    target = begun()
    target.command(SetAct(2, TABLE))
    half = SetAct(3, Piece(0, (1.0, 0.75, 0.5)))
    assert target.command(half).said == half.act
    assert target.command(half).said == half.act  # the answer was lost: the same nonce
    assert target.command(SetAct(4, Piece(3, (0.25, 0.0, 0.0)))).status == Status.DONE
    assert target.plain(Kind.ARM).status == Status.DONE


def test_settings_make_it_forget_the_table() -> None:
    target = begun()
    target.command(SetAct(2, TABLE))
    target.command(Configure(3, SETTINGS))
    assert target.command(SetAct(4, PIECE)).status == Status.NOT_NOW
    assert target.plain(Kind.ARM).status == Status.DONE


@pytest.mark.parametrize("state", list(State))
def test_it_is_taken_when_idle_only(state: State) -> None:
    target = begun()
    target.command(SetAct(2, TABLE))
    target.command(SetAct(3, PIECE))
    target.bring_to(state)
    assert target.command(SetAct(50, TABLE)).status == (Status.DONE if state is State.IDLE else Status.NOT_NOW)
    assert target.command(SetAct(51, PIECE)).status == (Status.DONE if state is State.IDLE else Status.NOT_NOW)


def test_it_needs_settings_and_torques_need_a_table() -> None:
    assert ScriptedTarget().command(SetAct(1, TABLE)).status == Status.NOT_NOW
    assert begun().command(SetAct(1, PIECE)).status == Status.NOT_NOW


WRONG_TABLES: list[dict[str, Any]] = [
    {"size": 0},
    {"size": MOST_OVER_ANGLE + 1},
    {"size": 2**32 - 1, "turn": 2**32 - 1},
    {"turn": 0},
    {"turn": 7},
]


@pytest.mark.parametrize("changes", WRONG_TABLES)
def test_a_table_that_is_none_is_refused(changes: dict[str, Any]) -> None:
    assert begun().command(SetAct(2, TABLE._replace(**changes))).status == Status.OUT_OF_RANGE


def test_the_ends_of_the_ranges_are_in() -> None:
    for changes in ({"size": 1, "turn": 1}, {"turn": 6}, {"size": MOST_OVER_ANGLE}):
        assert library().over_angle_begin(COverAngle(), CTable(*TABLE._replace(**changes)))
    for bad in (math.nan, math.inf):
        assert not library().over_angle_begin(COverAngle(), CTable(*TABLE._replace(below=bad)))
        assert not library().over_angle_begin(COverAngle(), CTable(*TABLE._replace(above=bad)))


@pytest.mark.parametrize("piece", [Piece(1, (0.0,)), Piece(0, ()), Piece(0, (0.0,) * 7), Piece(2**32 - 1, (0.0,))])
def test_a_piece_that_is_not_the_next_is_refused(piece: Piece) -> None:
    target = begun()
    target.command(SetAct(2, TABLE))
    assert target.command(SetAct(3, piece)).status == Status.OUT_OF_RANGE
    assert target.command(SetAct(4, PIECE)).status == Status.DONE


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_torque_that_is_no_number_is_refused_and_nothing_of_its_piece_taken(bad: float) -> None:
    table = COverAngle()
    assert library().over_angle_begin(table, CTable(*TABLE))
    assert not library().over_angle_take(table, CPiece.of(Piece(0, (0.0, bad))))
    assert table.filled == 0


def test_pieces_are_the_whole_table_in_order() -> None:
    head, pieces = pieces_of(over("detents, odd number"))
    assert head.size > 100 * MOST_TORQUES
    assert sum((piece.torques for piece in pieces), ()) == over("detents, odd number").torques
    assert [piece.at for piece in pieces] == list(range(0, head.size, MOST_TORQUES))


def test_too_long_a_table_is_said_to_be() -> None:
    settings = told("detents, odd number", 8192)
    (fault,) = faults_of_settings(settings, IDENTITY)
    assert "takes a table of" in fault
    assert "choose fewer counts" in fault


def test_an_older_target_is_refused_before_it_is_configured() -> None:
    """One that knows CONTROL, and neither pulses nor torque over the angle."""
    with PtyTarget() as fake, SerialDevice(fake.url) as device:
        with pytest.raises(DeviceError, match="no torque over the angle: it does not know OVER_ANGLE"):
            device.configure(told("detents"))
        assert Kind.CONFIGURE not in fake.target.heard


def test_the_host_holds_a_device_to_its_table() -> None:
    settings = told("all, and a damped wall", torque_limit_nm=0.05)
    wall = ShapedWall(settings, over("all, and a damped wall"))
    angles = 400 * np.cumsum(np.random.default_rng(1).integers(-3, 4, 200))
    coarse = angles * 1024 // NATIVE
    running = np.arange(200) >= 10
    before = np.concatenate([coarse[:1], coarse[:-1]])
    acting = [wall.torque(*pair) for pair in zip(coarse.tolist(), before.tolist(), strict=True)]
    torques = np.clip(acting, -0.05, 0.05) * running
    block = Block(0, 250 * np.arange(200), angles, torques.astype(np.float32).astype(float), np.zeros(200), running, 0)

    def check(torque_nm: np.ndarray) -> None:
        watch = LimitMonitor(settings, NATIVE, wired=True)
        watch.start()
        watch.check(block._replace(torque_nm=torque_nm))

    check(block.torque_nm)
    for place in (5, 60, 199):
        wrong = block.torque_nm.copy()
        wrong[place] += 1e-4
        with pytest.raises(DeviceError, match=f"at sample {place},"):
            check(wrong)
