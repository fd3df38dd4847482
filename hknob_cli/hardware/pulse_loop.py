"""The loop of a virtual trial of a pulse that a grip fires (Hasser, section 3.2): no wall, but a state machine.

Until the pulse the knob rests where the hand holds it. At the pulse the hand is that of the grip force at that sample,
and stays so: the pulse is over before anybody can answer. Sensors tell what is there at the sample: the angle and the
acceleration just before the new torque, the torque that acts from the sample on.
"""

import math
from math import tau

import numpy as np

from hknob_cli.hardware.control import GripTrigger, Phase
from hknob_cli.hardware.knob_motion import KnobMotion, Nuisances
from hknob_cli.hardware.person import grip_of, squeezing_hand
from hknob_cli.hardware.port import Array, Block, PulseOrder, Settings, Simulated, Squeeze
from hknob_cli.hardware.trial_wall import Sent
from hknob_cli.hardware.virtual import VirtualLoop, as_single

_SPENT = 50.0  # time constants of the amplifier after which nothing is left of its torque


class PulsedKnob:
    """A knob that rests until a hand is given, and moves about where it rested from then on."""

    def __init__(self, simulated: Simulated, *, interval_s: float, counts_per_rev: int, amplifier_s: float) -> None:
        """As a `KnobMotion`."""
        self._simulated, self._amplifier_s = simulated._replace(angle_rad=0.0), amplifier_s
        self._interval_s, self._counts_per_rev = interval_s, counts_per_rev
        self._neutral = simulated.angle_rad * counts_per_rev / tau
        self._motion: KnobMotion | None = None
        self._torque_nm, self._quiet_s = 0.0, 0.0

    @property
    def angle_counts(self) -> float:
        """Angle in counts, whole and broken."""
        return self._neutral + (self._motion.angle_counts if self._motion else 0.0)

    @property
    def speed_counts(self) -> float:
        """Speed in counts of a sample period."""
        return self._motion.speed_counts if self._motion else 0.0

    def take(self, squeeze: Squeeze, grip_n: float) -> None:
        """Let the hand at this grip hold it from now on."""
        hand = squeezing_hand(squeeze, grip_n)
        self._simulated = self._simulated._replace(**hand._asdict())
        self._motion = KnobMotion(
            self._simulated,
            interval_s=self._interval_s,
            counts_per_rev=self._counts_per_rev,
            amplifier_s=self._amplifier_s,
        )

    def move(self, torque_nm: float, push_nm: float, periods: float = 1.0) -> None:
        """Move for some sample periods under a commanded torque, and a push, both constant."""
        self._torque_nm = torque_nm
        self._quiet_s = 0.0 if torque_nm else self._quiet_s + periods * self._interval_s
        if self._motion is None or self._stays:
            return
        self._motion.move(torque_nm, push_nm, periods)

    @property
    def _stays(self) -> bool:
        """Whether friction holds it, and nothing will move it any more."""
        spent = self._quiet_s > _SPENT * self._amplifier_s + 2.0 * self._interval_s
        still = self._motion is not None and self._motion.speed_rad_s == 0.0
        return spent and still and self._simulated.coulomb_nm > 0.0

    def sensed(self, torque_nm: float, *, sees_friction: bool) -> tuple[float, float]:
        """Torque (N·m) from now on, of which ``torque_nm`` is commanded, and acceleration (rad/s²) until now.

        ``sees_friction``: less what friction takes of it from now on. A sensor that carries the motor reads that, and
        so what turns knob and hand: friction within the motor acts on its housing as on its shaft, and cancels there
        (Hasser, Section 4.2.3 and Appendix A). That all of the friction is within the motor is an assumption.
        """
        if self._motion is None:
            return torque_nm, 0.0
        lagged = self._motion.lagged_torque_nm
        told = torque_nm if lagged is None else lagged
        return told - (self._taken_by_friction(told) if sees_friction else 0.0), self._acceleration(lagged)

    def _taken_by_friction(self, acting_nm: float) -> float:
        """Friction (N·m) under the motor's torque from now on: its level, or what it holds a knob still against."""
        assert self._motion is not None
        one, speed = self._simulated, self._motion.speed_rad_s
        pull = acting_nm - one.stiffness * self._motion.angle_rad
        if speed == 0.0 and abs(pull) <= one.coulomb_nm:
            return pull
        return math.copysign(one.coulomb_nm, speed or pull)

    def _acceleration(self, lagged: float | None) -> float:
        """Acceleration (rad/s²) until now."""
        assert self._motion is not None
        one, speed = self._simulated, self._motion.speed_rad_s
        if speed == 0.0 and one.coulomb_nm > 0.0:
            return 0.0
        acting = self._torque_nm if lagged is None else lagged
        rubbing = math.copysign(one.coulomb_nm, speed)
        pull = acting - one.damping * speed - one.stiffness * self._motion.angle_rad - rubbing
        return pull / one.inertia


class PulseLoop(VirtualLoop):
    """The control loop of one trial of a pulse, from arming on."""

    def __init__(self, settings: Settings, simulated: Simulated, nuisances: Nuisances, native_counts: int) -> None:
        super().__init__(settings, simulated, nuisances, native_counts)
        assert isinstance(settings.pulse, PulseOrder)
        assert isinstance(simulated.squeeze, Squeeze)
        self._squeeze = simulated.squeeze
        self._trigger = GripTrigger(settings.pulse, settings.interval_s)
        self._knob = PulsedKnob(
            simulated,
            interval_s=settings.interval_s,
            counts_per_rev=native_counts,
            amplifier_s=nuisances.amplifier_s,
        )
        self._motion = self._knob  # what `VirtualLoop` moves and reads
        self._fired_s: float | None = None
        self._times, self._forces, self._cell = (np.empty(0) for _ in range(3))
        self._sensed: list[tuple[float, float]] = []

    def block(self, *, running: bool) -> Block:
        """The next samples, with those of the sensors that there are."""
        self._sensed = []
        block = super().block(running=running)
        count = len(block.time_us)
        told = np.array([*self._sensed, *[(0.0, 0.0)] * (count - len(self._sensed))]).reshape(count, 2)
        torque, acceleration, _ = self._squeeze.sensors
        if torque is not None:
            noise = self._disturbances.torque_nm(torque, self._settings.block_samples)[:count]
            block = block._replace(measured_torque_nm=as_single(told[:, 0] + noise))
        if acceleration is not None:
            noise = self._disturbances.acceleration_rad_s2(acceleration, self._settings.block_samples)[:count]
            block = block._replace(acceleration_rad_s2=as_single(told[:, 1] + noise))
        return block

    def _person(self, begins: Array, running: bool) -> tuple[Array, Array]:
        """No push (N·m), and what the grip cell shows (N), without its noise."""
        if running and self._began is None:
            self._began = float(begins[0])
        self._times = (begins - (self._began or 0.0)) * self._settings.interval_s
        self._forces = grip_of(self._squeeze, self._times, self._fired_s) if running else np.zeros(begins.size)
        return np.zeros(begins.size), self._forces + self._simulated.grip_offset_n

    def _shown(self, grips: Array) -> None:
        self._cell = as_single(grips)

    def _commanded(self, index: int, _coarse: int, _before: int, running: bool) -> Sent:
        """Torque that the state machine gives; the hand is that of the grip at which it fires."""
        i = index - self._index
        torque = self._trigger.step(float(self._cell[i]), running=running)
        if self._fired_s is None and self._trigger.phase is Phase.PULSE:
            self._fired_s = float(self._times[i])
            self._knob.take(self._squeeze, float(self._forces[i]))
        self._sensed.append(self._knob.sensed(torque, sees_friction=self._squeeze.sensors[2]))
        limit = self._settings.torque_limit_nm
        return Sent(max(-limit, min(limit, torque)))
