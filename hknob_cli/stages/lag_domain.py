"""Whether the bounded lag of a scene is within its domain: whoever holds the knob, it must damp more than it drives."""

from collections.abc import Iterator
from itertools import product

from hknob_cli.report.derived_numbers import body
from hknob_cli.specs.plan import GRIP, PERSON, Scene, SweepPlan, scene_at
from hknob_cli.theory.staircase import best_keep, slowness

LAG = "bounded_lag"


def has_domain(scene: Scene) -> bool:
    """Whether the controller of a scene is one that states a domain."""
    return scene.controller is not None and scene.controller.kind == LAG


def in_domain(scene: Scene) -> bool | None:
    """Whether a scene, its hand chosen, has keep >= J/(b tau) (docs/reference/controllers.md); None without a lag."""
    if scene.controller is None or not has_domain(scene):
        return None
    return scene.controller.keep >= min(1.0, _slowness(scene))


def domain_warning(sweep: SweepPlan, who: str) -> str:
    """What to say of a sweep some of whose cells are outside the domain, by the worst of them; empty where none is."""
    if not has_domain(sweep.scene):
        return ""
    scenes = list(_differing(sweep))
    outside = [scene for scene in scenes if in_domain(scene) is False]
    if not outside:
        return ""
    worst = max(outside, key=_slowness)
    assert worst.controller
    r = _slowness(worst)
    if r < 1.0:
        advice = f"keep must be at least {r:.2g}, best {best_keep(r):.2g}"
    else:
        advice = "no keep below 1 helps with this time_constant"
    return (
        f"{who}: bounded_lag with keep {worst.controller.keep:g} is outside its domain for {len(outside)} of"
        f" {len(scenes)} hands and knobs, where it may make the buzz larger: J/(b tau) reaches {r:.2g}; {advice}"
        " (docs/reference/controllers.md)"
    )


def _differing(sweep: SweepPlan) -> Iterator[Scene]:
    """The scenes of a sweep that differ in what the domain depends on: knob, hand and controller."""
    axes = {
        name: values
        for name, values in sweep.axes.items()
        if name in (PERSON, GRIP)
        or name.startswith(("knob.", "hand.", "controller.", "gear.", "motor.", "eddy_brake."))
    }
    for values in product(*axes.values()):
        yield scene_at(sweep.scene, dict(zip(axes, values, strict=True)))


def _slowness(scene: Scene) -> float:
    assert scene.controller
    inertia, damping, _ = body(scene)
    return slowness(inertia_kg_m2=inertia, damping_nm_s_per_rad=damping, time_constant_s=scene.controller.time_constant)
