"""Checks of recorded motions and of the work of orbits, against motions drawn by hand."""

from math import pi
from typing import Any

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import compute
from tests.page.claims.conftest import SCENE, Made

Q = 2.0 * pi / 1000


def row(time: float, angle: float, torque: float = 0.0, event: str = "", velocity: float = 0.0) -> dict[str, Any]:
    return {
        "sample_rate_hz": 1000.0,
        "counts_per_rev": 1000,
        "trial": 0,
        "time_s": time,
        "event": event,
        "angle_rad": angle * Q,
        "velocity_rad_s": velocity,
        "torque_nm": torque * 0.27 * Q,
        "energy_j": 0.0,
    }


def test_contacts_and_what_is_left(made: Made) -> None:
    track = [
        row(t * 1e-3, x, velocity=v) for t, (x, v) in enumerate([(1, -2), (-4, 1), (1, 1), (-1, 0), (-2, 0), (-1.5, 1)])
    ]
    evidence = made("a", {"trajectories": track})
    assert compute("contacts", evidence, {"result": "a"}) == 2
    assert compute("left_after", evidence, {"result": "a", "seconds": 2e-3}) == pytest.approx(25.0)
    assert compute("left_after", evidence, {"result": "a", "seconds": 1.0}) is None


def test_the_work_of_a_contact(made: Made) -> None:
    """One step of torque over a way out of three counts; held from samples, the analog wall does less."""
    track = [row(0, 0.0), row(1e-3, -1.0, 1.0, "sample"), row(2e-3, 0.0, 1.0, "sample"), row(3e-3, 2.0, 0.0, "sample")]
    made("counts", {"trajectories": track})
    evidence = made("analog", {"trajectories": [*track[:2], row(2e-3, 0.0, 0.0, "sample")]})
    unit = 0.27 * Q * Q
    assert compute("contact_gain", evidence, {"result": "counts"}) == pytest.approx(3.0 * unit)
    ratio = {"result": "counts", "to": "analog"}
    assert compute("contact_gain_ratio", evidence, ratio) == pytest.approx(3.0)
    assert compute("contact_gain_ratio", evidence, {**ratio, "same_motion": True}) == pytest.approx(3.0)
    assert compute("extra_on_exit", evidence, {"result": "counts"}) == pytest.approx(100.0)


def test_what_counts_add_inside_is_not_of_the_exit(made: Made) -> None:
    """A whole count's torque at half a count's depth: a half too much, half a count inside and a whole one outside."""
    track = [row(0, 0.0), row(1e-3, -0.5, 1.0, "sample"), row(2e-3, 1.0, 0.0, "sample")]
    evidence = made("a", {"trajectories": track})
    assert compute("extra_on_exit", evidence, {"result": "a"}) == pytest.approx(100.0 * 0.5 / 0.75)
    assert compute("extra_on_exit", evidence, {"result": "a", "after": 1.0}) is None


def test_the_staircase_of_floor(made: Made) -> None:
    """In at a steady speed to a depth of two counts, and out: half a count too deep on average, never too shallow."""
    depths = [i / 10 for i in range(21)]
    inward = [row(i * 1e-3, -depth, int(depth + 1e-9) + 1.0, velocity=-1.0) for i, depth in enumerate(depths[:-1])]
    evidence = made("a", {"trajectories": [row(-1e-3, 0.1, velocity=-1.0), *inward, row(20e-3, -2.0, 2.0)]})
    assert compute("reading_offset", evidence, {"result": "a"}) == pytest.approx(0.5, abs=1e-9)
    assert compute("reading_offset", evidence, {"result": "a", "statistic": "least"}) == pytest.approx(0.0, abs=1e-9)
    outward = [
        row(0.1 + i * 1e-3, depth - 2.0, int(2.0 - depth - 1e-9) + 1.0, velocity=1.0) for i, depth in enumerate(depths)
    ]
    outward[-1]["torque_nm"] = 0.0
    late = {**outward[10], "torque_nm": outward[9]["torque_nm"]}
    both = made("b", {"trajectories": [row(-1e-3, 0.1, velocity=-1.0), *inward, *outward]})
    assert compute("staircase_asymmetry", both, {"result": "b"}) == pytest.approx(0.0, abs=1e-9)
    lagging = made("c", {"trajectories": [row(-1e-3, 0.1), *inward, *outward[:10], late, *outward[11:]]})
    assert compute("staircase_asymmetry", lagging, {"result": "c"}) == pytest.approx(0.1, abs=1e-9)


def test_switches_and_their_delay(made: Made) -> None:
    """Crossings a quarter of an interval before the samples that see them."""
    track = []
    for k in range(8):
        side = 1.0 if k % 2 else -1.0
        track += [row(k * 1e-3, 0.5 * side, float(side < 0), "sample"), row((k + 0.75) * 1e-3, 0.0, float(side < 0))]
    evidence = made("a", {"trajectories": track})
    steady = {"result": "a", "after": 1.5e-3}
    assert compute("switches_at_samples", evidence, steady) == 100.0
    assert compute("switch_delay", evidence, steady) == pytest.approx(0.25, abs=1e-9)
    assert compute("switch_distance", evidence, steady) == pytest.approx(50.0)


def orbit(entry: float, exit_: float, staircase: float, low: float, high: float, basin: float) -> dict[str, Any]:
    work = entry + exit_ + staircase
    return {
        "sample_rate_hz": 1000.0,
        "counts_per_rev": 1000,
        "outcome": "cycle",
        "wall_work_j": work,
        "damping_loss_j": work,
        "late_entry_j": entry,
        "late_exit_j": exit_,
        "staircase_j": staircase,
        "min_rad": low * Q,
        "max_rad": high * Q,
        "basin_fraction": basin,
    }


def test_the_work_of_orbits(made: Made) -> None:
    rows = [orbit(1.0, 3.0, 0.0, -0.5, 0.5, 0.75), orbit(0.0, 0.0, 2.0, -2.5, -0.5, 0.25)]
    evidence = made("a", {"orbits": [*rows, {**rows[0], "outcome": "rest"}]}, scene=SCENE)
    share = {"result": "a", "parts": ["late_exit_j"]}
    assert compute("leak_share", evidence, share) == pytest.approx(37.5)
    assert compute("leak_share", evidence, {**share, "statistic": "largest"}) == pytest.approx(75.0)
    assert compute("least_leak_share", evidence, {"result": "a"}) == 0.0
    assert compute("work_over_loss", evidence, {"result": "a"}) == 0.0
    assert compute("orbits_at_wall", evidence, {"result": "a"}) == 75.0
    assert compute("orbits_over_edges", evidence, {"result": "a", "most": 1}) == 75.0
    assert compute("orbits_over_edges", evidence, {"result": "a", "most": 2}) == 100.0
    with pytest.raises(UsageError, match="parts"):
        compute("leak_share", evidence, {"result": "a", "parts": ["exit"]})
