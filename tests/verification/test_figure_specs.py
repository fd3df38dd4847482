"""Specs of the figures without a sample clock, and of the hardware grid, against models with 50 and 60 digits."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.specs.load import load
from hknob_cli.specs.source import read
from hknob_cli.stages.sweep.record import record_sweep
from tests import digits as mp
from tests.conftest import EXPERIMENTS, swept

from .general_reference import simulate
from .unsampled_reference import Ball

J, G = 2.2e-6, 0.001
COUNT = 2.0 * np.pi / 4096


def scene(name: str) -> dict[str, Any]:
    return read(EXPERIMENTS / f"{name}.yaml").value


def ball(name: str) -> Ball:
    spec = scene(name)
    parts, hand = spec["scene"], spec["scene"]["hand"]
    return Ball(
        inertia=mp.mpf(parts["knob"]["inertia"]) + mp.mpf(hand["inertia"]),
        damping=mp.mpf(hand.get("damping", 0)),
        stiffness=mp.mpf(0),
        wall=mp.mpf(parts["wall"]["stiffness"]),
        bias=mp.mpf(parts["bias"]["torque"]),
        quantum=2 * mp.pi / spec["grid"]["counts_per_rev"],
    )


def events(name: str) -> dict[float, list[dict[str, Any]]]:
    """Recorded events by where the recording starts, the start left out."""
    rows = record_sweep(load(EXPERIMENTS / f"{name}.yaml", ())).to_pylist()
    found: dict[float, list[dict[str, Any]]] = {}
    for row in rows:
        if row["event"]:
            found.setdefault(row.get("start_rad", scene(name)["starts"]["angle"]), []).append(row)
    return {start: ones[1:] for start, ones in found.items()}


@pytest.mark.parametrize(
    ("name", "most", "starts"),
    [
        ("encoder_wall", 40, 1),
        ("encoder_wall_damped", 30, 1),
        ("stiff_wall", 16, 3),
        ("stiff_wall_contact", 3, 1),
    ],
)
def test_events_of_a_wall_without_a_clock(name: str, most: int, starts: int) -> None:
    """Figs. 23-26: count edges and turning points, in time and angle.

    A velocity is rounded at each event, 1e-16 of the largest; 40 of them, and a turning point's time from the bias
    alone, leave 1e-13 of a flight and of the highest angle.
    """
    found = events(name)
    assert len(found) == starts
    for start, rows in found.items():
        expected = ball(name).run(start, scene(name)["starts"].get("velocity", 0.0), min(most, len(rows)))
        assert len(expected) >= min(most, 3)
        scale = float(expected[-1][0])
        high = max(start, *(float(abs(row[1])) for row in expected))
        for got, (time, theta, omega, _level) in zip(rows, expected, strict=False):
            assert got["time_s"] == pytest.approx(float(time), rel=0, abs=1e-12 * scale)
            assert got["angle_rad"] == pytest.approx(float(theta), rel=0, abs=1e-13 * high)
            assert got["velocity_rad_s"] == pytest.approx(float(omega), rel=0, abs=1e-12 * 5.0)


@pytest.mark.parametrize("name", ["encoder_wall", "stiff_wall"])
def test_counts_alone_add_no_energy(name: str) -> None:
    """Figs. 23, 24: at every peak, of every start, the energy of the start, g theta."""
    for start, rows in events(name).items():
        peaks = [row for row in rows if row["velocity_rad_s"] == 0.0 and row["angle_rad"] > 0.0]
        assert len(peaks) >= 3
        assert [row["energy_j"] for row in peaks] == pytest.approx([G * start] * len(peaks), rel=1e-13)


def test_a_stiff_wall_is_entered() -> None:
    """Fig. 25: one step of torque, K times one count; depth by the balance of energy, g h = (K dtheta - g) depth."""
    rows = events("stiff_wall_contact")[1.0e-5]
    step = 27.0 * 2.0 * np.pi / 128
    assert [row["torque_nm"] for row in rows] == pytest.approx([step, step, 0.0], rel=1e-14)
    depth = (0.5 * J * 4.263**2 + G * 1.0e-5) / (step - G)
    assert rows[1]["angle_rad"] == pytest.approx(-depth, rel=1e-10)
    assert depth == pytest.approx(15.1e-6, rel=1e-2)


def test_contact_settles_in_about_50_ms() -> None:
    """Fig. 26: the motion left spans one count 19 ms after first contact; 0.07 of one, 1.5 % of its depth, after 50."""
    orbit = swept(EXPERIMENTS / "encoder_wall_damped.yaml").orbits.to_pylist()[0]
    turns = [(float(t), float(x)) for t, x, v, _ in ball("encoder_wall_damped").run(0.02, 0, 60) if v == 0]
    entry = float(ball("encoder_wall_damped").run(0.02, 0, 1)[0][0])
    assert orbit["contact_s"] == pytest.approx(entry, rel=1e-12)
    settled = orbit["settling_s"]
    later = [x for t, x in turns if t > settled]
    earlier = [x for t, x in turns if t < settled]
    # At that time the knob rises through the height one count above the lowest turn to come.
    assert np.ptp(later) <= COUNT < earlier[-1] - min(later)
    at_end = [x for t, x in turns if t > entry + 0.05]
    assert np.ptp(at_end) == pytest.approx(0.074 * COUNT, rel=0.01)
    assert orbit["max_rad"] == pytest.approx(-2.0 * COUNT, rel=1e-14)


CELLS = [(455.0, 256), (1000.0, 512), (1000.0, 1024), (4000.0, 512), (4000.0, 1024), (455.0, 2048), (4000.0, 2048)]


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("rate", "counts"), CELLS)
@pytest.mark.parametrize("name", ["chapter8", "chapter8_friction"])
def test_hardware_grid(name: str, rate: float, counts: int) -> None:
    """Chapter 8: the trial sampled half a period after its start, 0.2 s long, to 60 digits, ends in the orbit found.

    What a period changes in the state, e, shrinks from period to period at least as the hand does, by exp(-b t / 2J):
    e/(1 - that) remains, in the norm of energy, whose ratio to distances is below 2.
    """
    setting = (f"grid.sample_rate_hz={rate}", f"grid.counts_per_rev={counts}", "starts.phases=1")
    orbit = swept(EXPERIMENTS / f"{name}.yaml", *setting).orbits.to_pylist()[0]
    trial = simulate(
        scene(name)["scene"],
        sample_rate_hz=rate,
        counts_per_rev=counts,
        angle_rad=0.02,
        velocity_rad_s=0.0,
        samples=int(0.2 * rate),
        find_turns=True,
    )
    if orbit["outcome"] == "rest":
        assert trial.samples[-1].velocity == 0
        assert trial.samples[-1].angle == trial.samples[-20].angle
        return
    period, cycles = orbit["period_samples"], orbit["cycles_per_period"]
    turns = np.array([float(x) for x in trial.friction.turns[-2 * cycles :]])
    peak_to_peak = abs(turns[::2].mean() - turns[1::2].mean())
    now, before = trial.samples[-1], trial.samples[-1 - period]
    change = float(abs(now.angle - before.angle) + abs(now.velocity - before.velocity) / mp.sqrt(0.04 / J))
    bound = 2.0 * change / (1.0 - np.exp(-0.5 * 3.45e-4 / J * period / rate))
    assert bound < 0.02 * orbit["p2p_rad"]
    assert orbit["p2p_rad"] == pytest.approx(peak_to_peak, rel=0, abs=bound)
    assert orbit["frequency_hz"] == pytest.approx(cycles * rate / period, rel=1e-14)
    one_before = [float(x) for x in trial.friction.turns[-4 * cycles : -2 * cycles]]
    assert one_before == pytest.approx(turns, rel=0, abs=2.0 * bound)


def test_friction_of_the_hardware_stops_it_at_2048_counts() -> None:
    """There friction exceeds half the torque of a count, at every rate; elsewhere pitch rises and size falls."""
    bare, rough = (
        (swept(EXPERIMENTS / f"{name}.yaml").cells.to_pylist()) for name in ("chapter8", "chapter8_friction")
    )
    for one, other in zip(bare, rough, strict=True):
        assert one["certified_fraction"] == other["certified_fraction"] == 1.0
        assert one["at_rest_fraction"] == 0.0
        stops = 0.5 * 0.27 * 2.0 * np.pi / one["counts_per_rev"] < 0.56e-3
        assert other["at_rest_fraction"] == (1.0 if stops else 0.0)
        assert stops or other["frequency_hz"] > one["frequency_hz"]
        assert stops or other["p2p_rad"] < one["p2p_rad"]
    ratios = [b["frequency_hz"] / a["frequency_hz"] for a, b in zip(bare, rough, strict=True) if b["frequency_hz"]]
    assert np.mean(ratios) == pytest.approx(2.21, abs=0.01)
