"""Specs of pulses that a grip fires: what is taken, and the fault of each thing that is not."""

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.load import validate
from hknob_cli.specs.pulses import PulsePlan
from hknob_cli.specs.source import parse

BARE = "kind: hw-run\nname: p\nwhat: pulses\n"


def planned(text: str) -> PulsePlan:
    plan = validate(parse(text, "p.yaml"))
    assert isinstance(plan, PulsePlan)
    return plan


def faults(text: str) -> list[str]:
    with pytest.raises(SpecError) as caught:
        validate(parse(text, "p.yaml"))
    return str(caught.value).splitlines()


def test_a_bare_spec_is_the_dissertations() -> None:
    plan = planned(BARE)
    assert plan.grips == (0.71, 1.3, 2.4, 4.3, 7.8, 14.2)
    assert (plan.pulses.width, plan.pulses.trials, plan.pulses.sample_rate) == (0.02, 3, 1e4)
    assert (plan.pulses.trigger, plan.torques) == ("threshold", ())
    assert not plan.is_source


def test_grips_are_sorted_with_their_torques() -> None:
    plan = planned(BARE + "pulses: {grips: [4 N, 2], torques: [0.009, 5 mN*m]}\n")
    assert (plan.grips, plan.torques) == ((2.0, 4.0), (0.005, 0.009))


WRONG = {
    "wall: {stiffness: 0.1}\n": "p.yaml:4:1: wall: must be absent with what: pulses: it is of a buzz",
    "grid: {counts_per_rev: [512]}\n": "p.yaml:4:1: grid: must be absent with what: pulses: it is of a buzz",
    "grip: {target: 1}\n": "p.yaml:4:1: grip: must be absent with what: pulses: it is of a buzz",
    "person: {push: 0.001}\n": "p.yaml:4:1: person: must be absent with what: pulses: it is of a buzz",
    "device: {driver: serial}\n": (
        "p.yaml:4:9: device: must have exactly one of url and target with the driver serial"
    ),
    "device: {driver: serial, target: host}\npulses: {sensors: {torque_noise: 0.1}}\n": (
        "p.yaml:5:19: pulses.sensors: must be absent: they are for the driver virtual"
    ),
    "device: {driver: serial, target: host}\nnuisances: {jitter: 1 us}\n": (
        "p.yaml:5:12: nuisances: must be absent: they are for the driver virtual"
    ),
    "device: {driver: serial, target: qemu}\npulses: {sample_rate: 1 kHz}\nlimits: {watchdog: 1.5 ms}\n": (
        "p.yaml:6:20: limits.watchdog: must be two samples at least, 0.002 s, got 0.0015"
    ),
    "device: {driver: replay, recordings: [x]}\n": (
        "p.yaml:4:18: device.driver: must be virtual or serial with what: pulses: what was recorded has its "
        "pulse already, and sysid reads it"
    ),
    "device: {url: COM3}\n": "p.yaml:4:15: device.url: must be absent: it is for the driver serial",
    "pulses: {grips: [2, 15]}\n": (
        "p.yaml:4:17: pulses.grips: must be at most 14.2 N, the firmest grip of table 1, got 15"
    ),
    "pulses: {grips: [2, 2]}\n": "p.yaml:4:17: pulses.grips: must differ, got 2, 2",
    "pulses: {grips: [2], torques: [0.01, 0.02]}\n": "p.yaml:4:31: pulses.torques: must be one a grip, 1, got 2",
    "pulses: {grips: [2], torques: [0.2]}\n": (
        "p.yaml:4:32: pulses.torques[0]: must be at most limits.torque, 0.1 N*m, got 0.2"
    ),
    "pulses: {grips: []}\n": "p.yaml:4:17: pulses.grips: ",
    "pulses: {width: 10 us}\n": "p.yaml:4:17: pulses.width: must be a sample at least, 0.0001 s, got 1e-05",
    "pulses: {window: {after: 10 ms}}\n": (
        "p.yaml:4:26: pulses.window.after: must be >= 0.0202 s, the pulse and 2 samples, got 0.01"
    ),
    "pulses: {window: {after: 5}, timeout: 4}\n": "p.yaml:4:39: pulses.timeout: must be > window.after, 5 s",
    "pulses: {window: {after: 5}, timeout: 5}\n": "p.yaml:4:39: pulses.timeout: must be > window.after, 5 s",
    "pulses: {width: 60 ms, person: {reaction: 0.05}}\n": (
        "p.yaml:4:43: pulses.person.reaction: must be > the width of the pulse, 0.06 s, in which nobody lets go"
    ),
    "pulses: {sample_rate: 100 kHz, timeout: 900}\n": (
        "p.yaml:4:41: pulses.timeout: must be shorter: 1.8e+08 samples, at most 2e+07"
    ),
    "pulses: {trials: 100}\nrepeats: 100\n": (
        "p.yaml:4:18: pulses.trials: must be at most 1000 trials, with grips and repeats, got 60000"
    ),
    "pulses: {trigger: hold}\n": "p.yaml:4:19: pulses.trigger: ",
    "pulses: {release: 1}\n": "p.yaml:4:19: pulses.release: ",
    "pulses: {person: {table: 6}}\n": "p.yaml:4:26: pulses.person.table: ",
    "pulses: {dwel: 1}\n": "p.yaml:4:10: pulses.dwel: ",
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_said_at_its_place(text: str) -> None:
    found = faults(BARE + text)
    assert len(found) == 1
    assert found[0].startswith(WRONG[text])


def test_pulses_are_absent_of_a_buzz() -> None:
    assert faults("kind: hw-run\nname: p\npulses: {trials: 1}\n") == [
        "p.yaml:3:1: pulses: must be absent where what is not pulses"
    ]


def test_a_knob_lighter_than_the_hand_takes_off_is_a_fault_of_the_grips() -> None:
    """Table 1's firm grips have less inertia than the apparatus alone."""
    from hknob_cli.hardware.campaign import check_persons

    plan = planned(BARE + "pulses: {grips: [1]}\nknob: {inertia: 1 g*cm^2}\n")
    with pytest.raises(SpecError, match=r"p.yaml:4:\d+: pulses.grips: .*no inertia together"):
        check_persons(plan)


@pytest.mark.parametrize("written", ["null", "~"])
def test_no_recordings_at_all_are_a_fault_of_the_spec(written: str) -> None:
    """Their length is asked of a list alone."""
    text = f"kind: sysid\nname: x\nrecordings: {written}\n"
    assert faults(text) == ["p.yaml:1:7: kind: needs recordings, or virtual to make some, or a study"]


def test_a_watchdog_of_two_samples() -> None:
    text = BARE + "device: {driver: serial, target: host}\npulses: {sample_rate: 1 kHz}\nlimits: {watchdog: 2 ms}\n"
    assert planned(text).limits.watchdog == 0.002


def test_sensors_are_for_the_virtual_device() -> None:
    assert planned(BARE + "pulses: {sensors: {torque_noise: 0.1}}\n").pulses.sensors.torque_noise == 0.1


def test_the_most_pulses_of_a_campaign() -> None:
    assert planned(BARE + "pulses: {grips: [1, 2], trials: 5}\nrepeats: 100\n").repeats == 100
    assert faults(BARE + "pulses: {grips: [1, 2, 3, 4], trials: 3}\nrepeats: 100\n") == [
        "p.yaml:4:39: pulses.trials: must be at most 1000 trials, with grips and repeats, got 1200"
    ]


def test_what_damps_the_knob_goes_into_its_damping() -> None:
    motor = "motor: {torque_constant: 0.0234, resistance: 12.3, winding: shorted}\n"
    assert faults(BARE + motor) == [
        "p.yaml:4:1: motor: must be absent with what: pulses: its damping goes into that of the knob"
    ]
