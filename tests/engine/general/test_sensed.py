"""Tests of `engine.general.laws.sensed` and of sums that drift: what the proofs ask for, and that it is enough."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.certificate import PROVEN
from hknob_cli.engine.general.columns import begin_columns
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.laws.cascade import sums_agree
from hknob_cli.engine.general.laws.law import AT_SWITCH
from hknob_cli.engine.general.laws.period import certify_with_law
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.general.laws.sensed import carried, chart_interval, move_columns, sense
from hknob_cli.engine.general.laws.step import FREE, advance_with_law, driven_slope
from hknob_cli.engine.general.search import make_space
from hknob_cli.engine.outcome import Outcome, Reason
from tests.controllers.laws import CONTROLLERS
from tests.engine.general.test_laws import made, period_of, settled

SENSORS = ["damping, sensor", "half sample, sensor", "matched wall, sensor", "damping, negative"]
PARTS: dict[str, dict[str, Any]] = {
    "alone": {},
    "delay": {"actuator": {"delay_samples": 1.5}},
    "lag": {"actuator": {"time_constant": 5e-5}},
    "step": {"actuator": {"torque_step": 1e-4}},
    "limit": {"actuator": {"torque_limit": 0.002}},
}


def found(name: str, **parts: Any) -> tuple[Any, Any, Any]:
    """A cell, its law, and the one end of a trial."""
    _, cell = made(CONTROLLERS[name], **parts)
    engine = LawEngine(cell.law)
    search = engine.search(
        cell.knob.body,
        cell.knob.wall,
        cell.knob.start(0.02, 0.0),
        rate=cell.rate,
        phases=1,
        delay_line=engine.past_length,
        max_samples=20_000,
    )
    return cell, engine._law, search.attractors[0]


def certified(cell: Any, law: Any, z: Any, past: Any, period: int) -> tuple[int, Any]:
    """Status of a proof of a state and a memory, and its work space."""
    space = make_space(cell.knob.body.order, len(past), lambda count: [0.0] * count)
    status, *_ = certify_with_law(list(z), list(past), period, cell.knob.body, cell.knob.wall, law, space)
    return status, space


def readings(cell: Any, law: Any, z: Any, past: Any, samples: int) -> list[float]:
    """What a trial reads."""
    x, memory, pad, seen = list(z), list(past), [0.0] * (2 * len(z)), []
    for _ in range(samples):
        seen.append(read(x[0], cell.knob.wall))
        advance_with_law(x, memory, cell.knob.body, cell.knob.wall, law, pad)
    return seen


@pytest.mark.parametrize("parts", PARTS)
@pytest.mark.parametrize("name", SENSORS)
def test_a_cycle_under_a_sensed_velocity_is_proven(name: str, parts: str) -> None:
    _, _, orbit = found(name, **PARTS[parts])
    assert orbit.outcome is Outcome.CYCLE
    assert orbit.reason is Reason.NONE
    assert 0.0 < orbit.bound < orbit.margin


@pytest.mark.one_in(3)
@pytest.mark.parametrize("parts", ["alone", "delay", "lag"])
@pytest.mark.parametrize("name", SENSORS)
def test_what_is_captured_stays_and_what_cannot_stay_is_not_captured(name: str, parts: str) -> None:
    """In random directions, as far out as the proof goes: the readings of 40 periods are those of the orbit."""
    cell, law, orbit = found(name, **PARTS[parts])
    z, past = np.array([orbit.x, orbit.v, *orbit.state]), list(orbit.line)
    numbers = np.random.default_rng(5)
    for _ in range(3):
        way = numbers.normal(size=len(z))
        way[1::2] *= 0.3
        low, high = 0.0, 4.0 * orbit.margin / np.abs(way[0])
        for _ in range(12):
            middle = 0.5 * (low + high)
            status, _ = certified(cell, law, z + middle * way, past, orbit.period)
            low, high = (middle, high) if status == PROVEN else (low, middle)
        assert low > 0.0
        assert high < 4.0 * orbit.margin / np.abs(way[0])  # beyond an edge nothing is captured
        far = z + low * way
        status, space = certified(cell, law, far, past, orbit.period)  # so far out, it may be another orbit's
        seen = readings(cell, law, space.orbit, law.periodic, orbit.period)
        assert status == PROVEN
        assert readings(cell, law, far, past, 40 * orbit.period) == 40 * seen


def test_what_rounding_adds_goes_through_every_later_interval() -> None:
    cell, law, orbit = found("damping, sensor", **PARTS["delay"])
    body, wall = cell.knob.body, cell.knob.wall
    m = body.order + law.ages - 1
    space = make_space(body.order, len(law.beside), lambda count: [0.0] * count)
    space.orbit[:] = [orbit.x, orbit.v]
    past = list(orbit.line)
    maps = []
    space.state[:] = space.orbit
    for i in range(7):
        begin_columns(space, m)
        _, _, _, law.slopes[i] = sense(past, wall, law, space, m)
        move_columns(past, body, law, space, m)
        maps.append(np.array(space.cols).reshape(-1, space.width)[:m, :m].T.copy())
    chart_interval(list(past), body, law, space, m)
    noise, first = np.array([1e-3, 2e-3, 3e-3, 4e-3][:m]), np.array([5e-3, 1e-3, 2e-3, 3e-3][:m])
    law.noise[: 2 * m] = [*noise, *first]
    total, through = np.zeros(m), np.eye(m)
    for one in reversed(maps):
        total += np.abs(through) @ noise
        through = through @ one
    total += np.abs(through) @ first
    assert [carried(i, 0, m, 7, law, m, space.spare) for i in range(m)] == pytest.approx(total.tolist(), rel=1e-12)
    assert len({law.slopes[i] for i in range(7)}) == 2  # with and without the damper


def test_a_rest_under_a_sensed_velocity_is_proven() -> None:
    cell, _, rest = found("damping, sensor", bias={"torque": 1.8e-3})
    assert (rest.outcome, rest.reason) == (Outcome.REST, Reason.NONE)
    step = 0.27 * cell.knob.quantum_rad
    assert cell.knob.angle_rad(rest.x) == pytest.approx((step - 1.8e-3) / 0.04, rel=1e-9)


def test_a_trial_whose_speed_comes_to_the_cut_off_is_not_captured() -> None:
    """From the sample at which the orbit is fastest: a cut-off far above that speed, at it, and just above it."""
    cell, law, orbit = found("damping, sensor")
    passed, pad = [], [0.0] * 4
    z, past = [orbit.x, orbit.v], list(orbit.line)
    for _ in range(orbit.period):
        passed.append((abs(z[1]), list(z), list(past)))
        advance_with_law(z, past, cell.knob.body, cell.knob.wall, law, pad)
    fastest, z, past = max(passed)
    for cut, expected in ((1.5, PROVEN), (1.0 + 1e-14, AT_SWITCH)):
        other = law._replace(fixed=[*law.fixed[:6], cut * fastest])
        assert certified(cell, other, z, past, orbit.period)[0] == expected
    other = law._replace(fixed=[*law.fixed[:6], 1.001 * fastest])
    assert certified(cell, other, z, past, orbit.period)[0] == PROVEN
    away = [z[0], 1.002 * z[1]]
    assert certified(cell, other, away, past, orbit.period)[0] != PROVEN
    assert certified(cell, law, away, past, orbit.period)[0] == PROVEN


def test_slopes_end_at_the_amplifiers_limit_and_between_steps() -> None:
    _, cell = made(CONTROLLERS["damping, sensor"])
    wall = cell.knob.wall._replace(limit=2.0)
    assert driven_slope(1.0, -0.5, wall) == (-0.5, 2.0)
    assert driven_slope(-3.0, -0.5, wall) == (0.0, 2.0)
    assert driven_slope(1.0, 0.0, wall) == (0.0, FREE)
    assert driven_slope(0.6, -0.5, wall._replace(step=0.5)) == pytest.approx((0.0, 0.3))


def test_a_sum_that_drifts_is_proven_while_it_decides_nothing() -> None:
    _, cell = made(CONTROLLERS["passivity, no reset"], actuator={"delay_samples": 1.5})
    z, past, law = settled(cell)
    period = period_of(cell, z, past, law) if law.drifts < 0 else period_of_readings(cell, law, z, past)
    assert certified(cell, law, z, past, period)[0] == PROVEN
    lap = list(past)
    x, pad = list(z), [0.0] * 4
    for _ in range(period):
        advance_with_law(x, lap, cell.knob.body, cell.knob.wall, law, pad)
    assert lap[law.drifts] < past[law.drifts] < 0.0
    owed = list(past)
    owed[law.drifts] = 10.0
    assert certified(cell, law, z, owed, period)[0] != PROVEN
    owed[law.drifts] = -1e-3  # not so much that the damper gives its most at each count
    assert certified(cell, law, z, owed, period)[0] != PROVEN
    owed[law.drifts] = 100.0 * past[law.drifts]
    assert certified(cell, law, z, owed, period)[0] == PROVEN


def period_of_readings(cell: Any, law: Any, z: Any, past: Any) -> int:
    """Samples after which the plant is back."""
    x, memory, pad = list(z), list(past), [0.0] * 4
    for n in range(1, 400):
        advance_with_law(x, memory, cell.knob.body, cell.knob.wall, law, pad)
        if max(abs(x[0] - z[0]), abs(x[1] - z[1])) < 1e-9:
            return n
    raise AssertionError("it does not repeat")


def test_sums_agree_where_they_are_equal_or_decide_nothing() -> None:
    _, cell = made(CONTROLLERS["passivity"])
    law = cell.law
    past = [0.0, 0.0, -5.0, 0.0]
    for other, room, expected in ((-5.0, -np.inf, True), (-4.0, -np.inf, False), (-6.0, 1.5, True), (-7.0, 1.5, False)):
        assert sums_agree(past, [0.0, 0.0, other, 0.0], room, law) == expected
