"""What the rules of the hardware allow last, and what they refuse first; small parts by hand."""

import json
import struct
from fractions import Fraction
from math import floor, tau
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.hardware.control import GripTrigger, Phase, ShapedWall, over_angle_of
from hknob_cli.hardware.journal import ABOUT, read_about
from hknob_cli.hardware.knob_motion import LATEST, Disturbances, Nuisances
from hknob_cli.hardware.order import USUAL_GRIP_N, faults_of_settings, faults_of_simulated, settings_of, trials_of
from hknob_cli.hardware.person import Person, _push
from hknob_cli.hardware.port import ROUNDINGS, Block, Converters, OverAngle, PulseOrder, Sine
from hknob_cli.hardware.trial_file import about_pulse, joined
from hknob_cli.hardware.trial_phases import Ended, PulsePhases
from hknob_cli.hardware.trial_wall import MOST, NONE, Conversion, Slot, converters_of, room_of, slots_of
from hknob_cli.hardware.wire.answers import BLOCK, LOOKS, _unpack_block
from hknob_cli.hardware.wire.codes import HAND as HAND_OF_WIRE
from hknob_cli.hardware.wire.codes import MOST_HANDS, MOST_SINES, SINE, SQUEEZE, Kind, unpack_squeeze
from hknob_cli.hardware.wire.messages import Decoder, Unread, frame, is_message, nobody_text
from hknob_cli.specs.over_angle import Effects, EndStops
from hknob_cli.specs.parts import Actuator
from hknob_cli.specs.pulses import Pulses, Window
from tests.hardware.campaigns import SPEC, planned
from tests.hardware.trials import ALIGNED, HAND, settings


def test_torque_over_the_angle_and_the_walls_damper() -> None:
    """The damper inside alone, over the interval; sizes add."""
    over = OverAngle(first=-4, turn=1000, below=0.0, above=0.0, torques=(0.0, 0.1, 0.2, 0.0, 0.3))
    wall = ShapedWall(settings(2000, 1000, wall_damping=1e-4), over)
    brake = 1e-4 * (tau / 1000) * 2000
    assert wall.torques(-2, -3) == [pytest.approx(0.2 - brake)]
    assert wall.torque(-2, -1) == pytest.approx(0.2 + brake)
    assert wall.torques(0, -3) == [0.3]
    for before in (-3, -1):
        torques, size = wall.sized(-2, before)
        assert torques == wall.torques(-2, before)
        assert size == pytest.approx(0.2 + brake)


def test_a_table_over_the_angle_is_in_newton_meters() -> None:
    """A spring below half a radian, and the wall's, at the counts' lower edges."""
    told = settings(1000, 1000, wall_stiffness=0.25)
    found = over_angle_of(Effects(end_stops=EndStops(2.0, low=-0.5)), told)
    assert (found.first, len(found.torques)) == (-86, 91)  # from within the stop to where nothing is left
    wall = ShapedWall(told, found)
    for count in (-1, -100, -200):
        angle = count * tau / 1000
        stop = 2.0 * max(0.0, -0.5 - angle)
        assert wall.torques(count, count) == [pytest.approx(0.25 * -angle + stop, abs=0.02)]
    assert wall.torques(3, 3) == [0.0]


@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("native", [5, 1000, 1001])
def test_counts_of_the_wall_are_exact(rounding: str, native: int) -> None:
    """Against whole fractions: one by one, and many at once."""
    told = settings(1000, 512, converters=Converters(rounding=ROUNDINGS.index(rounding)))
    conversion = Conversion(told, native)
    angles = range(-40, 40)
    exact = [Fraction(angle * 512, native) for angle in angles]
    by = {
        "floor": [floor(one) for one in exact],
        "nearest": [floor((angle * 512 + native // 2) // native) for angle in angles],
        "ceil": [floor(one) + 1 for one in exact],
        "truncate": [floor(one) + 1 if floor(one) < 0 else floor(one) for one in exact],
    }
    assert [conversion.count(angle) for angle in angles] == by[rounding]
    assert conversion.counts(np.array(angles)).tolist() == by[rounding]


def test_which_converters_make_steps() -> None:
    assert converters_of(None, Actuator(delay_samples=1.0)) == NONE._replace(delay_samples=1.0)
    assert converters_of(None, Actuator(torque_limit=0.5)) == NONE._replace(limit_nm=0.5)
    for name, steps in (("step_nm", True), ("dead_band_nm", True), ("limit_nm", False)):
        assert Conversion(settings(converters=NONE._replace(**{name: 1e-3})), 1000).steps is steps


def test_a_hand_has_let_go_below_the_level_and_not_at_it() -> None:
    trigger = GripTrigger(PulseOrder(2.0, 0.1, 0.0, 0.5, 0.2, 2e-3), 1e-3)
    for cell, phase in ((0.5, Phase.RELAX), (0.49, Phase.SQUEEZE), (2.0, Phase.PULSE), (0.5, Phase.PULSE)):
        trigger.step(cell, running=True)
        assert trigger.phase is phase
    trigger.step(0.5, running=True)
    assert trigger.phase is Phase.RELEASE
    trigger.step(0.49, running=True)
    assert trigger.phase is Phase.DONE


def pulse_block(first: int, grips: list[float], torques: list[float], *, on: bool = True) -> Block:
    count = len(grips)
    times = (first + np.arange(count)) * 1000
    return Block(first, times, np.zeros(count, int), np.array(torques), np.array(grips), np.full(count, on), 0)


def test_a_pulse_is_over_when_its_window_is_recorded() -> None:
    """A sample more than that, where the hand has let go."""
    order = PulseOrder(2.0, 0.1, 0.0, 0.5, 0.25, 2e-3)
    pulses = Pulses(zero=0.002, timeout=0.02, window=Window(0.004, 0.008))
    phases = PulsePhases(pulses, order, 1e-3)
    assert (phases.grip_n, phases.torque_nm, phases.phase_s, phases.zeroed) == (0.0, 0.0, 0.0, False)
    assert phases.follow(pulse_block(0, [0.0] * 2, [0.0] * 2, on=False)) is None
    assert phases.zeroed
    assert phases.follow(pulse_block(2, [0.0, 2.0, 2.0, 0.0], [0.0, 0.25, 0.25, 0.0])) is None
    assert (phases.settled_sample, phases.grip_n, phases.torque_nm) == (3, 1.0, 0.0)
    ended = [phases.follow(pulse_block(6 + i, [0.0], [0.0])) for i in range(6)]
    assert ended == [None] * 5 + [Ended.RELEASED]


@pytest.mark.parametrize("fired", range(100, 900, 7))
def test_a_window_has_both_its_edges_wherever_it_lies(fired: int) -> None:
    """However its times are rounded."""
    count = 1000
    samples = joined([pulse_block(0, [0.0] * count, [0.0] * count)])
    kept = about_pulse(samples, fired, Window(0.05, 0.1))
    assert kept.number.tolist() == list(range(fired - 50, fired + 101))
    last = about_pulse(samples, None, Window(0.05, 0.1))
    assert last.number.tolist() == list(range(count - 151, count))


def test_every_sample_may_be_late_and_no_more_than_that() -> None:
    assert Nuisances(late_share=1.0).checked().late_share == 1.0
    with pytest.raises(UsageError, match=r"late_share must be <= 1, got 1\.01"):
        Nuisances(late_share=1.01).checked()
    assert LATEST == 3.0
    _, late = Disturbances(Nuisances(late_share=1.0), settings(), HAND).begins(2000)
    assert late.min() >= 0.5
    assert 2.9 < late.max() < 3.0


def test_no_push_has_no_sines() -> None:
    assert _push(Person(push_nm=0.0), 0.0, np.random.default_rng(1)) == (0.0, ())


def test_a_controllers_hand_is_that_of_the_grip() -> None:
    remedies = "reference: half\nremedies: {half: {change: {controller: {kind: half_sample}}}}\n"

    def numbers(grip: str) -> Any:
        plan = planned(SPEC + remedies + f"grip: {grip}\n")
        control = settings_of(plan, trials_of(plan)[0]).control
        assert control is not None
        return control.numbers

    assert numbers("none") == numbers(f"{{target: {USUAL_GRIP_N}}}")
    assert numbers("{target: 4}") != numbers("none")


KNOWING = ALIGNED._replace(knows_converters=True, knows_over_angle=True)
RANGES = {
    "period_ns": (KNOWING.shortest_period_ns, 10**9),
    "counts_per_rev": (1, KNOWING.native_counts),
    "wall_stiffness": (0.0, 1e3),
    "wall_damping": (0.0, 1e3),
    "torque_limit_nm": (5e-324, 10.0),
    "speed_limit_rad_s": (5e-324, 1e4),
    "watchdog_us": (1000, 50_000),
    "block_samples": (1, 48),
}


@pytest.mark.parametrize("name", RANGES)
def test_settings_at_the_ends_of_their_ranges(name: str) -> None:
    """The block as long as 50 ms at most is another rule."""
    least, most = RANGES[name]
    for value in (least, most):
        assert faults_of_settings(settings()._replace(**{name: value}), KNOWING) == []
    beyond = [least - 1, most + 1] if isinstance(least, int) else [np.nextafter(least, -1.0), np.nextafter(most, 1e9)]
    for value in beyond:
        (said,) = faults_of_settings(settings()._replace(**{name: value}), KNOWING)
        assert said.startswith(f"{name} must be ")


def test_room_for_torques_that_are_under_way() -> None:
    assert room_of(1, MOST - 2.0) == MOST
    for delay, faults in ((MOST - 2.0, 0), (MOST - 1.0, 1)):
        told = settings(converters=NONE._replace(delay_samples=delay))
        assert len(faults_of_settings(told, KNOWING)) == faults
        over = OverAngle(first=0, turn=1024, below=0.0, above=0.0, torques=(0.0,))
        assert len(faults_of_settings(told._replace(over_angle=over), KNOWING)) == faults


def test_as_many_sines_as_there_is_room_for() -> None:
    sine = Sine(1e-3, 1.0, 0.0)
    for name in ("push_sines", "grip_sines"):
        assert faults_of_simulated(HAND._replace(**{name: (sine,) * MOST_SINES})) == []
        (said,) = faults_of_simulated(HAND._replace(**{name: (sine,) * (MOST_SINES + 1)}))
        assert said.startswith(f"at most {MOST_SINES} sines")


def test_when_late_torques_go_out() -> None:
    assert slots_of((0.0,), 0.0) == [Slot(0.0, 0, 0)]
    assert slots_of((0.0,), 1.25) == [Slot(0.0, 2, 0), Slot(0.25, 1, 0)]
    assert slots_of((0.0, 0.5), 2.0) == [Slot(0.0, 2, 0), Slot(0.5, 2, 1)]
    assert slots_of((0.0, 0.5), 2.25) == [Slot(0.0, 3, 1), Slot(0.25, 2, 0), Slot(0.75, 2, 1)]


@pytest.mark.parametrize(
    ("climbs", "hands", "sines", "good"),
    [
        (0, 0, 0, True),
        (1, MOST_HANDS, MOST_SINES, True),
        (2, 1, 1, False),
        (1, MOST_HANDS + 1, 0, False),
        (1, 0, MOST_SINES + 1, False),
    ],
)
def test_hands_and_sines_of_a_squeeze(climbs: int, hands: int, sines: int, *, good: bool) -> None:
    data = SQUEEZE.pack(*[1.0] * 6, climbs, hands, sines)
    data += b"".join([HAND_OF_WIRE.pack(*[1.0] * 4)] * hands + [SINE.pack(*[1.0] * 3)] * sines)
    if good:
        assert len(unpack_squeeze(data).hands) == hands
    else:
        with pytest.raises(struct.error):
            unpack_squeeze(data)


def test_a_block_has_a_sample_and_readings_where_it_says_so() -> None:
    head = BLOCK.pack(1, 2, 3, 4, 0, 0)
    with pytest.raises(ValueError, match="length"):
        _unpack_block(head, looks=False)
    with pytest.raises(ValueError, match="readings"):
        _unpack_block(head + LOOKS.pack(0), looks=True)


def test_what_would_be_a_message() -> None:
    """The version, the type of an answer, and something besides the checksum."""
    for body, is_one in (
        (bytes((1, Kind.ACK, 7)), True),
        (bytes((1, Kind.EVENT, 7)), True),
        (bytes((1, Kind.ACK - 1, 7)), False),
        (bytes((1, Kind.EVENT + 1, 7)), False),
        (bytes((2, Kind.ACK, 7)), False),
        (bytes((1, Kind.ACK)), False),
    ):
        assert is_message(frame(body)[:-1]) is is_one, body


def test_what_could_not_be_read_since() -> None:
    assert Unread(5, 7).since(Unread(2, 3)) == Unread(3, 4)


@pytest.mark.parametrize(("none", "amid"), [(1, False), (0, True), (0, False)])
def test_text_from_a_port_is_not_nobody(none: int, *, amid: bool) -> None:
    said = nobody_text(Unread(0, none), versions=set(), echoed=False, amid=amid, baud=115_200, patience_s=2.0)
    assert said.startswith("what comes from this port is not the protocol" if none or amid else "nobody answered")


def test_a_frame_of_nothing_is_none() -> None:
    decoder = Decoder()
    assert decoder.feed(b"\0\0") == []
    assert (decoder.damaged, decoder.held) == (0, 0)


@pytest.mark.parametrize("said", [{"identity": 5, "source": True}, {"identity": "a", "source": 1}, {"identity": "a"}])
def test_a_folder_that_says_something_else_says_nothing(said: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / ABOUT).write_text(json.dumps({"identity": "a", "source": True}))
    assert read_about(tmp_path) == {"identity": "a", "source": True}
    (tmp_path / ABOUT).write_text(json.dumps(said))
    assert read_about(tmp_path) is None
