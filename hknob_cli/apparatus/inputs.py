"""Inputs other than a pulse: step, ramp, sinusoid, chirp, noise, pseudorandom binary sequence (Hasser, sec. 2.1).

Each is a torque that is held from sample to sample, as high as moves the mean hand of a grip by 0.09 rad at the most.
A virtual hand has neither reflexes nor will, which the text names as the price of long inputs.
"""

from functools import cache

import numpy as np

from hknob_cli.apparatus.hand import SecondOrder
from hknob_cli.apparatus.simulated_motion import follow, mechanism
from hknob_cli.apparatus.streams import Purpose, stream
from hknob_cli.recordings.trial import Array
from hknob_cli.specs.identification import InputPlan

_NOISE = 3  # of the bench's random streams
_REGISTER = 9  # bits: 511 chips before a sequence repeats


def unit_input(one: InputPlan, interval_s: float) -> Array:
    """The input at every sample (n,), its largest value 1."""
    time: Array = interval_s * np.arange(round(one.duration_s / interval_s), dtype=np.float64)
    which = np.floor(time / one.chip_s * (1.0 + 1e-12)).astype(int)
    rate = (one.to_hz - one.from_hz) / one.duration_s
    found: Array
    if one.kind == "step":
        found = np.ones_like(time)
    elif one.kind == "ramp":
        found = (np.arange(time.size) + 1.0) / time.size
    elif one.kind == "sine":
        found = np.sin(2.0 * np.pi * one.from_hz * time)
    elif one.kind == "chirp":
        found = np.sin(2.0 * np.pi * (one.from_hz + 0.5 * rate * time) * time)
    elif one.kind == "prbs":
        found = binary_sequence(int(which[-1]) + 1)[which]
    else:
        drawn = stream(0, Purpose.BENCH, _NOISE).standard_normal(int(which[-1]) + 1)
        found = (drawn / np.max(np.abs(drawn)))[which]
    return found


def binary_sequence(length: int) -> Array:
    """A maximal-length sequence of 1 and -1, by a shift register with the polynomial x^9 + x^5 + 1."""
    register = [1] * _REGISTER
    found = np.empty(length)
    for i in range(length):
        found[i] = 2.0 * register[-1] - 1.0
        register = [register[8] ^ register[4], *register[:-1]]
    return found


@cache
def scaled_input(one: InputPlan, hand: SecondOrder, interval_s: float, peak_rad: float) -> Array:
    """The input as torque (n,), N·m, at which a hand that nothing disturbs turns by ``peak_rad`` (rad) at the most."""
    shape = unit_input(one, interval_s)
    body = mechanism(hand)
    angle = follow(body, body.rest(0.0), runs(shape), interval_s)[:, 0]
    scaled: Array = shape * (peak_rad / float(np.max(np.abs(angle))))
    return scaled


def runs(values: Array) -> list[tuple[float, int]]:
    """Values (n,) as stretches of one value, with their lengths."""
    ends = np.flatnonzero(np.diff(values)) + 1
    starts = np.concatenate(([0], ends))
    counts = np.diff(np.concatenate((starts, [len(values)])))
    return [(float(values[at]), int(count)) for at, count in zip(starts, counts, strict=True)]
