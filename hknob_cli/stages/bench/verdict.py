"""What a run is worth: its error against the reference, and the verdict.

- accurate: no sample's angle is off by more than ``accurate`` (1e-6) of the reference's swing;
- inaccurate: it is, but the motion ends on the same attractor: in the last third of the trial peak to peak, and the
  highest and the lowest angle, are within ``same_attractor`` (1 %) of the swing of the reference's, and the encoder
  shows the same counts, where a count is not below that;
- wrong attractor: it ends in another cycle, at rest instead of in a cycle, or flies off;
- failed: an exception, an angle that is not a number, a scene that the method cannot express;
- too slow: stopped at the time limit;
- no reference: the run is good, but the scene's reference has failed or takes too long.

The swing is the reference's peak to peak in the last third, or, where that is below a thousandth of what it is over the
whole trial, as at rest, the latter.
"""

from math import inf
from typing import NamedTuple

from hknob_cli.baselines.controller import Controller
from hknob_cli.specs.plan import BenchScene

REST = 1e-3

Angles = list[float]


class Measure(NamedTuple):
    """Lowest and highest angle and swing (rad), and the counts that the encoder shows, of a trial's last third."""

    low_rad: float
    high_rad: float
    swing_rad: float
    counts: frozenset[int]

    @property
    def p2p_rad(self) -> float:
        """Peak to peak."""
        return self.high_rad - self.low_rad


class Judged(NamedTuple):
    """Errors of a run, and the verdict; relative errors are to the reference's swing."""

    verdict: str
    error_rad: float
    relative_error: float
    p2p_rad: float
    p2p_relative_error: float


def measure(trial: BenchScene, angles: Angles) -> Measure:
    """Measure the last third of a trial, from angles (rad) at its samples."""
    last = angles[2 * len(angles) // 3 :]
    p2p = max(last) - min(last)
    whole = max(angles) - min(angles)
    controller = Controller(trial)
    counts = frozenset(controller.level(angle) for angle in last) if controller.rounding else frozenset[int]()
    return Measure(min(last), max(last), p2p if p2p > REST * whole else whole, counts)


def judge(trial: BenchScene, angles: Angles, reference: Angles, *, accurate: float, same_attractor: float) -> Judged:
    """Compare finite angles (rad) at all samples with those of the reference."""
    ours, theirs = measure(trial, angles), measure(trial, reference)
    error = max(abs(a - b) for a, b in zip(angles, reference, strict=True))
    relative = _over(error, theirs.swing_rad)
    off = _over(abs(ours.p2p_rad - theirs.p2p_rad), theirs.swing_rad)
    near = same_attractor * theirs.swing_rad
    ends = max(abs(ours.low_rad - theirs.low_rad), abs(ours.high_rad - theirs.high_rad))
    fine = Controller(trial).quantum < near
    if relative <= accurate:
        verdict = "accurate"
    elif off <= same_attractor and ends <= near and (fine or ours.counts == theirs.counts):
        verdict = "inaccurate"
    else:
        verdict = "wrong attractor"
    return Judged(verdict, error, relative, ours.p2p_rad, off)


def _over(value: float, scale: float) -> float:
    if value == 0.0:
        return 0.0
    return value / scale if scale > 0.0 else inf
