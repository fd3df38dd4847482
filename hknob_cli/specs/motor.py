"""What a motor or a magnet does to the knob beside the torque that is asked of it, from constants of data sheets.

Its cogging, too: magnets prefer some angles to others, whatever the current is.

A winding that turns in its motor's field gets a voltage Kt w, and with R and L a current whose torque brakes,

    L di/dt + R i = V - Kt w,   torque = Kt i,

which is viscous damping Kt²/R where L is 0, and else a damper behind a spring of Kt²/L (a Maxwell element). A current
amplifier takes that away, a voltage amplifier leaves it. Source: Hasser, Chapter 11 (electromechanical damping).
"""

from typing import Annotated, Literal, NamedTuple

from hknob_cli.specs.quantity import Angle, Bounds, Quantity, Torque, declared

Winding = Literal["shorted", "voltage", "current"]


@declared()
class Motor(NamedTuple):
    """A motor by its constants: a winding that damps the knob, or that turns commands into torque, or both."""

    torque_constant: Annotated[float, Quantity("N*m/A", gt=0, le=1e6), "Kt; in SI units also volts per rad/s"]
    resistance: Annotated[
        float, Quantity("ohm", gt=0, le=1e12), "R of the circuit: of the winding and of what is in series with it"
    ]
    winding: Annotated[
        Winding,
        "what its ends are on: 'shorted', on each other, beside the winding that is driven; 'voltage', on an amplifier "
        "of voltage, which drives it; 'current', on one of current",
    ]
    inductance: Annotated[float, Quantity("H", ge=0, le=1e6), "L of the circuit"] = 0.0
    bandwidth: Annotated[
        float | None,
        Quantity("Hz", gt=0, le=1e9),
        "of the current loop, a lag of first order from command to torque; null: without lag",
    ] = None
    supply_voltage: Annotated[
        float | None, Quantity("V", gt=0, le=1e6), "the most that the amplifier of voltage gives; null: any"
    ] = None

    def wrong(self) -> str:
        """What its winding does not have; empty if nothing."""
        if self.winding != "current" and self.bandwidth is not None:
            return f"bandwidth: must be absent where winding is {self.winding}: it is of a current loop"
        if self.winding == "shorted" and self.supply_voltage is not None:
            return "supply_voltage: must be absent where winding is shorted: no amplifier drives it"
        if self.winding == "current" and self.inductance != 0.0:
            return "inductance: must be absent where winding is current: the amplifier overcomes it; give its bandwidth"
        if self.winding == "current" and self.supply_voltage is not None:
            fall = self.torque_constant * self.torque_constant / self.resistance
            return (
                "supply_voltage: must be absent where winding is current: the largest torque would fall with the speed "
                f"by Kt²/R = {fall:.3g} N*m for each rad/s, which no engine follows; give actuator.torque_limit"
            )
        return ""


MOST_COGS = 10**6  # in a revolution


@declared()
class Cogging(NamedTuple):
    """A torque of the motor's true angle, without current: a triangle wave with places of rest at equal distances."""

    per_revolution: Annotated[
        int,
        Bounds(strict=True, ge=1, le=MOST_COGS),
        "places of rest in a turn of the motor: the least common multiple of poles and slots",
    ]
    torque: Annotated[Torque, "the largest, a quarter of a period from a place of rest; 0: none"] = 0.0
    centre: Annotated[Angle, "angle of one of them, of the motor"] = 0.0


@declared()
class EddyBrake(NamedTuple):
    """A magnet over a disc of metal that turns with the knob: viscous damping share·s·d·A·B²·r².

    Source: Heald, Magnetic braking: improved theory, Am. J. Phys. 56, 521 (1988), at speeds far below 2/(μ0 s d).
    """

    flux_density: Annotated[float, Quantity("T", gt=0, le=100), "B through the disc"]
    conductivity: Annotated[float, Quantity("S/m", gt=0, le=1e9), "s of the disc; 5.8e7 of copper"]
    thickness: Annotated[float, Quantity("m", gt=0, le=1), "d of the disc"]
    area: Annotated[float, Quantity("m^2", gt=0, le=1), "A of the magnet's pole"]
    radius: Annotated[float, Quantity("m", gt=0, le=1), "r from the axis to the middle of the pole"]
    share: Annotated[
        float,
        Bounds(strict=True, gt=0, le=1, allow_inf_nan=False),
        "of the voltage that is not lost on the currents' way back; 1 where that has no resistance, about 0.5 by a "
        "square pole on a wide disc",
    ]

    @property
    def damping(self) -> float:
        """N·m·s/rad."""
        return (
            self.share
            * self.conductivity
            * self.thickness
            * self.area
            * (self.flux_density * self.radius)
            * (self.flux_density * self.radius)
        )


class Coil(NamedTuple):
    """A shorted winding with inductance, as the knob feels it.

    ``damping``: Kt²/R, of a slow motion, N·m·s/rad; ``time_constant``: L/R, s.
    """

    damping: float
    time_constant: float
