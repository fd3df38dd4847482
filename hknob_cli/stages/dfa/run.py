"""The describing-function analysis: limit cycles of every cell by each method, beside the complete lists of a sweep."""

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from math import pi
from pathlib import Path
from typing import Any

import pyarrow as pa

from hknob_cli.errors import UsageError
from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import Column, axis_column
from hknob_cli.results.files import input_digest
from hknob_cli.results.parted import read_result, result_schema
from hknob_cli.results.provenance import scene_of
from hknob_cli.scene.plain_knob import SampledKnob, sample_knob
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.parquet import why_unreadable
from hknob_cli.specs.plan import COUNTS, RATE, Cell, DfaPlan, Encoder, Scene, scene_at
from hknob_cli.stages import compare
from hknob_cli.stages.compare import key_of, sweep_file
from hknob_cli.theory.laws import MOST_FRICTION
from hknob_cli.theory.relay import Attached, Relay, RelayCycle, attached_to, describing_function, tsypkin
from hknob_cli.theory.staircase import MOST_PAIRS, sampled_cycles, swings

LISTED = (
    Column("listed", pa.bool_(), "", "whether the sweep's complete list has this cycle; null where none is complete"),
    Column("listed_count", pa.int64(), "1", "cycles in the cell's list; null where it is not complete"),
)

SAME = 1e-9  # of two peaks to peak that are of one cycle, relative

_Cycle = tuple[int, float]  # period in samples, peak to peak in rad


def digest_of_lists(folder: str) -> str | None:
    """Digest of the sweep's orbits, an input of what is compared with them; None without. Raises `UsageError`."""
    path = sweep_file(folder).with_name("orbits.parquet")
    return input_digest(path) if path.exists() else None


class Lists:
    """The complete lists of a sweep's cycles, by cell; ``any``: whether there is one."""

    def __init__(self, folder: str, axes: Sequence[str], scene: Scene) -> None:
        """Read those of the sweep in ``folder``; none if its push is another. Raises `UsageError`."""
        self._axes = list(axes)
        self._lists: dict[tuple[str, ...], list[_Cycle]] = {}
        cells = sweep_file(folder)
        theirs = scene_of(result_schema(cells).metadata)
        if theirs is None or theirs.bias != scene.bias:
            return
        for row in _rows(cells, [*axes, "complete"]):
            if row["complete"]:
                self._lists[key_of(row, axes)] = []
        if not self._lists:
            return
        for row in _rows(cells.with_name("orbits.parquet"), [*axes, "outcome", "period_samples", "p2p_rad"]):
            left = self._lists.get(key_of(row, axes))
            if left is not None and row["outcome"] == "cycle":
                left.append((row["period_samples"], row["p2p_rad"]))

    @property
    def any(self) -> bool:
        """Whether a list is complete."""
        return bool(self._lists)

    def mark(self, cell: Cell, found: list[dict[str, Any]]) -> None:
        """Give each row ``found`` in a cell its `LISTED`; no two rows are one listed cycle."""
        listed = self._lists.get(key_of(cell, self._axes))
        if listed is None:
            return
        left = list(listed)
        for row in found:
            row["listed_count"] = len(listed)
            period, p2p = row.get("period_samples"), row["p2p_rad"]
            if period is None or p2p is None:
                continue
            match = next((one for one in left if one[0] == period and abs(one[1] - p2p) <= SAME * p2p), None)
            row["listed"] = match is not None
            if match:
                left.remove(match)


def _rows(path: Path, columns: list[str]) -> list[dict[str, Any]]:
    """Some columns of a table. Raises `UsageError` where it cannot be read or lacks one that every sweep has."""
    try:
        table = read_result(path)
    except (OSError, pa.ArrowException) as error:
        raise UsageError(f"against: {path} {why_unreadable(error)}; run the sweep again") from None
    there = [name for name in columns if name in table.column_names]
    rows: list[dict[str, Any]] = table.select(there).to_pylist()
    return [{**dict.fromkeys(columns), **row} for row in rows]


COLUMNS = (
    Column("method", pa.string(), "", "df1, df4, ...: that many odd harmonics; tsypkin: all; sampled: exact"),
    Column("orbit", pa.int64(), "1", "number of the limit cycle within cell and method, the highest pitch first"),
    Column("p2p_rad", pa.float64(), "rad", "peak to peak; null where the method finds no limit cycle"),
    Column("amplitude_rad", pa.float64(), "rad", "half of peak to peak"),
    Column("frequency_hz", pa.float64(), "Hz", "cycles per second"),
    Column("in_domain", pa.bool_(), "", "whether the method's assumptions hold in this cell"),
    Column("reason", pa.string(), "", "which assumption does not hold, or why there is no limit cycle"),
)
SAMPLED = (
    Column("period_samples", pa.int64(), "sample", "period of a cycle of the sampled relay"),
    Column("samples_inside", pa.int64(), "sample", "how many of them see the lower level"),
)

FEW = "it has fewer than four samples a cycle, the method assumes many"

Progress = Callable[[int, int], None]


class DfaStage:
    """An analysis that is ready to run."""

    def __init__(self, plan: DfaPlan, *, notify: Callable[[str], None] = lambda _text: None) -> None:
        """Make ready. Raises `UsageError` if there is no sweep to compare with where one is named."""
        self.plan = plan
        self.notify = notify
        self.against = compare.Against(plan.against, list(plan.axes), cells_of(plan)) if plan.against else None
        self.lists: Lists | None = None
        if plan.against and "sampled" in plan.methods:
            self.lists = Lists(plan.against, list(plan.axes), plan.scene)
        self._cycles: dict[tuple[str, Relay], list[RelayCycle]] = {}

    def run(self, progress: Progress = lambda _done, _total: None) -> pa.Table:
        """Rows for every cell, method and cycle; ``progress`` is told of the cells. Raises `ComputationError`."""
        columns = [axis_column(name, self.plan.units[name]) for name in self.plan.axes]
        columns += [*COLUMNS, *(SAMPLED if "sampled" in self.plan.methods else ())]
        columns += LISTED if self.lists and self.lists.any else ()
        columns += compare.COLUMNS if self.against else ()
        return build_table(columns, list(self._rows(progress)))

    def _rows(self, progress: Progress) -> Iterator[dict[str, Any]]:
        blank = {column.name: None for column in (*COLUMNS, *SAMPLED, *LISTED)}
        every = cells_of(self.plan)
        for done, cell in enumerate(every):
            progress(done, len(every))
            scene = scene_at(self.plan.scene, cell)
            knob = sample_knob(scene, sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))
            more = _attached(scene, cell)
            width = (scene.encoder or Encoder()).width_counts(knob.quantum_rad)
            for method in self.plan.methods:
                found = list(self._found(knob, method, more, width))
                found = [{**blank, **row} for row in found]
                if method == "sampled" and self.lists:
                    self.lists.mark(cell, found)
                for number, row in enumerate(found):
                    if row["p2p_rad"] is not None:
                        row["amplitude_rad"] = 0.5 * row["p2p_rad"]
                    beside = (
                        self.against.columns(cell, p2p_rad=row["p2p_rad"], frequency_hz=row["frequency_hz"])
                        if self.against
                        else {}
                    )
                    yield {**cell, **row, "method": method, "orbit": number, **beside}

    def _found(self, knob: SampledKnob, method: str, more: Attached | None, width: float) -> Iterator[dict[str, Any]]:
        """Cycles by a method; ``width``: of the encoder's hysteresis, counts."""
        if method == "sampled":
            return self._sampled(knob)
        if width and (nothing := _forgets(method, more)):
            return iter([{"in_domain": False, "reason": nothing}])
        return self._staircase(knob, more) if method == "staircase" else self._continuous(knob, method, more, width)

    @staticmethod
    def _staircase(knob: SampledKnob, more: Attached | None) -> Iterator[dict[str, Any]]:
        """Cycles by one harmonic of the whole wall, under the push that there is."""
        loop = knob.loop
        if nothing := _no_relay(knob, more) or (_beyond("staircase", more) if more else ""):
            yield {"in_domain": False, "reason": nothing}
            return
        unit = Relay(loop.alpha, loop.beta, 1.0, _delay(knob), more)
        pitches = describing_function(unit, 1)
        found = [(cycle, swing) for cycle in reversed(pitches) for swing in swings(loop, 0.25 * pi * cycle.amplitude)]
        if not found:
            yield {"in_domain": False, "reason": "no motion that the wall keeps up"}
        for cycle, swing in found:
            few = cycle.omega > 0.5 * pi
            yield {
                "p2p_rad": 2.0 * swing.amplitude * knob.quantum_rad,
                "frequency_hz": cycle.omega / (2.0 * pi * knob.period_s),
                "in_domain": not few,
                "reason": FEW if few else "",
            }

    def _continuous(
        self, knob: SampledKnob, method: str, more: Attached | None, width: float
    ) -> Iterator[dict[str, Any]]:
        """Cycles by harmonics; those of a unit relay, which cells of equal rate share, scaled."""
        loop = knob.loop
        if nothing := _no_relay(knob, more) or (_beyond(method, more) if more else ""):
            yield {"in_domain": False, "reason": nothing}
            return
        if more:
            more = more._replace(friction=more.friction / (0.5 * loop.kappa))
        unit = Relay(loop.alpha, loop.beta, 1.0, _delay(knob), more, width / loop.kappa)
        if (method, unit) not in self._cycles:
            harmonics = int(method[2:]) if method.startswith("df") else 0
            cycles = describing_function(unit, harmonics) if harmonics else tsypkin(unit)
            self._cycles[method, unit] = cycles
        cycles = self._cycles[method, unit]
        if not cycles:
            yield {"in_domain": False, "reason": "no intersection below the Nyquist frequency", "orbit": 0}
        for cycle in reversed(cycles):
            amplitude = 0.5 * loop.kappa * cycle.amplitude
            reasons = self._assumptions(knob, amplitude, cycle.omega, width)
            if more and 0.5 * more.friction > MOST_FRICTION:
                reasons.append(
                    f"friction is {0.5 * more.friction:.3g} of a torque step, the method assumes that it never sticks"
                )
            if not cycle.single:
                reasons.append("the wave crosses the edge more than twice a cycle, so it is none of a relay")
            yield {
                "p2p_rad": 2.0 * amplitude * knob.quantum_rad,
                "frequency_hz": cycle.omega / (2.0 * pi * knob.period_s),
                "in_domain": not reasons,
                "reason": "; ".join(reasons),
            }

    @staticmethod
    def _assumptions(knob: SampledKnob, amplitude: float, omega: float, width: float) -> list[str]:
        """Assumptions of a symmetric relay in continuous time that do not hold."""
        loop = knob.loop
        reasons = []
        step = loop.kappa * (1.0 - loop.offset)
        push = (loop.gamma - loop.beta * knob.shift) / step if step > 0.0 else 0.0
        if abs(push - 0.5) > 1e-9:
            reasons.append(f"the bias is {push:.3g} of a count's torque step, the method assumes 0.5")
        if loop.offset != 0.0 or knob.shift != 0.0:
            reasons.append("the encoder has no edge at the wall's, the method assumes one")
        if amplitude > 1.0 + 0.5 * width:
            most = f"{1.0 + 0.5 * width:g}"
            reasons.append(f"it swings {amplitude:.3g} counts to each side, the method assumes at most {most}")
        if omega > 0.5 * pi:
            reasons.append(FEW)
        return reasons

    def _sampled(self, knob: SampledKnob) -> Iterator[dict[str, Any]]:
        """Exact cycles, with their sample counts."""
        if nothing := _no_relay(knob, None):
            yield {"in_domain": False, "reason": nothing}
            return
        found = sampled_cycles(knob.loop, delay_line=knob.delay_line, functions=self._functions)
        if not found:
            reason = f"more than {MOST_PAIRS} candidates" if found is None else "no cycle between two levels"
            if knob.loop.alpha == 0.0 or knob.loop.beta == 0.0:
                reason = "no isolated cycles without damping and hand stiffness"
            yield {"in_domain": False, "reason": reason}
        for cycle in found or []:
            yield {
                "p2p_rad": (cycle.highest - cycle.lowest) * knob.quantum_rad,
                "frequency_hz": cycle.cycles / (cycle.period * knob.period_s),
                "in_domain": True,
                "reason": "",
                "period_samples": cycle.period,
                "samples_inside": cycle.inside,
            }

    @cached_property
    def _functions(self) -> dict[str, Any]:
        from hknob_cli.engine.compiling import tell_compiling
        from hknob_cli.engine.jit import compiled, waiting

        tell_compiling(self.notify)
        if text := waiting():
            self.notify(text)
        return compiled()


def _delay(knob: SampledKnob) -> float:
    """Mean samples from an edge to its torque: half a hold, and the transport delay."""
    return 0.5 + max(0, knob.delay_line - 1) + knob.loop.split


def _attached(scene: Scene, cell: Cell) -> Attached | None:
    """A finger, a lag or friction of the cell; None for a plain body."""
    hand, actuator = scene.hand, scene.actuator
    if not (scene.knob.coulomb_torque or (hand and hand.finger) or (actuator and actuator.time_constant)):
        return None
    from hknob_cli.scene.general_knob import sample_general

    knob = sample_general(scene, sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))
    return attached_to(knob.body)


def _no_relay(knob: SampledKnob, more: Attached | None) -> str:
    """Why there is no cycle, if so: there is no relay, or nothing takes the energy that a late one adds."""
    if knob.loop.kappa == 0.0:
        return "the wall has no stiffness"
    loses = knob.loop.alpha + (more.pad_damping + more.finger_damping if more else 0.0)
    return "there is no viscous damping, so that no cycle is bounded" if loses == 0.0 else ""


def _forgets(method: str, more: Attached | None) -> str:
    """Why a method has no word on hysteresis beside what is attached; empty where it has."""
    if method == "staircase":
        return "its wall has no memory; dfN and tsypkin know hysteresis"
    if more and more.friction:
        return "friction turns with the velocity, hysteresis with the angle: one relay cannot be both"
    return ""


def _beyond(method: str, more: Attached) -> str:
    """Why a method has no word on what is attached; empty where it has."""
    if method == "tsypkin":
        return "its closed form is of one body; dfN with many harmonics comes as near"
    if more.friction and method != "df1":
        return "friction turns with the velocity, which df1 alone knows"
    return ""
