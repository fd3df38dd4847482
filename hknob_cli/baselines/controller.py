"""The controller: what the encoder reports, what the wall commands, and when the command acts.

    measured m = (round(angle / q - offset) + offset) q
    command  u = -K m - B (m - m at the sample before) / T  if m < 0, else 0

then rounded to the nearest multiple of the torque step, clamped to the torque limit, and delayed. Source: Hasser,
sections 6.3-6.4; damping by backward difference, Colgate & Schenkel (1994).
"""

from collections.abc import Callable
from math import floor, pi
from typing import Any

from hknob_cli.baselines.plant import Number
from hknob_cli.specs.plan import Actuator, BenchScene

Piece = tuple[Any, Any]  # command (N·m), and for how long it acts (s)


class Controller:
    """Encoder, virtual wall and actuator of a trial, one sample after the other."""

    def __init__(
        self, trial: BenchScene, number: Number = float, down: Callable[[Any], Any] = floor, turn: Any = 2.0 * pi
    ) -> None:
        """Start at rest: no torque; ``number`` makes numbers, ``down`` rounds them, ``turn`` is 2 pi in them."""
        scene = trial.scene
        actuator = scene.actuator or Actuator()
        self.number, self.down = number, down
        self.period = 1 / number(trial.sample_rate_hz)
        self.quantum = turn / trial.counts_per_rev if scene.encoder and trial.counts_per_rev else number(0.0)
        self.rounding = scene.encoder.rounding if scene.encoder else ""
        self.offset = number(scene.encoder.offset_counts) if scene.encoder else number(0.0)
        self.stiffness, self.damping = number(scene.wall.stiffness), number(scene.wall.damping)
        self.limit = None if actuator.torque_limit is None else number(actuator.torque_limit)
        self.step = number(actuator.torque_step)
        whole = int(actuator.delay_samples)
        part = number(actuator.delay_samples) - whole
        self.early = part * self.period  # time for which an interval still runs under the older command
        self.under_way: list[Any] = [number(0.0)] * (whole + (1 if part else 0))
        self.before: Any = None

    def level(self, angle: Any) -> int:
        """Count that the encoder shows; of a continuous sensor -1 inside the wall, and 0 outside."""
        if not self.rounding:
            return -1 if angle < 0 else 0
        x = angle / self.quantum - self.offset
        if self.rounding == "nearest":
            return int(self.down(x + self.number(0.5)))
        if self.rounding == "ceil" or (self.rounding == "truncate" and x < 0):
            return -int(self.down(-x))
        return int(self.down(x))

    def reported(self, level: int) -> Any:
        """Angle that a count stands for, rad."""
        return (level + self.offset) * self.quantum

    def measured(self, angle: Any) -> Any:
        """Angle that the sensor reports, rad."""
        return self.reported(self.level(angle)) if self.rounding else angle

    def edges(self, level: int) -> tuple[Any, Any]:
        """Angles between which the encoder shows ``level``, rad."""
        low, high = self.number(0.0), self.number(1.0)
        if self.rounding == "nearest":
            low, high = self.number(-0.5), self.number(0.5)
        elif self.rounding == "ceil" or (self.rounding == "truncate" and level < 0):
            low, high = self.number(-1.0), self.number(0.0)
        elif self.rounding == "truncate" and level == 0:
            low = self.number(-1.0)
        return (level + low + self.offset) * self.quantum, (level + high + self.offset) * self.quantum

    def command(self, measured: Any) -> Any:
        """Torque commanded at a sample, N·m."""
        before = measured if self.before is None else self.before
        self.before = measured
        torque = self.number(0.0)
        if measured < 0:
            torque = -self.stiffness * measured - self.damping * (measured - before) / self.period
        if self.step > 0:
            torque = self.step * self.down(torque / self.step + self.number(0.5))
        if self.limit is not None:
            torque = min(max(torque, -self.limit), self.limit)
        return torque

    def without_clock(self, level: int) -> tuple[Any, tuple[Any, Any]]:
        """Command while the encoder shows ``level``, and the angles, rad, between which it does.

        With a continuous sensor nothing is commanded, which the motion has in itself, and ``level`` is -1 inside the
        wall and 0 outside.
        """
        zero = self.number(0.0)
        if self.rounding:
            return self.command(self.reported(level)), self.edges(level)
        return zero, ((None, zero) if level < 0 else (zero, None))

    def sample(self, angle: Any) -> tuple[Piece, ...]:
        """What acts from this sample to the next."""
        self.under_way.append(self.command(self.measured(angle)))
        oldest = self.under_way.pop(0)
        if not self.early:
            return ((oldest, self.period),)
        return (oldest, self.early), (self.under_way[0], self.period - self.early)


def leaves(low: Any, high: Any) -> list[tuple[Callable[[Any], Any], int]]:
    """The events of the angle leaving its bounds, None where it has none, and the way it goes.

    An event is a function of the state that is positive until it happens.
    """
    events: list[tuple[Callable[[Any], Any], int]] = []
    if low is not None:
        events.append((lambda z: z[0] - low, -1))
    if high is not None:
        events.append((lambda z: high - z[0], 1))
    return events
