"""Specs of a campaign on a knob with torques over the angle: what is taken, and the fault of each thing that is not."""

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.hardware.order import settings_of, trials_of
from hknob_cli.specs.campaign import HwRunPlan
from hknob_cli.specs.load import validate
from hknob_cli.specs.source import parse

BARE = "kind: hw-run\nname: d\n"
DETENTS = "detents: {per_revolution: 12, torque: 6 mN*m}\n"

WALLED = DETENTS + "wall: {stiffness: 0.27}\n"


def planned(text: str) -> HwRunPlan:
    plan = validate(parse(text, "d.yaml"))
    assert isinstance(plan, HwRunPlan)
    return plan


def test_there_is_no_wall_where_none_is_listed() -> None:
    assert planned(BARE).first.wall.stiffness == 0.27
    assert planned(BARE + DETENTS).first.wall.stiffness == 0.0
    assert planned(BARE + DETENTS + "wall: {stiffness: 0.1}\n").first.wall.stiffness == 0.1


def test_every_trial_has_the_table_at_its_own_counts() -> None:
    plan = planned(BARE + DETENTS)
    turns = {trial.counts_per_rev: settings_of(plan, trial).over_angle.turn for trial in trials_of(plan)}
    assert turns == {counts: counts // 4 for counts in (256, 512, 1024, 2048)}  # 12 detents: three in each quarter
    assert settings_of(planned(BARE), trials_of(plan)[0]).over_angle is None


@pytest.mark.parametrize("device", ["driver: virtual", "driver: serial, target: qemu", "driver: serial, url: COM3"])
def test_every_device_that_moves_takes_them(device: str) -> None:
    text = BARE + f"device: {{{device}}}\n"
    for part in (DETENTS, "profile: {points: [[0, 0.01], [1, 0]]}\n", "end_stops: {stiffness: 1, high: 1}\n"):
        assert planned(text + part).effects is not None
    assert planned(text + "dead_zone: {width: 0.1, stiffness: 1}\n").effects is not None


WRONG = {
    WALLED + "controller: {kind: bounded_lag}\n": "d.yaml:5:13: controller: must be absent beside",
    DETENTS + "device: {driver: replay, recordings: [x]}\n": "d.yaml:3:10: detents: must be absent: what is replayed",
    DETENTS + "what: pulses\n": "d.yaml:3:1: detents: must be absent with what: pulses: it is of a buzz",
    "detents: {per_revolution: 200, torque: 0.001}\n": "d.yaml:3:27: detents.per_revolution: must be at most 128",
    "detents: {torque: 0.001}\n": "d.yaml:3:10: detents: must have exactly one of",
    "end_stops: {stiffness: 1, low: 2, high: 1}\n": "d.yaml:3:12: end_stops: low must be below high",
    "profile: {points: [[1, 0], [0, 0]]}\n": "d.yaml:3:10: profile",
    "dead_zone: {width: 0.1}\n": "d.yaml:3:1: dead_zone.stiffness: ",
    WALLED + "remedies: {plain wall: {}, lag: {change: {controller: {kind: bounded_lag}}}}\n": (
        "d.yaml:5:42: remedies.lag.change: must be absent beside a pattern of detents"
    ),
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_said_at_its_place(text: str) -> None:
    with pytest.raises(SpecError) as caught:
        planned(BARE + text)
    found = str(caught.value).splitlines()
    assert len(found) == 1
    assert found[0].startswith(WRONG[text]), found
