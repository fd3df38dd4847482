"""Torque over the measured angle, summed into a table: against the words of each part, count by count."""

from fractions import Fraction
from math import pi, sin
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.controller import command
from hknob_cli.errors import ComputationError
from hknob_cli.scene.general_knob import GeneralKnob, sample_general
from hknob_cli.specs.plan import DeadZone, Detents, Encoder, EndStops, Hand, Knob, Profile, Scene, Wall


def knob(counts: int = 96, *, stiffness: float = 0.0, encoder: Encoder | None = None, **parts: Any) -> GeneralKnob:
    scene = Scene(Knob(1.9e-6), Wall(stiffness), Hand(3e-7, 3e-4, 0.04), None, encoder or Encoder(), None, **parts)
    return sample_general(scene, sample_rate_hz=1000.0, counts_per_rev=counts)


def torque(one: GeneralKnob, count: int) -> float:
    """N·m commanded at a count."""
    return float(command(float(count), float(count), one.wall)) * one.torque_nm


COUNTS = range(-400, 400)


@pytest.mark.parametrize("counts", [96, 100, 1024])
@pytest.mark.parametrize("number", [1, 5, 12])
def test_sine(counts: int, number: int) -> None:
    one = knob(counts, detents=Detents(0.008, number))
    for n in COUNTS:
        assert torque(one, n) == pytest.approx(-0.008 * sin(2.0 * pi * number * n / counts), rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("offset", [0.0, 0.25])
@pytest.mark.parametrize("zone", [0.0, 0.1])
def test_spring_jumps_half_way(offset: float, zone: float) -> None:
    """Half way belongs to the detent above it, to the last count."""
    one = knob(96, encoder=Encoder(offset_counts=offset), detents=Detents(0.008, 12, shape="spring", dead_zone=zone))
    part = zone / (2.0 * pi / 12)
    for n in COUNTS:
        place = (Fraction(n) + Fraction(offset)) * 12 / 96
        away = float(place - int((place + Fraction(1, 2)).__floor__()))
        size = max(0.0, abs(away) - part / 2) / (0.5 - part / 2)
        assert torque(one, n) == pytest.approx(-0.008 * np.sign(away) * size, rel=1e-12, abs=1e-14)
    if offset == 0.0:
        assert torque(one, 4) == pytest.approx(0.008)
        assert torque(one, 3) < 0.0


def test_triangle_peaks_a_quarter_away() -> None:
    one = knob(96, detents=Detents(0.008, 12, shape="triangle"))
    expected = [0.0, -0.004, -0.008, -0.004, 0.0, 0.004, 0.008, 0.004]
    for n in COUNTS:
        assert torque(one, n) == pytest.approx(expected[n % 8], abs=1e-14)


def test_centre_and_spacing() -> None:
    by_number = knob(1024, detents=Detents(0.008, 16, centre=0.01))
    by_spacing = knob(1024, detents=Detents(0.008, spacing=2.0 * pi / 16, centre=0.01))
    for n in COUNTS:
        expected = -0.008 * sin(16 * (2.0 * pi * n / 1024 - 0.01))
        assert torque(by_number, n) == pytest.approx(expected, abs=1e-13)
        assert torque(by_spacing, n) == torque(by_number, n)


def test_range() -> None:
    one = knob(360, detents=Detents(0.008, spacing=0.15, range=(-0.3, 0.45)))
    for n in COUNTS:
        angle = 2.0 * pi * n / 360
        expected = -0.008 * sin(2.0 * pi * angle / 0.15) if -0.3 <= angle <= 0.45 else 0.0
        assert torque(one, n) == pytest.approx(expected, abs=1e-13)


POINTS = ((-0.5, 0.004), (-0.1, 0.001), (0.2, 0.0), (0.4, -0.006))


def test_profile() -> None:
    linear, stepped = (knob(128, profile=Profile(POINTS, kind)) for kind in ("linear", "stepped"))
    for n in COUNTS:
        angle = 2.0 * pi * n / 128
        between = np.interp(angle, *zip(*POINTS, strict=True))
        assert torque(linear, n) == pytest.approx(float(between), abs=1e-14)
        step = next((t for a, t in reversed(POINTS) if a <= angle), POINTS[0][1])
        assert torque(stepped, n) == pytest.approx(step, abs=1e-14)


@pytest.mark.parametrize("span", [2.0 * pi / 3, 2.0 * pi, 6.0 * pi])
@pytest.mark.parametrize("kind", ["linear", "stepped"])
def test_periodic_profile(span: float, kind: str) -> None:
    shares, torques = (0.0, 0.1, 0.45, 0.8, 1.0), (0.002, -0.004, 0.001, 0.003, 0.002)
    start = -0.2001
    points = tuple((start + share * span, u) for share, u in zip(shares, torques, strict=True))
    one = knob(128, profile=Profile(points, kind, periodic=True))
    for n in COUNTS:
        place = ((2.0 * pi * n / 128 - start) / span) % 1.0
        if kind == "linear":
            expected = float(np.interp(place, shares, torques))
        else:
            expected = next(u for share, u in reversed(list(zip(shares, torques, strict=True))) if share <= place)
        assert torque(one, n) == pytest.approx(expected, abs=1e-13)


def test_a_step_on_a_count_begins_there() -> None:
    """2 pi / 12 is not a double: a count and a step that are meant to be one angle are one."""
    for count in range(1, 40):
        for angle in (2.0 * pi * count / 12, count * (2.0 * pi / 12), round(2.0 * pi / 12 * count, 15)):
            one = knob(12, profile=Profile(((-1.0, 0.001), (angle, 0.002)), "stepped"))
            assert torque(one, count) == pytest.approx(0.002)
            assert torque(one, count - 1) == pytest.approx(0.001)


def test_end_stops_and_dead_zone() -> None:
    stops = knob(128, end_stops=EndStops(0.5, -0.3, 1.0))
    low_only = knob(128, end_stops=EndStops(0.5, low=-0.3))
    zone = knob(128, dead_zone=DeadZone(0.2, 0.3, centre=0.1))
    limited = knob(128, dead_zone=DeadZone(0.2, 0.3, torque=0.05))
    for n in COUNTS:
        angle = 2.0 * pi * n / 128
        below, above = 0.5 * max(0.0, -0.3 - angle), 0.5 * max(0.0, angle - 1.0)
        assert torque(stops, n) == pytest.approx(below - above, abs=1e-13)
        assert torque(low_only, n) == pytest.approx(below, abs=1e-13)
        over = max(0.0, angle - 0.2) - max(0.0, -angle)
        assert torque(zone, n) == pytest.approx(-0.3 * over, abs=1e-13)
        over = max(0.0, angle - 0.1) - max(0.0, -0.1 - angle)
        assert torque(limited, n) == pytest.approx(-min(0.05, max(-0.05, 0.3 * over)), abs=1e-13)


def test_torques_add_up() -> None:
    parts: dict[str, Any] = {
        "profile": Profile(POINTS),
        "detents": Detents(0.008, 12, shape="triangle"),
        "end_stops": EndStops(0.5, -0.3, 1.0),
        "dead_zone": DeadZone(0.2, 0.3),
    }
    together = knob(100, stiffness=0.27, **parts)
    alone = [knob(100, stiffness=0.27), *(knob(100, **{name: part}) for name, part in parts.items())]
    for n in COUNTS:
        assert torque(together, n) == pytest.approx(sum(torque(one, n) for one in alone), abs=1e-12)


def test_without_a_part_there_is_no_table() -> None:
    assert knob(128, stiffness=0.27).wall.table is None


def test_a_table_that_is_too_long_is_refused() -> None:
    with pytest.raises(ComputationError, match="takes a table of"):
        knob(10_000_000, end_stops=EndStops(0.5, -3.0, 3.0))


def test_an_encoder_without_counts_is_refused() -> None:
    scene = Scene(Knob(1.9e-6), Wall(0.27), None, None, Encoder(), None, end_stops=EndStops(0.5, -1.0))
    with pytest.raises(ComputationError, match="needs an encoder's counts"):
        sample_general(scene, sample_rate_hz=1000.0, counts_per_rev=None)
