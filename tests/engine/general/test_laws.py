"""Tests of `engine.general.laws`: the functions beside the array programs, and what a proof asks for."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.attractors import Patience
from hknob_cli.engine.certificate import NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.general.laws import follow
from hknob_cli.engine.general.laws.cascade import pushed_apart, torques_apart
from hknob_cli.engine.general.laws.law import PIECE, SPAN
from hknob_cli.engine.general.laws.period import certify_with_law
from hknob_cli.engine.general.laws.rest import settles_with_law
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past, decide
from hknob_cli.engine.general.search import make_space
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.rest import AT_REST, MOVING
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.laws import CONTROLLERS

SCENE: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
}


def made(controller: dict[str, Any], **parts: Any) -> Any:
    """A cell of the hand on the knob under a controller, with more parts."""
    scene = {name: {**part, **parts.get(name, {})} for name, part in SCENE.items()}
    scene |= {name: part for name, part in parts.items() if name not in scene}
    plain = SceneSpec.model_validate({**scene, "controller": controller}).plain()
    return plain, make_law(plain, sample_rate_hz=1000.0, counts_per_rev=1024)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_what_is_remembered_follows_from_the_readings(name: str) -> None:
    """Two memories that differ in what fades: as many torques differ, in all, as the bound allows."""
    _, cell = made(CONTROLLERS[name], actuator={"delay_samples": 1.5})
    law, wall = cell.law, cell.knob.wall
    one, other = [0.0] * len(law.beside), [0.0] * len(law.beside)
    begin_past(one, -1.0, law)
    if law.fading < 0 or law.guarded:
        return
    begin_past(other, -1.0, law)
    other[law.fading] += 0.4
    allowed, apart = torques_apart(one, other, law), 0.0
    numbers = np.random.default_rng(4)
    for _ in range(4000):
        shown = float(numbers.integers(-4, 2))
        decide(shown, 0.0, one, wall, law)
        decide(shown, 0.0, other, wall, law)
        apart += abs(one[-1] - other[-1])
    assert 0.5 * allowed < apart <= allowed * (1.0 + 1e-12)


@pytest.mark.parametrize("delay", [0.0, 0.3, 1.0, 2.6])
@pytest.mark.parametrize("name", ["impulse, short", "impulse, timed", "bounded lag"])
def test_the_pieces_of_an_interval_fill_it(name: str, delay: float) -> None:
    _, cell = made(CONTROLLERS[name], actuator={"delay_samples": delay})
    spans = [cell.law.sched[i * PIECE + SPAN] for i in range(cell.law.pieces)]
    assert min(spans) > 0.0
    assert sum(spans) == pytest.approx(1.0, abs=1e-15)


def test_a_law_that_does_not_tell_counts_outside_apart_is_followed() -> None:
    """Its levels are those of the wall, as they are compared from sample to sample."""
    _, cell = made({"kind": "bounded_lag", "time_constant": 0.01}, knob={"coulomb_torque": 1e-4})
    assert cell.law.watch.damping == 0.0
    found = LawEngine(cell.law).search(
        cell.knob.body,
        cell.knob.wall,
        cell.knob.start(0.02, 0.0),
        rate=cell.rate,
        phases=1,
        delay_line=len(cell.law.beside),
        max_samples=20_000,
    )
    assert found.attractors[0].certified


def test_interpreted_and_compiled_find_the_same_bits() -> None:
    from hknob_cli.engine.jit import compiled

    _, cell = made({"kind": "bounded_lag", "time_constant": 0.01}, knob={"coulomb_torque": 1e-4})
    found = []
    for functions in (None, compiled("laws")):
        engine = LawEngine(cell.law, functions)
        found.append(
            engine.search(
                cell.knob.body,
                cell.knob.wall,
                cell.knob.start(0.02, 0.0),
                rate=cell.rate,
                phases=2,
                delay_line=engine.past_length,
                max_samples=20_000,
            )
        )
    assert found[0] == found[1]
    assert found[0].attractors[0].certified


def settled(cell: Any, samples: int = 6000) -> tuple[Any, Any, Any]:
    """State and memory after so many samples, and the law."""
    law, knob = cell.law, cell.knob
    z, pad, past = knob.start(0.02, 0.0), [0.0] * 4, [0.0] * len(law.beside)
    begin_past(past, np.floor(z[0]), law)
    for _ in range(samples):
        advance_with_law(z, past, knob.body, knob.wall, law, pad)
    return z, past, law


def period_of(cell: Any, z: Any, past: Any, law: Any) -> int:
    """Samples after which the motion is back."""
    x, memory, pad = list(z), list(past), [0.0] * 4
    for n in range(1, 400):
        advance_with_law(x, memory, cell.knob.body, cell.knob.wall, law, pad)
        if max(abs(x[0] - z[0]), abs(x[1] - z[1])) < 1e-9:
            return n
    raise AssertionError("it does not repeat")


def test_a_trial_is_captured_as_far_as_the_margin_and_no_further() -> None:
    _, cell = made({"kind": "bounded_lag", "time_constant": 0.01}, knob={"coulomb_torque": 1e-4})
    z, past, law = settled(cell)
    space = make_space(2, len(past), lambda count: [0.0] * count)
    n = period_of(cell, z, past, law)
    body, wall = cell.knob.body, cell.knob.wall
    status, margin, _, _, bound = certify_with_law(z, past, n, body, wall, law, space)
    assert status == PROVEN
    room = (margin - bound) / (law.weight / (1.0 - law.fade) * body.reach)
    for share, expected in ((0.99, PROVEN), (1.01, NOT_CAPTURED)):
        other = list(past)
        other[law.fading] += share * room
        assert certify_with_law(z, other, n, body, wall, law, space)[0] == expected


def test_a_memory_that_counts_otherwise_is_no_orbit() -> None:
    _, cell = made({"kind": "velocity_damping", "damping": 3e-4}, knob={"coulomb_torque": 1e-5})
    z, past, law = settled(cell)
    space = make_space(2, len(past), lambda count: [0.0] * count)
    n = period_of(cell, z, past, law)
    body, wall = cell.knob.body, cell.knob.wall
    assert certify_with_law(z, past, n, body, wall, law, space)[0] == PROVEN
    past[0] += 1.0
    assert certify_with_law(z, past, n, body, wall, law, space)[0] != PROVEN


def test_friction_holds_a_knob_while_the_mean_still_moves() -> None:
    """It rests as long as the friction holds the torque of now, and of all times to come."""
    _, cell = made({"kind": "bounded_lag"}, knob={"coulomb_torque": 5e-4}, bias={"torque": 1.6e-3})
    law, knob = cell.law, cell.knob
    body, wall = knob.body, knob.wall
    orbit, away = [0.0, 0.0], [0.0, 0.0]
    past = [0.0] * len(law.beside)
    begin_past(past, -1.0, law)
    past[0] = 1.0
    for _ in range(law.ages):
        decide(-1.0, 0.0, past, wall, law)
    u = wall.kappa  # a count deep, at the end
    pull = u + body.drive
    z = [-0.5, 0.0]
    assert abs(pull - body.beta * z[0]) < body.friction
    assert settles_with_law(z, -1.0, past, body, wall, law, orbit, away) == AT_REST
    spare = body.friction - abs(pull - body.beta * z[0])
    for share, held in ((0.9, True), (1.1, False)):
        late = list(past)
        late[0] = 1.0 - share * spare * (1.0 - law.fade) / law.weight
        newest = law.line + (law.ages - 1) * law.parts
        fate = settles_with_law(z, -1.0, late, body, wall, law, orbit, away)
        assert late[newest] == past[newest]
        assert (fate == AT_REST) == held


def test_a_knob_does_not_rest_while_its_torque_is_cut_off() -> None:
    """Although the filtered speed damps nothing: below the cut-off the wall's torque comes back."""
    controller = {"kind": "velocity_damping", "damping": 0.0, "low_pass": 0.05, "cut_off": 2.0}
    _, cell = made(controller, knob={"coulomb_torque": 5e-4}, bias={"torque": 1.6e-3})
    law, knob = cell.law, cell.knob
    for share, fate in ((0.0, AT_REST), (0.99, AT_REST), (1.01, MOVING)):
        past = [0.0] * len(law.beside)
        begin_past(past, -1.0, law)
        for _ in range(law.ages):
            decide(-1.0, 0.0, past, knob.wall, law)
        past[law.fading] = share * law.fixed[6]
        assert settles_with_law([-0.5, 0.0], -1.0, past, knob.body, knob.wall, law, [0.0] * 2, [0.0] * 2) == fate


def test_a_mean_that_hardly_moves_divides_by_nothing() -> None:
    _, cell = made({"kind": "bounded_lag", "time_constant": 9e5}, knob={"coulomb_torque": 1e-4})
    assert 0.0 < 1.0 - cell.law.fade < 1e-8


def test_torques_push_nowhere_without_a_difference() -> None:
    _, cell = made({"kind": "bounded_lag"}, hand={"stiffness": 0.0})
    assert pushed_apart(0.0, 0.0, cell.knob.body) == 0.0
    assert pushed_apart(1.0, 0.0, cell.knob.body) == pytest.approx(1.0 / cell.knob.body.alpha)


def test_what_reads_the_velocity_beside_friction_is_labelled() -> None:
    _, cell = made(CONTROLLERS["damping, sensor"], knob={"coulomb_torque": 1e-5})
    engine = LawEngine(cell.law)
    found = engine.search(
        cell.knob.body,
        cell.knob.wall,
        cell.knob.start(0.02, 0.0),
        rate=cell.rate,
        phases=1,
        delay_line=engine.past_length,
        max_samples=10_000,
    )
    assert [one.reason for one in found.attractors] != [Reason.NONE]
    assert all(one.outcome in (Outcome.CYCLE, Outcome.REST) for one in found.attractors)


@pytest.mark.parametrize("name", ["first-order hold", "bounded lag"])
def test_a_motion_that_repeats_to_the_bit_is_not_moved_to_the_end(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """As if all of its periods were followed, where no proof succeeds: the same end, after as many samples."""
    moved = [0]

    def unproven(*given: Any) -> Any:
        _, *numbers = certify_with_law(*given)
        return (ON_EDGE, *numbers)

    def counted(*given: Any) -> float:
        moved[0] += 1
        return advance_with_law(*given)

    monkeypatch.setattr(follow, "certify_with_law", unproven)
    monkeypatch.setattr(follow, "advance_with_law", counted)
    _, cell = made({**CONTROLLERS[name], **({"time_constant": 0.01} if name == "bounded lag" else {})})
    knob = cell.knob
    ends, most = [], 6000
    for passed in (follow.periods_passed, lambda *_: 0):
        monkeypatch.setattr(follow, "periods_passed", passed)
        engine = LawEngine(cell.law, patience=Patience(samples=10**9))
        start, moved[0] = knob.start(0.02, 0.0), 0
        end = engine.search(
            knob.body,
            knob.wall,
            start,
            rate=cell.rate,
            phases=1,
            delay_line=engine.past_length,
            max_samples=most,
        )
        ends.append((end, moved[0]))
    (short, few), (full, all_of_them) = ends
    assert [one.reason for one in full.attractors] == [Reason.ON_EDGE]
    assert short == full
    assert few < 0.5 * all_of_them
    assert full.samples == most
