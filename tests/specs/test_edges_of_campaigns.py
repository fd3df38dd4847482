"""Campaigns on a knob: what each rule of their specs allows last, and what it refuses first."""

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.campaign import HwRunPlan
from hknob_cli.specs.drive import limited
from hknob_cli.specs.load import load_text, validate
from hknob_cli.specs.plan import (
    Actuator,
)
from hknob_cli.specs.source import parse
from tests.conftest import SPEC
from tests.hardware.campaigns import REMEDIES, planned
from tests.hardware.campaigns import SPEC as BENCH
from tests.specs.test_edges_of_rules import wrong


def test_nuisances_and_person_are_kept() -> None:
    plan = validate(parse(BENCH + "nuisances: {jitter: 1e-6}\n", "spec.yaml"))
    assert isinstance(plan, HwRunPlan)
    assert plan.nuisances.jitter == 1e-6
    assert not plan.person.wandering_push


SERIAL = BENCH.replace("kind: hw-run\n", "kind: hw-run\ndevice: {driver: serial, url: socket://localhost:1}\n")


# A campaign's spec with one change, and what is wrong with it, if anything.
CAMPAIGNS: dict[str, tuple[str, str]] = {
    "grip as wide as its target": (BENCH + "grip: {target: 0.7, band: 0.7}\n", "grip.band: must be < the target of"),
    "a grip less wide": (BENCH + "grip: {target: 0.7, band: 0.69}\n", ""),
    "no grip": (BENCH + "grip: none\n", ""),
    "the slowest rate": (BENCH.replace("[1000, 2000]", "[1]"), ""),
    "slower": (BENCH.replace("[1000, 2000]", "[0.5]"), "grid.sample_rate_hz[0]: must be 1 to 1000000 Hz, got 0.5"),
    "the fastest rate": (BENCH.replace("[1000, 2000]", "[1000000]"), ""),
    "a trial as long as settling and the least buzz": (BENCH.replace("longest: 2", "longest: 0.15"), ""),
    "a shorter trial": (
        BENCH.replace("longest: 2", "longest: 0.14"), "trial.longest: must be >= 0.15, settle and the least buzz, got",
    ),
    "faster": (BENCH.replace("[1000, 2000]", "[1000001]"), "grid.sample_rate_hz[0]: must be 1 to 1000000 Hz"),
    "a watchdog of two samples": (SERIAL + "limits: {watchdog: 0.002}\n", ""),
    "a watchdog of less": (
        SERIAL + "limits: {watchdog: 0.0019}\n",
        "limits.watchdog: must be two samples at least, 0.002 s at 1000 Hz, got 0.0019",
    ),
    "the port of another driver": (BENCH + "device: {url: /dev/x}\n", "device.url: "),
}  # fmt: skip


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_limits_of_a_campaign(name: str) -> None:
    text, said = CAMPAIGNS[name]
    found = wrong(text)
    assert len(found) == bool(said)
    assert not said or found[0].startswith(said)


def test_the_longest_trial_of_a_campaign() -> None:
    """20 million samples: 0.5 s before the wall, and 199.5 s with it, at 100 kHz."""
    text = BENCH.replace("[1000, 2000]", "[100000]").replace("zero: 0.05", "zero: 0.5")
    assert wrong(text.replace("longest: 2", "longest: 199.5")) == []
    assert [one.split(":")[0] for one in wrong(text.replace("longest: 2", "longest: 199.51"))] == ["trial.longest"]


def test_the_most_trials_of_a_campaign_count_its_remedies() -> None:
    remedies = "remedies: {plain wall: {}, soft: {change: {wall: {stiffness: 0.1}}}}\n"
    five = BENCH.replace("[1000, 2000]", "[1000, 1001, 1002, 1003, 1004]").replace("[256, 512]", "[256]")
    six = five.replace("1004", "1004, 1005")
    eleven = six.replace("1005", "1005, 1006, 1007, 1008, 1009, 1010")
    assert wrong(f"{eleven}repeats: 100\n") == ["grid: must be at most 1000 trials with repeats, got 1100"]
    assert wrong(f"{five}{remedies}repeats: 100\n") == []
    assert wrong(f"{six}{remedies}repeats: 100\n") == [
        "grid: must be at most 1000 trials with repeats and remedies, got 1200"
    ]


def test_a_limit_beside_a_supply_voltage_is_a_fault_and_another_actuator_is_not() -> None:
    motor = "motor: {torque_constant: 0.0234, resistance: 12.3, winding: voltage, supply_voltage: 1.2}\n"
    assert wrong(f"{BENCH}{motor}actuator: {{delay_samples: 1}}\n") == []
    assert wrong(f"{BENCH}{motor}actuator: {{torque_limit: 0.1}}\n") == [
        "actuator.torque_limit: must be absent beside motor.supply_voltage: Kt V/R is the limit"
    ]


def test_what_a_remedy_on_a_knob_must_not_change_is_pointed_at() -> None:
    text = BENCH + REMEDIES.replace("  softer", "  faster: {change: {grid: {}}}\n  softer") + "reference: plain wall\n"
    with pytest.raises(SpecError) as raised:
        load_text(text, "spec.yaml")
    assert [(fault.line, fault.column) for fault in raised.value.faults] == [(8, 21)]


def test_a_campaign_without_a_grip_cell_has_no_grip() -> None:
    assert planned(BENCH + "grip: none\n").course.grip is None


def test_a_grip_that_is_wrong_within_is_said_to_be_wrong_there() -> None:
    assert wrong(BENCH + "grip: {target: -1}\n") == ["grip.target: must be > 0, got -1"]


def test_a_lag_of_the_winding_or_of_the_current_loop_is_the_lag() -> None:
    for winding, key in (("voltage, inductance: 1.0e-3", "inductance"), ("current, bandwidth: 100", "bandwidth")):
        motor = f"motor: {{torque_constant: 0.0234, resistance: 12.3, winding: {winding}}}\n"
        assert wrong(f"{BENCH}{motor}nuisances: {{amplifier: 1.0e-3}}\n") == [
            f"nuisances.amplifier: must be absent beside motor.{key}, which is the lag"
        ]
        assert wrong(f"{BENCH}{motor}nuisances: {{jitter: 1.0e-6}}\n") == []
    motor = "motor: {torque_constant: 0.0234, resistance: 12.3, winding: voltage}\n"
    assert wrong(f"{BENCH}{motor}nuisances: {{amplifier: 1.0e-3}}\n") == []


@pytest.mark.parametrize(
    ("own", "motor", "found"), [(0.01, 0.1, 0.01), (0.1, 0.01, 0.01), (None, 0.1, 0.1), (0.1, None, 0.1)]
)
def test_the_lower_limit_of_torque_holds(own: float | None, motor: float | None, found: float) -> None:
    assert limited(Actuator(torque_limit=own), motor).torque_limit == found
    assert motor is None or limited(None, motor).torque_limit == motor
    assert limited(Actuator(delay_samples=1.0, torque_limit=own), motor).delay_samples == 1.0


def test_detents_of_a_campaign_take_the_place_of_its_wall() -> None:
    detents = "detents: {per_revolution: 12, torque: 0.01}\n"
    assert planned(BENCH + detents).first.wall.stiffness == 0.0
    assert planned(BENCH + detents + "wall: {stiffness: 0.3}\n").first.wall.stiffness == 0.3


def test_what_goes_with_remedies_alone() -> None:
    more = "reference: plain wall\nagainst: there\nhand: pinch\n"
    keys = ("reference", "against", "hand")
    assert wrong(BENCH + more) == [f"{key}: must be absent without remedies" for key in keys]
    assert wrong(BENCH + REMEDIES + more) == []


def test_an_actuator_of_a_device_gives_a_torque() -> None:
    assert wrong(BENCH + "actuator: {torque_limit: 1.0}\n") == []
    assert wrong(BENCH + "actuator: {torque_limit: 0}\n") == ["actuator.torque_limit: must be > 0 on a device"]


def test_the_speed_of_a_port() -> None:
    assert wrong(SERIAL.replace("url: socket://localhost:1", "url: COM3, baud: 9600")) == []
    assert wrong(SERIAL.replace("url: socket://localhost:1", "target: host, baud: 9600")) == [
        "device.baud: must be absent with target, which has no port to set"
    ]


def test_nobody_knows_the_model_of_a_knob_at_a_port() -> None:
    text = SERIAL + "controller: {kind: matched_wall}\n"
    assert wrong(text) == ["model: required: matched_wall acts by a model of knob and hand, which nobody knows here"]
    assert wrong(text.replace("url: socket://localhost:1", "target: host")) == []


def test_a_winding_without_inductance_is_no_lag() -> None:
    motor = "  motor: {torque_constant: 0.0234, resistance: 12.3, winding: voltage}\n"
    assert wrong(SPEC.replace("grid:", motor + "  actuator: {time_constant: 1.0e-3}\ngrid:")) == []
    device = SERIAL.replace("url: socket://localhost:1", "target: host")
    assert wrong(device + motor.strip() + "\n") == []
