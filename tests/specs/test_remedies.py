"""Faults of controllers and of trials of remedies: each with its place, and what is allowed."""

import pytest

from hknob_cli.specs.controller import KINDS, Controller
from hknob_cli.specs.load import validate
from hknob_cli.specs.source import parse
from tests.conftest import ROOT, SPEC, faults_of, loaded

TRIAL = """\
kind: remedies
name: small
base:
  scene:
    knob: {inertia: 1.9e-6}
    wall: {stiffness: 0.27}
  grid: {sample_rate_hz: [1000], counts_per_rev: [1024]}
  starts: {phases: 2}
hands:
  light: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}
cases:
  usual: {sample_rate_hz: 1000, counts_per_rev: 2650}
remedies:
  plain wall: {}
  lag:
    change: {scene: {controller: {kind: bounded_lag}}}
"""


# What stands in the scene, and the fault.
CONTROLLERS = {
    "unknown kind": ("{kind: magic}", "8:22: scene.controller.kind: must be 'bounded_lag', 'first_order_hold'"),
    "no kind": ("{keep: 0.1}", "8:3: scene.controller.kind: missing, and required"),
    "key of another kind": (
        "{kind: stiffening, keep: 0.1}",
        "8:40: scene.controller.keep: must be absent where kind is stiffening, which has surface, depth",
    ),
    "nothing kept": ("{kind: bounded_lag, keep: 0}", "8:41: scene.controller.keep: must be > 0, got 0"),
    "no time": ("{kind: bounded_lag, time_constant: 0 s}", "scene.controller.time_constant: must be > 0"),
    "long pulse": ("{kind: impulse_damping, pulse: 1.5}", "scene.controller.pulse: must be <= 1, got 1.5"),
    "many detections": ("{kind: impulse_damping, detections: 5000}", "scene.controller.detections: must be <= 1000"),
    "no damping": ("{kind: velocity_damping}", "8:15: scene.controller: must have damping where kind is velocity_dam"),
    "no damper": ("{kind: passivity}", "8:15: scene.controller: must have a damping > 0 where kind is passivity"),
    "negative damper": ("{kind: passivity, damping: -1}", "must have a damping > 0 where kind is passivity"),
    "no window": ("{kind: velocity_damping, damping: 1, window: 0}", "scene.controller.window: must be >= 1, got 0"),
    "window too long": (
        "{kind: velocity_damping, damping: 1, window: 65}",
        "scene.controller.window: must be <= 64, got 65",
    ),
    "half a sample": ("{kind: velocity_damping, damping: 1, window: 1.5}", "scene.controller.window: must be"),
    "filter of a sensor": (
        "{kind: velocity_damping, damping: 1, velocity: sensor, low_pass: 4 ms}",
        "scene.controller.low_pass: must be absent where velocity is sensor: it is of the differenced velocity",
    ),
    "one line": (
        "{kind: velocity_damping, damping: 1, velocity: adaptive}",
        "8:15: scene.controller: must have a window of 2 samples or more where velocity is adaptive",
    ),
    "no bandwidth": (
        "{kind: velocity_damping, damping: 1, velocity: tracking}",
        "8:15: scene.controller: must have a bandwidth where velocity is tracking",
    ),
    "filter faster than its samples": (
        "{kind: velocity_damping, damping: 1, velocity: tracking, bandwidth: 500}",
        "scene.controller.bandwidth: must be < 500 rad/s at 1000 Hz, got 500: the filter is stable where",
    ),
    "bandwidth of differences": (
        "{kind: velocity_damping, damping: 1, bandwidth: 100}",
        "scene.controller.bandwidth: must be absent where velocity is differenced: it is of velocity: tracking",
    ),
    "time-out of differences": (
        "{kind: velocity_damping, damping: 1, time_out: 100 ms}",
        "scene.controller.time_out: must be absent where velocity is differenced: it is of velocity: timed",
    ),
    "no acceleration": (
        "{kind: velocity_damping, damping: 1, velocity: kalman}",
        "8:15: scene.controller: must have an acceleration where velocity is kalman",
    ),
    "acceleration of differences": (
        "{kind: velocity_damping, damping: 1, acceleration: 100}",
        "scene.controller.acceleration: must be absent where velocity is differenced: it is of velocity: kalman",
    ),
    "low-pass on a filter": (
        "{kind: velocity_damping, damping: 1, velocity: tracking, bandwidth: 100, low_pass: 1 ms}",
        "scene.controller.low_pass: must be absent where velocity is tracking: it is of the differenced velocity",
    ),
    "window of a clock": (
        "{kind: velocity_damping, damping: 1, velocity: timed, window: 3}",
        "scene.controller.window: must be absent where velocity is timed",
    ),
    "angle that nothing filters": (
        "{kind: velocity_damping, damping: 1, angle: filtered}",
        "scene.controller.angle: must be counted where nothing filters: give a low_pass, or velocity: tracking or",
    ),
    "estimate of another kind": (
        "{kind: matched_wall, velocity: timed}",
        "scene.controller.velocity: must be differenced or sensor where kind is matched_wall",
    ),
    "cut off at rest": ("{kind: velocity_damping, damping: 1, cut_off: 0}", "scene.controller.cut_off: must be > 0"),
    "filter of no damper": ("{kind: stiffening, low_pass: 4 ms}", "must be absent where kind is stiffening, which has"),
    "wrong unit": ("{kind: stiffening, depth: 3 s}", "which is not a kind of rad"),
    "unknown key": ("{kind: stiffening, dept: 0.1}", "scene.controller.dept: unknown key; did you mean 'depth'?"),
}


@pytest.mark.parametrize("name", CONTROLLERS)
def test_fault_of_a_controller(name: str) -> None:
    controller, message = CONTROLLERS[name]
    text = SPEC.replace("grid:", f"  controller: {controller}\ngrid:")
    found = faults_of(text)
    assert message in found
    assert len(found.splitlines()) == 1


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("{stiffness: 0.27}", "{stiffness: 0}", "6:21: scene.wall.stiffness: must be > 0"),
        ("[1024]", "[1024]\n  controller.keep: [0.1]", 'grid["controller.keep"]'),
        ("starts:", "growth: {duration: 1}\nstarts:", "growth"),
    ],
)
def test_parts_that_no_controller_has_been_built_for(old: str, new: str, place: str) -> None:
    text = SPEC.replace("grid:", "  controller: {kind: stiffening}\ngrid:", 1).replace(old, new, 1)
    assert place in faults_of(text)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("{inertia: 1.9e-6}", "{inertia: 1.9e-6, coulomb_torque: 1e-4}"),
        ("{stiffness: 0.27}", "{stiffness: 0.27, damping: 1e-4}"),
        ("grid:", "  actuator: {delay_samples: 1}\ngrid:"),
        ("grid:", "  actuator: {time_constant: 1 ms}\ngrid:"),
        ("grid:", "  actuator: {torque_step: 1e-4}\ngrid:"),
        ("[1024]", "[1024]\n  knob.coulomb_torque: [0, 1e-4]"),
    ],
)
def test_a_controller_goes_with_what_real_knobs_have(old: str, new: str) -> None:
    plan = loaded(SPEC.replace("grid:", "  controller: {kind: stiffening}\ngrid:", 1).replace(old, new, 1))
    assert plan.scene.controller
    assert plan.scene.controller.kind == "stiffening"


@pytest.mark.parametrize("kind", ["dfa", "predict"])
def test_analyses_refuse_a_controller(kind: str) -> None:
    text = SPEC.replace("grid:", "  controller: {kind: stiffening}\ngrid:").replace("kind: sweep", f"kind: {kind}")
    text = text[: text.index("starts:")]
    assert f"scene.controller: must be absent: a controller is not in {kind}" in faults_of(text)


def test_methods_that_are_no_list_are_a_fault() -> None:
    text = SPEC.replace("kind: sweep", "kind: dfa") + "methods: 3\n"
    assert "methods: must be a list, got 3" in faults_of(text)


def test_every_kind_has_its_numbers_in_the_plan() -> None:
    named = {key for kind in KINDS.values() for key in kind.keys}
    assert named == set(Controller._fields) - {"kind"}


# What is replaced in the trial, by what, and the fault.
TRIALS = {
    "no remedies": (TRIAL[TRIAL.index("  plain") :], "  {}\n", "remedies"),
    "unknown reference": (
        "remedies:", "reference: nothing\nremedies:", "13:12: reference: must be one of remedies (pla",
    ),
    "hand of the base": (
        "    wall:", "    hand: {inertia: 1}\n    wall:", "base.scene.hand: must be absent: hands are",
    ),
    "hand with a finger": (
        "{inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}",
        "{finger: {inertia: 3.0e-7}, fingerpad: {damping: 1e-3, stiffness: 1}}",
        "10:10: hands.light: must be",
    ),
    "unknown key of the base": ("  starts:", "  start:", 'base.start: unknown key; scene, grid, starts and limits'),
    "fault of the base": ("{stiffness: 0.27}", "{stiffness: -1}", "6:23: base.scene.wall.stiffness: must be >= 0"),
    "fault of a change": ("bounded_lag}", "bounded}", "16:41: remedies.lag.change.scene.controller.kind: must be"),
    "not of a change": ("{scene: {con", "{starts: {phases: 1}, scene: {con", "must not have starts: a remedy"),
    "a hand of its own": ("{scene: {con", "{scene: {hand: {inertia: 1}, con", "must not have scene.hand: hands are"),
    "another axis": (
        "{scene: {con", "{grid: {wall.stiffness: [1, 2]}, scene: {con", "must leave the axes of the base as",
    ),
    "two cells at a case": ("{scene: {con", "{grid: {sample_rate_hz: [1, 2]}, scene: {con", "one cell at each case"),
    "no clock": (
        "{scene: {controller: {kind: bounded_lag}}}", "{scene: {sampling: continuous}}", "must leave a sample",
    ),
    "a clock that jitters": (
        "{scene: {controller: {kind: bounded_lag}}}", "{scene: {clock: {jitter: 0.1}}}",
        "must leave a sample clock without jitter: what is compared are cycles",
    ),
    "pushes in the wrong order": (
        "remedies:", "press: {torques: [0.02, 0.01]}\nremedies:", "press.torques: must be two",
    ),
    "tuned by what is not there": (
        "    change: {scene: {con", "    tune: {controller.kep: [0.1]}\n    change: {scene: {con",
        'remedies.lag.tune["controller.kep"]: unknown key; did you mean \'controller.keep\'?',
    ),
    "tuned by what its kind has not": (
        "    change: {scene: {con", "    tune: {controller.surface: [0.1]}\n    change: {scene: {con",
        "must be absent where kind is bounded_lag",
    ),
    "tuned beyond what is allowed": (
        "    change: {scene: {con", "    tune: {controller.keep: [0.1, 2]}\n    change: {scene: {con",
        'remedies.lag.tune["controller.keep"][1]: must be <= 1, got 2',
    ),
    "tuned by two": (
        "    change: {scene: {con",
        "    tune: {controller.keep: [0.1], controller.time_constant: [1]}\n    change: {scene: {con",
        "remedies.lag.tune: must",
    ),
    "tuned to hands": (
        "    change: {scene: {con", "    tune: {hand.damping: [0.1]}\n    change: {scene: {con",
        "must be of the device: hands are listed under hands",
    ),
    "case without counts": (", counts_per_rev: 2650}", "}", "12:3: cases.usual.counts_per_rev: missing"),
}  # fmt: skip


@pytest.mark.parametrize("name", TRIALS)
def test_fault_of_a_trial(name: str) -> None:
    old, new, message = TRIALS[name]
    assert old in TRIAL
    assert message in faults_of(TRIAL.replace(old, new, 1))


def test_a_trial_as_plain_values() -> None:
    plan = validate(parse(TRIAL, "spec.yaml"))
    plain, lag = plan.remedies
    assert plain.grid.scene.controller is None
    assert lag.grid.scene.controller == Controller(kind="bounded_lag")
    assert lag.cases[0].axes == {"sample_rate_hz": [1000.0], "counts_per_rev": [2650], "person": [1]}
    assert plan.hands == ("light",)


def test_the_documents_count_the_remedies_as_the_file_does() -> None:
    plan = validate(parse((ROOT / "experiments" / "remedies.yaml").read_text(), "remedies.yaml"))
    beside = [one for one in plan.remedies if one.name != plan.reference]
    own = [one.name for one in beside if one.source == "own"]
    assert own == ["bounded lag", "edge-triggered update"]
    assert all(one.source for one in plan.remedies)
    page = " ".join((ROOT / "docs" / "reference" / "controllers.md").read_text().split())
    assert f"{len(beside)} remedies beside the plain wall" in page
    assert "Two of those are our own: the bounded lag, and the update at every edge" in page
    head = (ROOT / "experiments" / "remedies.yaml").read_text().partition("kind:")[0]
    assert f"{len(beside)} remedies against the buzz" in head
    assert "two of our own" in head.replace("\n# ", " ")
