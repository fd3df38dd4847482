"""MuJoCo: the knob a hinge with damping, stiffness and friction loss, moved by a motor; the finger a second hinge.

The fingerpad is a tendon between the two hinges; the actuator's lag is the motor's own filter. Where a hold is split by
a fractional delay, the time step is made to fit each part. MuJoCo's friction is a soft constraint, not Coulomb's law;
``stiff`` makes it as hard as MuJoCo lets it be at the time step, instead of its defaults.
"""

from math import ceil
from typing import Any

from hknob_cli.baselines.model import Controller, LostError, bias_torque
from hknob_cli.specs.plan import Actuator, BenchScene, Hand

INTEGRATORS = {"mujoco_euler": "Euler", "mujoco_implicitfast": "implicitfast", "mujoco_rk4": "RK4"}

_MODEL = """<mujoco>
<option timestep="{step!r}" integrator="{integrator}">
  <flag gravity="disable" contact="disable" {flags}/>
</option>
<worldbody>{bodies}</worldbody>
{tendon}
<actuator>{motor}</actuator>
</mujoco>"""
_BODY = """<body><inertial pos="0 0 0" mass="1e-3" diaginertia="{j!r} {j!r} {j!r}"/>
<joint name="{name}" type="hinge" axis="0 0 1" damping="{b!r}" stiffness="{k!r}"
 frictionloss="{friction!r}"{solver}/></body>"""
_STIFF = ' solimpfriction="0.9999 0.9999 0.001 0.5 2" solreffriction="0.00001 1"'  # the time: at least two steps
_PAD = """<tendon><fixed springlength="0" damping="{b!r}" stiffness="{k!r}">
<joint joint="knob" coef="1"/><joint joint="finger" coef="-1"/></fixed></tendon>"""
_LAG = '<general joint="knob" dyntype="filterexact" dynprm="{lag!r}" gainprm="1"/>'


def available() -> bool:
    """Whether MuJoCo is installed."""
    from importlib.util import find_spec

    return find_spec("mujoco") is not None


class MujocoHinge:
    """See `run.Integrator`; the state is MuJoCo's own, of which the angle is handed back."""

    def __init__(self, trial: BenchScene, controller: Controller, *, method: str, substeps: int, stiff: bool) -> None:
        """Make ready. Raises `LostError` where MuJoCo does not take the model."""
        import mujoco

        # Else it writes its warnings into a file in the working directory.
        mujoco.set_mju_user_warning(lambda _text: None)
        self.mujoco, self.controller, self.substeps = mujoco, controller, substeps
        scene = trial.scene
        hand, actuator = scene.hand or Hand(), scene.actuator or Actuator()
        self.lag = actuator.time_constant > 0.0
        # The bias is a force applied beside the motor, which the lag must not touch.
        self.bias = bias_torque(scene, controller.quantum)
        bodies = _BODY.format(
            name="knob",
            j=scene.knob.inertia + hand.inertia,
            b=scene.knob.damping + hand.damping,
            k=hand.stiffness,
            friction=scene.knob.coulomb_torque,
            solver=_STIFF if stiff else "",
        )
        tendon = ""
        if hand.finger and hand.fingerpad:
            finger, pad = hand.finger, hand.fingerpad
            bodies += _BODY.format(
                name="finger", j=finger.inertia, b=finger.damping, k=finger.stiffness, friction=0.0, solver=""
            )
            tendon = _PAD.format(b=pad.damping, k=pad.stiffness)
        text = _MODEL.format(
            step=float(controller.period / substeps),
            integrator=INTEGRATORS[method],
            flags="" if scene.knob.coulomb_torque else 'constraint="disable"',
            bodies=bodies,
            tendon=tendon,
            motor=_LAG.format(lag=actuator.time_constant) if self.lag else '<motor joint="knob"/>',
        )
        try:
            self.model = mujoco.MjModel.from_xml_string(text)
        except ValueError as error:
            raise LostError(f"MuJoCo does not take the model: {str(error).splitlines()[0]}") from None
        self.data = mujoco.MjData(self.model)
        self.steps = 0

    def start(self, trial: BenchScene) -> Any:
        """State at the start: the finger moves with the knob, no torque acts."""
        self.data.qpos[:], self.data.qvel[:] = trial.angle, trial.velocity
        self.data.qfrc_applied[0] = -self.bias
        return self.data.qpos

    def hold(self, state: Any, command: float, duration: float) -> Any:
        """State after a constant command."""
        count = max(1, ceil(self.substeps * duration / self.controller.period - 1e-9))
        self._step(command, duration / count, count)
        return state

    def free(self, state: Any, duration: float) -> Any:
        """State after a time under a controller that acts at every step."""
        count = max(1, ceil(self.substeps * duration / self.controller.period - 1e-9))
        for _ in range(count):
            self._step(self.controller.command(self.controller.measured(state[0])), duration / count, 1)
        return state

    def _step(self, command: float, step: float, count: int) -> None:
        self.model.opt.timestep = step
        self.data.ctrl[0] = command
        self.mujoco.mj_step(self.model, self.data, count)
        self.steps += count
        if any(self.data.warning.number):
            raise LostError("MuJoCo warns of an unstable simulation")
