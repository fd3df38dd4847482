"""A trial's parts by hand: what is read, moved, told and kept, number by number."""

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import DeviceError, SpecError, UsageError
from hknob_cli.hardware import campaign as campaign_module
from hknob_cli.hardware import journal, order, person, trial_run
from hknob_cli.hardware.archive import Archive
from hknob_cli.hardware.campaign import GO_ON, IN_VAIN, UNSAFE, Campaign
from hknob_cli.hardware.control import ControlledWall, ShapedWall, looks_of, over_angle_of, pulse_of
from hknob_cli.hardware.journal import ABOUT, RECORDING, Journal, packed, read_journal, source_digests
from hknob_cli.hardware.knob_motion import PATIENCE, KnobMotion, Nuisances
from hknob_cli.hardware.order import faults_of_settings, key_of, settings_of, trials_of
from hknob_cli.hardware.person import (
    PRINTED_TARGET_N,
    Person,
    _grip,
    _push,
    grip_of,
    hold,
    printed_grips,
    squeezer,
    wander_sines,
)
from hknob_cli.hardware.port import Drift, OverAngle, PulseOrder, Sine, Squeeze, Torque
from hknob_cli.hardware.pulse_loop import PulsedKnob, PulseLoop
from hknob_cli.hardware.tables import _fired_s, _pulse, _pulse_doubts, _torque_hz, campaign_tables, pulse_tables
from hknob_cli.hardware.trial_file import Recorded, Samples, _more, joined, read_trial, write_trial
from hknob_cli.hardware.trial_phases import Ended, PulsePhases
from hknob_cli.hardware.trial_run import Nobody, Outcome, Task, run_trial
from hknob_cli.hardware.trial_wall import NONE, ROUNDINGS, Conversion, PlainWall, Sent, TrialWall, slots_of
from hknob_cli.hardware.virtual import IDENTITY, VirtualDevice, VirtualLoop
from hknob_cli.recordings.spectrum import torque_rises_hz
from hknob_cli.results.campaign_files import TRIED, TRUTH
from hknob_cli.specs.campaign import Course, Knob
from hknob_cli.specs.over_angle import Effects
from hknob_cli.specs.plan import EndStops
from tests.hardware import campaigns, pulses
from tests.hardware.controllers import told
from tests.hardware.fake_target import made_up
from tests.hardware.trials import HAND, settings

MS = 1e-3
KNOB = Knob(1.9e-6)
RUBS = HAND._replace(stiffness=0.0, damping=1e-4, coulomb_nm=1e-3, inertia=2e-6, angle_rad=0.0, push_nm=0.0)
PLAIN = Squeeze(
    aim_n=2.0,
    rise_s=0.5,
    overshoot=0.15,
    climbs=True,
    reaction_s=0.2,
    relax_s=0.1,
    strength_n=30.0,
    hands=((1.0, 2e-6, 1e-4, 0.0), (3.0, 2e-6, 1e-4, 0.0)),
)
ORDER = PulseOrder(grip_n=1.0, band_n=0.1, dwell_s=0.0, release_n=0.5, torque_nm=0.01, width_s=4e-3)


# The knob.


def test_a_part_of_a_period_is_a_part() -> None:
    """From rest under a constant torque without damping, half a period is a quarter of the way."""
    free = HAND._replace(damping=0.0, stiffness=0.0, angle_rad=0.0)
    for periods in (0.5, 1.0, 2.0):
        motion = KnobMotion(free, interval_s=MS, counts_per_rev=1000)
        motion.move(1e-3, 0.0, periods)
        assert motion.angle_rad == pytest.approx(0.5 * 1e-3 / free.inertia * (periods * MS) ** 2, rel=1e-12)


def test_compiling_is_asked_for_once_where_it_is_worth_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the first of many moves of a third state; at its first, where another knob has been compiled; else never."""
    asked: list[int] = []
    monkeypatch.setattr(KnobMotion, "_compile", lambda self: asked.append(self._moves))
    for lag, is_compiled, at in ((MS, False, [PATIENCE]), (MS, True, [1]), (0.0, False, [])):
        asked.clear()
        monkeypatch.setattr(KnobMotion, "_is_compiled", is_compiled)
        motion = KnobMotion(RUBS, interval_s=MS, counts_per_rev=1000, amplifier_s=lag)
        monkeypatch.setattr(motion, "_advance_span", lambda *_: None)
        for _ in range(PATIENCE + 2):
            motion.move(0.0, 0.0, 0.5)
        assert asked == at


def held(simulated: Any = RUBS) -> PulsedKnob:
    """A knob in the hand of a person at 2 N."""
    one = PulsedKnob(simulated, interval_s=MS, counts_per_rev=1000, amplifier_s=0.0)
    one.take(PLAIN, 2.0)
    return one


def test_friction_takes_what_holds_a_knob_and_its_level_of_what_moves_it() -> None:
    one = held()
    for told_nm, left in ((5e-4, 0.0), (-5e-4, 0.0), (3e-3, 2e-3), (-3e-3, -2e-3)):
        assert one.sensed(told_nm, sees_friction=True)[0] == pytest.approx(left, abs=1e-18)
        assert one.sensed(told_nm, sees_friction=False)[0] == told_nm


def test_a_knob_that_rests_stays_once_all_torque_is_spent() -> None:
    """After two samples without a torque; one that has friction."""
    one = held()
    for moved, stays in ((1.0, False), (1.0, False), (1.0, True)):
        one.move(0.0, 0.0, moved)
        assert one._stays is stays
    one.move(5e-4, 0.0)
    assert not one._stays
    smooth = held(RUBS._replace(coulomb_nm=0.0))
    for _ in range(5):
        smooth.move(0.0, 0.0)
    assert not smooth._stays


def test_an_acceleration_is_by_torque_damping_and_friction() -> None:
    """None of a knob that friction holds; of a smooth one from rest too."""
    one = held()
    assert one.sensed(5e-4, sees_friction=False)[1] == 0.0
    one.move(3e-3, 0.0)
    speed = one._motion.speed_rad_s if one._motion else 0.0
    assert speed > 0.0
    assert one.sensed(0.0, sees_friction=False)[1] == pytest.approx((3e-3 - 1e-4 * speed - 1e-3) / 2e-6, rel=1e-12)
    smooth = held(RUBS._replace(coulomb_nm=0.0))
    smooth._torque_nm = 1e-3
    assert smooth.sensed(0.0, sees_friction=False)[1] == pytest.approx(1e-3 / 2e-6, rel=1e-12)


# The loop.


def pulse_loop(**changes: Any) -> PulseLoop:
    simulated = RUBS._replace(squeeze=PLAIN._replace(**changes), grip_n=1.0, grip_offset_n=0.25)
    return PulseLoop(settings(block_samples=600, pulse=ORDER), simulated, Nuisances(), 1000)


def test_nobody_squeezes_before_the_start_and_then_from_there() -> None:
    """After 0.2 s by 4 N a second."""
    loop = pulse_loop()
    assert loop.block(running=False).grip_n.tolist() == [0.25] * 600
    for begun in (loop, pulse_loop()):
        grip = begun.block(running=True).grip_n
        assert grip[:201].tolist() == [0.25] * 201
        assert grip[400] == pytest.approx(0.25 + 4.0 * 0.2, rel=1e-6)


def test_noise_of_a_sensor_is_added(monkeypatch: pytest.MonkeyPatch) -> None:
    plain, noisy = pulse_loop(sensors=(0.0, 0.0, False)), pulse_loop(sensors=(0.0, 0.0, False))
    for name in ("torque_nm", "acceleration_rad_s2"):
        monkeypatch.setattr(noisy._disturbances, name, lambda _std, count: np.full(count, 2.0**-5))
    one, other = plain.block(running=True), noisy.block(running=True)
    for name in ("measured_torque_nm", "acceleration_rad_s2"):
        assert getattr(other, name) - getattr(one, name) == pytest.approx(2.0**-5, rel=1e-5)


def test_two_samples_never_have_one_time() -> None:
    """Nor the last of a block and the first of the next, in one microsecond."""
    loop = VirtualLoop(settings(), HAND, Nuisances(), 1000)
    assert loop._microseconds(np.array([0.0, 1.0, 1.0])).tolist() == [0, 1000, 1001]
    assert loop._microseconds(np.array([1.0, 1.0, 2.0])).tolist() == [1002, 1003, 2000]


def test_a_reading_within_an_interval_has_the_noise_of_its_sample() -> None:
    loop = VirtualLoop(told("impulse that reads"), HAND, Nuisances(), 100_000)
    at = loop._motion.angle_counts
    for noise in (0.0, 2.5, -3.75):
        loop._noise = noise
        loop._look(1)
        assert loop._looked[1] == math.floor(at + noise)


def test_a_device_is_told_a_knob_or_keeps_the_one_it_was_told() -> None:
    device = VirtualDevice()
    device.configure(settings())
    with pytest.raises(DeviceError, match="no a simulated knob and person"):
        device.arm()
    device.configure(settings(), HAND)
    device.configure(settings())
    device.arm()


def test_a_walls_torques_begin_where_its_controllers_do() -> None:
    assert TrialWall(told("long impulse"), 1000).begins == (0.0, 0.5)
    assert TrialWall(told("hold in steps"), 1000).begins == pytest.approx((0.0, 1.0 / 3.0, 2.0 / 3.0))
    assert TrialWall(settings(), 1000).begins == (0.0,)


def test_a_controllers_memory_begins_with_the_place_that_is_shown() -> None:
    """A matched wall's one row: count and offset; then the reading, and those within the interval."""
    shifted = told("half sample", converters=NONE._replace(offset_counts=0.25))
    for one, rows in ((shifted, 1), (told("impulse that reads"), 1)):
        assert one.control is not None
        wall = ControlledWall(one, one.control)
        wall.torque(-3, -2)
        assert len(wall.memory) == rows + 1 + len(looks_of(one.control))
    at_rest = ControlledWall(shifted, shifted.control)  # type: ignore[arg-type]
    moving = ControlledWall(shifted, shifted.control)  # type: ignore[arg-type]
    numbers = shifted.control.numbers if shifted.control else ()
    # Of the speed that it differences: from the count before, whatever the offset.
    still, fast = at_rest.torque(-3, -3), moving.torque(-3, -2)
    quantum = math.tau / shifted.counts_per_rev
    assert fast - still == pytest.approx(0.27 * quantum * numbers[1] * numbers[3], rel=1e-12)


def test_the_size_of_a_torque_is_that_of_its_terms() -> None:
    """The law's, the brake's, and the depth's: 0.27 N m a rad, 2e-5 N m s a rad."""
    one = told("lag", wall_damping=2e-5)
    assert one.control is not None
    quantum = math.tau / one.counts_per_rev
    torques, size = ControlledWall(one, one.control).sized(-3, -1)
    (spring,) = ControlledWall(one._replace(wall_damping=0.0), one.control).torques(-3, -1)
    brake = 2e-5 * (-2.0 * quantum) / MS
    assert torques == pytest.approx([spring - brake])
    assert spring > 0.0 > brake
    assert size == pytest.approx(spring - brake + 3.0 * 0.27 * quantum)


@pytest.mark.parametrize("rounding", ["floor", "ceil", "nearest"])
def test_a_coarse_count_by_hand(rounding: str) -> None:
    """A tenth of the device's own, a quarter of a count up: its edges are at 2.5, 12.5, ... own counts."""
    shifted = NONE._replace(rounding=ROUNDINGS.index(rounding), offset_counts=0.25)
    one = Conversion(settings(counts=100, converters=shifted), 1000)
    for angle in range(-30, 31):
        at = (angle - 2.5) / 10.0
        wanted = {"floor": math.floor(at), "ceil": math.floor(at) + 1, "nearest": math.floor(at + 0.5)}[rounding]
        assert one.count(angle) == wanted
        assert one.counts(np.array([angle])).tolist() == [wanted]


# The person who squeezes.


def test_wander_is_a_share_of_the_force() -> None:
    wandering = PLAIN._replace(sines=(Sine(0.125, 0.5, 0.25), Sine(0.0625, 2.0, 1.0)))
    for time in (0.1, 0.2, 0.5, 0.7):
        t = max(time - 0.2, 0.0)
        share = 0.125 * math.sin(math.pi * t + 0.25) + 0.0625 * math.sin(4.0 * math.pi * t + 1.0)
        assert grip_of(wandering, np.array([time]), None)[0] == pytest.approx(4.0 * t * (1.0 + share), rel=1e-13)


def test_people_aim_and_cells_are_off_by_shares_of_chances(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two spreads each: 6 % above the target, two of the cell's; half of the posture's way; and nobody pushes."""

    class Chances:
        def standard_normal(self, size: int = 0) -> Any:
            return np.zeros(size) if size else 2.0

        def uniform(self, low: float, high: float) -> float:
            return low + 0.75 * (high - low)

    monkeypatch.setattr(person, "stream", lambda *_: Chances())
    for who, aim in (("person: {person: 1, ", 0.71 * 1.06), ("person: {person: 0, ", 0.71)):
        plan = pulses.planned(pulses.SPEC.replace("person: {", who))
        trial = next(one for one in trials_of(plan) if one.grip_target_n == 0.71)
        found = squeezer(plan, trial)
        assert found.squeeze
        assert found.squeeze.aim_n == pytest.approx(aim, rel=1e-14)
        assert found.grip_offset_n == pytest.approx(2.0 * Person().zero_std_n, rel=1e-14)
        assert (found.angle_rad, found.push_nm) == (pytest.approx(0.025), 0.0)


def test_each_person_and_each_block_has_a_chance_of_its_own() -> None:
    """The ratio of the hands at a grip in two blocks is that of the blocks: another for another person."""
    ratios = set()
    for who in (1, 2):
        text = pulses.SPEC.replace("person: {", f"person: {{person: {who}, ").replace("trials: 2", "trials: 1")
        plan = pulses.planned(text + "repeats: 3\n")
        hands = [squeezer(plan, one).squeeze for one in trials_of(plan) if one.grip_target_n == 0.71]
        first, *others = (one.hands[0] for one in hands if one)
        assert len(others) == 2
        ratios |= {round(other[k] / first[k], 9) for other in others for k in (1, 2, 3)}
    assert len(ratios) == 12


# What the host makes of it.


def phases() -> PulsePhases:
    return PulsePhases(pulses.planned().pulses._replace(zero=4 * MS), ORDER, MS)


def test_the_cell_is_read_for_as_long_as_told() -> None:
    one = phases()
    block = made_up(0, 3, 1000.0, started=None)._replace(torque_nm=np.zeros(3))
    one.follow(block)
    assert not one.zeroed
    one.follow(block._replace(first=3))
    assert one.zeroed


def test_a_torque_that_is_not_the_pulses_is_told_with_its_sample() -> None:
    one, block = phases(), made_up(40, 4, 1000.0, started=None)
    with pytest.raises(DeviceError, match=r"at sample 42$"):
        one.follow(block._replace(torque_nm=np.array([0.0, 0.0, 5e-3, 5e-3])))


def recorded(torques: list[float], **changes: Any) -> Recorded:
    """Samples 10, 11, ... of a pulse, at 0.5 N more each and half a radian more each."""
    import pyarrow as pa

    count = len(torques)
    columns = {
        "sample": np.arange(10, 10 + count),
        "torque_nm": torques,
        "angle_rad": 0.5 * np.arange(count),
        "grip_n": 1.0 + 0.5 * np.arange(count),
    }
    plan = pulses.planned()
    one = Recorded(trials_of(plan)[0], pa.table(columns), Ended.RELEASED.value, 12, 0, 0, 0.0, "it", 1000)
    return one._replace(started_sample=2, **changes)


def test_what_the_samples_say_of_a_pulse() -> None:
    one = recorded([0.0, 0.0, 0.01, 0.01, 0.01, 0.0])
    said = _pulse(one, MS)
    assert said["pulse_width_s"] == pytest.approx(3.0 * MS)
    assert said["fired_s"] == pytest.approx(10.0 / one.trial.sample_rate_hz)
    assert (said["grip_n"], said["grip_pulse_n"]) == (2.0, 2.5)
    assert said["peak_rad"] == pytest.approx(2.5 - 0.5)  # from the mean up to the pulse


def test_a_doubt_is_said_of_the_end_and_of_what_is_missing() -> None:
    assert _pulse_doubts(recorded([0.0])) == []
    doubts = _pulse_doubts(recorded([0.0], ended=Ended.OPERATOR.value, gaps=3))
    assert doubts == ["the operator ended it", "3 samples are missing"]


def test_angles_are_turns_of_the_devices_encoder() -> None:
    empty = np.empty(0)
    counts = np.array([0, 500, -250])
    one = Samples(counts, counts, counts, empty, empty, empty, 0)
    assert one.angle_rad(1000) == pytest.approx([0.0, math.pi, -0.5 * math.pi])


def test_a_pulse_has_no_coarser_count() -> None:
    trial = trials_of(campaigns.planned())[0]
    names = [one.name for one in _more(trial)]
    assert "counts_per_rev" in names
    assert [one.name for one in _more(trial._replace(grip_target_n=2.0))] == [
        one for one in names if one != "counts_per_rev"
    ]


def test_torque_rises_are_of_a_buzz_alone() -> None:
    """Of one that lasts, in its steady part: a rise every fourth sample."""

    class Measured:
        steady = (4, 45)
        sustained = True

    column = {"time_s": np.arange(60) * MS, "torque_nm": np.tile([0.0, 1.0, 1.0, 0.0], 15)}
    column["time_s"][45] += 0.5 * MS
    measured: Any = Measured()
    assert _torque_hz(column, measured) == torque_rises_hz(column["time_s"][4:46], column["torque_nm"][4:46])
    assert _torque_hz(column, measured) == pytest.approx(250.0, rel=0.1)
    measured.sustained = False
    assert _torque_hz(column, measured) == 0.0


# A campaign.


def test_a_table_that_is_not_of_samples_is_no_trial(tmp_path: Path) -> None:
    """One with a column less, or with none."""
    plan = campaigns.planned()
    campaign = Campaign(
        plan,
        Archive(tmp_path, identity="one", is_source=False, stamp=b"{}"),
        lambda stack: stack.enter_context(VirtualDevice()),
        lambda _trial: HAND,
    )
    with VirtualDevice() as device:
        campaign._archive.enter()
        one = campaign._run(device, campaign.trials[0])
    assert campaign.recorded == 1
    assert one.started_sample is None
    rows = campaign_tables([one], plan)[1]
    assert {one.name for one in TRIED}.isdisjoint(rows.column_names)
    assert rows["grip_zero_n"].to_pylist() == [one.zero_n]
    torques = one.table["torque_nm"].to_pylist()
    times = one.table["time_s"].to_pylist()
    still = one.table.set_column(one.table.column_names.index("time_s"), "time_s", [[times[1], *times[1:]]])
    spoilt = one.table.set_column(one.table.column_names.index("torque_nm"), "torque_nm", [[math.nan, *torques[1:]]])
    for table, fine in (
        (one.table, True),
        (one.table.drop_columns(["grip_n"]), False),
        (one.table.slice(0, 0), False),
        (spoilt, False),
        (still, False),
    ):
        path = tmp_path / "trial.parquet"
        write_trial(path, one._replace(table=table), b"{}")
        assert (read_trial(path) is not None) is fine


def test_of_a_pulse_it_is_kept_when_the_trial_was_started() -> None:
    kept: list[Recorded] = []

    class Shelf:
        finish = staticmethod(kept.append)

    plan, shelf, nobody = pulses.planned(), Shelf(), None
    campaign = Campaign(plan, shelf, nobody, nobody)  # type: ignore[arg-type]
    block = made_up(0, 30, 1000.0, started=12)
    assert block.running.tolist() == [False] * 12 + [True] * 18
    trial, outcome = campaign.trials[0], Outcome(Ended.UNFIRED, None, 0)
    campaign._finish(trial, key_of(plan, trial), "it", 1000, [block], outcome)
    assert [one.started_sample for one in kept] == [12]


def test_a_folder_of_trials_is_a_source_once_something_is_recorded(tmp_path: Path) -> None:
    folder = tmp_path / RECORDING
    folder.mkdir()
    (folder / ABOUT).write_text(json.dumps({"identity": "one", "source": True}))
    assert source_digests(tmp_path) == {}
    (folder / "trial_1.parquet").write_bytes(b"")
    assert source_digests(tmp_path) == {RECORDING: "one"}
    (folder / ABOUT).write_text(json.dumps({"identity": "one", "source": False}))
    assert source_digests(tmp_path) == {}


def test_a_device_without_a_grip_cell_is_refused_what_asks_for_one() -> None:
    """And takes a trial that asks for no grip."""
    nobody: Any = None
    asking, not_asking = campaigns.planned(), campaigns.planned(campaigns.SPEC + "grip: none\n")
    with VirtualDevice() as device:
        blind = VirtualDevice(identity=device.identity._replace(no_grip_cell=True))
    with pytest.raises(UsageError, match="has no grip cell"):
        Campaign(asking, nobody, nobody, nobody)._check_ranges(blind)
    Campaign(not_asking, nobody, nobody, nobody)._check_ranges(blind)
    assert Campaign(asking, nobody, nobody, nobody).recorded == 0


def test_drift_is_that_of_a_device_that_samples_by_a_clock() -> None:
    """Of a recording, or a computed knob, nothing is asked."""

    class Drifting(VirtualDevice):
        drift = Drift(0.5, 0.0)  # type: ignore[assignment]

    plan = campaigns.planned()
    trial = trials_of(plan)[0]
    task = Task(trial, 1, settings_of(plan, trial), HAND, plan.course, live=False)
    with Drifting() as device:
        assert run_trial(device, task, lambda _block: None, Nobody()).drift is None


def test_more_readings_than_a_block_has_room_for_leave_its_size_alone() -> None:
    """The device then says what it cannot do."""
    text = campaigns.SPEC + "controller: {kind: impulse_damping, detections: 4}\n"
    plan = campaigns.planned(text)
    trial = trials_of(plan)[0]
    fine = settings_of(plan, trial).block_samples
    assert fine > 0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(order, "most_samples", lambda _looks: 0)
        assert settings_of(plan, trial).block_samples >= fine


# A sample of changes that nothing else has found.


def test_an_unfinished_trial_is_set_aside_with_what_was_recorded(tmp_path: Path) -> None:
    plan = campaigns.planned()
    archive, trial = Archive(tmp_path, identity="one", is_source=True, stamp=b"{}"), trials_of(plan)[0]
    archive.enter()
    journal = archive.begin(trial, {"key": list(key_of(plan, trial)), "device": "it", "native_counts": 1000})
    journal.keep(made_up(0, 4, 1000.0, started=1))
    journal.close()
    path = archive.set_aside(trial)
    assert path is not None
    one = read_trial(path)
    assert one is not None
    assert (one.ended, one.gaps, one.table.num_rows) == ("aborted", 0, 4)


@pytest.mark.parametrize(
    ("torque", "driver", "said"),
    [(Torque.ON, "serial", UNSAFE), (Torque.OFF, "serial", GO_ON), (Torque.OFF, "virtual", IN_VAIN)],
)
def test_a_fault_says_what_to_do_then(torque: Torque, driver: str, said: str) -> None:
    class Shelf:
        def set_aside(self, _trial: Any) -> None:
            return None

    device = {"virtual": "", "serial": "device: {driver: serial, url: somewhere}\n"}[driver]
    text = (
        campaigns.SPEC.replace("person: {wandering_push: false, grip_wander: false}\n", "")
        if device
        else campaigns.SPEC
    )
    plan, shelf, nobody = campaigns.planned(text + device), Shelf(), None
    campaign = Campaign(plan, shelf, nobody, nobody)  # type: ignore[arg-type]
    journal: Any = Shelf()
    journal.close = lambda: None
    with pytest.raises(DeviceError) as found:
        campaign._broken_off(journal, campaign.trials[0], DeviceError("broke"), torque)
    assert str(found.value).endswith(f"nothing was recorded of it; {said}")


def test_a_pulse_is_a_sample_at_least_and_half_a_second_at_most() -> None:
    assert pulse_of(ORDER._replace(width_s=1e-5), MS).width == 1
    for width, fine in ((0.5, True), (0.502, False)):
        told_so = settings(pulse=ORDER._replace(width_s=width))
        wrong = [one for one in faults_of_settings(told_so, IDENTITY) if "must last at most 0.5 s" in one]
        assert (not wrong) is fine


def test_a_pulses_recording_is_told_apart_by_its_grip() -> None:
    plan = pulses.planned()
    assert [key_of(plan, one).grip_target_n for one in trials_of(plan)] == [0.71, 0.71, 4.3, 4.3]
    plain = campaigns.planned()
    assert isinstance(plain.course, Course)
    assert {key_of(plain, one).grip_target_n for one in trials_of(plain)} == {plain.course.grip_target_n}


def test_a_block_is_of_one_sample_at_least() -> None:
    slow = trials_of(campaigns.planned())[0]._replace(sample_rate_hz=1.0)
    assert settings_of(campaigns.planned(), slow).block_samples == 1
    plan = pulses.planned()
    slow = trials_of(plan)[0]
    assert settings_of(plan, slow).block_samples > 1
    assert settings_of(plan, slow._replace(sample_rate_hz=1.0)).block_samples == 1


def test_the_size_of_a_torque_over_the_angle_has_no_sign() -> None:
    over = OverAngle(-2, 4, 0.0, 0.0, (-0.25, -0.5, 0.75, 0.125))
    wall = ShapedWall(settings(wall_damping=0.0), over)
    for count, torque in ((-2, -0.25), (-1, -0.5), (0, 0.75), (1, 0.125)):
        assert wall.sized(count, count) == ([torque], abs(torque))


def test_the_size_of_a_plain_walls_torque_is_at_its_shifted_count() -> None:
    shifted = settings(counts=1000, wall_damping=1e-5, converters=NONE._replace(offset_counts=0.25))
    quantum = math.tau / 1000
    (torque,), size = PlainWall(shifted).sized(-3, -1)
    spring, brake = 0.27 * 2.75 * quantum, 1e-5 * 2.0 * quantum / MS
    assert (torque, size) == (pytest.approx(spring + brake), pytest.approx(spring + brake))
    assert PlainWall(shifted).sized(0, -1) == ([0.0], 0.0)


def test_a_grip_wanders_no_more_than_trials_differ() -> None:
    """Where the wander within a trial says more than was printed of all, the mean is the printed one."""
    person = Person(grip_wander_share=5.0)
    grip, sines = _grip(person, np.random.default_rng(1))
    assert grip == pytest.approx(person.grip_target_n / PRINTED_TARGET_N * printed_grips()[0])
    assert len(sines) == 4


def test_a_push_is_drawn_until_its_weakest_moment_is_above_friction() -> None:
    """Without wander its weakest moment is itself; with wander of 0.1 and tremor of 0.03 it is 0.74 of it."""

    class Chances:
        def __init__(self) -> None:
            self.left = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]

        def uniform(self, _low: float, _high: float) -> float:
            return 1.0

        def standard_normal(self) -> float:
            return self.left.pop(0)

    person, chances = Person(), Chances()
    rng: Any = chances
    # The first is 0.98 of the mean, and 0.73e-3 at its weakest; the fourth of exp(0.297 - 0.0196) = 1.319.
    push, _ = _push(person, 0.73e-3, rng)
    spread = math.sqrt(math.log1p(0.2**2))
    weakest = 1.0 - 2.0 * (0.1 + 0.03)
    wanted = [1e-3 * math.exp(spread * z - 0.5 * spread * spread) for z in (0.0, 0.5, 1.0, 1.5, 2.0, 2.5)]
    assert push == pytest.approx(next(one for one in wanted if one * weakest > 0.73e-3))
    assert wanted[0] * weakest < 0.73e-3 < 1e-3 * weakest


def test_what_has_no_size_does_not_wander() -> None:
    rng = np.random.default_rng(1)
    assert wander_sines(rng, 0.0, 0.1, 0.1) == ()
    assert wander_sines(rng, 1.0, 0.0, 0.0) == ()
    found = wander_sines(rng, 2.0, 0.0, 0.25)
    assert [one.amplitude for one in found] == [0.5, 0.5]


def test_a_grip_that_is_held_wanders_by_its_share() -> None:
    plan = pulses.planned()
    found = squeezer(plan, trials_of(plan)[0])
    assert found.squeeze
    assert [one.amplitude for one in found.squeeze.sines] == [plan.pulses.person.wander] * 2
    assert plan.pulses.person.wander > 0.0


def test_a_pulse_is_cut_at_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    loop = pulse_loop()
    loop.block(running=True)
    for asked, given in ((0.04, 0.04), (1.0, 0.05), (-1.0, -0.05)):
        monkeypatch.setattr(loop._trigger, "step", lambda *_, asked=asked, **__: asked)
        assert loop._commanded(loop._index, 0, 0, running=True).torque_nm == given


def test_friction_is_against_the_speed_and_not_the_torque() -> None:
    one = held()
    one.move(3e-3, 0.0)
    for told_nm in (3e-3, -3e-3, 0.0):
        assert one.sensed(told_nm, sees_friction=True)[0] == pytest.approx(told_nm - 1e-3)


def test_a_pulses_torque_may_differ_by_a_millionth() -> None:
    share = 1e-6 * ORDER.torque_nm
    for off, fine in ((share, True), (1.5 * share, False)):
        one, block = phases(), made_up(0, 4, 1000.0, started=None)
        given = block._replace(torque_nm=np.full(4, off))
        if fine:
            one.follow(given)
        else:
            with pytest.raises(DeviceError, match="not that of the pulse"):
                one.follow(given)


def test_a_grip_is_what_is_above_the_cells_zero() -> None:
    one = phases()
    block = made_up(0, 4, 1000.0, started=None)._replace(torque_nm=np.zeros(4), grip_n=np.full(4, 0.25))
    one.follow(block)
    one.follow(block._replace(first=4, running=np.full(4, True), grip_n=np.full(4, 0.625)))
    assert one.grip_n == 0.375


def test_late_samples_are_counted_on() -> None:
    block = made_up(0, 2, 1000.0, started=None)
    assert joined([block._replace(overruns=1), block._replace(first=2, overruns=3)]).overruns == 3
    assert joined([]).overruns == 0


def test_each_part_of_an_interval_has_its_torque() -> None:
    wall = TrialWall(told("long impulse"), 1000)
    wall.torques(-3, -3)
    sent = wall.torques(-5, -3)
    assert len(sent.later) == 1
    assert sent.torque_nm > sent.later[0] > 0.0


def test_before_it_has_read_anything_a_reading_is_0() -> None:
    loop = VirtualLoop(told("impulse that reads"), HAND, Nuisances(), 100_000)
    looks = loop.block(running=False).looks
    assert looks is not None
    assert not looks.any()
    assert VirtualLoop(settings(), HAND, Nuisances(), 100_000).block(running=True).looks is None


def test_noise_of_angle_and_grip_is_added(monkeypatch: pytest.MonkeyPatch) -> None:
    """2.5 counts, and 0.125 N."""
    plain, noisy = (VirtualLoop(settings(), HAND, Nuisances(), 1000) for _ in range(2))
    monkeypatch.setattr(noisy._disturbances, "angle_rad", lambda count: np.full(count, 2.5 * math.tau / 1000))
    monkeypatch.setattr(noisy._disturbances, "grip_n", lambda count: np.full(count, 0.125))
    at = plain._motion.angle_counts
    one, other = plain.block(running=False), noisy.block(running=False)
    assert one.angle_counts.tolist() == [math.floor(at)] * 40
    assert other.angle_counts.tolist() == [math.floor(at + 2.5)] * 40
    assert other.grip_n - one.grip_n == pytest.approx(0.125)


def test_a_brake_acts_from_the_first_count_inside() -> None:
    over = OverAngle(-2, 4, 0.0, 0.0, (-0.25, -0.5, 0.75, 0.125))
    wall = ShapedWall(settings(counts=1000, wall_damping=1e-5), over)
    brake = 1e-5 * (math.tau / 1000) / MS
    assert wall.torques(-1, -2) == [pytest.approx(-0.5 - brake)]
    assert wall.sized(-1, -2)[1] == pytest.approx(0.5 + brake)
    assert wall.torques(0, -1) == [0.75]


def test_a_torque_over_the_angle_is_that_of_shifted_counts() -> None:
    """A stop of 2 N m a rad, and the wall: at the angle that the encoder shows, a quarter of a count up."""
    quantum = math.tau / 1000
    for converters, shift in ((None, 0.0), (NONE._replace(offset_counts=0.25), 0.25)):
        found = over_angle_of(Effects(end_stops=EndStops(2.0, low=-0.5)), settings(counts=1000, converters=converters))
        wall = ShapedWall(settings(counts=1000, wall_damping=0.0), found)
        deep = -0.5 - (-100.0 + shift) * quantum
        plain = -0.27 * (-100.0 + shift) * quantum
        assert wall.torques(-100, -100)[0] == pytest.approx(2.0 * deep + plain, rel=1e-9)


def test_somebody_may_push_or_grip_by_nothing_at_all() -> None:
    """But not by less."""
    limp = Person(push_nm=0.0, wandering_push=False, grip_wander=False)
    assert hold(limp, KNOB, seed=1, place=(1,)).push_nm == 0.0
    for wrong in (limp._replace(push_nm=-1e-9), limp._replace(grip_target_n=-1e-9), limp._replace(push_nm=math.inf)):
        with pytest.raises(UsageError, match="must be >= 0"):
            hold(wrong, KNOB, seed=1, place=(1,))


def test_nobody_is_asked_to_hold_a_knob_as_nobody_can(monkeypatch: pytest.MonkeyPatch) -> None:
    """A computed knob, or that of a target that is one; who holds a real one is not for the program to say."""

    def who_of(_plan: Any) -> Any:
        def who(_trial: Any) -> Any:
            raise UsageError("no such hand")

        return who

    monkeypatch.setattr(campaign_module, "who_of", who_of)
    plan = campaigns.planned()
    for driver, target, asked in (("virtual", None, True), ("serial", "host", True), ("serial", None, False)):
        given = plan._replace(device=plan.device._replace(driver=driver, target=target))
        if asked:
            with pytest.raises(SpecError, match="no such hand"):
                campaign_module.check_persons(given)
        else:
            campaign_module.check_persons(given)


def test_a_record_may_be_as_long_as_the_longest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "one"
    written = Journal(path, {"about": 1})
    written.keep(made_up(0, 4, 1000.0, started=None))
    written.close()
    longest = len(packed(made_up(0, 4, 1000.0, started=None)))
    for more, whole in ((0, True), (-1, False)):
        monkeypatch.setattr(journal, "_LONGEST", longest + more)
        found = read_journal(path)
        assert found is not None
        assert (len(found.blocks) == 1, found.whole) == (whole, whole)


def test_a_pulse_may_come_at_the_very_start() -> None:
    one = recorded([0.0, 0.01])
    rate = one.trial.sample_rate_hz
    for settled, started, samples in ((0, 0, 0), (12, 2, 10), (12, None, 12)):
        found = _fired_s(one._replace(settled_sample=settled, started_sample=started))
        assert found == pytest.approx(samples / rate)


def test_of_a_real_hand_nothing_is_known_but_what_was_measured() -> None:
    import pyarrow as pa

    one, plan = recorded([0.0, 0.0, 0.01, 0.01]), pulses.planned()
    one = one._replace(table=one.table.append_column("device_time_us", pa.array([0, 100, 200, 300])))
    real = plan._replace(device=plan.device._replace(driver="serial", target=None))
    names = {column.name for column in TRUTH}
    assert names <= set(pulse_tables([one], plan)[1].column_names)
    assert names.isdisjoint(pulse_tables([one], real)[1].column_names)


def test_faults_of_settings_are_said_before_those_of_a_block(monkeypatch: pytest.MonkeyPatch) -> None:
    nobody: Any = None
    long = settings(rate=500)
    looking = told("long impulse that reads most often")
    monkeypatch.setattr(order, "MOST_LOOKS", 2)
    for said in ([], ["the rate"]):
        monkeypatch.setattr(order, "faults_of_settings", lambda *_, said=said: list(said))
        for one, what in ((long, "must take at most"), (looking, "reads its encoder at most")):
            found = order.faults(one, nobody)
            assert len(found) == 1
            assert (what in found[0]) is (said == [])


def test_a_pulse_of_no_torque_is_none() -> None:
    for torque, fine in ((0.0, False), (1e-9, True), (0.05, True), (0.0500001, False)):
        given = settings(pulse=ORDER._replace(torque_nm=torque))
        wrong = [one for one in faults_of_settings(given, IDENTITY) if "must be above 0" in one]
        assert (not wrong) is fine


def test_a_delay_moves_the_parts_of_an_interval() -> None:
    """Up to 0.75 and from there, half a sample late: what would begin at 1.25 is of the next interval."""
    assert slots_of((0.0, 0.75), 0.5) == [(0.0, 1, 0), (0.25, 1, 1), (0.5, 0, 0)]
    assert slots_of((0.0, 0.75), 2.0) == [(0.0, 2, 0), (0.75, 2, 1)]


def test_every_phase_of_a_trial_has_its_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is left after the stop is there to be read: no time of the trial is for that."""
    bounds: list[tuple[float, str]] = []
    bound = trial_run.Bound

    def noted(seconds: float, what: str, device: Any, *, live: bool) -> Any:
        bounds.append((seconds, what))
        return bound(seconds, what, device, live=live)

    monkeypatch.setattr(trial_run, "Bound", noted)
    plan = campaigns.planned()
    trial = trials_of(plan)[0]
    task = Task(trial, 1, settings_of(plan, trial), HAND, plan.course, live=False)
    with VirtualDevice() as device:
        run_trial(device, task, lambda _block: None, Nobody())
    assert [seconds for seconds, _ in bounds] == [plan.course.zero, plan.course.longest, 0.0]


def test_an_angle_beyond_all_counts_is_not_read() -> None:
    loop = VirtualLoop(told("impulse that reads"), HAND, Nuisances(), 100_000)
    loop._looked[0] = 7
    loop._motion = SimpleNamespace(angle_counts=0.0)  # type: ignore[assignment]
    for at, read in ((2.0**31, 7), (2.0**31 - 0.5, 2**31 - 1), (-(2.0**31), -(2**31)), (-(2.0**31) - 0.5, -(2**31))):
        loop._noise = at
        loop._look(0)
        assert loop._looked[0] == read


def test_a_fault_is_told_with_its_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    loop = VirtualLoop(settings(), HAND, Nuisances(), 1000)
    loop.block(running=False)
    torques = iter([Sent(0.0)] * 3 + [Sent(math.nan)])
    monkeypatch.setattr(loop._wall, "torques", lambda *_: next(torques))
    assert len(loop.block(running=True).time_us) == 4
    assert loop.fault == "the torque is not a number, at sample 43"
