"""Random scenes: for how many is the list of attractors complete, and do random starts end elsewhere?

    python tests/crosscheck/every_start/random_scenes.py plain --count 300 --seconds 2

FAMILY is `plain` (starts anywhere), `affine` (delay, torque limit, torque step, virtual damping), `friction`,
`finger`, `lag`, `late` (friction, lag and often a delay), or `angle` (detents, end stops, dead zones, profiles, half of
them with friction); starts in a range.
Each scene is searched by the engine, for --seconds of the clock at most. Where the list
is complete, --starts random starts are simulated by matrix exponentials (`tests/verification/general_starts.py`,
`lagged_starts.py`), which use nothing of the package. What their readings repeat in the end must be on the list.
Scenes with an offset of the encoder, and those that take more than --samples samples, are searched only. The exit code
is 1 if an end was not listed.
"""

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[3]))

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.sets.friction_search import FrictionSetEngine
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.sets.search import Box, Search, SetEngine
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.scene.plain_knob import SampledKnob
from hknob_cli.specs.scene import SceneSpec
from tests.verification.general_starts import readings, turned
from tests.verification.lagged_starts import starts_of
from tests.verification.scenes import sample

FAMILIES = ("plain", "affine", "friction", "finger", "lag", "late", "angle")
ANGLE, VELOCITY = 0.02, 2.0  # rad, rad/s: the range
FAR, FAST = 0.3, 5.0  # the same of a torque over the angle, to hold more than one detent
SETTLED = 40.0  # time constants until most starts have settled
PATIENCE = 16  # times as many samples where some have not


class Cell(NamedTuple):
    """A scene as a spec writes it, sample rate, counts of a revolution."""

    scene: dict[str, Any]
    rate: float
    counts: int


class Draw:
    """Random numbers of one seed."""

    def __init__(self, seed: int) -> None:
        self.chance = np.random.default_rng(seed)

    def between(self, low: float, high: float) -> float:
        """Evenly spread logarithm."""
        return float(np.exp(self.chance.uniform(np.log(low), np.log(high))))

    def plain(self) -> Cell:
        """Inertias, stiffnesses and damping over decades, any rounding."""
        inertia, stiffness, ratio = self.between(1e-7, 1e-4), self.between(1e-3, 3.0), self.between(0.01, 10.0)
        scene = {
            "knob": {"inertia": inertia / 2, "damping": 0.0},
            "hand": {
                "inertia": inertia / 2,
                "damping": 2.0 * ratio * (stiffness * inertia) ** 0.5,
                "stiffness": stiffness,
            },
            "wall": {"stiffness": self.between(1e-2, 10.0)},
            "bias": {"half_quantum": True} if self.chance.random() < 0.4 else {"torque": self.between(1e-5, 3e-2)},
            "encoder": {
                "rounding": str(self.chance.choice(["floor", "ceil", "truncate", "nearest"])),
                "offset_counts": 0.0 if self.chance.random() < 0.5 else float(self.chance.uniform(0.0, 0.999)),
            },
        }
        return Cell(scene, self.between(100.0, 20_000.0), round(self.between(32.0, 16_384.0)))

    def hand_on_knob(self) -> Cell:
        """A knob in a hand, each number within a factor of some three of the dissertation's."""
        scene = {
            "knob": {"inertia": self.between(1e-6, 1e-5), "damping": self.between(1e-6, 1e-4)},
            "hand": {
                "inertia": self.between(1e-7, 1e-6),
                "damping": self.between(1e-4, 1e-3),
                "stiffness": self.between(0.02, 0.2),
            },
            "wall": {"stiffness": self.between(0.1, 1.0)},
            "bias": {"torque": self.between(3e-4, 3e-3)},
        }
        return Cell(scene, self.between(100.0, 2500.0), int(2 ** self.chance.integers(7, 11)))

    def affine(self) -> Cell:
        """One to three of delay, limit, step and virtual damping."""
        cell = self.hand_on_knob()
        step = cell.scene["wall"]["stiffness"] * 2.0 * np.pi / cell.counts
        parts = self.chance.choice(
            ["delay", "limit", "step", "damping"], size=self.chance.integers(1, 4), replace=False
        )
        actuator: dict[str, float] = {}
        if "delay" in parts:
            actuator["delay_samples"] = float(np.round(self.chance.uniform(0.1, 3.0), 2))
        if "limit" in parts:
            actuator["torque_limit"] = self.between(1.0, 10.0) * step
        if "step" in parts:
            actuator["torque_step"] = self.between(0.05, 1.0) * step
        if "damping" in parts:
            cell.scene["wall"]["damping"] = self.between(0.01, 0.2) * cell.scene["wall"]["stiffness"] / cell.rate
        return cell._replace(scene={**cell.scene, **({"actuator": actuator} if actuator else {})})

    def friction(self) -> Cell:
        """Coulomb friction of 0.01 to 3 times the torque of half a count; in two thirds a delay, or limit and step."""
        cell = self.hand_on_knob()
        step = cell.scene["wall"]["stiffness"] * 2.0 * np.pi / cell.counts
        cell.scene["knob"]["coulomb_torque"] = 0.5 * step * self.between(0.01, 3.0)
        more: list[dict[str, float]] = [
            {},
            {"delay_samples": 1.0},
            {"torque_limit": 4.0 * step, "torque_step": 0.2 * step},
        ]
        actuator = more[int(self.chance.integers(3))]
        return cell._replace(scene={**cell.scene, **({"actuator": actuator} if actuator else {})})

    def finger(self) -> Cell:
        """A hand of finger and fingerpad."""
        cell = self.hand_on_knob()
        hand = {
            "finger": {
                "inertia": self.between(1e-7, 1e-6),
                "damping": self.between(1e-3, 1e-2),
                "stiffness": self.between(0.1, 1.0),
            },
            "fingerpad": {"damping": self.between(1e-4, 1e-3), "stiffness": self.between(0.02, 0.2)},
        }
        return cell._replace(scene={**cell.scene, "hand": hand})

    def lag(self) -> Cell:
        """A current loop of a hundredth of a sample to half of one."""
        cell = self.hand_on_knob()
        return cell._replace(scene={**cell.scene, "actuator": {"time_constant": self.between(0.01, 0.5) / cell.rate}})

    def late(self) -> Cell:
        """Friction and a lag of a hundredth of a sample to three; in two thirds a delay, or limit and step."""
        cell = self.friction()
        lag = {"time_constant": self.between(0.01, 3.0) / cell.rate}
        return cell._replace(scene={**cell.scene, "actuator": {**cell.scene.get("actuator", {}), **lag}})

    def angle(self) -> Cell:
        """One or two torques over the angle, a wall in a third; friction, or delay, limit and step."""
        cell = self.hand_on_knob()
        if self.chance.random() < 2.0 / 3.0:
            cell.scene["wall"]["stiffness"] = 0.0
        makers = [self._profile, self._detents, self._end_stops, self._dead_zone]
        parts: dict[str, Any] = {}
        for maker in self.chance.choice(makers, size=self.chance.integers(1, 3), replace=False):
            parts |= maker(2.0 * np.pi / cell.counts)
        if self.chance.random() < 0.5:
            cell.scene["knob"]["coulomb_torque"] = self.between(1e-5, 5e-4)
        more: list[dict[str, float]] = [
            {},
            {"delay_samples": float(self.chance.integers(1, 4))},
            {"torque_limit": 4e-3, "torque_step": 1e-4},
            {"dead_band": 3e-4},
        ]
        actuator = more[int(self.chance.integers(4))]
        return cell._replace(scene={**cell.scene, **parts, **({"actuator": actuator} if actuator else {})})

    def _profile(self, _quantum: float) -> dict[str, Any]:
        angles = np.sort(self.chance.uniform(-0.3, 0.3, self.chance.integers(2, 6)))
        points = [[float(angle), float(self.chance.uniform(-4e-3, 4e-3))] for angle in angles]
        return {"profile": {"points": points, "interpolation": str(self.chance.choice(["linear", "stepped"]))}}

    def _detents(self, quantum: float) -> dict[str, Any]:
        shape = str(self.chance.choice(["sine", "triangle", "spring"]))
        most = int(2.0 * np.pi / (4.0 * quantum))
        number = min(most, int(self.chance.choice([6, 12, 24, 48])))
        zone = {"dead_zone": 0.2 * 2.0 * np.pi / number} if shape == "spring" and self.chance.random() < 0.5 else {}
        return {"detents": {"per_revolution": number, "torque": self.between(1e-3, 1e-2), "shape": shape, **zone}}

    def _end_stops(self, _quantum: float) -> dict[str, Any]:
        low, high = -self.chance.uniform(0.0, 0.2), self.chance.uniform(0.01, 0.2)
        return {"end_stops": {"low": float(low), "high": float(high), "stiffness": self.between(0.05, 0.5)}}

    def _dead_zone(self, _quantum: float) -> dict[str, Any]:
        zone = {"width": float(self.chance.uniform(0.0, 0.3)), "stiffness": self.between(0.05, 0.5)}
        return {"dead_zone": {**zone, **({"torque": 4e-3} if self.chance.random() < 0.5 else {})}}


class Searched(NamedTuple):
    """What the engine says, the knob in its units, the corners of the starts simulated, and the slowest rate."""

    search: Search | None
    knob: GeneralKnob | SampledKnob
    far: tuple[float, float]  # rad, rad/s
    rate: float


def search_cell(family: str, cell: Cell, seconds: float) -> Searched:
    """Every start, anywhere or in the range."""
    general = sample_general(
        SceneSpec.model_validate(cell.scene).plain(), sample_rate_hz=cell.rate, counts_per_rev=cell.counts
    )
    if family == "plain":
        knob = sample(cell.scene, cell.rate, cell.counts)
        found = SetEngine(compiled("sets")).search_anywhere(knob.loop, max_samples=None, seconds=seconds)
        ranges = found.region or (0.0, 0.0, 0.0, 0.0)
        far = 3.0 * max(map(abs, ranges[:2])), 3.0 * max(map(abs, ranges[2:]))  # from outside of the region, too
        unit = knob.quantum_rad, knob.quantum_rad * cell.rate
        return Searched(found, knob, (far[0] * unit[0], far[1] * unit[1]), general.rate)
    far = (FAR, FAST) if family == "angle" else (ANGLE, VELOCITY)
    box = Box(general.position(-far[0]), general.position(far[0]), general.speed(-far[1]), general.speed(far[1]))
    rubs = general.body.friction > 0.0
    kind, group = (FrictionSetEngine, "friction sets") if rubs else (GeneralSetEngine, "general sets")
    engine = kind(compiled(group))
    given = {"rate": general.rate, "delay_line": general.delay_line, "max_samples": None, "seconds": seconds}
    found = engine.search_box(general.body, general.wall, box, **given)
    return Searched(found, general, far, general.rate)


def random_ends(cell: Cell, far: tuple[float, float], starts: int, samples: int, kept: int, seed: int) -> NDArray[Any]:
    """Readings of the last ``kept`` samples of random starts, shape (kept, starts)."""
    chance = np.random.default_rng(seed)
    states = np.column_stack([chance.uniform(-far[0], far[0], starts), chance.uniform(-far[1], far[1], starts)])
    if "coulomb_torque" not in cell.scene["knob"]:
        return readings(cell.scene, cell.rate, cell.counts, states, samples, kept)
    trials = starts_of(cell.scene, cell.rate, cell.counts)
    seen = trials.readings(states[:, 0], states[:, 1], samples, kept)
    return seen if trials.over else np.minimum(seen, 0.0)


def unlisted(cell: Cell, found: Searched, starts: int, most: int, seed: int) -> int | None:
    """Number of random starts that end off the list; None where the cell is not simulated."""
    assert found.search is not None
    orbits = [one for one in found.search.attractors if one.outcome in (Outcome.CYCLE, Outcome.REST)]
    longest = max(one.period for one in orbits)
    samples = int(SETTLED / found.rate) + 200
    offset = cell.scene.get("encoder", {}).get("offset_counts", 0.0)
    if offset or samples + longest > most:
        return None
    names = {levels_of(cell, found.knob, one) for one in orbits}
    lost = starts
    while lost and samples + longest <= PATIENCE * most:  # a transient may be long beside the slowest decay
        seen = random_ends(cell, found.far, starts, samples, 2 * longest, seed)
        lost = 0
        for j in range(starts):
            last = [int(level) for level in seen[:, j]]
            lost += not any(turned(last[-len(name) :]) == name for name in names)
        samples *= 4
    return lost


def levels_of(cell: Cell, knob: GeneralKnob | SampledKnob, one: Attractor) -> tuple[int, ...]:
    """Readings of one period, simulated apart from the engine."""
    if one.outcome is not Outcome.REST:
        return turned(_replayed(cell, knob, one))
    if cell.scene.get("encoder") is None and isinstance(knob, SampledKnob):
        return (min(0, int(np.floor(one.x))),)
    return tuple(_replayed(cell, knob, one)[-1:])


def _replayed(cell: Cell, knob: GeneralKnob | SampledKnob, one: Attractor) -> list[int]:
    """Readings over the second of two periods: the first fills the line of commands under way."""
    if isinstance(knob, GeneralKnob):
        from hknob_cli.engine.general.controller import read
        from hknob_cli.engine.general.interval import advance

        z, ring, before, head, seen = [one.x, one.v, *one.state], list(one.line), one.before, 0, []
        for _ in range(one.period):
            shown = int(read(z[0], knob.wall))
            seen.append(shown if knob.wall.table is not None else min(0, shown))
            before, head = advance(z, before, ring, head, knob.body, knob.wall, [0.0] * (2 * knob.body.order))
        return seen
    state = np.array([[knob.angle_rad(one.x), one.v * knob.quantum_rad * cell.rate]])
    return [int(level) for level in readings(cell.scene, cell.rate, cell.counts, state, 0, one.period)[:, 0]]


def cells(family: str, count: int, seed: int) -> Iterator[Cell]:
    """Random cells of a family, each of its own seed."""
    for number in range(count):
        yield getattr(Draw(seed + number), family)()


def main() -> int:
    """Print what was found; 1 if an end was not listed."""
    about = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    about.add_argument("family", choices=FAMILIES)
    about.add_argument("--count", type=int, default=100)
    about.add_argument("--seconds", type=float, default=2.0)
    about.add_argument("--starts", type=int, default=200)
    about.add_argument("--samples", type=int, default=20_000)
    about.add_argument("--seed", type=int, default=1)
    given = about.parse_args()
    tally: Counter[str] = Counter()
    times, left, lost = [], [], []
    for number, cell in enumerate(cells(given.family, given.count, given.seed)):
        begun = time.process_time()
        found = search_cell(given.family, cell, given.seconds)
        times.append(time.process_time() - begun)
        search = found.search
        if search is None:
            tally["not followed"] += 1
        elif search.grows is not None or any(one.outcome is Outcome.DIVERGED for one in search.attractors):
            tally["grows"] += 1
        elif search.complete:
            tally["complete"] += 1
            off = unlisted(cell, found, given.starts, given.samples, given.seed + number)
            tally["simulated"] += off is not None
            if off:
                lost.append((number, off))
                print(f"scene {number}: {off} of {given.starts} starts end off the list", flush=True)
        else:
            tally[f"open: {search.why.name.lower()}"] += 1
            left.append((number, round(search.undecided, 4)))
    print(f"{given.family}: {given.count} scenes, seed {given.seed}, at most {given.seconds:g} s each: {dict(tally)}")
    print(f"processor time: median {np.median(times):.3f} s, largest {max(times):.2f} s")
    print(f"open, with the largest share without a proven end: {left}")
    print(f"{given.starts} random starts each; scenes with ends off the list: {lost or 'none'}")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
