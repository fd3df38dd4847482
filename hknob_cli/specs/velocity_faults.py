"""What of a controller's numbers does not go with where its velocity is from."""

from hknob_cli.specs.controller import Controller
from hknob_cli.specs.part import Place
from hknob_cli.specs.plan import RATE, Axes

DIFFERENCED = ("differenced", "sensor")  # what every kind with a velocity has
# Numbers of velocity_damping, the velocities that they are of, and what these are called in a fault.
OF = {
    "window": (("differenced", "adaptive"), "the differenced velocity"),
    "low_pass": (("differenced", "timed", "adaptive"), "the differenced velocity"),
    "time_out": (("timed",), "velocity: timed"),
    "detections": (("timed",), "velocity: timed"),
    "bandwidth": (("tracking",), "velocity: tracking"),
    "acceleration": (("kalman",), "velocity: kalman"),
}


def velocity_contradictions(spec: Controller, given: frozenset[str], axes: Axes) -> list[tuple[Place, str]]:
    """Faults of a controller with a velocity: their places in the spec, and what is wrong; ``given``: its keys."""
    where = f"where velocity is {spec.velocity}"
    if spec.kind != "velocity_damping":
        if spec.velocity in DIFFERENCED:
            return []
        return [(("scene", "controller", "velocity"), f"must be differenced or sensor where kind is {spec.kind}")]
    found: list[tuple[Place, str]] = []

    def values(key: str) -> list[float]:
        return list(axes.get(f"controller.{key}", [getattr(spec, key)]))

    def place(key: str) -> Place:
        return ("grid", f"controller.{key}") if f"controller.{key}" in axes else ("scene", "controller", key)

    for key, (velocities, name) in OF.items():
        there = key in given or f"controller.{key}" in axes
        if there and spec.velocity not in velocities:
            found.append((place(key), f"must be absent {where}: it is of {name}"))
    if spec.velocity == "adaptive" and min(values("window")) < 2:
        at = place("window") if "window" in given or "controller.window" in axes else ("scene", "controller")
        found.append((at, f"must have a window of 2 samples or more {where}: one has one line only"))
    if spec.velocity == "kalman" and "acceleration" not in given and "controller.acceleration" not in axes:
        found.append((("scene", "controller"), f"must have an acceleration {where}"))
    if spec.velocity == "tracking":
        if "bandwidth" not in given and "controller.bandwidth" not in axes:
            found.append((("scene", "controller"), f"must have a bandwidth {where}"))
        elif RATE in axes and not 2.0 * max(values("bandwidth")) < min(axes[RATE]):
            slowest = min(axes[RATE])
            found.append(
                (
                    place("bandwidth"),
                    f"must be < {slowest / 2.0:g} rad/s at {slowest:g} Hz, got {max(values('bandwidth')):g}: "
                    "the filter is stable where it is less than half the sample rate",
                )
            )
    if spec.angle == "filtered" and spec.velocity not in ("tracking", "kalman") and max(values("low_pass")) == 0.0:
        message = "must be counted where nothing filters: give a low_pass, or velocity: tracking or kalman"
        found.append((("scene", "controller", "angle"), message))
    return found
