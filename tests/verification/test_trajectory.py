"""The recursion against a 60-digit model: theta at every sample of long transients.

Verified: `engine.loop` (levels, delay line, hold by hold propagation), the start of a trial and the ensemble's own
kernel, against the sampled equation of motion of the theory ("Symbols and signs"). Required: theta within
1e-12 rad over 10^4 samples in ten cells of both kinds of bias.

The bound leaves room: a step rounds x by a few units in the last place, and the plant's slowest mode forgets in 1/rate
samples, so the error stays below a few eps * |theta|max * (samples of a time constant), at most
5 * 2.2e-16 * 0.2 rad * 130 = 3e-14 rad here. A difference of one level shows as about a count, > 7e-4 rad.
"""

from typing import Any

import pytest

from hknob_cli.engine.ensemble import advance
from hknob_cli.engine.loop import Loop, drive_of, interval, level_of, push
from hknob_cli.engine.propagator import hold_coefficients
from tests import digits as mp

from .reference import Cell, build_cell
from .scenes import PHASES, RATES_HZ, START_RAD, hand_on_knob, sample

WITHIN_RAD = 1e-12  # the accuracy promised

LONG = [
    ("torque", RATES_HZ[0], 128, 0),
    ("torque", RATES_HZ[1], 8192, 63),
    ("torque", RATES_HZ[3], 1024, 17),
    ("torque", RATES_HZ[4], 512, 31),
    ("torque", RATES_HZ[6], 4096, 40),
    ("half_quantum", RATES_HZ[0], 8192, 5),
    ("half_quantum", RATES_HZ[2], 256, 63),
    ("half_quantum", RATES_HZ[3], 1024, 32),
    ("half_quantum", RATES_HZ[5], 2048, 11),
    ("half_quantum", RATES_HZ[6], 128, 0),
]

SHORT = [
    hand_on_knob(delay=0.3),
    hand_on_knob("half_quantum", delay=0.75),
    hand_on_knob(delay=1.0),
    hand_on_knob("half_quantum", delay=2.4),
    hand_on_knob(delay=7.0),
    hand_on_knob(rounding="nearest"),
    hand_on_knob("half_quantum", rounding="nearest", offset=0.3),
    hand_on_knob(rounding="ceil"),
    hand_on_knob("half_quantum", rounding="ceil", offset=0.6),
    hand_on_knob("half_quantum", offset=0.37),
    hand_on_knob(rounding="nearest", offset=0.8, delay=1.6),
]


def package_start(loop: Loop, x: float, v: float, phase: int, phases: int) -> tuple[float, float]:
    """State at the first sample of trial ``phase``, step by step as `ensemble` walks the phases."""
    free = drive_of(0.0, loop)
    s, g, f = hold_coefficients(loop.alpha, loop.beta, 0.5 / phases)
    y = free - loop.beta * x
    x, v = x + (s * v + g * y), f * v + s * y
    s, g, f = hold_coefficients(loop.alpha, loop.beta, 1.0 / phases)
    for _ in range(phase):
        y = free - loop.beta * x
        x, v = x + (s * v + g * y), f * v + s * y
    return x, v


def compare(
    scene: dict[str, Any], rate_hz: float, counts: int, phase: int, samples: int, velocity: float = 0.0
) -> None:
    """Run both recursions side by side, with the kernel's `advance` beside the package's `push` and `interval`."""
    knob = sample(scene, rate_hz, counts)
    cell: Cell = build_cell(scene, sample_rate_hz=rate_hz, counts_per_rev=counts)
    loop = knob.loop
    x, v = package_start(loop, knob.position(START_RAD), knob.speed(velocity), phase, PHASES)
    lane_x, lane_v, lane_line = [x], [v], [0.0] * knob.delay_line
    ring, head, lane_head = [0.0] * knob.delay_line, 0, 0
    seen = set()
    start = cell.start((mp.mpf(START_RAD), mp.mpf(velocity)), phase, PHASES)
    for i, ((theta, _), level) in enumerate(cell.run(start, samples)):
        error = float(abs(knob.angle_rad(x) - theta))
        assert error <= WITHIN_RAD, f"sample {i}: theta off by {error:.3g} rad, margin {float(cell.margin(theta)):.3g}"
        acted_on = level_of(x, loop.sense)
        assert acted_on == min(level, 0), f"sample {i}: level {acted_on}, expected {level}"
        assert (lane_x[0], lane_v[0]) == (x, v), f"sample {i}: the kernel's lane differs from the recursion"
        seen.add(min(level, 0))
        older, newer = push(acted_on, ring, head, loop)
        x, v = interval(x, v, older, newer, loop)
        head = (head + 1) % knob.delay_line if knob.delay_line else 0
        lane_head = advance(lane_x, lane_v, lane_line, lane_head, knob.delay_line, 1, loop)
    assert len(seen) > 1, "the trial never changed level: nothing was tested"


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("bias", "rate_hz", "counts", "phase"), LONG)
def test_theta_over_10000_samples(bias: str, rate_hz: float, counts: int, phase: int) -> None:
    """Ten cells of the grid, five for each reading of the bias, stiffness 0.04."""
    compare(hand_on_knob(bias), rate_hz, counts, phase, 10_000)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("counts", [256, 4096])
@pytest.mark.parametrize(
    "scene", SHORT, ids=lambda s: f"{'{rounding}-{offset_counts}'.format(**s['encoder'])}-{s['actuator']}"
)
def test_theta_with_delay_and_other_encoders(scene: dict[str, Any], counts: int) -> None:
    """Delays in fractions of a sample and of several, and encoders that round and sit otherwise; a moving start."""
    compare(scene, RATES_HZ[3], counts, 21, 2_000, velocity=-1.5)
