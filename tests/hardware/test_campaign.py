"""Tests of `hardware.campaign`: its order, what becomes of every trial, and that the torque is off on every way out."""

import math
import shutil
from collections import Counter, deque
from pathlib import Path

import numpy as np
import pytest

from hknob_cli.errors import DeviceError, RefusedError, SpecError, UsageError
from hknob_cli.hardware.campaign import check_persons
from hknob_cli.hardware.journal import move_to_earlier, spec_digest
from hknob_cli.hardware.order import settings_of, trials_of
from hknob_cli.hardware.port import Block
from hknob_cli.hardware.trial_file import read_trial
from hknob_cli.hardware.trial_run import Nobody, View, Wish
from hknob_cli.hardware.wire.sending import GAP_PATIENCE_S
from hknob_cli.hardware.wire.session import SIMULATED_SILENCE_S
from hknob_cli.recordings.read import read
from tests.hardware.campaigns import REMEDIES, SPEC, Faulty, campaign, planned


def test_every_cell_once_in_each_repeat_in_an_order_of_its_own() -> None:
    plan = planned(SPEC + "repeats: 3\n")
    trials = trials_of(plan)
    assert [trial.number for trial in trials] == list(range(1, 13))
    cells = Counter((trial.block, trial.sample_rate_hz, trial.counts_per_rev) for trial in trials)
    assert set(cells.values()) == {1}
    assert len(cells) == 12
    assert trials == trials_of(plan)
    orders = {tuple(trial[2:4] for trial in trials_of(plan._replace(seed=seed))) for seed in range(20)}
    assert len(orders) > 10
    straight = trials_of(plan._replace(shuffled=False, repeats=1))
    assert [trial[2:4] for trial in straight] == [(1000, 256), (1000, 512), (2000, 256), (2000, 512)]


def test_settings_of_a_trial() -> None:
    plan = planned()
    trial = trials_of(plan)[0]._replace(sample_rate_hz=455.0, counts_per_rev=2048)
    settings = settings_of(plan, trial)
    assert (settings.period_ns, settings.counts_per_rev, settings.block_samples) == (2_197_802, 2048, 5)
    assert (settings.wall_stiffness, settings.watchdog_us) == (0.27, 40_000)
    assert settings_of(plan, trial._replace(sample_rate_hz=25_000.0)).block_samples == 48


def test_a_campaign_is_recorded_whole(tmp_path: Path) -> None:
    device = Faulty()
    done = campaign(tmp_path, device).run()
    assert [one.trial.number for one in done] == [1, 2, 3, 4]
    assert device.calls.count("start") == 4
    assert device.calls[-1] == "release"
    for one in done:
        assert one.ended == "buzz"
        assert (one.gaps, one.overruns) == (0, 0)
        assert one.zero_n == pytest.approx(0.3, abs=1e-6)  # of the person's grip cell, in f32
        assert one.table["sample"].to_numpy().tolist() == list(range(one.table.num_rows))
    recordings = read(tmp_path / "recording" / f"{one.trial.label}.parquet" for one in done)
    assert [trial.key.trial for trial in recordings] == [1, 2, 3, 4]
    for trial, one in zip(recordings, done, strict=True):
        assert np.array_equal(trial.torque_nm, one.table["torque_nm"].to_numpy())
        on = one.table["running"].to_numpy(zero_copy_only=False)
        held = np.arange(on.sum()) / one.trial.sample_rate_hz
        rounding = 2.0**-23  # of forces below 2 N in f32, once for the force and once for the zero
        assert np.allclose(trial.grip_n[on], 0.72 * (1.0 - np.exp(-held / 0.2)), rtol=0.0, atol=rounding)


def test_a_trial_ends_when_enough_was_heard(tmp_path: Path) -> None:
    one = campaign(tmp_path, Faulty()).run()[0]
    running = one.table["running"].to_numpy(zero_copy_only=False)
    start = int(np.argmax(running))
    interval = 1.0 / one.trial.sample_rate_hz
    assert one.settled_sample is not None
    after = (one.table.num_rows - one.settled_sample) * interval
    assert 0.2 <= after <= 0.2 + 3 * 0.01  # the most, in whole blocks of 10 ms, and the block of the phase's change
    grip = one.table["grip_n"].to_numpy()
    held = np.flatnonzero(np.abs(grip[start:] - 0.71) <= 0.15)[0] * interval
    settled = (one.settled_sample - start) * interval
    assert held + 0.05 - 0.02 <= settled <= held + 0.05 + 0.02


def test_rest_is_believed(tmp_path: Path) -> None:
    """No wall, no buzz: the hand's spring and damper bring the knob to rest."""
    done = campaign(tmp_path, Faulty(), planned(SPEC + "wall: {stiffness: 0}\n")).run()
    assert {one.ended for one in done} == {"rest"}


def test_a_grip_that_is_never_held_ends_at_the_longest(tmp_path: Path) -> None:
    text = SPEC.replace("longest: 2", "longest: 0.4") + "grip: {target: 2.0}\n"
    done = campaign(tmp_path, Faulty(), planned(text)).run()
    assert {(one.ended, one.settled_sample) for one in done} == {("longest", None)}


def test_a_fault_leaves_everything_on_the_disk_and_the_next_run_goes_on(tmp_path: Path) -> None:
    whole = campaign(tmp_path / "whole", Faulty()).run()
    (tmp_path / "out").mkdir()
    device = Faulty(fail_at=70)
    plan = planned(SPEC + "device: {driver: serial, url: x}\n")
    with pytest.raises(DeviceError) as error:
        campaign(tmp_path / "out", device, plan, is_source=True).run()
    assert device.calls[-1] == "release"
    trial = trials_of(planned())[device.calls.count("start") - 1]
    said = str(error.value)
    place = f"trial {trial.number} of 4 ({trial.sample_rate_hz:g} Hz, {trial.counts_per_rev} counts): the link is cut"
    assert said.startswith(place)
    assert "torque released" in said
    assert "run the same command again" in said
    kept = read_trial(tmp_path / "out" / "recording" / "aborted" / f"{trial.label}_1.parquet")
    assert kept is not None
    again = Faulty()
    done = campaign(tmp_path / "out", again, plan, is_source=True).run()
    assert again.calls.count("start") == 4 - (trial.number - 1)
    for one, other in zip(done, whole, strict=True):
        assert one == other
    assert kept.table.equals(whole[trial.number - 1].table.slice(0, kept.table.num_rows))
    assert kept.table.num_rows > 0


@pytest.fixture(autouse=True)
def _folders(tmp_path: Path) -> None:
    (tmp_path / "whole").mkdir()


@pytest.mark.parametrize("error", [KeyboardInterrupt(), MemoryError(), OSError(5, "Input/output error")])
def test_released_whatever_is_raised(tmp_path: Path, error: BaseException) -> None:
    for at in (1, 3, 20, 65):
        device = Faulty(fail_at=at, error=error)
        said: list[str] = []
        with pytest.raises(type(error)):
            campaign(tmp_path, device, say=said.append).run()
        assert device.calls[-1] == "release"
        assert bool(said) == isinstance(error, KeyboardInterrupt)


class Asking(Nobody):
    """An operator with a wish at one of the looks."""

    def __init__(self, wish: Wish, at: int) -> None:
        self.wish, self.at, self.looks = wish, at, 0
        self.seen: list[View] = []

    def look(self, view: View) -> Wish:
        self.looks += 1
        self.seen.append(view)
        return self.wish if self.looks == self.at else Wish.GO_ON


def test_the_operator_ends_a_trial(tmp_path: Path) -> None:
    done = campaign(tmp_path, Faulty(), operator=Asking(Wish.END, 40)).run()
    assert [one.ended for one in done] == ["operator", "buzz", "buzz", "buzz"]


def test_the_operator_repeats_a_trial(tmp_path: Path) -> None:
    device = Faulty()
    done = campaign(tmp_path, device, operator=Asking(Wish.REPEAT, 40)).run()
    assert device.calls.count("start") == 5
    assert [one.ended for one in done] == ["buzz"] * 4
    assert len(list((tmp_path / "recording" / "aborted").iterdir())) == 1


def test_the_operator_stops(tmp_path: Path) -> None:
    device, said = Faulty(), []
    with pytest.raises(KeyboardInterrupt):
        campaign(tmp_path, device, operator=Asking(Wish.STOP, 40), say=said.append).run()
    assert device.calls[-1] == "release"
    assert "torque released" in said[0]


class Slow(Faulty):
    """Its samples take as long as a driver may wait for them, or never come."""

    def __init__(self, slow_s: float) -> None:
        super().__init__()
        self.slow_s = slow_s

    def read(self, timeout_s: float) -> Block | None:
        return super().read(timeout_s) if timeout_s >= self.slow_s else None


def test_how_long_a_link_may_be_silent_is_for_its_driver_to_say(tmp_path: Path) -> None:
    longest = SIMULATED_SILENCE_S + GAP_PATIENCE_S
    plan = planned(SPEC + "device: {driver: serial, url: x}\n")
    assert len(campaign(tmp_path, Slow(longest), plan, is_source=True).run()) == 4


def test_a_driver_that_hangs_does_not_hang_the_campaign(tmp_path: Path) -> None:
    device = Slow(math.inf)
    plan = planned(SPEC + "device: {driver: serial, url: x}\n")
    with pytest.raises(DeviceError, match=r"trial 1 of 4 .*: no samples for 3 s; torque released"):
        campaign(tmp_path, device, plan, is_source=True).run()
    assert device.calls[-1] == "release"


class Lagging(Faulty):
    """A device whose samples are handed on a block late, as over a wire: some are left to read after the stop."""

    def __init__(self) -> None:
        super().__init__()
        self.kept: deque[Block] = deque()
        self.sampled: list[int] = []

    def arm(self) -> None:
        super().arm()
        self.kept.clear()
        self.sampled.append(0)

    def read(self, timeout_s: float) -> Block | None:
        while len(self.kept) < 2 and (block := super().read(timeout_s)) is not None:
            self.kept.append(block)
            self.sampled[-1] += len(block.time_us)
        return self.kept.popleft() if self.kept else None


def test_samples_that_are_read_after_the_stop_are_kept(tmp_path: Path) -> None:
    device = Lagging()
    done = campaign(tmp_path, device).run()
    assert [one.table.num_rows for one in done] == device.sampled


class Spoilt(Lagging):
    """Every block of a phase of its trials has a torque that no limit allows."""

    def __init__(self, when: str) -> None:
        super().__init__()
        self.when, self.phase = when, ""

    def arm(self) -> None:
        super().arm()
        self.phase = "zero"

    def start(self) -> None:
        super().start()
        self.phase = "on"

    def stop(self) -> None:
        super().stop()
        self.phase = "stopped"

    def read(self, timeout_s: float) -> Block | None:
        block = super().read(timeout_s)
        if block is None or self.phase != self.when:
            return block
        return block._replace(torque_nm=np.full(block.torque_nm.size, 99.0))


@pytest.mark.parametrize("when", ["zero", "on", "stopped"])
def test_what_is_beyond_a_limit_ends_the_trial_in_every_phase_and_is_kept(tmp_path: Path, when: str) -> None:
    device = Spoilt(when)
    with pytest.raises(DeviceError, match="the torque is beyond the limit"):
        campaign(tmp_path, device).run()
    assert device.calls[-1] == "release"
    (kept,) = (tmp_path / "recording" / "aborted").iterdir()
    assert 99.0 in read_trial(kept).table["torque_nm"].to_pylist()


def test_what_the_operator_sees(tmp_path: Path) -> None:
    operator = Asking(Wish.GO_ON, 0)
    campaign(tmp_path, Faulty(), operator=operator).run()
    first = [view for view in operator.seen if view.trial.number == 1]
    assert list(dict.fromkeys(view.state for view in first)) == ["zero", "grip", "buzz"]
    assert first[-1].grip_n == pytest.approx(0.72, abs=0.15)
    assert all(view.trials == 4 for view in first)


def test_recordings_of_a_device_are_kept(tmp_path: Path) -> None:
    campaign(tmp_path, Faulty(), is_source=True).run()
    before = {path.name: path.read_bytes() for path in (tmp_path / "recording").glob("*.parquet")}
    device = Faulty()
    with pytest.raises(RefusedError, match="made with another spec"):
        campaign(tmp_path, device, identity="other", is_source=True).run()
    assert device.calls == []
    assert {path.name: path.read_bytes() for path in (tmp_path / "recording").glob("*.parquet")} == before
    assert move_to_earlier(tmp_path) == tmp_path / "earlier" / "1"
    campaign(tmp_path, device, identity="other", is_source=True).run()
    assert device.calls.count("start") == 4
    assert len(list((tmp_path / "earlier" / "1" / "recording").glob("*.parquet"))) == 4


def test_a_device_at_another_port_is_the_same_campaign() -> None:
    text = SPEC.replace("person: {wandering_push: false, grip_wander: false}\n", "")
    first = planned(text + "device: {driver: serial, url: /dev/ttyACM0}\n")
    same = planned(text + "device: {driver: serial, url: /dev/ttyACM1, baud: 115200}\n")
    built = planned(text + "device: {driver: serial, target: host}\n")
    assert spec_digest(first.values) == spec_digest(same.values)
    assert spec_digest(first.values) != spec_digest({**first.values, "seed": 3})
    assert spec_digest(first.values) != spec_digest(built.values)


def test_what_trials_are_compared_with_is_no_other_campaign() -> None:
    plan = planned(SPEC + REMEDIES)
    compared = planned(SPEC + REMEDIES + "against: somewhere\nhand: pinch\nreference: softer wall\n")
    assert spec_digest(plan.values) == spec_digest(compared.values)
    assert spec_digest(plan.values) != spec_digest(planned(SPEC + REMEDIES.replace("0.15,", "0.2,")).values)


def test_a_campaign_of_remedies_goes_on_where_it_broke_off(tmp_path: Path) -> None:
    plan = planned(SPEC + REMEDIES)
    whole = campaign(tmp_path / "whole", Faulty(), plan).run()
    assert [one.trial for one in whole] == list(trials_of(plan))
    device = Faulty(fail_at=140)
    (tmp_path / "out").mkdir()
    with pytest.raises(DeviceError) as error:
        campaign(tmp_path / "out", device, plan, is_source=True).run()
    trial = trials_of(plan)[device.calls.count("start") - 1]
    cell = f"{trial.sample_rate_hz:g} Hz, {trial.counts_per_rev} counts, {trial.remedy}"
    assert str(error.value).startswith(f"trial {trial.number} of 12 ({cell}): the link is cut")
    again = Faulty()
    done = campaign(tmp_path / "out", again, plan, is_source=True).run()
    assert again.calls.count("start") == 12 - (trial.number - 1)
    assert all(one == other for one, other in zip(done, whole, strict=True))
    # A finished trial is that of its remedy: the same trials under other names are done again, and kept.
    renamed = planned(SPEC + REMEDIES.replace("softer wall", "soft wall"))
    other = Faulty()
    campaign(tmp_path / "out", other, renamed, is_source=True).run()
    assert other.calls.count("start") == 4
    assert len(list((tmp_path / "out" / "recording" / "aborted").glob("*.parquet"))) == 5


def test_a_campaign_without_remedies_says_nothing_of_them(tmp_path: Path) -> None:
    (one, *_) = campaign(tmp_path, Faulty()).run()
    file = next((tmp_path / "recording").glob("*.parquet"))
    assert b"remedy" not in file.read_bytes()
    assert str(one.trial).count(",") == 1


def test_what_was_computed_gives_way(tmp_path: Path) -> None:
    campaign(tmp_path, Faulty()).run()
    device = Faulty()
    campaign(tmp_path, device, identity="other").run()
    assert device.calls.count("start") == 4


def test_a_folder_that_is_half_removed_is_no_hindrance(tmp_path: Path) -> None:
    campaign(tmp_path, Faulty()).run()
    plain = shutil.rmtree

    def cut_short(path: Path) -> None:
        (path / "campaign.json").unlink()
        raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shutil, "rmtree", cut_short)
        with pytest.raises(KeyboardInterrupt):
            campaign(tmp_path, Faulty())._archive.leave()
    assert shutil.rmtree is plain
    assert len(campaign(tmp_path, Faulty(), identity="other").run()) == 4
    assert {path.name for path in tmp_path.iterdir()} == {"recording", "whole"}


@pytest.mark.parametrize("about", [None, "[1, 2]", '{"title": "holiday"}', '{"identity": "one"}'])
def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path, about: str | None) -> None:
    (tmp_path / "recording").mkdir()
    if about is not None:
        (tmp_path / "recording" / "campaign.json").write_text(about)
    (tmp_path / "recording" / "song.wav").write_text("mine")
    with pytest.raises(RefusedError, match="not written by hknob"):
        campaign(tmp_path, Faulty()).run()
    assert (tmp_path / "recording" / "song.wav").read_text() == "mine"


def test_another_encoder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DeviceError):
        campaign(tmp_path, Faulty(fail_at=70), is_source=True).run()
    other = Faulty()
    other._identity = other._identity._replace(native_counts=4096, name="other")
    with pytest.raises(RefusedError, match="'other' has 4096 counts"):
        campaign(tmp_path, other, is_source=True).run()
    assert other.calls.count("start") == 0


def test_what_the_device_cannot_do_is_said_before_the_first_trial(tmp_path: Path) -> None:
    device = Faulty()
    device._identity = device._identity._replace(native_counts=300, name="coarse")
    with pytest.raises(UsageError, match="'coarse' cannot do that: counts_per_rev must be from 1 to 300, got 512"):
        campaign(tmp_path, device).run()
    assert not [call for call in device.calls if call != "release"]
    assert not (tmp_path / "recording").exists()


@pytest.mark.parametrize("damage", ["cut", "another"])
def test_a_file_that_is_no_such_trial_is_not_taken_for_it(tmp_path: Path, damage: str) -> None:
    done = campaign(tmp_path, Faulty()).run()
    first, second = (tmp_path / "recording" / f"{one.trial.label}.parquet" for one in done[:2])
    first.write_bytes(second.read_bytes() if damage == "another" else first.read_bytes()[:-100])
    device = Faulty()
    again = campaign(tmp_path, device).run()
    assert device.calls.count("start") == 1
    assert [one.trial for one in again] == [one.trial for one in done]
    assert again[0].table.equals(done[0].table)


@pytest.mark.parametrize("damage", ["cut", "garbage", "empty", "middle"])
def test_a_broken_journal_is_kept_and_the_trial_done_again(tmp_path: Path, damage: str) -> None:
    with pytest.raises(MemoryError):
        campaign(tmp_path, Faulty(fail_at=30, error=MemoryError())).run()
    folder = tmp_path / "recording"
    label = trials_of(planned())[0].label
    kept = folder / "aborted" / f"{label}_1.parquet"
    assert kept.exists()
    part = folder / f"{label}.part"
    content = {"cut": b"hknob trial 1\n\x07", "garbage": b"\x00" * 999, "empty": b"", "middle": b"hknob trial 1\nxxxx"}
    part.write_bytes(content[damage])
    assert len(campaign(tmp_path, Faulty()).run()) == 4
    assert (folder / "aborted" / f"{label}_2.part").read_bytes() == content[damage]


@pytest.mark.parametrize(("grip", "place"), [("grip: {target: 95}\n", "6:16"), ("grip: {band: 0.1}\nseed: 3\n", None)])
def test_a_grip_beyond_the_table_is_told_where_it_is_written(grip: str, place: str | None) -> None:
    plan = planned(SPEC + grip)
    if place is None:
        check_persons(plan)
        return
    with pytest.raises(SpecError, match=rf"^spec\.yaml:{place}: grip\.target: trial 1 .* up to a grip of 14\.2 N"):
        check_persons(plan)
