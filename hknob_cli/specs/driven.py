"""What a motor by its constants and an eddy brake come to for the knob of a simulated device, as in a scene."""

from typing import Any, NamedTuple

from hknob_cli.specs.declared import Place
from hknob_cli.specs.electrical import reduced
from hknob_cli.specs.motor import Coil, EddyBrake, Motor
from hknob_cli.specs.parts import Actuator, Knob, Scene, Wall

BESIDE_SUPPLY = "must be absent beside motor.supply_voltage: Kt V/R is the limit"  # of actuator.torque_limit


class Driven(NamedTuple):
    """The knob with their damping, a winding that remembers, and lag (s) and torque limit (N·m) of the amplifier."""

    knob: Knob
    coil: Coil | None
    lag_s: float
    limit_nm: float | None


def driven_of(knob: Any, motor: Motor | None, eddy_brake: EddyBrake | None) -> Driven:
    """What they come to; ``knob`` has the fields of a scene's."""
    found = reduced(Scene(knob=Knob(*knob), wall=Wall(0.0), motor=motor, eddy_brake=eddy_brake))
    actuator = found.actuator or Actuator()
    return Driven(found.knob, found.coil, actuator.time_constant, actuator.torque_limit)


def driven_faults(spec: Any, knob: Any, *, virtual: bool) -> list[tuple[Place, str]]:
    """What of the motor of a campaign's ``spec`` is not followed there, and what it excludes.

    ``virtual``: whether the device is the virtual one; else it is a target whose knob is simulated.
    """
    if spec.motor is None:
        return []
    found: list[tuple[Place, str]] = []
    driven = driven_of(knob, spec.motor, None)
    lag = "inductance" if driven.coil else "bandwidth"
    if driven.coil and not virtual:
        text = "must be 0 with a target: the knob that its firmware simulates has no winding that remembers"
        found.append((("motor", "inductance"), text))
    elif driven.lag_s and not virtual:
        text = "must be absent with a target: the amplifier that its firmware simulates has no lag"
        found.append((("motor", "bandwidth"), text))
    if driven.lag_s and spec.nuisances is not None and spec.nuisances.amplifier:
        found.append((("nuisances", "amplifier"), f"must be absent beside motor.{lag}, which is the lag"))
    if driven.limit_nm is not None and spec.actuator is not None and spec.actuator.torque_limit is not None:
        found.append((("actuator", "torque_limit"), BESIDE_SUPPLY))
    return found


def limited(actuator: Any, limit_nm: float | None) -> Any:
    """An actuator, None for none, with the limit of a motor; its own, which a remedy has given it, if that is less."""
    if limit_nm is None:
        return actuator
    made = actuator or Actuator()
    own = made.torque_limit
    return made._replace(torque_limit=limit_nm if own is None else min(own, limit_nm))
