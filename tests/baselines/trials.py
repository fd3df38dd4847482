"""Trials for the tests of the rivals: a free knob at 1 kHz, and whatever a test adds."""

from typing import Any

from hknob_cli.baselines.digits60 import Digits60, context
from hknob_cli.baselines.model import Deadline, follow
from hknob_cli.specs.plan import BenchScene, Encoder, Knob, Scene, Wall
from hknob_cli.stages.bench.timed import Setting, run_rival

INERTIA, STIFFNESS, PERIOD, COUNTS = 2e-6, 0.3, 1e-3, 1000
FINE = Setting("fine", tolerance=1e-12)


def trial(*, angle: float = 0.01, velocity: float = 0.0, samples: int = 3, **parts: Any) -> BenchScene:
    """A trial of a knob without damping, hand and bias; ``parts`` replace or add parts of its scene."""
    scene = Scene(
        **{
            "knob": Knob(INERTIA),
            "wall": Wall(STIFFNESS),
            "hand": None,
            "bias": None,
            "encoder": Encoder(),
            "actuator": None,
            **parts,
        }
    )
    counts = COUNTS if scene.encoder else None
    return BenchScene("test", scene, 1.0 / PERIOD, counts, angle, velocity, samples, "digits60")


def by_digits60(case: BenchScene) -> list[Any]:
    """Angles at the samples, to 60 digits."""
    deadline = Deadline(60.0)
    model = Digits60(case, context(), deadline)
    return follow(case, model.controller, model, model.start(case), deadline).angles


def by(method: str, case: BenchScene, setting: Setting = FINE) -> list[float]:
    """Angles at the samples, by a rival."""
    return [float(angle) for angle in run_rival(case, method, setting, Deadline(60.0)).angles]
