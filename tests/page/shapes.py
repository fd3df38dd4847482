"""Small specs of every kind of result in every shape: no axis that varies, one, two, three; rest, and nothing else."""

from pathlib import Path

from hknob_cli.specs.load import load
from hknob_cli.stages.job import Job, work_of
from hknob_cli.stages.make import make

SCENE = "scene: {knob: {inertia: 1.9e-6}, hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}, WALL}\n".replace(
    "WALL", "wall: {stiffness: 0.27}, bias: {torque: 0.001}"
)
UNDAMPED = SCENE.replace(", damping: 3.45e-4, stiffness: 0.04", "")
RESTS = SCENE.replace("torque: 0.001", "torque: 0.0")
HALF = SCENE.replace("torque: 0.001", "half_quantum: true")
GRIDS = {
    "one cell": "grid: {sample_rate_hz: 1000, counts_per_rev: 1024}\n",
    "one axis": "grid: {sample_rate_hz: [500, 1000, 2000], counts_per_rev: 1024}\n",
    "two axes": "grid: {sample_rate_hz: [500, 1000], counts_per_rev: [512, 1024, 2048]}\n",
    "three axes": "grid: {sample_rate_hz: [500, 1000], counts_per_rev: [512, 1024], wall.stiffness: [0.2, 0.27]}\n",
    "four axes": (
        "grid: {sample_rate_hz: [500, 1000], counts_per_rev: [512, 1024, 2048], wall.stiffness: [0.2, 0.27],"
        " bias.torque: [0.001, 0.002]}\n"
    ),
}
UNCOUNTED = {
    name: grid.replace("counts_per_rev: 1024", "bias.torque: 0.001")
    .replace("counts_per_rev: [512, 1024, 2048]", "bias.torque: [0.001, 0.002]")
    .replace("counts_per_rev: [512, 1024]", "bias.torque: [0.001, 0.002]")
    for name, grid in GRIDS.items()
    if name != "four axes"
}
UNSAMPLED = {
    "one cell": "grid: {counts_per_rev: 1024}\n",
    "one axis": "grid: {counts_per_rev: [512, 1024]}\n",
    "two axes": "grid: {counts_per_rev: [512, 1024], wall.stiffness: [0.2, 0.27]}\n",
    "three axes": "grid: {counts_per_rev: [512, 1024], wall.stiffness: [0.2, 0.27], bias.torque: [0.001, 0.002]}\n",
}
DESIGNS = {
    "one axis": "grid: {design: {sobol: 8}, sample_rate_hz: {log: [500, 2000]}, counts_per_rev: 1024}\n",
    "two axes": "grid: {design: {sobol: 8}, sample_rate_hz: {log: [500, 2000]}, counts_per_rev: {log: [512, 2048]}}\n",
    "three axes": (
        "grid: {design: {sobol: 32}, sample_rate_hz: {log: [500, 2000]}, counts_per_rev: {log: [512, 2048]},"
        " wall.stiffness: {lin: [0.2, 0.3]}}\n"
    ),
}
STARTS = "starts: {angle: 0.02, phases: 4}\n"
PERCEIVE = "perceive: {knob_radius: 8.9 mm}\n"
TRIED = """\
kind: remedies
name: x
base:
  scene: {knob: {inertia: 19.8 g*cm^2}, wall: {stiffness: 0.27}, bias: {torque: 0.001}}
  GRID
  starts: {phases: 2}
hands:
  light: {table: 1, grip_n: 0.71}
  firm: {inertia: 3.0e-7, damping: 1.0e-3, stiffness: 0.1}
remedies:
  plain wall: {}
  bounded lag:
    change: {scene: {controller: {kind: bounded_lag, keep: 0.15, time_constant: 0.05}}}
    needs: a running mean
"""
CASES = """\
cases:
  coarse: {sample_rate_hz: 1000, counts_per_rev: 360}
  fine: {sample_rate_hz: 2000, counts_per_rev: 1024}
"""
SOUGHT = """\
kind: design
name: x
base:
  scene: {knob: {inertia: 19.8 g*cm^2}, wall: {stiffness: 0.27}, bias: {torque: 0.001}}
  starts: {phases: 2}
people: [{table: 1, grip_n: 0.71}, {table: 2, grip_n: 2.4}]
perceive: {knob_radius: 8.9 mm, extrapolate: true}
choices:
CHOICES
present: {sample_rate_hz: 1000, counts_per_rev: 1440}
remedies:
  plain wall: {}
  bounded lag: {cost: 0.25, change: {scene: {controller: {kind: bounded_lag, keep: 0.15, time_constant: 0.02}}}}
constraints: {stiffness: {at_least: 0.26}, touch: {above_present: 0}}
"""
_RATES = "  sample_rate_hz: [{value: 500}, {value: 1000, cost: 0.5}]\n"
_ONE_RATE = "  sample_rate_hz: [{value: 1000, cost: 0.5}]\n"
_COUNTS = "  counts_per_rev: [{value: 360}, {value: 1440, cost: 2, label: geared}]\n"
_ONE_COUNT = "  counts_per_rev: [{value: 1440, cost: 2}]\n"
_DAMPING = "  knob.damping: [{value: 0}, {value: 5.0e-4, cost: 1}]\n"
CHOICES = {
    "one cell": _ONE_RATE + _ONE_COUNT,
    "one axis": _RATES + _ONE_COUNT,
    "two axes": _RATES + _COUNTS,
    "three axes": _RATES + _COUNTS + _DAMPING,
}
IDEAL = "rig: {coulomb_nm: 0.0, amplifier_s: 0.0}"
SYSID = {
    "one condition": f"virtual: {{experiments: [1], subjects: 1, blocks: 1, trials: 2, grips: [0.71], {IDEAL}}}\n",
    "people": f"virtual: {{experiments: [1], subjects: 2, blocks: 2, trials: 2, grips: [0.71, 14.2], {IDEAL}}}\n",
    "experiments": f"virtual: {{experiments: [1, 2], subjects: 2, blocks: 1, trials: 1, grips: [0.71], {IDEAL}}}\n",
    "fourth order": (
        f"virtual: {{experiments: [1], subjects: 1, blocks: 1, trials: 2, grips: [14.2], model: fourth, {IDEAL}}}\n"
        "estimators: [output_error, fourth_order]\n"
    ),
    "apparatus": (
        "what: apparatus\nvirtual: {trials: 1}\nestimators: [least_squares, output_error_friction]\n"
        "settling_time_constant: 50 us\n"
    ),
    "motor": "what: motor\nvirtual: {}\n",
    "grip cell": "what: grip_cell\nvirtual: {}\n",
    "bias": "study: {bias: {repeats: 2, grips: [14.2], nuisances: {noise_rad: [0.0, 1.0e-3], decimation: [1, 10]}}}\n",
    "hidden inertia": "study: {hidden_inertia: {ratios: [1, 10, 100]}}\n",
    "both studies": "study: {bias: {repeats: 2, nuisances: {lag_s: [0.0, 5.0e-5]}}, hidden_inertia: {ratios: [10]}}\n",
}
BENCH = """\
kind: bench
name: x
base:
  scene: {knob: {inertia: 1.9e-6}, wall: {stiffness: 0.27}, bias: {torque: 0.001}, HAND}
  sample_rate_hz: 1000
  counts_per_rev: 1024
  starts: {angle: 0.005}
  duration: 0.02
scenes: {nominal: {}}
methods: [exact, rk23, euler]
settings: {tolerances: [1.0e-9], substeps: [1]}
""".replace("HAND", "hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}")
CAMPAIGN = """\
kind: hw-run
name: x
grid: {GRID}
trial: {zero: 0.05, settle: 0.05, buzz: [0.1, 0.2], longest: 2}
person: {wandering_push: false, grip_wander: false}
"""
REMEDIES = """\
remedies:
  plain wall: {}
  bounded lag: {change: {controller: {kind: bounded_lag, keep: 0.15, time_constant: 0.2}}, needs: a running mean}
"""
CAMPAIGNS = {
    "one cell": "sample_rate_hz: [1000], counts_per_rev: [256]",
    "one axis": "sample_rate_hz: [1000, 2000], counts_per_rev: [256]",
    "two axes": "sample_rate_hz: [1000, 2000], counts_per_rev: [256, 512]",
    "many rates": "sample_rate_hz: [800, 900, 1000, 1200, 1500, 2000, 3000], counts_per_rev: [256]",
}


def _sweep(rest: str) -> str:
    return f"kind: sweep\nname: x\n{rest}"


def _all() -> dict[str, str]:
    """Specs by what they are of; those that are compared with a sweep say ``against: AGAINST``."""
    found = {f"sweep, {shape}": _sweep(SCENE + grid + STARTS) for shape, grid in GRIDS.items()}
    for shape, grid in GRIDS.items():
        still = grid.replace("0.001", "0.0").replace("0.002", "0.0001")
        found[f"sweep at rest, {shape}"] = _sweep(RESTS + still + STARTS)
    for shape in ("one cell", "one axis", "two axes", "three axes"):
        grid = GRIDS[shape]
        found[f"sweep with perceive, {shape}"] = _sweep(SCENE + grid + STARTS + PERCEIVE)
        found[f"sweep of people, {shape}"] = _sweep(
            SCENE.replace("hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}, ", "")
            + "population: {table: 1, grip_n: 0.71, people: 3, seed: 1}\n" + grid + STARTS
        )  # fmt: skip
        found[f"sweep with record, {shape}"] = _sweep(SCENE + grid + STARTS + "record: {duration: 0.02}\n")
        found[f"sweep of growth, {shape}"] = _sweep(UNDAMPED + grid + STARTS + "growth: {duration: 0.3}\n")
        found[f"sweep with a controller, {shape}"] = _sweep(
            SCENE.replace("scene: {", "scene: {controller: {kind: half_sample}, ") + grid + STARTS
        )
        found[f"sweep of a continuous sensor, {shape}"] = _sweep(
            SCENE.replace("scene: {", "scene: {encoder: none, ") + UNCOUNTED[shape] + STARTS
        )
        found[f"sweep without a clock, {shape}"] = _sweep(
            SCENE.replace("scene: {", "scene: {sampling: continuous, ") + UNSAMPLED[shape] + "starts: {angle: 0.02}\n"
        )
    for shape, grid in DESIGNS.items():
        found[f"sweep of a design, {shape}"] = _sweep(SCENE + grid + STARTS)
    for shape in ("one cell", "one axis", "two axes", "three axes", "four axes"):
        for kind, scene in (("dfa", HALF), ("predict", SCENE)):
            spec = f"kind: {kind}\nname: x\n{scene}{GRIDS[shape]}"
            if kind == "dfa" and shape == "four axes":
                spec = spec.replace("half_quantum: true", "torque: 0.001")
            spec += "methods: [df1, df4, tsypkin, sampled]\n" if kind == "dfa" else ""
            found[f"{kind}, {shape}"] = spec
            found[f"{kind} against a sweep, {shape}"] = spec + "against: AGAINST\n"
    for shape in ("one cell", "one axis", "two axes", "three axes"):
        tried = TRIED.replace("GRID", GRIDS[shape].strip().replace("wall.stiffness", "knob.inertia"))
        tried = tried.replace("[0.2, 0.27]", "[1.9e-6, 4.0e-6]")
        found[f"remedies, {shape}"] = tried
        found[f"remedies with cases, {shape}"] = tried + CASES
        found[f"design, {shape}"] = SOUGHT.replace("CHOICES\n", CHOICES[shape])
    found["remedies with perceive"] = TRIED.replace("GRID", GRIDS["one axis"].strip()) + PERCEIVE
    found["remedies with cases and perceive"] = TRIED.replace("GRID", GRIDS["one axis"].strip()) + CASES + PERCEIVE
    found |= {f"sysid, {sort}": f"kind: sysid\nname: x\n{text}" for sort, text in SYSID.items()}
    found |= {f"hw-run, {shape}": CAMPAIGN.replace("GRID", grid) for shape, grid in CAMPAIGNS.items()}
    for shape, grid in CAMPAIGNS.items():
        found[f"hw-run of remedies, {shape}"] = CAMPAIGN.replace("GRID", grid) + REMEDIES
    found["bench"] = BENCH
    return found


SHAPES = _all()


def against_of(name: str) -> str:
    """The spec of the sweep that one of `SHAPES` is compared with; empty where it is not."""
    if "against" not in SHAPES[name]:
        return ""
    half = name.startswith("dfa") and not name.endswith("four axes")
    return _sweep((HALF if half else SCENE) + GRIDS[name.rpartition(", ")[2]] + STARTS)


def make_result(name: str, root: Path) -> Path:
    """Run one of `SHAPES` as its stage does, and return the folder of its results."""
    text = SHAPES[name]
    if other := against_of(name):
        text = text.replace("AGAINST", str(_run(other, root / "against")))
    return _run(text, root / "result")


def make_report(folders: dict[str, Path], root: Path) -> Path:
    """The page of a report that lists nothing but results."""
    listed = "".join(f"  {name}: {folder}\n" for name, folder in folders.items())
    return _run(f"kind: report\nname: page\ntitle: A page\nresults:\n{listed}", root / "report") / "report.html"


def _run(text: str, folder: Path) -> Path:
    folder.mkdir(parents=True)
    path = folder / "spec.yaml"
    path.write_text(text)
    plan = load(path)
    kind = text.split()[1]
    make(Job(kind, plan, folder / "out", quiet=True, unattended=True), work_of(kind))
    return folder / "out"
