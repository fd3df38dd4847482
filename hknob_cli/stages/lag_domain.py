"""Whether the bounded lag of a scene stays within its domain: whoever holds the knob, it must damp and not drive."""

from collections.abc import Iterable

from hknob_cli.spec.plan import Hand, Scene
from hknob_cli.theory.bounded_lag import least_keep

LAG = "bounded_lag"


def has_domain(scene: Scene) -> bool:
    """Whether the controller of a scene is one that states a domain."""
    return scene.controller is not None and scene.controller.kind == LAG


def in_domain(scene: Scene) -> bool | None:
    """Whether a scene, its hand chosen, keeps at least what `least_keep` asks for; None without such a controller."""
    if scene.controller is None or not has_domain(scene):
        return None
    return scene.controller.keep >= _least(scene)


def domain_warning(scenes: Iterable[Scene], where: str) -> str:
    """What to say of the worst of some scenes that are outside the domain; ``where`` they are. Empty where none is."""
    outside = [scene for scene in scenes if in_domain(scene) is False]
    if not outside:
        return ""
    worst = max(outside, key=_least)
    assert worst.controller
    return (
        f"{where}: outside the domain of bounded_lag, keep {worst.controller.keep:g} is below"
        f" J/(J + b tau) = {_least(worst):.2g}: below one count the lag drives, and may make the buzz larger"
    )


def _least(scene: Scene) -> float:
    hand = scene.hand or Hand()
    assert scene.controller
    return least_keep(
        inertia_kg_m2=scene.knob.inertia + hand.inertia,
        damping_nm_s_per_rad=scene.knob.damping + hand.damping,
        time_constant_s=scene.controller.time_constant,
    )
