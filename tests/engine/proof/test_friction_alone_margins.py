"""Samples of one level, without a look at each: `general.interval.rubs_alone`, `general.follow.rub_on`."""

from math import inf, nextafter
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.engine.follow import CYCLE_PROVEN, REST_PROVEN, UNSETTLED
from hknob_cli.engine.general import ensemble, follow
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.controller import depth_level, read
from hknob_cli.engine.general.follow import KNOWN, follow_trial, rub_on
from hknob_cli.engine.general.interval import advance, rubs_alone
from hknob_cli.engine.general.search import GeneralEngine, as_list, make_space
from tests.engine.general.bodies import knob
from tests.engine.trial_space import trial_of

SLOW = knob(rate_hz=20_000.0)  # many samples of one reading
PLAIN: dict[str, Any] = {}
MORE: dict[str, dict[str, Any]] = {
    "no friction": {"knob": {"inertia": 1.9e-6}},
    "a finger": {
        "hand": {
            "finger": {"inertia": 3e-7, "damping": 3e-4, "stiffness": 0.04},
            "fingerpad": {"damping": 1e-3, "stiffness": 2.0},
        }
    },
    "a delay": {"actuator": {"delay_samples": 1}},
    "cogging": {"cogging": {"torque": 1e-4, "per_revolution": 8}},
    "hysteresis": {"encoder": {"hysteresis_counts": 0.2}},
    "virtual damping": {"wall": {"stiffness": 0.27, "damping": 1e-4}},
    "jitter": {"clock": {"jitter": 0.1}},
}


@pytest.mark.parametrize("parts", [PLAIN, {"detents": {"per_revolution": 24, "torque": 1e-3}}])
def test_friction_alone(parts: dict[str, Any]) -> None:
    one = knob(**parts)
    assert rubs_alone([0.0] * one.delay_line, one.body, one.wall)


@pytest.mark.parametrize("what", MORE)
def test_friction_and_more(what: str) -> None:
    one = knob(**MORE[what])
    assert not rubs_alone([0.0] * one.delay_line, one.body, one.wall)


def test_friction_and_a_continuous_sensor() -> None:
    one = knob(counts=None, encoder="none")
    assert not rubs_alone([], one.body, one.wall)


def trial(trail: int, orbits: list[tuple[float, float]]) -> Any:
    """With proven orbits, of a deepest sample and a margin each."""
    rows = [[0.0] * FIELDS for _ in orbits]
    for row, (_, margin) in zip(rows, orbits, strict=True):
        row[0], row[2] = CYCLE_PROVEN, margin
    space = make_space(2, 0, lambda count: [0.0] * count)._replace(trail=[7.0] * trail)
    return trial_of([0.0, 0.0], [], space, rows, [[x, 0.0] for x, _ in orbits])


def path(x: float, v: float, count: int) -> list[tuple[float, float]]:
    """States at ``count`` samples from a state on, by the loop of all scenes."""
    wall, z, found = as_list(SLOW.wall), [x, v], [(x, v)]
    for _ in range(count):
        advance(z, read(z[0], wall), [], 0, SLOW.body, wall, [0.0] * 4)
        found.append((z[0], z[1]))
    return found


def moved(states: list[tuple[float, float]], most: int, limit: float, trail: int = 100, since: int = 3,
          orbits: list[tuple[float, float]] | None = None) -> tuple[Any, list[float]]:  # fmt: skip
    one, wall = trial(trail, orbits or []), as_list(SLOW.wall)
    one.z[:] = states[0]
    shown, more = rub_on(read(one.z[0], wall), most, since, limit, one, SLOW.body, wall)
    return (*one.z, shown, more), one.space.trail


@given(
    x=st.floats(-6.0, 3.0),
    v=st.floats(-0.05, 0.05) | st.floats(-1e-3, 1e-3),
    most=st.integers(0, 60),
    since=st.integers(0, 70),
)
def test_it_moves_as_the_loop_does_while_the_level_stays(x: float, v: float, most: int, since: int) -> None:
    states = path(x, v, most + 1)
    wall = as_list(SLOW.wall)
    levels = [depth_level(read(at, wall), wall) for at, _ in states]
    same = next((i for i, level in enumerate(levels[1 : most + 1]) if level != levels[0]), most)
    (*state, shown, more), trail = moved(states, most, 1e6, trail=64, since=since)
    assert more == same
    assert tuple(state) == states[same + 1]
    readings = [read(at, wall) for at, _ in states[: same + 1]]
    assert shown == readings[-1]
    wanted = [7.0] * 64
    for i, one in enumerate(readings[1:]):
        if since + i < 64:
            wanted[since + i] = one
    assert trail == wanted


OUT = path(0.2, 0.04, 9)  # away from the wall, through one count


def test_it_turns_round_within_a_sample() -> None:
    states = path(0.2, 1e-3, 30)
    turned = next(i for i, (_, v) in enumerate(states) if v < 0.0)
    assert 1 < turned < 20
    (*state, _, more), _ = moved(states, turned, 1e6)
    assert (tuple(state), more) == (states[turned + 1], turned)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_stops_where_the_trial_has_left(side: float) -> None:
    """A position at the limit is past it; outside the wall, to either side of a wall that holds nothing."""
    states = OUT if side > 0.0 else path(-0.1, -0.04, 9)
    wall = as_list(SLOW.wall)
    assert len({depth_level(read(at, wall), wall) for at, _ in states[:8]}) == 1
    for k in (1, 2, 5):
        at = abs(states[k][0])
        assert max(abs(one) for one, _ in states[:k]) < at
        assert moved(states, 7, at)[0][3] == k - 1
        assert moved(states, 7, nextafter(at, inf))[0][3] == k


def test_it_stops_beside_a_proven_orbit() -> None:
    at = OUT[4][0]
    for orbits, stops in (([(at, 1e-3)], 3), ([(50.0, 1e-3), (at, 1e-3)], 3), ([(at, 0.0)], 7), ([], 7)):
        assert moved(OUT, 7, 1e6, orbits=orbits)[0][3] == stops


ENDS = {
    "cycles": (knob(rate_hz=2154.0, counts=256), None),
    "rests": (knob(rate_hz=1000.0, counts=2048, knob={"inertia": 1.9e-6, "coulomb_torque": 5.6e-4}), None),
    "undecided": (knob(rate_hz=10_000.0, counts=512), 601),
    "at the very end": (SLOW, 37),
}


@pytest.mark.parametrize("what", ENDS)
def test_a_trial_ends_as_it_does_sample_by_sample(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the same sample, whatever becomes of it; ``trial_by_trial`` notes all that `follow_trial` says."""
    one, most = ENDS[what]
    found = []
    for single in (False, True):
        said: list[Any] = []
        moves: list[int] = []

        def rub(*values: Any, single: bool = single, moves: list[int] = moves) -> Any:
            shown, room, *rest = values
            after = rub_on(shown, 0 if single else room, *rest)
            moves.append(after[1])
            return after

        def trial_by_trial(trial: Any, *rest: Any, said: list[Any] = said) -> Any:
            end = follow_trial(trial, *rest)
            said.append((end, list(trial.z), list(trial.space.trail[: end[1]])))
            return end

        monkeypatch.setattr(follow, "rub_on", rub)
        monkeypatch.setattr(ensemble, "follow_trial", trial_by_trial)
        search = GeneralEngine().search(
            one.body, one.wall, one.start(0.02, 0.0), rate=one.rate, phases=4, delay_line=0, max_samples=most
        )
        found.append((search, said))
        assert (max(moves) == 0) == single
    assert found[0] == found[1]
    kinds = {end[0] for end, *_ in found[0][1]}
    assert kinds <= {"cycles": {CYCLE_PROVEN, KNOWN}, "rests": {REST_PROVEN}}.get(what, {UNSETTLED})
