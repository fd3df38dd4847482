"""Random sampled scenes with three parts or more each, against the 60-digit model: one count of all that composes.

    python tests/verification/random_scenes.py --count 500

Parts are drawn by their names in the table of what goes with what (`specs.capabilities`); a scene that the table
refuses is drawn anew. One trial of each scene is followed by the engine and by the model (`general_reference`, and
`law_reference` under a controller), from the same start. Compared are

- the trial: every one of the first samples,
- the outcome: what the trial settles to, if the model settles in time,
- each proven cycle: derived again at 60 digits, within the bound that it was given,
- energy: the torque's work over a cycle is what dampers and friction take, to 1e-9.

A trial is compared as far as no sample comes so near to an edge that rounding may decide. With a continuous sensor,
whose torque follows every rounding, beside cogging, and where teeth part, it is compared as far as these do not grow.
``--bare`` draws scenes that all have a continuous sensor, and torque over the angle, cogging, play or jitter beside it.
The exit code is 1 if anything disagrees; such a scene is printed with its number, which ``--only`` runs again.
"""

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.errors import SpecError
from hknob_cli.measure.general_orbit import GeneralMeasurer, LawMeasurer
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.bench import merged
from hknob_cli.specs.capabilities import TRIALS, engine_of, parts_of
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.specs.source import Source
from tests import digits as mp
from tests.controllers.laws import CONTROLLERS, EVERY, LOOP_ONLY
from tests.specs.small_cells import CHANGES
from tests.verification import general_reference as reference
from tests.verification.general_orbits import measure, solve
from tests.verification.general_scenes import GRASP, KNOB, TWO_PARTS
from tests.verification.law_reference import simulate_law
from tests.verification.law_scenes import FOR_EVER, Drawn
from tests.verification.test_general_orbits import Found, positions
from tests.verification.test_jitter import intervals
from tests.verification.test_laws_in_the_general_loop import check_orbit
from tests.verification.test_over_angle import random_part

NAMES = [*sorted(CONTROLLERS), *sorted(LOOP_ONLY)]
LEAST_PARTS = 3
ANGLE, VELOCITY, PHASE = 0.02, -0.5, 0.5  # rad, rad/s, of a sample: where trials start
COMPARED = 60  # samples of a trial that are compared one by one
SETTLED = 500  # samples by which the model should have settled, to compare what it settles to
UNPROVEN = (Reason.PARTS, Reason.COGS, Reason.PARTS_OR_COGS)  # cycles that attract to first order
THROUGH_PLAY = 80  # of a motion whose teeth may part, or beside cogging
BEFORE_CHAOS = 30  # samples that are compared of it: neighbours part tenfold in 10 to 29 ms, and so do roundings
LONGEST = 40  # samples of a period that is derived again, for the time that 60 digits take
CLEAR = 1e-6  # counts from an edge within which rounding may decide, far beyond the roundings of so many samples
STUCK = 1e-9  # from the friction, relatively, within which rounding decides whether a knob sticks
WITHIN = 1e-9  # of a position, by the largest and a count
NUDGE = 2.0**-46  # of a state: 128 roundings
STILL = 1e-3  # counts by which a trial that has nearly settled still moves; what is left is at most `LEFT` times that
LEFT = 30.0
BALANCE = 1e-9
LONGEST_S = 15.0  # of a trial: some teeth bounce in steps too small to end
ROUNDINGS = 16.0 * 2.0**-53
Scene = dict[str, Any]

# Parts that are not drawn, with the reason.
NOT_DRAWN = {
    "gear": "a rigid one is a heavier knob with more counts; one that yields is drawn",
    **dict.fromkeys(("grip", "people", "squeeze"), "they become the numbers of a hand"),
    "unsampled": "the model has a sample clock",
    "jitter": "no motion repeats; `jittered` adds it to a scene that is drawn",
    "undamped": "no cycle of it is proven",
    **dict.fromkeys(("hand", "hand_damping", "hand_stiffness", "bias"), "every scene has them unless it draws others"),
    **dict.fromkeys(
        ("speed_sensor", "estimated_speed", "kalman", "several_readings", "pulses", "knob_model", "by_counts"),
        "they come with the controller that is drawn",
    ),
}


class Case(NamedTuple):
    """A random scene: its number, parts, sample rate and counts of a revolution (None: a continuous sensor)."""

    number: int
    parts: tuple[str, ...]
    scene: Scene
    rate_hz: float
    counts: int | None

    def __str__(self) -> str:
        """Enough to find it again."""
        return f"scene {self.number}: {', '.join(self.parts)}; {self.rate_hz:g} Hz x {self.counts}: {self.scene}"


def log_uniform(chance: Random, low: float, high: float) -> float:
    """Evenly spread powers of ten."""
    return float(10.0 ** chance.uniform(low, high))


def in_part(name: str, key: str, draw: Callable[[Random], Any]) -> Callable[[Random, Scene], None]:
    """What gives a scene a number of one of its parts."""

    def add(chance: Random, scene: Scene) -> None:
        scene[name] = {**scene.get(name, {}), key: draw(chance)}

    return add


def _motor(**more: Any) -> Callable[[Random, Scene], None]:
    def add(chance: Random, scene: Scene) -> None:
        plain = {"torque_constant": chance.uniform(0.01, 0.03), "resistance": chance.uniform(1.0, 5.0)}
        drawn = {name: value(chance) if callable(value) else value for name, value in more.items()}
        scene["motor"] = {**scene.get("motor", {"winding": "shorted", **plain}), **drawn}

    return add


def _controller(chance: Random, scene: Scene) -> None:
    scene["controller"] = dict(EVERY[chance.choice(NAMES)])
    if scene["wall"]["stiffness"] == 0.0:
        scene["controller"]["everywhere"] = True


def _over_angle(name: str) -> Callable[[Random, Scene], None]:
    def add(chance: Random, scene: Scene) -> None:
        made: Scene = {}
        while name not in made:
            made = random_part(chance)
        scene[name] = made[name]
        if chance.random() < 0.3 and "controller" not in scene:
            scene["wall"] = {"stiffness": 0.0}

    return add


def _hand(chance: Random) -> Scene:
    """A hand, light or firm."""
    grip = chance.random()
    return {"inertia": 1e-7 + 5e-7 * grip, "damping": 1e-4 + 1.1e-3 * grip, "stiffness": 0.005 + 0.3 * grip}


def _no_hand(chance: Random, scene: Scene) -> None:
    del scene["hand"]
    scene["knob"]["damping"] = log_uniform(chance, -4.3, -3.3)


def _gear(chance: Random, scene: Scene) -> None:
    """One that yields, its motor's friction that of the knob."""
    scene["gear"] = {
        "ratio": chance.choice([2.5, 7.4]),
        "motor_inertia": 10.0 ** chance.uniform(-9.0, -7.5),
        "stiffness": chance.choice([1.0, 5.0, 50.0]),
        "mesh_damping": chance.choice([1e-4, 2e-3, 1e-2]),
    }


def _play(chance: Random, scene: Scene) -> None:
    if "gear" not in scene:
        _gear(chance, scene)
    scene["gear"]["backlash"] = chance.choice([3e-4, 2e-3, 5e-3, 2e-2])


def _friction(chance: Random, scene: Scene) -> None:
    level = log_uniform(chance, -5.5, -3.0)
    if "gear" in scene:
        scene["gear"]["motor_coulomb_torque"] = level / scene["gear"]["ratio"]
    else:
        scene["knob"]["coulomb_torque"] = level


def _cogging(chance: Random, scene: Scene) -> None:
    scene["cogging"] = {
        "torque": log_uniform(chance, -4.0, -2.0) / (scene["gear"]["ratio"] if "gear" in scene else 1.0),
        "per_revolution": chance.choice([24, 42, 84, 132]),
        "centre": chance.uniform(-0.1, 0.1),
    }


def _as_in_its_small_cell(change: Scene) -> Callable[[Random, Scene], None]:
    """What gives a scene the change of a small cell, its numbers up to three times larger or smaller."""

    def varied(value: Any, chance: Random) -> Any:
        if isinstance(value, dict):
            return {key: varied(one, chance) for key, one in value.items()}
        return value * log_uniform(chance, -0.5, 0.5) if isinstance(value, float) else value

    def add(chance: Random, scene: Scene) -> None:
        scene.update(merged(scene, varied(change, chance)))

    return add


MAKERS: dict[str, Callable[[Random, Scene], None]] = {
    "mesh": _gear,
    "play": _play,
    "friction": _friction,
    "cogging": _cogging,
    "knob_damping": in_part("knob", "damping", lambda chance: log_uniform(chance, -6.0, -4.5)),
    "handless": _no_hand,
    "unheld": lambda _, scene: scene.update(hand={"inertia": 3.0e-7, "damping": 3.0e-4, "stiffness": 0.0}),
    "finger": lambda _, scene: scene.update(hand=dict(TWO_PARTS)),
    "unpushed": lambda _, scene: scene.update(bias={"torque": 0.0}),
    "virtual_damping": in_part("wall", "damping", lambda chance: log_uniform(chance, -6.0, -4.7)),
    "delay": in_part("actuator", "delay_samples", lambda chance: chance.choice([0.3, 0.5, 1.0, 1.4, 2.0])),
    "lag": in_part("actuator", "time_constant", lambda chance: log_uniform(chance, -4.5, -3.3)),
    "torque_limit": in_part("actuator", "torque_limit", lambda chance: chance.uniform(0.0015, 0.006)),
    "torque_step": in_part("actuator", "torque_step", lambda chance: log_uniform(chance, -5.0, -3.7)),
    "dead_band": in_part("actuator", "dead_band", lambda chance: chance.uniform(2e-4, 3e-3)),
    "rounding": in_part("encoder", "rounding", lambda chance: chance.choice(["nearest", "ceil", "truncate"])),
    "offset": in_part("encoder", "offset_counts", lambda chance: chance.uniform(0.0, 0.99)),
    "hysteresis": in_part("encoder", "hysteresis_counts", lambda chance: chance.uniform(0.02, 1.5)),
    "backlash": in_part("encoder", "backlash", lambda chance: log_uniform(chance, -4.0, -2.3)),
    "bare": lambda _, scene: scene.update(encoder="none"),
    "motor": _motor(),
    "coil": _motor(inductance=lambda chance: log_uniform(chance, -4.5, -3.3)),
    "current_loop": _motor(winding="current", bandwidth=lambda chance: chance.uniform(300.0, 3000.0)),
    "supply": _motor(winding="voltage", supply_voltage=lambda chance: chance.uniform(0.2, 1.0)),
    "eddy_brake": lambda chance, scene: scene.update(
        eddy_brake={
            **{"conductivity": 5.8e7, "thickness": 1e-3, "area": 1e-4, "radius": 0.02, "share": 0.5},
            "flux_density": chance.uniform(0.05, 0.3),
        }
    ),
    "profile": _over_angle("profile"),
    "detents": _over_angle("detents"),
    "end_stops": _over_angle("end_stops"),
    "dead_zone": _over_angle("dead_zone"),
    "controller": _controller,
}
# Any other part as its small cell has it, more of it or less.
MAKERS |= {
    part: _as_in_its_small_cell(change["scene"])
    for part, change in CHANGES.items()
    if part not in (*MAKERS, *NOT_DRAWN)
}


RARE = ("unheld", "handless")  # what nothing holds seldom comes to an end that is proven


def draw(number: int) -> Case:
    """The scene of a number: three to seven parts, among them a controller in two of three."""
    chance = Random(f"composed {number}")
    while True:
        names = {"controller"} if chance.random() < 2.0 / 3.0 else set()
        rare = [name for name in RARE if chance.random() < 0.75]
        names |= set(
            chance.sample([name for name in MAKERS if name not in ("controller", *rare)], chance.randint(2, 6))
        )
        scene: Scene = {
            "knob": {"inertia": KNOB["inertia"]},
            "hand": dict(GRASP) if chance.random() < 0.4 else _hand(chance),
            "wall": {"stiffness": 0.27},
            "bias": {"half_quantum": True} if chance.random() < 0.3 else {"torque": 0.001},
        }
        for name in MAKERS:  # in the order of the table, so that a number names one scene
            if name in names and not (name in ("hysteresis", "backlash", "bare", "offset") and _bare(scene)):
                MAKERS[name](chance, scene)
        rate, counts = chance.choice([464.0, 1000.0, 2154.0]), chance.choice([256, 512, 1024, 2048])
        one = Case(number, tuple(sorted(names)), scene, rate, None if _bare(scene) else counts)
        if is_taken(one):
            return one


def jittered(number: int) -> Case | None:
    """The scene of a number with a clock that jitters, and a delay of whole samples; None where that is refused."""
    one, chance = draw(number), Random(f"clock {number}")
    clock = {"jitter": chance.choice([0.02, 0.1, 0.33, 0.9]), "seed": chance.randrange(2**31 - 1)}
    scene = {**one.scene, "clock": clock}
    if (scene.get("actuator") or {}).get("delay_samples"):
        scene["actuator"] = {**scene["actuator"], "delay_samples": float(chance.choice([1, 2]))}
    found = one._replace(parts=(*one.parts, "jitter"), scene=scene)
    return found if is_taken(found) else None


BESIDE_BARE = ("profile", "detents", "end_stops", "dead_zone", "cogging", "play", "jitter")


def bared(number: int) -> Case:
    """The scene of a number with a continuous sensor, and one or two parts that need no counts."""
    chance = Random(f"bare {number}")
    while True:
        beside = {BESIDE_BARE[number % len(BESIDE_BARE)], *chance.sample(BESIDE_BARE, chance.choice([0, 0, 1]))}
        one = draw(chance.randrange(2**31))
        scene = {**one.scene, "encoder": "none"}
        if "half_quantum" in scene["bias"]:
            scene["bias"] = {"torque": 0.001}
        for name in MAKERS:
            if name in beside:
                MAKERS[name](chance, scene)
        if "jitter" in beside:
            scene["clock"] = {"jitter": chance.choice([0.02, 0.1, 0.33, 0.9]), "seed": chance.randrange(2**31 - 1)}
            if (scene.get("actuator") or {}).get("delay_samples"):
                scene["actuator"] = {**scene["actuator"], "delay_samples": float(chance.choice([1, 2]))}
        lost = {"rounding", "offset", "hysteresis", "backlash"}
        parts = tuple(sorted({*one.parts, "bare", *beside} - lost))
        found = Case(number, parts, scene, one.rate_hz, None)
        if is_taken(found):
            return found


def _bare(scene: Scene) -> bool:
    return scene.get("encoder") == "none"


def is_taken(one: Case) -> bool:
    """Whether the table takes the scene, and it has at least three of the parts that were drawn."""
    source = Source("spec.yaml")
    grid: dict[str, Any] = {"sample_rate_hz": [one.rate_hz]}
    if one.counts is not None:
        grid["counts_per_rev"] = [one.counts]
    start = {"angle": ANGLE, "velocity": VELOCITY, "phases": 1}
    source.value = {"kind": "sweep", "name": "one", "scene": one.scene, "grid": grid, "starts": start}
    try:
        plan = validate(source)
    except SpecError:
        return False
    assert isinstance(plan, SweepPlan)
    return len(set(one.parts) & parts_of(plan.scene)) >= LEAST_PARTS


class Followed(NamedTuple):
    """What the package makes of a scene: its engine's trial, and what that settles to."""

    knob: GeneralKnob
    engine: GeneralEngine
    end: Attractor
    made: Any  # the cell under a controller, or None
    samples: np.ndarray  # positions at samples, counts (at most COMPARED)


def follow(one: Case, *, in_code: bool = True) -> Followed:
    """Search from the start, with one phase, and run the trial once more to see its samples.

    ``in_code``: by a compiled engine.
    """
    plain = reduced(SceneSpec.model_validate(one.scene).plain())
    made = None
    engine: GeneralEngine
    if engine_of(plain, TRIALS) == "laws":
        made = make_law(plain, sample_rate_hz=one.rate_hz, counts_per_rev=one.counts)
        engine = LawEngine(made.law, compiled("laws") if in_code else None, patience=FOR_EVER)
        knob, rate, line = made.knob, made.rate, engine.past_length
    else:
        knob = sample_general(plain, sample_rate_hz=one.rate_hz, counts_per_rev=one.counts)
        engine = GeneralEngine(compiled("general") if in_code else None, patience=FOR_EVER)
        rate, line = knob.rate, knob.delay_line
    start = knob.start(ANGLE, VELOCITY)
    samples = np.array(list(islice(trial(knob, made, start), COMPARED)))
    if knob.wall.analog > 0.0 or samples_of(one) == THROUGH_PLAY:
        other = np.array(list(islice(trial(knob, made, start, nudge=NUDGE), COMPARED)))
        grown = np.abs(other - samples) > WITHIN * (1.0 + np.abs(samples).max())
        samples = samples[: int(np.argmax(grown)) if grown.any() else COMPARED]
    found = engine.search(  # last, for what runs out of time stays halted
        knob.body, knob.wall, start, rate=rate, phases=1, delay_line=line, max_samples=2**15, seconds=LONGEST_S
    )
    (end,) = found.attractors
    return Followed(knob, engine, end, made, samples)


def trial(knob: GeneralKnob, made: Any, start: list[float], nudge: float = 0.0) -> Iterator[float]:
    """Positions at the samples of a trial by the package, interpreted; ``nudge``: relative, of the state at each."""
    from hknob_cli.engine.general.advance import advance_span
    from hknob_cli.engine.general.controller import read
    from hknob_cli.engine.general.interval import advance, advance_jittering, begin_clock
    from hknob_cli.engine.general.laws.step import advance_jittering_with_law, advance_with_law, begin_past
    from hknob_cli.engine.general.search import as_list

    wall, pad, z = as_list(knob.wall), [0.0] * (2 * knob.body.order), list(start)
    jitters = wall.clock is not None
    plainly, with_law = (advance_jittering, advance_jittering_with_law) if jitters else (advance, advance_with_law)
    advance_span(z, 0.0, PHASE, knob.body, pad)
    begin_clock(wall.clock, 0.0)
    if made is None:
        before, head, ring = read(z[0], wall), 0, [0.0] * knob.delay_line
        while True:
            yield z[0]
            before, head = plainly(z, before, ring, head, knob.body, wall, pad)
            z[:2] = [value * (1.0 + nudge) for value in z[:2]]
    past = [0.0] * len(made.law.beside)
    begin_past(past, read(z[0], wall), made.law)
    while True:
        yield z[0]
        with_law(z, past, knob.body, wall, made.law, pad)
        z[:2] = [value * (1.0 + nudge) for value in z[:2]]


def model(one: Case) -> Iterator[tuple[Any, float]]:
    """Angles at the samples of the model's trial [rad], and how clear of every edge it has stayed [counts]."""
    clock, phase, lengths = one.scene.get("clock"), mp.mpf(PHASE), None
    if clock:
        phase, lengths = phase * (1 + mp.mpf(clock["jitter"])), intervals(clock["jitter"], clock["seed"], 0)
    if "controller" in one.scene:
        for theta, _, clear in simulate_law(
            one.scene, one.rate_hz, one.counts, angle=ANGLE, velocity=VELOCITY, phase=phase, intervals=lengths
        ):
            yield theta, clear
        return
    run = reference.simulate(
        one.scene,
        sample_rate_hz=one.rate_hz,
        counts_per_rev=one.counts,
        angle_rad=ANGLE,
        velocity_rad_s=VELOCITY,
        phase=phase,
        samples=samples_of(one),
        intervals=list(islice(lengths, samples_of(one))) if lengths else None,
    )
    quantum = float(run.control.quantum or 1)
    command = float(run.control.stiffness or 1) * quantum
    clear = min(run.edge / quantum, run.step / command)
    if run.friction.bodies.friction and run.friction.closest < STUCK:
        clear = 0.0
    for sample in run.samples:
        yield sample.angle, clear


def ratio_of(one: Case) -> Any:
    """Of a gear."""
    return mp.mpf((one.scene.get("gear") or {}).get("ratio", 1))


def samples_of(one: Case) -> int:
    """How long the model runs; teeth that part, and cogging, are followed in steps, each of them a series."""
    stepped = "cogging" in one.scene or (one.scene.get("gear") or {}).get("backlash")
    return THROUGH_PLAY if stepped else SETTLED


class Verdict(NamedTuple):
    """What was compared of a scene: outcome of the package, samples, whether the outcome, and proven cycles."""

    outcome: str
    samples: int
    settled: bool
    cycles: int
    largest: float  # error of a position of a proven cycle, over the bound that it was given


def compare(one: Case, *, in_code: bool = True) -> Verdict:
    """Compare a scene, compiled or not. Raises `AssertionError` where package and model disagree."""
    found = follow(one, in_code=in_code)
    unit = 2 * mp.pi / one.counts / ratio_of(one) if one.counts else mp.mpf(found.knob.quantum_rad)
    shift = mp.mpf(found.knob.shift)
    size = 1.0 + float(np.abs(found.samples).max())
    seen: list[float] = []
    clear = float("inf")
    for i, (theta, gap) in enumerate(islice(model(one), samples_of(one))):
        clear = gap
        if clear < CLEAR:
            break
        x = theta / unit - shift
        if i < min(len(found.samples), BEFORE_CHAOS if samples_of(one) == THROUGH_PLAY else COMPARED):
            off = float(abs(x - mp.mpf(float(found.samples[i])))) / size
            assert off <= WITHIN, f"sample {i} is {off:.3g} off: {one}"
        seen.append(float(x))
    settled = clear >= CLEAR and same_outcome(found, np.array(seen), one)
    cycles, largest = 0, 0.0
    end = found.end
    known = found.made is not None or not found.knob.wall.hysteresis  # `solve` has no turning points
    if end.outcome is Outcome.CYCLE and end.certified and end.period <= LONGEST and known:
        largest = derive(one, found)
        cycles = 1
    if end.outcome is Outcome.CYCLE and (end.certified or end.reason in UNPROVEN):
        audit(one, found)
    label = f"{end.outcome.name.lower()}{'' if end.certified else ', not proven'}"
    return Verdict(label, min(len(seen), len(found.samples)), settled, cycles, largest)


def same_outcome(found: Followed, seen: np.ndarray, one: Case) -> bool:
    """Whether the model has settled by its last samples; what it then does is what the package says."""
    end, period = found.end, found.end.period
    sure = end.certified or (found.made is not None and found.knob.wall.analog > 0.0)
    if end.outcome is Outcome.REST and sure:
        low, high = end.span or (end.x, end.x)
        moves = float(np.ptp(seen[-16:]))
        if moves > STILL:
            return False
        near = LEFT * moves + CLEAR
        assert low - near <= seen[-1] <= high + near, f"rests at {seen[-1]}, not {low} to {high}: {one}"
        return True
    if end.outcome is Outcome.CYCLE and sure and 2 * period < len(seen):
        last, before = seen[-period:], seen[-2 * period : -period]
        moves = float(np.abs(last - before).max())
        if moves > STILL:
            return False
        # The trial may be in another of the shifts of the same orbit: its deepest sample is the orbit's first.
        at = int(np.argmin(last))
        off = abs(float(last[at]) - end.x)
        assert off <= LEFT * moves + CLEAR, f"the deepest sample is {last[at]}, not {end.x}: {one}"
        return True
    return end.outcome is Outcome.DIVERGED and abs(seen[-1]) > 10.0 * abs(seen[0])


def derive(one: Case, found: Followed) -> float:
    """Derive a proven cycle again at 60 digits: its largest error over the bound it was given."""
    end, knob = found.end, found.knob
    if found.made is not None:
        assert one.counts
        assert isinstance(found.engine, LawEngine)
        drawn = Drawn("", one.parts, one.scene, one.rate_hz, one.counts)
        return check_orbit(drawn, found.made, end)[1]
    solved = solve(one.scene, one.rate_hz, one.counts, knob, end)
    assert solved.closes, f"does not close: {one}"
    unit = solved.control.quantum or mp.mpf(knob.quantum_rad)
    exact = [z[0] / unit - mp.mpf(knob.shift) for z in solved.run.states]
    measured = GeneralMeasurer(knob, found.engine).measure(end)
    seen = positions(Found(one.scene, one.rate_hz, one.counts, knob, end, measured), in_code=found.engine.compiled)
    worst = 0.0
    for x, y in zip(seen, exact, strict=True):
        off = float(abs(mp.mpf(float(x)) - y))
        allowed = end.bound + ROUNDINGS * end.period * float(np.ptp(seen) + np.abs(seen).max())
        assert off <= allowed, f"{off:.3g} counts off, bound {end.bound:.3g}: {one}"
        worst = max(worst, off / end.bound)
        if one.counts is not None:
            same = solved.control.measured((mp.mpf(float(x)) + mp.mpf(knob.shift)) * unit)
            assert same == solved.control.measured((y + mp.mpf(knob.shift)) * unit), one
    if solved.run.corners:
        return worst
    expected = measure(solved)
    # Of a winding that a voltage drives the model has one current; the package splits it by voltage and speed.
    energies = () if solved.bodies.driven else ("wall_work_j", "damping_loss_j")
    for name in ("p2p_rad", "min_rad", "max_rad", "rms_rad", "frequency_hz", *energies):
        scale = float(expected["wall_work_j"] if name.endswith("_j") else abs(expected[name]))
        assert float(abs(getattr(measured, name) - expected[name])) <= WITHIN * scale, f"{name}: {one}"
    return worst


def audit(one: Case, found: Followed) -> None:
    """The torque's work over a proven cycle is what dampers and friction take.

    A small cycle far from the neutral angle has the rounding of its angles, times the torque that holds it there.
    """
    if found.made is not None:
        measured = LawMeasurer(found.knob, found.engine).measure(found.end)
    else:
        measured = GeneralMeasurer(found.knob, found.engine).measure(found.end)
    lost = measured.damping_loss_j + (measured.friction_loss_j if found.knob.body.friction > 0.0 else 0.0)
    if not np.isfinite(lost):
        return
    hand = one.scene.get("hand") or {}
    stiffness = (hand.get("finger") or hand).get("stiffness", 0.0)
    far = max(abs(measured.min_rad), abs(measured.max_rad))
    rounding = ROUNDINGS * found.end.period * stiffness * far * far
    assert abs(measured.wall_work_j - lost) <= BALANCE * abs(lost) + rounding, (
        f"{measured.wall_work_j} J, {lost} J lost: {one}"
    )


def main() -> int:
    """Run the campaign and print its counts."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--count", type=int, default=500, help="scenes")
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--only", type=int, nargs="+", help="numbers of scenes")
    parser.add_argument("--jitter", action="store_true", help="with a sample clock that jitters, where it is taken")
    parser.add_argument("--bare", action="store_true", help="with a continuous sensor, and what needs no counts")
    parser.add_argument("--every", type=int, default=50, help="scenes after which a line is printed")
    args = parser.parse_args()
    numbers = args.only or range(args.first, args.first + args.count)
    outcomes: Counter[str] = Counter()
    parts: Counter[str] = Counter()
    totals = np.zeros(4)
    bad, largest, begin = 0, 0.0, time.perf_counter()
    for done, number in enumerate(numbers, 1):
        one = bared(number) if args.bare else jittered(number) if args.jitter else draw(number)
        if one is None:
            outcomes["refused beside jitter"] += 1
            continue
        parts.update(one.parts)
        try:
            found = compare(one)
        except AssertionError as error:
            bad += 1
            print(f"DISAGREES {number}: {error}", flush=True)
            continue
        except reference.NotHandledError:
            outcomes["not handled by the model"] += 1
            continue
        outcomes[found.outcome] += 1
        totals += np.array([found.samples > 0, found.samples, found.settled, found.cycles])
        largest = max(largest, found.largest)
        if done % args.every == 0 or done == len(numbers):
            compared, samples, settled, cycles = (int(total) for total in totals)
            print(
                f"{done} scenes, {time.perf_counter() - begin:.0f} s: {compared} trials compared ({samples} samples), "
                f"{settled} outcomes the same, {cycles} cycles derived again (largest error {largest:.2g} of the "
                f"bound), {bad} disagree",
                flush=True,
            )
    print(f"outcomes: {dict(outcomes.most_common())}")
    print(f"parts: {dict(parts.most_common())}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
