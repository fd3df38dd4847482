"""Numbers of the protocol: message types, answers, states of a target, and why it tripped (docs/reference/wire.md)."""

from enum import IntEnum

VERSION = 1


class Kind(IntEnum):
    """Types of messages; the target's have their top bit set."""

    HELLO = 0x01
    CONFIGURE = 0x02
    ARM = 0x03
    START = 0x04
    STOP = 0x05
    RELEASE = 0x06
    ALIVE = 0x07
    AGAIN = 0x08
    ZERO = 0x09
    SIMULATE = 0x10
    CONTROL = 0x11
    PULSE = 0x12
    SQUEEZE = 0x13
    OVER_ANGLE = 0x14
    TORQUES = 0x15
    ABILITIES = 0x16
    CONVERTERS = 0x17
    ACK = 0x81
    BLOCK = 0x82
    EVENT = 0x83
    READINGS = 0x84


class Law(IntEnum):
    """Controllers that a target can run; the names are those of their functions in `controllers`."""

    BOUNDED_LAG = 1
    FIRST_ORDER_HOLD = 2
    PASSIVITY = 3
    PHASE_DAMPING = 4
    STIFFENING = 5
    VELOCITY_DAMPING = 6
    DIFFERENCED_VELOCITY = 7
    TIMED_VELOCITY = 8
    ADAPTIVE_VELOCITY = 9
    TRACKED_VELOCITY = 10
    IMPULSE_DAMPING = 11
    HALF_SAMPLE = 12
    MATCHED_WALL = 13

    @property
    def bit(self) -> int:
        """Its place among the laws that a target has."""
        return 1 << self


ALL_LAWS = sum(law.bit for law in Law)


class Status(IntEnum):
    """What became of a command."""

    DONE = 0
    NOT_NOW = 1
    OUT_OF_RANGE = 2
    NOT_KNOWN = 3


class State(IntEnum):
    """What a target is doing."""

    IDLE = 0
    ARMED = 1
    RUNNING = 2
    TRIPPED = 3


class Trip(IntEnum):
    """Why a target took its torque off by itself."""

    NONE = 0
    WATCHDOG = 1
    SPEED = 2
    NOT_A_NUMBER = 3
    EMERGENCY_STOP = 4
    NO_ROOM = 5


STATUS_TEXT = {
    Status.DONE: "done",
    Status.NOT_NOW: "not in this state",
    Status.OUT_OF_RANGE: "a value is out of its range",
    Status.NOT_KNOWN: "it does not know this command",
}
TRIP_TEXT = {
    Trip.NONE: "it did not say why",
    Trip.WATCHDOG: "it did not hear from this computer for the watchdog's time (program stopped, or cable out?)",
    Trip.SPEED: "the knob turned faster than the speed limit",
    Trip.NOT_A_NUMBER: "a torque was not a number",
    Trip.EMERGENCY_STOP: "the emergency stop was pressed",
    Trip.NO_ROOM: "this computer took no samples for so long that the target has no room for more",
}
