"""How much work a cell of a sweep is, roughly: decides whether compiling pays.

Work is counted in trial-samples of the engine that a cell takes. A guess that is too low costs little: the interpreter
gives up where a search needs the compiler (`engine.attractors.NeedsCompilerError`), and the cell begins again.
"""

from hknob_cli.engine.budget import sample_limit, settling_samples
from hknob_cli.engine.propagator import slowest_rate
from hknob_cli.scene.sampled_knob import sample_knob
from hknob_cli.specs.plan import COUNTS, RATE, Cell, SweepPlan, scene_at
from hknob_cli.stages.sweep.cell import GROWTH_S, LAW_SETS, engine_group

DETECTION = 300.0  # samples of a trial beyond its transient, roughly
UNKNOWN = 2000.0  # samples of a trial of more than two states, roughly
CORNERS = 4.0  # times that a sample takes longer where turning points, or slopes of cogging, are looked for, roughly
BOXED = 8e6  # samples of the plain loop that take as long as a cell whose starts fill a box, at least, roughly
BOXED_LAW = 2e5  # samples of the sets under a controller that such a cell takes, roughly


def expected_samples(plan: SweepPlan, cell: Cell) -> tuple[str, float]:
    """Group of engine functions that a cell takes, and rough number of trial-samples; decides if compiling pays."""
    scene, phases = scene_at(plan.scene, cell), plan.starts.phases
    group = engine_group(plan, scene)
    if group == "unsampled":
        return group, 0.0
    if group == "bounces":
        return group, phases * cell[RATE] * (plan.growth_s or GROWTH_S)
    more = bool((scene.hand and scene.hand.finger) or (scene.actuator and scene.actuator.time_constant))
    work = phases * (CORNERS if scene.cogging or (more and scene.knob.coulomb_torque > 0.0) else 1.0)
    if more:
        return group, work * UNKNOWN
    loop = sample_knob(scene, sample_rate_hz=cell[RATE], counts_per_rev=int(cell.get(COUNTS, 1))).loop
    rate = slowest_rate(loop.alpha, loop.beta)
    if group == "sets" and plan.starts.many:
        return group, BOXED
    if group == LAW_SETS and plan.starts.many and scene.controller:
        return group, BOXED_LAW
    return group, work * (settling_samples(rate, sample_limit(rate, loop.alpha > 0.0)) + DETECTION)
