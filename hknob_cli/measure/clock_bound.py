"""How far a knob swings at most under every clock that jitters so much, from the starts of a sweep.

What trials show is of the intervals that their seed draws. This is of all sequences of intervals between the shortest
and the longest, also of those that are chosen to make the knob swing.
"""

from collections.abc import Callable
from typing import Any

from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.attractors import NeedsCompilerError
from hknob_cli.engine.general.every_clock import ClockBound, is_bounded, start_region, start_regions
from hknob_cli.engine.general.search import as_compiled
from hknob_cli.scene.general_knob import GeneralKnob
from hknob_cli.specs.plan import Starts

Functions = dict[str, Callable[..., Any]]


def clock_bound_rad(
    knob: GeneralKnob, starts: Starts, functions: Functions | None, *, seconds: float | None = None
) -> float | None:
    """A bound on largest less smallest angle in the end, rad; 0: all motions come to rest.

    None without a clock that jitters, where the scene has more in it than `engine.general.every_clock` is of, where no
    bound is found, and where it takes longer than ``seconds``. From one start the first sample comes at any time within
    the longest interval; a range of starts is of states at a sample. Raises `NeedsCompilerError` without compiled
    ``functions``.
    """
    if knob.wall.clock is None or not is_bounded(knob.body, knob.wall, knob.delay_line):
        return None
    if functions is None:
        raise NeedsCompilerError
    body, wall = as_compiled(knob.body, knob.wall)
    if starts.span:
        low, high, slowest, fastest = starts.span
        regions = start_region([knob.start(low, slowest), knob.start(high, fastest)])
    else:
        regions = start_regions(body, knob.start(starts.angle, starts.velocity))
    with Alarm(seconds, body.halt):
        counts = ClockBound(functions, body, wall).range(regions)
    return None if counts is None else counts * knob.quantum_rad
