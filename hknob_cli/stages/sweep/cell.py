"""One cell of a sweep: to the engine that its scene needs, and to the measures of what it finds."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.attractors import PATIENCE, USUAL, Attractor, Engine, NeedsCompilerError, Patience, Search, whole
from hknob_cli.engine.loop import Loop
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.orbit import Measurer, OrbitMeasures
from hknob_cli.scene.plain_knob import random_starts, sample_knob
from hknob_cli.specs.capabilities import COLUMNS, STARTS, TRIALS, engine_of, parts_of, takes
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import COUNTS, GRIP, PERSON, RATE, Cell, Scene, SweepPlan, scene_at
from hknob_cli.stages.sweep.every_start import StartsFinder, why_open

if TYPE_CHECKING:
    from hknob_cli.stages.sweep.perceived import Perceived

LAW_SETS = "friction sets"  # group of sets of starts with friction, or under a controller
COGGING_SETS = "cogging sets"  # group of ranges beside cogging
CLOCKS = "clocks"  # group of what bounds every clock
SETS_OF_LAWS = ("general sets", LAW_SETS, "friction arcs")  # groups of sets that a controller may be among, too
GROWTH_S = 1.0  # over which the bounces of an undamped knob are collected, where the spec does not say
MAX_EVENTS = 2_000_000  # that a trial without a sample clock may take
MAX_EVENTS_INTERPRETED = 20_000


class CellResult(NamedTuple):
    """One cell: its axis values, attractors and their measures, quantum (rad), and trial-samples taken.

    Where all starts are meant, ``complete``: whether all are proven to end in these attractors; ``pieces``,
    ``undecided``, ``why``, ``share_error``: as in `engine.attractors.Search`. ``region``: largest angle (rad) and speed
    (rad/s) of the region that every motion comes into, where starts are anywhere; ``grows``: those beyond which all
    grow without bound.
    ``clock_bound``: on how far (rad) a motion swings in the end under every clock, where the sample clock jitters.
    ``group``: the engine functions it took, as `engine.jit` names them; ``growth``: of the energy of bounces;
    ``contact``: how a trial without a sample clock settles.
    """

    cell: Cell
    quantum_rad: float
    attractors: tuple[Attractor, ...]
    measures: tuple[OrbitMeasures, ...]
    samples: int
    group: str = "plain"
    growth: Any = None  # measure.growth.Growth
    contact: Any = None  # measure.unsampled.UnsampledTrial
    complete: bool = False
    pieces: int = 0
    undecided: float | None = None
    share_error: float | None = None
    region: tuple[float, float] | None = None
    grows: tuple[float, float] | None = None
    why: Reason = Reason.NONE
    clock_bound: float | None = None
    perceived: tuple["Perceived", ...] = ()  # one an attractor, where asked for


def may_bounce(plan: SweepPlan) -> bool:
    """Whether a sweep has cells of the bouncing ball: exact for a grid, for each axis bears on the matter by itself."""
    if plan.scene.controller:
        return False
    pushed = ("bias.torque", "wall.stiffness")
    cell = {
        name: max(values, key=abs) if name in pushed else min(values, key=abs)
        for name, values in plan.axes.items()
        if name not in (GRIP, PERSON)
    }
    hands = [{GRIP: grip} for grip in plan.axes.get(GRIP, [])] or [{PERSON: who} for who in plan.axes.get(PERSON, [])]
    return any(takes("bounces", parts_of(scene_at(plan.scene, {**cell, **hand}))) for hand in hands or [{}])


def shares_areas(plan: SweepPlan) -> bool:
    """Whether shares of ranges are areas: where sets are followed under a controller without friction."""
    if plan.scene.controller is None:
        return False
    cells = cells_of(plan)
    ends = [scene_at(plan.scene, cell) for i in (0, len(cells) - 1) for cell in cells.run(i, i + 1)]
    return all(engine_group(plan, scene) == LAW_SETS and "friction" not in parts_of(scene) for scene in ends)


def group_of(scene: Scene) -> str:
    """Group of engine functions that trials of a scene take."""
    return COLUMNS[engine_of(scene, TRIALS)].group


def engine_group(plan: SweepPlan, scene: Scene) -> str:
    """Group of engine functions that a cell of a sweep takes: by its scene, and by whether all starts are meant."""
    return COLUMNS[engine_of(scene, STARTS[plan.starts.kind])].group


class CellFinder:
    """Finds what cells settle to; has the engines, plain or compiled, that their scenes need. One per thread."""

    def __init__(
        self,
        functions: dict[str, dict[str, Callable[..., Any]]],
        stopped: Callable[[], bool] = lambda: False,
        patience: Callable[[str], Patience] = lambda _group: USUAL,
    ) -> None:
        """Make ready; ``functions``: compiled engine functions by group; ``stopped``: asked whether to give up.

        ``patience``: of the interpreter, where a group is not compiled.
        """
        self.functions = functions
        self.stopped = stopped
        self.patience = patience
        self._engine: Engine | None = None
        self._starts = StartsFinder(functions, stopped, patience)
        self._general: Any = None

    def find(self, plan: SweepPlan, cell: Cell) -> CellResult:
        """Run one cell. Raises `ComputationError`, and `NeedsCompilerError` where the interpreter is too slow."""
        scene = scene_at(plan.scene, cell)
        group = engine_group(plan, scene)
        if group == "unsampled":
            return self._find_unsampled(plan, cell)
        if group == "bounces":
            return self._find_growth(plan, cell)
        if group == "laws" or (group in SETS_OF_LAWS and group_of(scene) == "laws"):
            return self._find_with_law(plan, cell, group)
        if group in ("general", COGGING_SETS, *SETS_OF_LAWS):
            return self._find_general(plan, cell, group)
        knob = sample_knob(scene, sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))
        functions = self.functions.get("sets" if group == "sets" else "plain")
        if self._engine is None or self._engine.compiled != (functions is not None):
            self._engine = Engine(functions, self.stopped)
        self._engine.patience = self.patience(group)
        search = self._starts.search_plain(plan, knob) if group == "sets" else None
        if search is None:
            search = self._engine.search(
                knob.loop,
                x=knob.position(plan.starts.angle),
                v=knob.speed(plan.starts.velocity),
                phases=plan.starts.phases,
                delay_line=knob.delay_line,
                max_samples=plan.max_samples,
                seconds=plan.seconds_per_cell,
            )
        measurer = Measurer(knob, self._engine)
        found = _result(cell, knob.quantum_rad, search, measurer.measure, group, _feeling(plan, measurer))
        return found._replace(region=_reach(knob, search.region), grows=_reach(knob, search.grows))

    def trace(self, loop: Loop, orbit: Attractor) -> Any:
        """One period of an orbit of the plain loop, as `engine.attractors.Engine.trace`."""
        assert self._engine
        return self._engine.trace(loop, orbit)

    def _find_general(self, plan: SweepPlan, cell: Cell, group: str) -> CellResult:
        from hknob_cli.engine.general.search import GeneralEngine
        from hknob_cli.measure.general_orbit import GeneralMeasurer
        from hknob_cli.measure.growth import clock_bound_rad
        from hknob_cli.scene.general_knob import sample_general

        counts = int(cell[COUNTS]) if COUNTS in cell else None
        knob = sample_general(scene_at(plan.scene, cell), sample_rate_hz=cell[RATE], counts_per_rev=counts)
        functions = self.functions.get(group)
        if self._general is None or self._general.compiled != (functions is not None):
            self._general = GeneralEngine(functions, self.stopped)
        self._general.patience = self.patience(group)
        try:
            bounding = functions or self.functions.get(CLOCKS)
            bound = clock_bound_rad(knob, plan.starts, bounding, seconds=plan.seconds_per_cell)
        except NeedsCompilerError:
            raise NeedsCompilerError(CLOCKS) from None
        try:
            search = self._starts.search_general(plan, knob, group) if group != "general" else None
            if search is None:
                search = _search_trials(plan, self._general, knob, rate=knob.rate, line=knob.delay_line)
        except NeedsCompilerError:
            raise NeedsCompilerError(group) from None
        measurer = GeneralMeasurer(knob, self._general)
        found = _result(cell, knob.quantum_rad, search, measurer.measure, group, _feeling(plan, measurer))
        return found._replace(region=_reach(knob, search.region), grows=_reach(knob, search.grows), clock_bound=bound)

    def _find_with_law(self, plan: SweepPlan, cell: Cell, group: str) -> CellResult:
        from hknob_cli.controllers.scalar_law import make_law
        from hknob_cli.engine.general.laws.search import LawEngine
        from hknob_cli.measure.general_orbit import LawMeasurer

        counts = int(cell[COUNTS]) if COUNTS in cell else None
        made = make_law(scene_at(plan.scene, cell), sample_rate_hz=cell[RATE], counts_per_rev=counts)
        engine = LawEngine(made.law, self.functions.get(group), self.stopped, self.patience(group))
        try:
            search = self._starts.search_law(plan, made, engine, group) if group != "laws" else None
            if search is None:
                search = _search_trials(plan, engine, made.knob, rate=made.rate, line=engine.past_length)
        except NeedsCompilerError:
            raise NeedsCompilerError(group) from None
        measurer = LawMeasurer(made.knob, engine)
        return _result(cell, made.knob.quantum_rad, search, measurer.measure, group, _feeling(plan, measurer))

    def _find_growth(self, plan: SweepPlan, cell: Cell) -> CellResult:
        from hknob_cli.measure.growth import bounce_peaks, energy_growth

        phases = plan.starts.phases
        knob = sample_knob(scene_at(plan.scene, cell), sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))
        duration = plan.growth_s or GROWTH_S
        alarm = Alarm(plan.seconds_per_cell)
        peaks = bounce_peaks(
            knob,
            angle_rad=plan.starts.angle,
            velocity_rad_s=plan.starts.velocity,
            phases=phases,
            duration_s=duration,
            functions=self.functions.get("bounces"),
            over=lambda: alarm.over,
        )
        ends = [whole(Outcome.UNDECIDED, Reason.NO_DAMPING, len(peaks))] if peaks else []
        if len(peaks) < phases:
            ends.append(whole(Outcome.UNDECIDED, Reason.TIME_LIMIT, phases - len(peaks)))
        search = Search(tuple(ends), int(len(peaks) * duration / knob.period_s))
        feeling = _feeling(plan, None)  # there is no cycle
        found = _result(cell, knob.quantum_rad, search, lambda _one: OrbitMeasures(), "bounces", feeling)
        return found._replace(growth=energy_growth(peaks))

    def _find_unsampled(self, plan: SweepPlan, cell: Cell) -> CellResult:
        from hknob_cli.measure.unsampled import settle
        from hknob_cli.scene.plain_knob import reduce_unsampled

        knob = reduce_unsampled(
            scene_at(plan.scene, cell), counts_per_rev=int(cell[COUNTS]) if COUNTS in cell else None
        )
        functions = self.functions.get("unsampled")
        tries = MAX_EVENTS_INTERPRETED * self.patience("unsampled").samples // PATIENCE
        most = MAX_EVENTS if functions else min(MAX_EVENTS, tries)
        trial = settle(
            knob,
            angle_rad=plan.starts.angle,
            velocity_rad_s=plan.starts.velocity,
            max_events=most,
            functions=functions,
        )
        if trial.events >= most and most < MAX_EVENTS:  # fewer bounces would be another result
            raise NeedsCompilerError("unsampled")
        attractor = Attractor(outcome=trial.outcome, reason=trial.reason, trials=1)
        measures = OrbitMeasures(
            cycles=trial.cycles,
            p2p_rad=trial.p2p_rad,
            min_rad=trial.min_rad,
            max_rad=trial.max_rad,
            rms_rad=trial.rms_rad,
            frequency_hz=trial.frequency_hz,
        )
        search = Search((attractor,), trial.events)
        found = _result(cell, knob.unit_rad, search, lambda _one: measures, "unsampled")
        return found._replace(contact=trial)


def _search_trials(plan: SweepPlan, engine: Any, knob: Any, *, rate: float, line: int) -> Search:
    """What trials settle to in the general loop: from phases of one start, or from random starts in ranges."""
    start, several = knob.start(plan.starts.angle, plan.starts.velocity), None
    if plan.starts.span:
        several = [knob.start(*one) for one in random_starts(plan.starts)]
        start = [max(map(abs, values)) for values in zip(*several, strict=True)]
    found: Search = engine.search(
        knob.body,
        knob.wall,
        start,
        several=several,
        rate=rate,
        phases=plan.starts.phases,
        delay_line=line,
        max_samples=plan.max_samples,
        seconds=plan.seconds_per_cell,
    )
    return found


def _reach(knob: Any, ranges: tuple[float, float, float, float] | None) -> tuple[float, float] | None:
    """Largest angle (rad) and speed (rad/s), either way, in ranges of position and speed in counts and samples."""
    if ranges is None:
        return None
    low, high, slowest, fastest = ranges
    speed = max(abs(slowest), abs(fastest)) * knob.quantum_rad / knob.period_s
    return max(abs(knob.angle_rad(low)), abs(knob.angle_rad(high))), speed


def _feeling(plan: SweepPlan, measurer: Any) -> Callable[[Attractor], "Perceived"] | None:
    """Tells what is felt and heard of an end of trials, if the plan asks for it: nothing of what is no cycle."""
    how = plan.perceive
    if how is None:
        return None
    from hknob_cli.stages.sweep.perceived import HIGHEST_HZ, Perceived, perceive

    def feel(one: Attractor) -> Perceived:
        return perceive(measurer.harmonics(one, HIGHEST_HZ), how) if one.outcome is Outcome.CYCLE else Perceived()

    return feel


def _result(
    cell: Cell,
    quantum_rad: float,
    search: Search,
    measure: Callable[[Attractor], OrbitMeasures],
    group: str,
    feel: Callable[[Attractor], "Perceived"] | None = None,
) -> CellResult:
    attractors, measures, perceived = [], [], []
    for one in search.attractors:
        measures.append(measure(one))
        if one.outcome is Outcome.CYCLE and not measures[-1].cycles:
            one = whole(Outcome.UNDECIDED, Reason.TOO_LONG, one.trials)
        attractors.append(one)
        if feel:
            perceived.append(feel(one))
    open_ = search.complete is not None and not search.complete
    return CellResult(
        cell=cell,
        quantum_rad=quantum_rad,
        attractors=tuple(attractors),
        measures=tuple(measures),
        samples=search.samples,
        group=group,
        complete=bool(search.complete),
        pieces=search.pieces,
        undecided=search.undecided,
        share_error=search.share_error,
        why=why_open(attractors) if open_ and search.why is Reason.NONE else search.why,
        perceived=tuple(perceived),
    )
