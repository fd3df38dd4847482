"""From cells of a grid to their starts under a controller: every clock phase of one, or every state of a box."""

from collections.abc import Callable, Sequence

import numpy as np

from hknob_cli.controllers.batch_stepper import BatchStepper
from hknob_cli.controllers.controller import ControlLaw
from hknob_cli.controllers.plant_batch import PlantBatch, flow_over, moved
from hknob_cli.controllers.sets.arcs import Arcs, make_flight
from hknob_cli.controllers.sets.follow import Ends, Follower, Limits
from hknob_cli.controllers.sets.polygons import Plants, box_polygons
from hknob_cli.engine.certificate import EPSILON
from hknob_cli.scene.sampled_knob import SampledKnob
from hknob_cli.specs.plan import Starts

ARCS = Limits(samples=20_000_000, unproven=16_384, seekers=4096)
BOXES = Limits(samples=100_000_000, unproven=256, seekers=64)


def follow_starts(
    remedy: ControlLaw,
    lanes: PlantBatch,
    knobs: Sequence[SampledKnob],
    starts: Starts,
    over: Callable[[], bool] = lambda: False,
) -> list[Ends]:
    """What all starts of each cell settle to; ``lanes`` has one lane a cell."""
    mover, cell = BatchStepper(remedy, lanes), np.arange(len(knobs))
    root = np.sqrt(lanes.beta)
    with np.errstate(over="ignore", invalid="ignore"):
        if starts.span:
            low, high, slowest, fastest = starts.span
            least = np.array([[knob.position(low), knob.speed(slowest)] for knob in knobs]).T
            most = np.array([[knob.position(high), knob.speed(fastest)] for knob in knobs]).T
            x, v = 0.5 * (least + most)
            wide, fast = 0.5 * (most - least)
            shape = box_polygons(Plants(lanes.alpha, lanes.beta), wide, fast)
            error = 8.0 * EPSILON * (np.abs(x) + wide + (np.abs(v) + fast) / root)
            return Follower(mover, BOXES, over).follow(cell, x, v, shape, shape.radius(cell), error)
        x = np.array([knob.position(starts.angle) for knob in knobs])
        v = np.array([knob.speed(starts.velocity) for knob in knobs])
        plants = zip(lanes.alpha, lanes.beta, lanes.gamma, x, v, strict=True)
        flights = [make_flight(*(float(value) for value in plant)) for plant in plants]
        arcs = Arcs(flights, cell, np.zeros(len(cell)), np.ones(len(cell)), np.full(len(cell), 0.5), 0)
        x, v = moved(x, v, -lanes.gamma, lanes.beta, flow_over(lanes, 0.5))
        return Follower(mover, ARCS, over).follow(cell, x, v, arcs, arcs.radius(cell), arcs.blur(cell))
