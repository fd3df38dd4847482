"""The energy audit's split of the wall's work: late entry, late exit, staircase."""

import numpy as np
import pytest

from hknob_cli.engine.orbit_cycle import potential
from hknob_cli.measure.general_orbit import split_leak
from hknob_cli.specs.load import load
from hknob_cli.stages.sweep.record import record_sweep
from tests.conftest import EXPERIMENTS, swept

K = 0.27
KAPPA = 1.7


def test_parts_add_up_to_the_work_of_the_wall(main_grid) -> None:
    """Over every orbit of the four readings of the grid; the wall that answers at once gives back all it takes.

    Without delay none is negative: over a hold from x0 to x1 the work is tau(x0) (x1 - x0) + U(x1) - U(x0), and U, of
    slope -tau, is convex.
    """
    for name, rows in main_grid.items():
        for row in rows if name.endswith(":orbits") else []:
            if row["outcome"] != "cycle":
                continue
            parts = [row["late_entry_j"], row["late_exit_j"], row["staircase_j"]]
            assert sum(parts) == pytest.approx(row["wall_work_j"], rel=0, abs=1e-12 * max(map(abs, parts)))
            assert min(parts) >= -1e-12 * max(parts)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("rate", "counts"), [(464.0, 4096), (1000.0, 1024), (215.0, 8192)])
def test_split_is_that_of_the_motion_in_time(rate: float, counts: int) -> None:
    """Sums of torque times distance over a recorded period, each piece told by where the knob is and what acts.

    A piece that straddles an edge is told wrongly by at most itself: K dtheta times its length, once for each crossing.
    """
    setting = (f"grid.sample_rate_hz={rate}", f"grid.counts_per_rev={counts}", "starts.phases=1")
    path = EXPERIMENTS / "hand_on_knob.yaml"
    orbit = swept(path, *setting).orbits.to_pylist()[0]
    period = orbit["period_samples"] / rate
    end = 0.5 / rate + round(0.25 * rate) / rate  # a sample
    interval = 5e-6
    record = f"record={{duration: {end + period}, interval: {interval}}}"
    rows = record_sweep(load(path, (*setting, record))).to_pylist()
    time, angle, torque = (np.array([row[n] for row in rows]) for n in ("time_s", "angle_rad", "torque_nm"))
    last = time >= end - 1e-12
    angle, torque = angle[last], torque[last][:-1]
    quantum = 2.0 * np.pi / counts
    moved, middle = np.diff(angle), 0.5 * (angle[1:] + angle[:-1])
    ideal = -K * quantum * np.minimum(0.0, np.floor(middle / quantum))
    inside, off = middle < 0.0, torque == 0.0
    late = (torque - ideal) * moved
    crossings = np.count_nonzero(np.diff(np.floor(angle / quantum)))
    bound = K * quantum * np.abs(moved).max() * (crossings + 2)
    assert late[inside & off].sum() == pytest.approx(orbit["late_entry_j"], rel=0, abs=bound)
    assert late[~inside].sum() == pytest.approx(orbit["late_exit_j"], rel=0, abs=bound)
    assert late[inside & ~off].sum() == pytest.approx(orbit["staircase_j"], rel=0, abs=bound)
    assert bound < 0.05 * orbit["wall_work_j"]


def test_a_hold_on_a_continuous_sensor() -> None:
    """In and out of a wall of stiffness 2 by whole steps: x = 1, -1, -3, -1, 1 with torques of the sample before.

    Entry: potential of the first step inside, 2 * 1/2. Exit: torque 2 over one unit. Inside: 2 * (-2), 6 * 2, 2 * 1,
    against a potential of 9 at the lowest: (-4 + 8) + (12 - 8) + (2 - 1).
    """
    found = split_leak(
        np.array([1.0, -1.0, -3.0, -1.0, 1.0]),
        np.array([0.0, 2.0, 6.0, 2.0]),
        edge=0.0,
        kappa=2.0,
        offset=0.0,
        analog=True,
    )
    assert found == pytest.approx((1.0, 2.0, 9.0))
    assert sum(found) == pytest.approx(2.0 * -2.0 + 6.0 * 2.0 + 2.0 * 2.0)


@pytest.mark.parametrize("offset", [0.0, 0.3])
@pytest.mark.parametrize("analog", [False, True])
def test_potential_is_the_integral_of_the_torque(offset: float, analog: bool) -> None:
    """The torque at depth d is K (floor(d) + 1 - offset), or K d; a midpoint sum over steps within a count is exact."""
    offset = 0.0 if analog else offset
    step = 1.0 / 256.0
    middles = np.arange(step / 2, 5.0, step)
    torque = KAPPA * (middles if analog else np.floor(middles) + 1.0 - offset)
    depths = np.arange(0, 5.0 + step / 2, step)
    expected = np.concatenate([[0.0], np.cumsum(torque) * step])
    found = [potential(depth, KAPPA, offset, analog) for depth in depths]
    assert found == pytest.approx(expected, rel=0, abs=1e-12)
    assert not any(potential(-depth, KAPPA, offset, analog) for depth in depths)


@pytest.mark.parametrize("edge", [0.0, -1.0])
@pytest.mark.parametrize("analog", [False, True])
def test_split_of_a_closed_walk(edge: float, analog: bool) -> None:
    """Straight steps cut so finely that none crosses an edge: each is late entry, late exit or staircase as a whole."""
    numbers = np.random.default_rng(3)
    x = np.append(numbers.integers(-4 * 64, 3 * 64, 30), 0) / 64.0
    x[-1] = x[0]
    torque = numbers.choice([0.0, 1.3, 2.9], 30)
    entry = leaving = staircase = 0.0
    for a, b, u in zip(x, x[1:], torque, strict=False):
        pieces = round(abs(b - a) * 64)
        for k in range(pieces):
            low, high = a + (b - a) * k / pieces, a + (b - a) * (k + 1) / pieces
            depth = edge - (low + high) / 2
            ideal = 0.0 if depth < 0.0 else KAPPA * (depth if analog else np.floor(depth) + 1.0)
            work = (u - ideal) * (high - low)
            if depth < 0.0:
                leaving += work
            elif u == 0.0:
                entry += work
            else:
                staircase += work
    found = split_leak(x, torque, edge=edge, kappa=KAPPA, offset=0.0, analog=analog)
    assert found == pytest.approx((entry, leaving, staircase), rel=0, abs=1e-11)
    assert sum(found) == pytest.approx(float((torque * np.diff(x)).sum()), rel=0, abs=1e-11)
