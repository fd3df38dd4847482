"""One cell of a sweep: to the engine that its scene needs, and to the measures of what it finds."""

from collections.abc import Callable
from typing import Any, NamedTuple

from hknob_cli.engine.attractors import (
    Attractor,
    Engine,
    NeedsCompilerError,
    Search,
    sample_limit,
    settling_samples,
)
from hknob_cli.engine.propagator import slowest_rate
from hknob_cli.measure.orbit import Measurer, OrbitMeasures
from hknob_cli.scene.sampled_knob import is_plain, sample_knob
from hknob_cli.spec.plan import COUNTS, RATE, Cell, SweepPlan, scene_at

DETECTION = 300.0  # samples of a trial beyond its transient, roughly
UNKNOWN = 2000.0  # samples of a trial of more than two states, roughly


class CellResult(NamedTuple):
    """One cell: its axis values, attractors and their measures, quantum (rad), and trial-samples taken.

    ``group``: the engine functions it took, as `engine.jit` names them.
    """

    cell: Cell
    quantum_rad: float
    attractors: tuple[Attractor, ...]
    measures: tuple[OrbitMeasures, ...]
    samples: int
    group: str = "plain"


def expected_samples(plan: SweepPlan, cell: Cell) -> tuple[str, float]:
    """Group of engine functions that a cell takes, and rough number of trial-samples; decides if compiling pays."""
    scene, phases = scene_at(plan.scene, cell), plan.starts.phases
    group = "plain" if is_plain(scene) else "general"
    if (scene.hand and scene.hand.finger) or (scene.actuator and scene.actuator.time_constant):
        return group, phases * UNKNOWN
    loop = sample_knob(scene, sample_rate_hz=cell[RATE], counts_per_rev=int(cell.get(COUNTS, 1))).loop
    rate = slowest_rate(loop.alpha, loop.beta)
    return group, phases * (settling_samples(rate, sample_limit(rate, damped=loop.alpha > 0.0)) + DETECTION)


class CellFinder:
    """Finds what cells settle to; has the engines, plain or compiled, that their scenes need. One per thread."""

    def __init__(self, functions: dict[str, dict[str, Callable[..., Any]]]) -> None:
        """Make ready; ``functions``: compiled engine functions by group."""
        self.functions = functions
        self._engine: Engine | None = None
        self._general: Any = None

    def find(self, plan: SweepPlan, cell: Cell) -> CellResult:
        """Run one cell. Raises `ComputationError`, and `NeedsCompilerError` where the interpreter is too slow."""
        scene = scene_at(plan.scene, cell)
        if not is_plain(scene):
            return self._find_general(plan, cell)
        knob = sample_knob(scene, sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))
        if self._engine is None:
            self._engine = Engine(self.functions.get("plain"))
        search = self._engine.search(
            knob.loop,
            x=knob.position(plan.starts.angle),
            v=knob.speed(plan.starts.velocity),
            phases=plan.starts.phases,
            delay_line=knob.delay_line,
            max_samples=plan.max_samples,
        )
        return _result(cell, knob.quantum_rad, search, Measurer(knob, self._engine).measure, "plain")

    def _find_general(self, plan: SweepPlan, cell: Cell) -> CellResult:
        from hknob_cli.engine.general.search import GeneralEngine
        from hknob_cli.measure.general_orbit import GeneralMeasurer
        from hknob_cli.scene.general_knob import sample_general

        counts = int(cell[COUNTS]) if COUNTS in cell else None
        knob = sample_general(scene_at(plan.scene, cell), sample_rate_hz=cell[RATE], counts_per_rev=counts)
        if self._general is None:
            self._general = GeneralEngine(self.functions.get("general"))
        try:
            search = self._general.search(
                knob.body,
                knob.wall,
                knob.start(plan.starts.angle, plan.starts.velocity),
                rate=knob.rate,
                phases=plan.starts.phases,
                delay_line=knob.delay_line,
                max_samples=plan.max_samples,
            )
        except NeedsCompilerError:
            raise NeedsCompilerError("general") from None
        return _result(cell, knob.quantum_rad, search, GeneralMeasurer(knob, self._general).measure, "general")


def _result(
    cell: Cell, quantum_rad: float, search: Search, measure: Callable[[Attractor], OrbitMeasures], group: str
) -> CellResult:
    return CellResult(
        cell=cell,
        quantum_rad=quantum_rad,
        attractors=search.attractors,
        measures=tuple(measure(one) for one in search.attractors),
        samples=search.samples,
        group=group,
    )
