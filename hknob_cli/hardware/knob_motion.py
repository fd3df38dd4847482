"""A simulated knob in somebody's hand: its exact motion from sample to sample, and what is not ideal about it.

The engine's general body does the moving, in counts of the device's own encoder and in sample periods. A push by the
person does not pass the amplifier; where that lags, its last state is the sum of both torques, and a change of the push
is added to it directly, which leaves its equation as it is: the push is constant from sample to sample.
"""

from math import isfinite
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np

from hknob_cli.engine.general.advance import advance_hold, advance_span
from hknob_cli.engine.general.body import SECOND
from hknob_cli.engine.general.slide_two import step_with_friction
from hknob_cli.errors import UsageError
from hknob_cli.hardware.port import Array, Settings, Simulated
from hknob_cli.recordings.trial import Purpose, stream
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.motor import Coil
from hknob_cli.specs.plan import Actuator, Hand, Knob, Scene, Wall

_ANGLE, _GRIP, _JITTER, _LATE, _TORQUE, _ACCELERATION = range(6)  # last number of each nuisance's stream


class Nuisances(NamedTuple):
    """Each is off at 0, and draws from a stream of its own, so that switching one on changes no other.

    ``angle_noise_rad``: rms of the encoder before it rounds; ``grip_noise_n``: rms of the grip cell; ``amplifier_s``:
    time constant of a first-order lag from command to torque; ``jitter_s``: rms by which a sample begins after its
    time, never before it; ``late_share``: share of samples that begin half a period to ``LATEST`` periods after it.

    The noise of a trial follows from ``seed``, its settings and its simulated person, whatever was run before.
    """

    angle_noise_rad: float = 0.0
    grip_noise_n: float = 0.0
    amplifier_s: float = 0.0
    jitter_s: float = 0.0
    late_share: float = 0.0
    seed: int = 0

    def checked(self) -> "Nuisances":
        """These. Raises `UsageError` for a number out of range."""
        for name, value in self._asdict().items():
            if not isfinite(value) or value < 0.0:
                raise UsageError(f"virtual device: {name} must be >= 0, got {value:g}")
        if self.late_share > 1.0:
            raise UsageError(f"virtual device: late_share must be <= 1, got {self.late_share:g}")
        return self


LATEST = 3.0  # periods that an overrun takes at most: an assumption, some ticks of the clock are missed


class Disturbances:
    """The nuisances of one trial, block after block; how they are cut into blocks changes nothing."""

    def __init__(self, nuisances: Nuisances, settings: Settings, simulated: Simulated) -> None:
        plain = simulated._replace(push_sines=(), grip_sines=())
        numbers = [value for value in plain if not isinstance(value, tuple)]
        numbers += [value for sine in (*simulated.push_sines, *simulated.grip_sines) for value in sine]
        numbers += [one.amplitude for one in simulated.squeeze.sines] if simulated.squeeze else []
        person = crc32(np.array(numbers, dtype="<f8").tobytes())
        place = settings.period_ns, settings.counts_per_rev, person

        def own(which: int) -> np.random.Generator:
            return stream(nuisances.seed, Purpose.DEVICE, *place, which)

        self._nuisances = nuisances
        self._angle, self._grip, self._jitter, self._late = own(_ANGLE), own(_GRIP), own(_JITTER), own(_LATE)
        self._torque, self._acceleration = own(_TORQUE), own(_ACCELERATION)
        self._jitter_periods = nuisances.jitter_s / settings.interval_s
        self._tick = 0

    def angle_rad(self, count: int) -> Array:
        """Noise of the encoder at the next samples."""
        return _noise(self._angle, self._nuisances.angle_noise_rad, count)

    def grip_n(self, count: int) -> Array:
        """Noise of the grip cell at the next samples."""
        return _noise(self._grip, self._nuisances.grip_noise_n, count)

    def torque_nm(self, rms: float, count: int) -> Array:
        """Noise of a torque sensor at the next samples."""
        return _noise(self._torque, rms, count)

    def acceleration_rad_s2(self, rms: float, count: int) -> Array:
        """Noise of an accelerometer at the next samples."""
        return _noise(self._acceleration, rms, count)

    def begins(self, count: int) -> tuple[Array, Array]:
        """When the next samples begin, and how late that is, both in periods: arrays (count,).

        A sample begins at the first tick of the clock after the last one began, or later. Ticks that pass meanwhile are
        not made up for.
        """
        late = np.abs(_noise(self._jitter, self._jitter_periods, count))
        if self._nuisances.late_share > 0.0:
            chance = self._late.random((count, 2))
            over = chance[:, 0] < self._nuisances.late_share
            late = np.where(over, 0.5 + (LATEST - 0.5) * chance[:, 1], late)
        ticks = np.zeros(count)
        if late.max() < 1.0:
            ticks[:] = self._tick + np.arange(count)
            self._tick += count
        else:
            for i in range(count):
                ticks[i] = self._tick
                self._tick += 1 + int(late[i])
        return ticks + late, late


def _noise(rng: np.random.Generator, rms: float, count: int) -> Array:
    return rms * rng.standard_normal(count) if rms > 0.0 else np.zeros(count)


PATIENCE = 8000  # moves of a third state, 0.3 ms each, after which the same code compiled is worth its loading


class KnobMotion:
    """Angle and speed of the knob of a `Simulated`, at rest at first.

    ``interval_s``: the unit of time of `move`; ``counts_per_rev``: of `angle_counts`; ``amplifier_s``: time constant of
    the amplifier's lag, 0 without; ``coil``: a winding that brakes the knob and remembers.
    Raises `ComputationError` if the numbers overflow.
    """

    _is_compiled = False

    def __init__(
        self,
        simulated: Simulated,
        *,
        interval_s: float,
        counts_per_rev: int,
        amplifier_s: float = 0.0,
        coil: Coil | None = None,
    ) -> None:
        scene = Scene(
            knob=Knob(simulated.inertia, simulated.damping, simulated.coulomb_nm),
            wall=Wall(0.0),
            hand=Hand(stiffness=simulated.stiffness),
            bias=None,
            encoder=None,
            actuator=Actuator(time_constant=amplifier_s),
            coil=coil,
        )
        knob = sample_general(scene, sample_rate_hz=1.0 / interval_s, counts_per_rev=counts_per_rev)
        self._knob, self._body, self._unit_nm = knob, knob.body, knob.torque_nm
        self._state: Any = knob.start(simulated.angle_rad, 0.0)
        self._pad: Any = [0.0] * (2 * knob.body.order)
        self._push = 0.0
        self._advance_span: Any = advance_span
        self._moves = 0

    @property
    def angle_counts(self) -> float:
        """Angle in counts, whole and broken."""
        return float(self._state[0])

    @property
    def angle_rad(self) -> float:
        """Angle."""
        return self._knob.angle_rad(float(self._state[0]))

    @property
    def speed_counts(self) -> float:
        """Speed in counts of a sample period."""
        return float(self._state[1])

    @property
    def speed_rad_s(self) -> float:
        """Speed."""
        return float(self._state[1]) * self._knob.quantum_rad / self._knob.period_s

    @property
    def lagged_torque_nm(self) -> float | None:
        """What the amplifier gives, the push taken off; None for one without lag, which gives what it is told."""
        return float(self._state[-1]) * self._unit_nm if self._body.lag > 0.0 else None

    def move(self, torque_nm: float, push_nm: float, periods: float = 1.0) -> None:
        """Move for some sample periods under a commanded torque, and a push into the wall, both constant."""
        body, state = self._body, self._state
        command = (torque_nm - push_nm) / self._unit_nm
        if body.lag > 0.0:
            state[-1] -= (push_nm - self._push) / self._unit_nm
            self._push = push_nm
        if body.order > 2:
            if periods == 1.0 and body.friction == 0.0:
                advance_hold(state, command, SECOND, body, self._pad)
                return
            self._moves += 1
            if self._moves == (1 if KnobMotion._is_compiled else PATIENCE):
                self._compile()
                body, state = self._body, self._state
        elif periods == 1.0:
            if body.friction > 0.0:
                state[0], state[1] = step_with_friction(
                    state[0], state[1], command, 1.0, body.s2, body.g2, body.f2, body
                )
            else:
                x, v = state[0], state[1]
                y = command - body.beta * x
                state[0], state[1] = x + (body.s2 * v + body.g2 * y), body.f2 * v + body.s2 * y
            return
        while periods > 0.0:
            self._advance_span(state, command, min(periods, 1.0), body, self._pad)
            periods -= 1.0

    def _compile(self) -> None:
        """Go on with compiled code, which is the same to the last bit."""
        import numpy as np

        from hknob_cli.engine.general.search import as_arrays
        from hknob_cli.engine.jit import compiled

        self._advance_span, self._body = compiled("general")["general.advance_span"], as_arrays(self._body)
        self._state, self._pad = np.array(self._state), np.array(self._pad)
        KnobMotion._is_compiled = True
