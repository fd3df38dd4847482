"""The methods of the benchmark by name, each with its settings, and one run of one in a scene, timed."""

import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from typing import NamedTuple

import numpy as np

from hknob_cli.baselines import digits60
from hknob_cli.baselines.fixed_step import METHODS as FIXED
from hknob_cli.baselines.fixed_step import FixedStep
from hknob_cli.baselines.model import PHASE, Controller, Deadline, LostError, Motion, TooSlowError, follow
from hknob_cli.baselines.programs import CLASSES as SCIPY
from hknob_cli.baselines.programs import INTEGRATORS as MUJOCO
from hknob_cli.baselines.programs import MujocoHinge, ScipyIntegrator
from hknob_cli.engine.jit import compiled as compiled_functions
from hknob_cli.errors import ComputationError, HknobError
from hknob_cli.measure.unsampled import events
from hknob_cli.scene.general_knob import follow_knob, sample_general
from hknob_cli.scene.plain_knob import reduce_unsampled
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


QUICK_S = 0.03  # runs are repeated while they take no longer together
MOST_REPEATS = 7
PATIENCE, LEAST_PATIENCE_S = 20.0, 1.0  # how many times longer than a run a reference may take, and at least
COMPILED = "compiled"
_WARM_SAMPLES = 4


class Run(NamedTuple):
    """What came of a run: angles (rad) at the samples, None with a ``reason`` where there are none.

    ``seconds``: processor time, the best of ``repeats``.
    """

    angles: list[float] | None
    reason: str
    too_slow: bool
    seconds: float
    repeats: int
    steps: int | None
    evaluations: int | None


class Reference(NamedTuple):
    """Angles (rad) at the samples that errors are against; None where there are none, and ``missing`` says why."""

    angles: list[float] | None
    missing: str = ""


def exact_settings(trial: BenchScene) -> list[Setting]:
    """How the exact engine is run: the same source both ways."""
    friction = "stick" if trial.scene.knob.coulomb_torque > 0.0 else "none"
    return [Setting("interpreted", friction), Setting(COMPILED, friction)]


def timed_run(trial: BenchScene, method: str, setting: Setting, *, limit_s: float) -> Run:
    """Run a method, again while it is quick; set-up included, compilation and imports not."""
    _warm(trial, method, setting, limit_s=limit_s)
    best, total, repeats = float("inf"), 0.0, 0
    motion: Motion | None = None
    reason, too_slow = "", False
    while repeats == 0 or (total < QUICK_S and repeats < MOST_REPEATS and motion):
        deadline = Deadline(limit_s)
        begin = time.process_time()
        try:
            with _unwarned(method):
                motion = _once(trial, method, setting, deadline)
        except TooSlowError:
            too_slow, motion = True, None
        except (LostError, HknobError, ArithmeticError, ValueError, RuntimeError, np.linalg.LinAlgError) as error:
            reason, motion = (str(error) or type(error).__name__).splitlines()[0], None
        seconds = time.process_time() - begin
        best, total, repeats = min(best, seconds), total + seconds, repeats + 1
    angles = [float(angle) for angle in motion.angles] if motion else None
    if angles and not all(abs(angle) < float("inf") for angle in angles):
        angles, reason = None, "the angle is no longer a number"
    if best > limit_s:
        angles, too_slow = None, True
    return Run(
        angles=None if too_slow else angles,
        reason=reason,
        too_slow=too_slow,
        seconds=best,
        repeats=repeats,
        steps=motion.steps if motion else None,
        evaluations=motion.evaluations if motion else None,
    )


def reference(trial: BenchScene, *, limit_s: float) -> Reference:
    """The scene's reference, in `PATIENCE` times ``limit_s``. Raises `UsageError` if it needs what is not installed."""
    patience = max(PATIENCE * limit_s, LEAST_PATIENCE_S)
    try:
        angles = _reference_motion(trial, patience).angles
    except TooSlowError:
        return Reference(None, f"{trial.reference} takes longer than {patience:g} s")
    except (LostError, ComputationError) as error:
        return Reference(None, f"{trial.reference} cannot follow it: {error}")
    return Reference([float(angle) for angle in angles])


def _reference_motion(trial: BenchScene, patience: float) -> Motion:
    if trial.reference == "exact":
        _warm(trial, "exact", Setting(COMPILED), limit_s=patience)
        return _exact(trial, Deadline(patience), compiled=True)
    mp = digits60.context()
    deadline = Deadline(patience)
    model = digits60.Digits60(trial, mp, deadline)
    return follow(trial, model.controller, model, model.start(trial), deadline)


def _once(trial: BenchScene, method: str, setting: Setting, deadline: Deadline) -> Motion:
    if method == "exact":
        return _exact(trial, deadline, compiled=setting.label == COMPILED)
    return run_rival(trial, method, setting, deadline)


def _exact(trial: BenchScene, deadline: Deadline, *, compiled: bool) -> Motion:
    if not trial.scene.sampled:
        return _exact_unsampled(trial, deadline, compiled=compiled)
    found = follow_knob(
        sample_general(trial.scene, sample_rate_hz=trial.sample_rate_hz, counts_per_rev=trial.counts_per_rev),
        angle_rad=trial.angle,
        velocity_rad_s=trial.velocity,
        phase=PHASE,
        samples=trial.samples,
        compiled=compiled,
        look=deadline.look,
    )
    return Motion(found.angle_rad.tolist(), trial.samples, None)


def _exact_unsampled(trial: BenchScene, deadline: Deadline, *, compiled: bool) -> Motion:
    """The knob without a sample clock, at the times at which a sampled one would be read."""
    times = (PHASE + np.arange(trial.samples + 1, dtype=np.float64)) / trial.sample_rate_hz
    motion = events(
        reduce_unsampled(trial.scene, counts_per_rev=trial.counts_per_rev),
        angle_rad=trial.angle,
        velocity_rad_s=trial.velocity,
        duration_s=float(times[-1]) * (1.0 + 1e-9),
        functions=compiled_functions("unsampled") if compiled else None,
        look=deadline.look,
    )
    return Motion(motion.at(times)[0].tolist(), len(motion.time_s), None)


@contextmanager
def _unwarned(method: str) -> Iterator[None]:
    """Without the warnings of a rival on its way out of bounds: the verdict says so. The engine has none to hide."""
    if method == "exact":
        yield
        return
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _warm(trial: BenchScene, method: str, setting: Setting, *, limit_s: float) -> None:
    """Load and compile what the run needs, which its time does not count."""
    if method in FIXED or method in MUJOCO or method == "exact":
        short = trial._replace(samples=min(trial.samples, _WARM_SAMPLES))
        few = setting if setting.substeps is None else setting._replace(substeps=1)
        try:
            with _unwarned(method):
                _once(short, method, few, Deadline(limit_s if method == "exact" else inf))
        except (LostError, TooSlowError, HknobError, ArithmeticError, ValueError):
            return  # the run itself will say so
    else:
        import scipy.integrate
        import scipy.optimize

        del scipy
        Controller(trial)
