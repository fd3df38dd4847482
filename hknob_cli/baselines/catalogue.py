"""The methods by name, the settings that each is tried with, and one run of one of them."""

from typing import NamedTuple

from hknob_cli.baselines.fixed_step import METHODS as FIXED
from hknob_cli.baselines.fixed_step import FixedStep
from hknob_cli.baselines.model import Controller, Deadline, Motion, follow
from hknob_cli.baselines.mujoco_hinge import INTEGRATORS as MUJOCO
from hknob_cli.baselines.mujoco_hinge import MujocoHinge
from hknob_cli.baselines.scipy_methods import CLASSES as SCIPY
from hknob_cli.baselines.scipy_methods import ScipyIntegrator
from hknob_cli.specs.plan import BenchPlan, BenchScene


class Setting(NamedTuple):
    """How a method is run.

    ``tolerance``: relative, None for the method's default; ``substeps``: steps a sample; ``smoothing``: rad/s, None for
    friction that sticks. ``friction`` says how it is treated: none, stick, smoothed, soft or stiff (a constraint).
    """

    label: str
    friction: str = "none"
    tolerance: float | None = None
    substeps: int | None = None
    smoothing: float | None = None


def settings(plan: BenchPlan, trial: BenchScene, method: str) -> list[Setting]:
    """Settings of a rival in a scene, the coarsest first."""
    rubs = trial.scene.knob.coulomb_torque > 0.0
    if method in SCIPY:
        found = []
        for smoothing in (None, plan.smoothing) if rubs else (None,):
            friction = "none" if not rubs else "smoothed" if smoothing else "stick"
            mark = ", smoothed" if smoothing else ""
            found.append(Setting(f"default{mark}", friction, smoothing=smoothing))
            found += [Setting(f"{rtol:g}{mark}", friction, rtol, smoothing=smoothing) for rtol in plan.tolerances]
        return found
    kinds = ("none",) if not rubs else ("soft", "stiff") if method in MUJOCO else ("stick",)
    return [
        Setting(f"{n} a sample{', stiff friction' if kind == 'stiff' else ''}", kind, substeps=n)
        for kind in kinds
        for n in plan.substeps
    ]


def run_rival(trial: BenchScene, method: str, setting: Setting, deadline: Deadline) -> Motion:
    """One run, set-up included. Raises what `run.follow` raises."""
    if method in FIXED:
        assert setting.substeps is not None
        return FixedStep(trial, method=method, substeps=setting.substeps).run(deadline)
    controller = Controller(trial)
    if method in SCIPY:
        integrator = ScipyIntegrator(
            trial,
            controller,
            method=method,
            tolerance=setting.tolerance,
            smoothing=setting.smoothing,
            deadline=deadline,
        )
        return follow(trial, controller, integrator, integrator.start(trial), deadline)
    assert setting.substeps is not None
    hinge = MujocoHinge(trial, controller, method=method, substeps=setting.substeps, stiff=setting.friction == "stiff")
    return follow(trial, controller, hinge, hinge.start(trial), deadline)
