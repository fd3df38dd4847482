"""One trial of any sampled scene, sample by sample, exact."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.ensemble import begin
from hknob_cli.engine.general.interval import begin_clock, jitters, next_span
from hknob_cli.engine.general.search import as_compiled, as_list
from hknob_cli.engine.general.trace import Rows, run
from hknob_cli.engine.jit import compiled as compiled_functions
from hknob_cli.errors import ComputationError
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.plan import Scene

Array = NDArray[np.float64]


class Trial(NamedTuple):
    """State at every sample, (samples + 1,) each, and the actuator's torque on the knob just after it."""

    time_s: Array
    angle_rad: Array
    velocity_rad_s: Array
    torque_nm: Array


def simulate(
    scene: Scene,
    *,
    sample_rate_hz: float,
    counts_per_rev: int | None,
    angle_rad: float,
    velocity_rad_s: float = 0.0,
    phase: float = 0.5,
    samples: int,
    compiled: bool = False,
) -> Trial:
    """Run one trial of a scene as `follow_knob`.

    Raises `ComputationError` if the scene's numbers overflow, or if it has no sample clock.
    """
    if not scene.sampled:
        raise ComputationError("a scene without a sample clock has no samples")
    knob = sample_general(scene, sample_rate_hz=sample_rate_hz, counts_per_rev=counts_per_rev)
    return follow_knob(
        knob, angle_rad=angle_rad, velocity_rad_s=velocity_rad_s, phase=phase, samples=samples, compiled=compiled
    )


def follow_knob(
    knob: GeneralKnob,
    *,
    angle_rad: float,
    velocity_rad_s: float,
    phase: float,
    samples: int,
    compiled: bool = False,
    look: Callable[[], None] = lambda: None,
) -> Trial:
    """Run one trial exactly, for ``samples`` intervals from its first sample, ``phase`` of a period after the start.

    ``compiled``: by the compiled engine, to the same last bit. ``look`` is called whenever the trial has become twice
    as long, and may end it by raising.
    """
    functions = compiled_functions("general") if compiled else None
    order, delay = knob.body.order, knob.delay_line
    body, wall = as_compiled(knob.body, knob.wall) if compiled else (knob.body, as_list(knob.wall))

    def zeros(count: int) -> Any:
        return np.zeros(count) if compiled else [0.0] * count

    pad = zeros(2 * order)
    state, ring = zeros(order), zeros(delay)
    table, torques = np.zeros((samples + 1, order)), np.zeros(samples + 1)
    start: Any = knob.start(angle_rad, velocity_rad_s)
    first = functions["general.begin"] if functions else begin
    through = functions["general.run"] if functions else run
    first(state, np.array(start) if compiled else start, phase, body, pad)
    before, head, done = read(state[0], wall), 0, 0
    begin_clock(wall.clock, 0.0)
    while True:  # an interval may take seconds
        count = min(max(done, 1), samples - done)
        part = slice(done, done + count + 1)
        rows = Rows(table[part].reshape(-1), torques[part])
        before, head = through(state, before, ring, head, body, wall, pad, rows)
        done += count
        if done == samples:
            break
        look()
    times = np.arange(samples + 1, dtype=np.float64)
    if jitters(wall.clock):
        begin_clock(wall.clock, 0.0)
        times[1:] = np.cumsum([next_span(wall.clock) for _ in range(samples)])
    return Trial(
        time_s=(phase + times) * knob.period_s,
        angle_rad=(table[:, 0] + knob.shift) * knob.quantum_rad,
        velocity_rad_s=table[:, 1] * (knob.quantum_rad / knob.period_s),
        torque_nm=torques * knob.torque_nm,
    )
