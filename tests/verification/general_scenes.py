"""Scenes with each feature alone, in pairs and all at once, and the starts and clocks they are run with."""

from typing import Any, NamedTuple

KNOB = {"inertia": 1.98e-6, "damping": 1.1e-5}
GRASP = {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04}
TWO_PARTS = {
    "finger": {"inertia": 3.0e-7, "damping": 2.9e-3, "stiffness": 0.4},
    "fingerpad": {"damping": 3.8e-4, "stiffness": 0.05},
}
RINGING = {  # a finger that rings against the pad several times between two samples
    "finger": {"inertia": 2.0e-7, "damping": 2.0e-5, "stiffness": 9.0},
    "fingerpad": {"damping": 3.0e-5, "stiffness": 6.0},
}
HEAVY = {  # a finger that swings on while the knob sticks, and pulls it loose
    "finger": {"inertia": 5.0e-5, "damping": 2.0e-4, "stiffness": 0.05},
    "fingerpad": {"damping": 2.0e-4, "stiffness": 0.3},
}
STIFF = {  # Hasser's fourth-order model at his highest grip: K1 = 10 K2, B1 = 10 B2
    "finger": {"inertia": 3.0e-7, "damping": 1.265e-2, "stiffness": 2.53},
    "fingerpad": {"damping": 1.265e-3, "stiffness": 0.253},
}


class Case(NamedTuple):
    """A scene, its clock and encoder, and its start."""

    name: str
    scene: dict[str, Any]
    rate_hz: float = 1000.0
    counts: int | None = 1024
    angle: float = 0.02
    velocity: float = -1.5
    phase: float = 0.5
    samples: int = 300

    @property
    def arguments(self) -> dict[str, Any]:
        """What a simulator is called with, beside the scene."""
        return {
            "sample_rate_hz": self.rate_hz,
            "counts_per_rev": self.counts,
            "angle_rad": self.angle,
            "velocity_rad_s": self.velocity,
            "phase": self.phase,
            "samples": self.samples,
        }


def scene(**parts: Any) -> dict[str, Any]:
    """A scene: knob, grasp, wall and a bias of 1 mN m, with ``parts`` added or changed."""
    made: dict[str, Any] = {
        "knob": dict(KNOB),
        "hand": dict(GRASP),
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
    }
    for name, value in parts.items():
        made[name] = {**made.get(name, {}), **value} if name in ("knob", "wall", "actuator") else value
    return {name: value for name, value in made.items() if value is not None}


RUBBING = {"coulomb_torque": 5.6e-4}
LIGHT = {"coulomb_torque": 6.0e-5}
HALF = {"half_quantum": True}

ALONE = [
    Case("plain", scene()),
    Case("friction", scene(knob=RUBBING)),
    Case("light friction", scene(knob=LIGHT)),
    Case("friction without damping or hand", scene(knob={**RUBBING, "damping": 0.0}, hand=None)),
    Case("strong friction", scene(knob={"coulomb_torque": 2.5e-3}), angle=0.06),
    Case("friction, slow clock", scene(knob=LIGHT), rate_hz=100.0),
    Case("two parts", scene(hand=TWO_PARTS)),
    Case("two parts, slow clock", scene(hand=TWO_PARTS), rate_hz=100.0, counts=256),
    Case("ringing finger", scene(hand=RINGING), rate_hz=500.0),
    Case("stiff finger", scene(hand=STIFF)),
    Case("no spring at all", scene(hand=None, knob={"damping": 2.0e-4})),
    Case(
        "critical damping",
        scene(knob={"inertia": 1.0 / 2**19, "damping": 0.0}, hand={"stiffness": 2.0**-5, "damping": 2.0**-11}),
    ),
    Case("lag", scene(actuator={"time_constant": 3.0e-4})),
    Case("lag of many samples", scene(actuator={"time_constant": 1.1e-2})),
    Case("lag of a small part", scene(actuator={"time_constant": 2.0e-6})),
    Case("delay", scene(actuator={"delay_samples": 0.37})),
    Case("delay of whole samples", scene(actuator={"delay_samples": 2.0})),
    Case("delay of several", scene(actuator={"delay_samples": 3.6})),
    Case("limit", scene(actuator={"torque_limit": 0.0021})),
    Case("torque step", scene(actuator={"torque_step": 2.3e-4})),
    Case("dead band", scene(actuator={"dead_band": 3.1e-3})),
    Case("virtual damping", scene(wall={"damping": 4.0e-5})),
    Case("nearest", scene(encoder={"rounding": "nearest"})),
    Case("ceil", scene(encoder={"rounding": "ceil"}), counts=256),
    Case("truncate", scene(encoder={"rounding": "truncate"}), counts=256),
    Case("truncate, offset", scene(encoder={"rounding": "truncate", "offset_counts": 0.4}), counts=128),
    Case("offset", scene(encoder={"rounding": "floor", "offset_counts": 0.3})),
    Case("half quantum", scene(bias=HALF)),
    Case("no bias", scene(bias=None)),
    Case("no encoder", scene(encoder="none"), rate_hz=4000.0, counts=None),
]

PAIRS = [
    Case("friction, lag", scene(knob=RUBBING, actuator={"time_constant": 3.0e-4})),
    Case("friction, slow lag", scene(knob=RUBBING, actuator={"time_constant": 8.0e-3})),
    Case("friction, delay", scene(knob=LIGHT, actuator={"delay_samples": 0.37})),
    Case("friction, two parts", scene(knob=RUBBING, hand=TWO_PARTS)),
    Case(
        "strong friction, ringing finger",
        scene(knob={"coulomb_torque": 4.0e-3}, hand=RINGING),
        rate_hz=300.0,
        angle=0.05,
        samples=100,
    ),
    Case("friction, stiff finger", scene(knob=LIGHT, hand=STIFF), samples=100),
    Case("friction, virtual damping", scene(knob=LIGHT, wall={"damping": 6.0e-5})),
    Case("friction, no encoder", scene(knob=RUBBING, encoder="none"), counts=None, rate_hz=2000.0),
    Case("friction, torque step", scene(knob=LIGHT, actuator={"torque_step": 2.3e-4})),
    Case("friction, dead band", scene(knob=LIGHT, wall={"damping": 2.0e-5}, actuator={"dead_band": 2.9e-3})),
    Case("friction, half quantum", scene(knob=LIGHT, bias=HALF)),
    Case("two parts, lag", scene(hand=TWO_PARTS, actuator={"time_constant": 5.0e-4})),
    Case("two parts, delay", scene(hand=TWO_PARTS, actuator={"delay_samples": 1.25})),
    Case("lag, delay", scene(actuator={"time_constant": 4.0e-4, "delay_samples": 0.8})),
    Case("step, limit", scene(actuator={"torque_step": 5.0e-4, "torque_limit": 0.0033})),
    Case(
        "virtual damping, truncate, offset",
        scene(wall={"damping": 5.0e-5}, encoder={"rounding": "truncate", "offset_counts": 0.25}),
    ),
    Case("virtual damping, nearest", scene(wall={"damping": 3.0e-5}, encoder={"rounding": "nearest"})),
    Case("dead band, no encoder", scene(encoder="none", actuator={"dead_band": 3.1e-3}), counts=None),
    Case("virtual damping, no encoder", scene(wall={"damping": 2.0e-5}, encoder="none"), rate_hz=4000.0, counts=None),
    Case("virtual damping, limit", scene(wall={"damping": 2.0e-4}, actuator={"torque_limit": 0.004})),
]

EVERYTHING = {
    "knob": RUBBING,
    "hand": TWO_PARTS,
    "wall": {"damping": 5.0e-5},
    "actuator": {"delay_samples": 0.6, "time_constant": 2.5e-4, "torque_limit": 0.006, "torque_step": 1.3e-4},
    "encoder": {"rounding": "nearest", "offset_counts": 0.2},
}

TOGETHER = [
    Case("all", scene(**EVERYTHING)),
    Case("all, light friction, long", scene(**{**EVERYTHING, "knob": LIGHT}), samples=1000),
    Case("all, grasp of one part", scene(**{**EVERYTHING, "hand": GRASP})),
    Case("all, half quantum, ceil", scene(**{**EVERYTHING, "bias": HALF, "encoder": {"rounding": "ceil"}}), counts=512),
    Case("all, at 4 kHz", scene(**EVERYTHING), rate_hz=4000.0, counts=4096),
    Case("all, first sample at once", scene(**EVERYTHING), phase=2.0**-40),
    Case("all, first sample after a period", scene(**EVERYTHING), phase=1.0),
]

# From rest inside the wall: what starts stuck, and what is released only when the lagging torque has grown.
STICKING = [
    Case("heavy finger pulls the knob loose", scene(knob={"coulomb_torque": 2.0e-3}, hand=HEAVY), angle=0.05),
    Case(
        "heavy finger, lag, delay",
        scene(knob={"coulomb_torque": 1.2e-3}, hand=HEAVY, actuator={"time_constant": 2.0e-3, "delay_samples": 1.7}),
        angle=0.05,
    ),
    Case(
        "heavy finger against a slow clock",
        scene(knob={"coulomb_torque": 8.0e-4}, hand=HEAVY, actuator={"time_constant": 9.0e-3}),
        rate_hz=40.0,
        angle=0.05,
        samples=60,
    ),
    Case(
        "stick and slip in the wall",
        scene(knob={"coulomb_torque": 9.0e-4}, actuator={"time_constant": 4.0e-3, "delay_samples": 1.2}),
        counts=512,
    ),
    Case("stuck for good", scene(knob={"coulomb_torque": 3.0e-2}), angle=-0.03, velocity=0.0),
    Case(
        "released by the lag",
        scene(knob={"coulomb_torque": 4.0e-3}, actuator={"time_constant": 6.0e-3}),
        angle=-0.03,
        velocity=0.0,
    ),
    Case("released by the wall", scene(knob={"coulomb_torque": 4.0e-3}), angle=-0.03, velocity=0.0),
    Case("finger lets go", scene(knob={"coulomb_torque": 1.5e-3}, hand=TWO_PARTS), angle=0.03, velocity=0.0),
]

LONG = [
    Case("plain, long", scene(), samples=2000),
    Case("friction, long", scene(knob=LIGHT), samples=1500),
    Case(
        "two parts, lag, delay, long",
        scene(hand=TWO_PARTS, actuator={"time_constant": 2.0e-4, "delay_samples": 0.4}),
        samples=2000,
    ),
]

CASES = [*ALONE, *PAIRS, *TOGETHER, *STICKING, *LONG]
