"""Every controller by the name that a spec gives it."""

from hknob_cli.controllers.controller import Remedy
from hknob_cli.specs.controller_plan import Controller


def make_remedy(plan: Controller) -> Remedy:
    """The controller of a scene; only its own file is loaded."""
    sensor = plan.velocity == "sensor"
    if plan.kind == "first_order_hold":
        from hknob_cli.controllers.first_order_hold import FirstOrderHold

        return FirstOrderHold(correct=plan.correct)
    if plan.kind == "half_sample":
        from hknob_cli.controllers.half_sample import HalfSample

        return HalfSample(sensor=sensor)
    if plan.kind == "matched_wall":
        from hknob_cli.controllers.matched_wall import MatchedWall

        return MatchedWall(sensor=sensor)
    if plan.kind == "velocity_damping":
        from hknob_cli.controllers.velocity_damping import VelocityDamping

        return VelocityDamping(plan.damping, sensor=sensor, everywhere=plan.everywhere)
    if plan.kind == "impulse_damping":
        from hknob_cli.controllers.impulse_damping import ImpulseDamping

        return ImpulseDamping(plan.pulse, plan.gain, plan.detections)
    if plan.kind == "phase_damping":
        from hknob_cli.controllers.phase_damping import PhaseDamping

        return PhaseDamping(plan.height, plan.degrees, both=plan.crossings == "both", kalman=plan.estimate == "kalman")
    if plan.kind == "passivity":
        from hknob_cli.controllers.passivity_control import PassivityControl

        return PassivityControl(plan.damping, reset=plan.reset)
    if plan.kind == "stiffening":
        from hknob_cli.controllers.stiffening_wall import StiffeningWall

        return StiffeningWall(plan.surface, plan.depth)
    from hknob_cli.controllers.bounded_lag import BoundedLag

    return BoundedLag(plan.keep, plan.time_constant)
