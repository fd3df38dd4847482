"""Tests of `specs.capabilities`: what a campaign on a knob takes, and why it does not take the rest."""

from typing import Any

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.capabilities import (
    REFUSED,
    VERDICTS,
    WHY,
)
from hknob_cli.specs.controller import KINDS
from hknob_cli.specs.load import validate
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.source import Source
from tests.specs.small_cells import CHANGES

TOLD = ("controller", "encoder", "actuator")  # what a device is told beside its wall
CONTROLLED = [part for part in CHANGES if part not in ("bare",) and {*TOLD} & {*CHANGES[part].get("scene", {})}]


@pytest.mark.parametrize("part", CONTROLLED)
def test_a_campaign_on_a_knob_refuses_what_the_table_says(part: str) -> None:
    source = Source("spec.yaml")
    told = {key: value for key, value in CHANGES[part]["scene"].items() if key in TOLD}
    source.value = {"kind": "hw-run", "name": "small", **told}
    if VERDICTS[part, "device"] != REFUSED:
        validate(source)
        return
    with pytest.raises(SpecError) as error:
        validate(source)
    assert all(one.message.startswith("must be one that a device can run") for one in error.value.faults)


HOST, REPLAYED = {"driver": "serial", "target": "host"}, {"driver": "replay", "recordings": ["a"]}
SENSING = CHANGES["speed_sensor"]["scene"]["controller"]
READING = CHANGES["several_readings"]["scene"]["controller"]


@pytest.mark.parametrize(
    ("controller", "device", "said"),
    [
        (SENSING, HOST, "controller.velocity: must not be sensor unless the driver is virtual"),
        (SENSING, REPLAYED, "controller.velocity: must not be sensor unless the driver is virtual"),
        (READING, REPLAYED, "controller.detections: must be 1 where recordings are played back"),
        ({**READING, "detections": 65}, HOST, "controller.detections: must be at most 64 unless the driver is virtual"),
    ],
)
def test_what_only_the_virtual_device_reads_is_refused_by_others(
    controller: dict[str, Any], device: dict[str, Any], said: str
) -> None:
    source = Source("spec.yaml")
    told = {"controller": controller, "device": device}
    source.value = {"kind": "hw-run", "name": "small", "model": {"inertia": 2e-6}, **told}
    if controller["kind"] == "impulse_damping":
        del source.value["model"]
    with pytest.raises(SpecError) as error:
        validate(source)
    (fault,) = error.value.faults
    assert f"{fault.key}: {fault.message}".startswith(said)
    source.value = {"kind": "hw-run", "name": "small", "remedies": {"plain wall": {}, "other": {"change": told}}}
    del source.value["remedies"]["other"]["change"]["device"]
    source.value["device"] = device
    with pytest.raises(SpecError) as error:
        validate(source)
    assert any(said.partition(": ")[2] in one.message for one in error.value.faults)


def test_a_controller_that_no_device_has_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(KINDS, "stiffening", KINDS["stiffening"]._replace(on_devices=False))
    source = Source("spec.yaml")
    source.value = {"kind": "hw-run", "name": "small", "controller": {"kind": "stiffening"}}
    with pytest.raises(SpecError) as error:
        validate(source)
    (fault,) = error.value.faults
    assert (fault.key, fault.message) == (
        "controller.kind",
        "must be one that a device can run: none has the law of stiffening",
    )


@pytest.mark.parametrize("detections", [4, 64])
def test_a_target_takes_readings_within_an_interval(detections: int) -> None:
    source = Source("spec.yaml")
    told = {"controller": {**READING, "detections": detections}, "device": HOST}
    source.value = {"kind": "hw-run", "name": "small", **told}
    validate(source)


MOVED = ("motor", "coil", "current_loop", "supply", "eddy_brake")


@pytest.mark.parametrize("part", MOVED)
def test_a_virtual_knob_takes_the_motors_of_the_table(part: str) -> None:
    source = Source("spec.yaml")
    source.value = {"kind": "hw-run", "name": "small", **CHANGES[part]["scene"]}
    assert VERDICTS[part, "device"] != REFUSED
    assert validate(source)


@pytest.mark.parametrize("part", [part for part in CONTROLLED if VERDICTS[part, "device"] == REFUSED])
def test_a_campaign_on_a_knob_has_a_reason_for_what_it_lacks(part: str) -> None:
    """Of a key that its spec has, as the column's own reason is that it has none."""
    assert (part, "device") in WHY


@pytest.mark.parametrize("part", OVER_ANGLE)
def test_a_campaign_on_a_knob_takes_what_the_table_says(part: str) -> None:
    source = Source("spec.yaml")
    source.value = {"kind": "hw-run", "name": "small", part: CHANGES[part]["scene"][part]}
    assert VERDICTS[part, "device"] != REFUSED
    assert getattr(validate(source).effects, part) is not None
