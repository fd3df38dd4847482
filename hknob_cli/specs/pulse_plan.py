"""From a spec of pulses that a grip fires to its plan, or to what is wrong with it."""

from typing import Any

from hknob_cli.errors import Fault, SpecError
from hknob_cli.specs.campaign import REPLAY, SERIAL, VIRTUAL, Nuisance, device_faults
from hknob_cli.specs.declared import Place
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.pulses import PULSES, PulsePlan, Pulses, Sensors
from hknob_cli.specs.source import Source

_OF_BUZZ = (
    *("wall", "controller", "encoder", "actuator", "model", "remedies", "reference", "against", "hand"),
    *("grid", "grip", "trial", "person"),
    *OVER_ANGLE,
)
_DAMPS = ("motor", "eddy_brake")
_NO_REPLAY = "what was recorded has its pulse already, and sysid reads it"
MOST_TRIALS = 1000
MOST_SAMPLES = 2e7  # of a trial, which is in memory as a whole
LEAST_REST = 2  # samples between the pulse and the end of the window


def plan_pulses(source: Source, spec: Any) -> PulsePlan:
    """A campaign of pulses as plain values; ``spec``: a valid `HwRunSpec`. Raises `SpecError`."""
    from hknob_cli.printed.tables import grasps

    pulses: Pulses = spec.pulses or Pulses()
    printed = [row.grip_n for row in grasps(pulses.person.table)]
    grips = tuple(sorted(dict.fromkeys(pulses.grips))) if pulses.grips else tuple(printed)
    faults: list[Fault] = []
    for key in _OF_BUZZ:
        if key in spec.model_fields_set:
            faults.append(source.fault((key,), "must be absent with what: pulses: it is of a buzz", at_key=True))
    for key in _DAMPS:
        if key in spec.model_fields_set:
            text = "must be absent with what: pulses: its damping goes into that of the knob"
            faults.append(source.fault((key,), text, at_key=True))
    for place, text in (*_device_faults(spec), *_faults(spec, pulses, grips, printed[-1])):
        faults.append(source.fault(place, text))
    if faults:
        raise SpecError(faults)
    by_grip = dict(zip(pulses.grips or printed, pulses.torques or (), strict=False))
    return PulsePlan(
        name=spec.name,
        device=spec.device,
        pulses=pulses,
        grips=grips,
        torques=tuple(by_grip[grip] for grip in grips) if by_grip else (),
        limits=spec.limits,
        shuffled=spec.order == "random",
        seed=spec.seed,
        repeats=spec.repeats,
        subject=spec.subject,
        experiment=spec.experiment,
        knob=spec.knob,
        nuisances=spec.nuisances or Nuisance(),
        values=source.value,
        grip_place=source.fault((PULSES, "grips"), ""),
    )


def _device_faults(spec: Any) -> list[tuple[Place, str]]:
    """A driver that fires no pulse, what a driver needs, and what only a virtual device has."""
    if spec.device.driver == REPLAY:
        return [(("device", "driver"), f"must be virtual or serial with what: pulses: {_NO_REPLAY}")]
    found: list[tuple[Place, str]] = [*device_faults(spec)]
    if spec.device.driver != VIRTUAL and (spec.pulses or Pulses()).sensors != Sensors():
        found.append(((PULSES, "sensors"), "must be absent: they are for the driver virtual"))
    return found


def _faults(spec: Any, pulses: Pulses, grips: tuple[float, ...], firmest_n: float) -> list[tuple[Place, str]]:
    """Numbers that exclude one another."""
    found: list[tuple[Place, str]] = []
    said = pulses.grips or []
    if len(set(said)) < len(said):
        found.append(((PULSES, "grips"), f"must differ, got {', '.join(f'{one:g}' for one in said)}"))
    if grips[-1] > firmest_n:
        text = f"must be at most {firmest_n:g} N, the firmest grip of table {pulses.person.table}, got {grips[-1]:g}"
        found.append(((PULSES, "grips"), text))
    if pulses.torques is not None and len(pulses.torques) != len(said or grips):
        found.append(((PULSES, "torques"), f"must be one a grip, {len(said or grips)}, got {len(pulses.torques)}"))
    for i, torque in enumerate(pulses.torques or ()):
        if torque > spec.limits.torque:
            text = f"must be at most limits.torque, {spec.limits.torque:g} N*m, got {torque:g}"
            found.append(((PULSES, "torques", i), text))
    interval = 1.0 / pulses.sample_rate
    if spec.limits.watchdog < 2.0 * interval and spec.device.driver == SERIAL:
        text = f"must be two samples at least, {2.0 * interval:g} s, got {spec.limits.watchdog:g}"
        found.append((("limits", "watchdog"), text))
    if pulses.width < interval:
        found.append(((PULSES, "width"), f"must be a sample at least, {interval:g} s, got {pulses.width:g}"))
    least = pulses.width + LEAST_REST * interval
    if pulses.window.after < least:
        text = f"must be >= {least:g} s, the pulse and {LEAST_REST} samples, got {pulses.window.after:g}"
        found.append(((PULSES, "window", "after"), text))
    if pulses.timeout <= pulses.window.after:
        found.append(((PULSES, "timeout"), f"must be > window.after, {pulses.window.after:g} s"))
    if pulses.person.reaction <= pulses.width:
        text = f"must be > the width of the pulse, {pulses.width:g} s, in which nobody lets go"
        found.append(((PULSES, "person", "reaction"), text))
    samples = pulses.sample_rate * (pulses.zero + 2.0 * pulses.timeout)
    if samples > MOST_SAMPLES:
        found.append(((PULSES, "timeout"), f"must be shorter: {samples:.2g} samples, at most {MOST_SAMPLES:.0e}"))
    count = len(grips) * pulses.trials * spec.repeats
    if count > MOST_TRIALS:
        text = f"must be at most {MOST_TRIALS} trials, with grips and repeats, got {count}"
        found.append(((PULSES, "trials"), text))
    return found
