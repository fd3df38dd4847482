"""Bodies for the unit tests, from scenes in the units of a person."""

from typing import Any

from hknob_cli.engine.general.columns import MARKS, begin_marks
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.scene import SceneSpec


def knob(rate_hz: float = 1000.0, counts: int | None = 1024, **parts: Any) -> GeneralKnob:
    """The knob under a hand, with ``parts`` of the scene replaced."""
    scene: dict[str, Any] = {
        "knob": {"inertia": 1.9e-6, "coulomb_torque": 2.0e-4},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
        **parts,
    }
    plain = SceneSpec.model_validate(scene).plain()
    return sample_general(plain, sample_rate_hz=rate_hz, counts_per_rev=counts)


def fresh_marks() -> list[float]:
    """Marks of a period that has not begun."""
    marks = [0.0] * MARKS
    begin_marks(marks)
    return marks
