"""A simulated knob in somebody's hand, moved from sample to sample: exact, with friction, a winding and a lag.

The engine's general body does the moving, in counts of the device's own encoder and in sample periods. A push by the
person does not pass the amplifier; where that lags, its last state is the sum of both torques, and a change of the push
is added to it directly, which leaves its equation as it is: the push is constant from sample to sample.
"""

from typing import Any

from hknob_cli.engine.general.advance import advance_hold, advance_span
from hknob_cli.engine.general.body import SECOND
from hknob_cli.engine.general.slide_two import step_with_friction
from hknob_cli.hardware.port import Simulated
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.motor import Coil
from hknob_cli.specs.plan import Actuator, Hand, Knob, Scene, Wall

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
