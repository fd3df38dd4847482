"""Controllers for the tests of targets: every law that one can run, as a spec gives it."""

import random
from collections.abc import Iterator

from hknob_cli.hardware.control import control_of
from hknob_cli.hardware.port import Settings
from hknob_cli.specs.campaign import Model
from hknob_cli.specs.controller import Controller
from tests.hardware.trials import settings

DAMPED = {"kind": "velocity_damping", "damping": 2e-5}
# Those that read the encoder within an interval.
READING = {
    "hold that reads": Controller("first_order_hold", detections=4),
    "hold that reads, in steps": Controller("first_order_hold", correct=False, detections=5, steps=3),
    "impulse that reads": Controller("impulse_damping", detections=20),
    "long impulse that reads most often": Controller("impulse_damping", pulse=0.5, detections=64),
    "timed within the interval": Controller(**DAMPED, velocity="timed", detections=8, time_out=0.02),
    "timed within it, filtered": Controller(**DAMPED, velocity="timed", detections=3, low_pass=1e-3, angle="filtered"),
}
CONTROLLERS = {
    "lag": Controller("bounded_lag", keep=0.15, time_constant=0.1),
    "hold": Controller("first_order_hold"),
    "hold without correction": Controller("first_order_hold", correct=False),
    "passivity": Controller("passivity", damping=1e-4),
    "passivity for ever": Controller("passivity", damping=1e-4, reset=False),
    "phase": Controller("phase_damping"),
    "phase by halves": Controller("phase_damping", crossings="both", degrees=90.0, height=2.0),
    "phase by Kalman": Controller("phase_damping", crossings="both", estimate="kalman"),
    "stiffening": Controller("stiffening", surface=0.3, depth=0.02),
    "damping": Controller(**DAMPED),
    "damping everywhere": Controller(**DAMPED, everywhere=True),
    "damping over a window": Controller(**DAMPED, window=7),
    "the longest window": Controller(**DAMPED, window=64, low_pass=2e-3),
    "damping through a low-pass": Controller(**DAMPED, low_pass=2e-3),
    "damping cut off": Controller(**DAMPED, low_pass=1e-3, cut_off=5.0),
    "spring at the filtered angle": Controller(**DAMPED, low_pass=2e-3, angle="filtered"),
    "timed": Controller(**DAMPED, velocity="timed", time_out=0.02),
    "timed through a low-pass": Controller(**DAMPED, velocity="timed", low_pass=1e-3, angle="filtered"),
    "adaptive": Controller(**DAMPED, velocity="adaptive", window=8),
    "the longest line": Controller(**DAMPED, velocity="adaptive", window=64, low_pass=1e-3, angle="filtered"),
    "tracking": Controller(**DAMPED, velocity="tracking", bandwidth=200.0),
    "tracking, filtered": Controller(**DAMPED, velocity="tracking", bandwidth=200.0, angle="filtered", cut_off=50.0),
    "Kalman's speed": Controller(**DAMPED, velocity="kalman", acceleration=300.0),
    "impulse as long as an interval": Controller("impulse_damping", pulse=1.0),
    "impulse": Controller("impulse_damping", gain=0.8),
    "long impulse": Controller("impulse_damping", pulse=0.5),
    "hold in steps": Controller("first_order_hold", steps=3),
    "hold in many steps without correction": Controller("first_order_hold", steps=64, correct=False),
    "half sample": Controller("half_sample"),
    "matched wall": Controller("matched_wall"),
    **READING,
}
MODEL = Model(2.2e-6, 3.45e-4, 0.04)  # knob and hand of `trials.HAND`


def told(name: str, rate: float = 1000, counts: int = 1024, **changes: float) -> Settings:
    """Settings of a trial under one of `CONTROLLERS`."""
    plain = settings(rate, counts, **changes)
    return plain._replace(control=control_of(CONTROLLERS[name], plain, MODEL))


def within(rng: random.Random, before: int, count: int, looks: int) -> list[int]:
    """Counts that an encoder may show within the interval between two samples, and now and then others."""
    least, most = sorted((before, count))
    return [rng.randrange(least - 1, most + 2) for _ in range(looks)]


def readings(seed: int, count: int) -> Iterator[int]:
    """Counts as an encoder may show them: still, buzzing about an edge, sliding in and out of the wall, and jumping."""
    rng = random.Random(seed)
    at = 0
    while count > 0:
        how, least = rng.choice(["still", "buzz", "slide", "jump"]), rng.randrange(1, 60)
        pace = rng.choice([-3, -2, -1, 1, 2, 3])
        for i in range(min(least, count)):
            if how == "jump":
                at = rng.randrange(-200, 50)
            elif how == "slide":
                at += pace if rng.random() < 0.5 else 0
            elif how == "buzz":
                at += rng.choice([-1, 0, 1]) if i % 3 else 0
            yield at
        count -= least
        at = max(-300, min(100, at))
