"""Parts of a curve at places where something ends, and the sizes that they say: small numbers, worked out by hand."""

from math import inf, pi

import pytest

from hknob_cli.engine.general.torque_curve import (
    CENTRE,
    DETENT,
    FAR,
    HALF,
    HEAD,
    HIGH,
    HIGHEST,
    LOW,
    LOWEST,
    MIDDLE,
    MOST,
    POINTS,
    SHAPE,
    SINE,
    SPACING,
    SPAN,
    SPRING,
    SPRUNG,
    STEPPED,
    STOP,
    TRIANGLE,
    ZONE,
    bend_of,
    curve_at,
    detents_at,
    place_at,
    profile_at,
    rounded_size,
    stops_at,
    zone_at,
)

NOTHING = (0.0, 0.0, inf, 0.0, 0.0)


def curve(points: tuple[tuple[float, float], ...] = (), **numbers: float) -> list[float]:
    values = [0.0] * HEAD + [x for x, _ in points] + [u for _, u in points]
    names = {
        **{"span": SPAN, "stepped": STEPPED, "detent": DETENT, "spacing": SPACING, "centre": CENTRE, "shape": SHAPE},
        **{"zone": ZONE, "begin": LOW, "end": HIGH, "stop": STOP, "low": LOWEST, "high": HIGHEST, "spring": SPRING},
        **{"half": HALF, "middle": MIDDLE, "most": MOST, "far": FAR},
    }
    open_ = {"spacing": 1.0, "begin": -inf, "end": inf, "low": -inf, "high": inf, "most": inf}
    for name, value in {**open_, **numbers}.items():
        values[names[name]] = value
    values[POINTS] = len(points)
    return values


RAMP = ((-2.0, 1.0), (0.0, 5.0), (4.0, -3.0))


@pytest.mark.parametrize(
    ("x", "said"),
    [
        (-5.0, (1.0, 0.0, 3.0, 0.0, 1.0)),
        (-2.0, (1.0, 2.0, 0.0, 2.0, 6.0)),
        (-1.5, (2.0, 2.0, 0.5, 2.0, 6.0)),
        (-0.5, (4.0, 2.0, 0.5, 2.0, 6.0)),
        (0.0, (5.0, -2.0, 0.0, 2.0, 8.0)),
        (1.0, (3.0, -2.0, 1.0, 2.0, 8.0)),
        (4.0, (-3.0, 0.0, 0.0, 0.0, 3.0)),
        (6.0, (-3.0, 0.0, 2.0, 0.0, 3.0)),
    ],
)
def test_a_profile(x: float, said: tuple[float, ...]) -> None:
    """To a point belongs what follows it."""
    assert profile_at(x, curve(RAMP)) == said
    stepped = curve(RAMP, stepped=1.0)
    u = {-5.0: 1.0, -2.0: 1.0, -1.5: 1.0, -0.5: 1.0, 0.0: 5.0, 1.0: 5.0, 4.0: -3.0, 6.0: -3.0}[x]
    assert profile_at(x, stepped) == (u, 0.0, said[2], 0.0, abs(u))


def test_the_size_of_a_profile_is_that_of_both_ends() -> None:
    assert profile_at(-1.0, curve(((-2.0, -1.0), (0.0, 5.0)))) == (2.0, 3.0, 1.0, 3.0, 6.0)


@pytest.mark.parametrize("scale", [1.0, 0.125])
def test_a_profile_that_repeats(scale: float) -> None:
    """Also one that is shorter than a count."""
    points = tuple((scale * x, u) for x, u in (*RAMP[:2], (4.0, 1.0)))
    repeats = curve(points, span=6.0 * scale)
    for turns in (-3, 0, 2):
        for x, (u, slope, room) in {-1.5: (2.0, 2.0, 0.5), 1.0: (4.0, -1.0, 1.0), -2.0: (1.0, 2.0, 0.0)}.items():
            found = profile_at(scale * (x + 6.0 * turns), repeats)
            assert found[:3] == pytest.approx((u, slope / scale, room * scale))
    assert [place_at(scale * x, repeats) for x in (-2.0, -0.1, 0.0, 3.9, 4.0, 6.0, -2.1)] == [0, 0, 1, 1, 2, 3, -1]


def test_many_points_are_found() -> None:
    points = tuple((float(k), float(k * k)) for k in range(9))
    for k in range(8):
        assert profile_at(k + 0.25, curve(points, stepped=1.0))[:3] == (k * k, 0.0, 0.25)
        assert profile_at(k + 0.25, curve(points))[1] == 2 * k + 1


# Detents of 3, 4 counts apart, about 1; shape: at a place, torque, slope, room, steepest slope, size.
DETENTS = {"detent": 3.0, "spacing": 4.0, "centre": 1.0}


@pytest.mark.parametrize(
    ("shape", "x", "said"),
    [
        (TRIANGLE, 1.0, (0.0, -3.0, 1.0, 3.0, 3.0)),
        (TRIANGLE, 1.5, (-1.5, -3.0, 0.5, 3.0, 3.0)),
        (TRIANGLE, 2.0, (-3.0, -3.0, 0.0, 3.0, 3.0)),
        (TRIANGLE, 2.5, (-1.5, 3.0, 0.5, 3.0, 3.0)),
        (TRIANGLE, 0.75, (0.75, -3.0, 0.75, 3.0, 3.0)),
        (TRIANGLE, -0.5, (1.5, 3.0, 0.5, 3.0, 3.0)),
        (SPRUNG, 1.0, (0.0, -1.5, 2.0, 1.5, 3.0)),
        (SPRUNG, 2.5, (-2.25, -1.5, 0.5, 1.5, 3.0)),
        (SPRUNG, -0.5, (2.25, -1.5, 0.5, 1.5, 3.0)),
        (SINE, 1.0, (0.0, -1.5 * pi, inf, 1.5 * pi, 3.0)),
        (SINE, 2.0, (-3.0, 0.0, inf, 1.5 * pi, 3.0)),
        (SINE, 0.0, (3.0, 0.0, inf, 1.5 * pi, 3.0)),
    ],
)
def test_detents(shape: float, x: float, said: tuple[float, ...]) -> None:
    for turns in (0, 5, -3):
        assert detents_at(x + 4.0 * turns, curve(**DETENTS, shape=shape)) == pytest.approx(said, abs=1e-12)


@pytest.mark.parametrize(
    ("x", "said"),
    [
        (1.0, (0.0, 0.0, 0.5, 0.0, 0.0)),
        (1.25, (0.0, 0.0, 0.25, 0.0, 0.0)),
        (1.5, (0.0, -2.0, 0.0, 2.0, 3.0)),
        (1.75, (-0.5, -2.0, 0.25, 2.0, 3.0)),
        (2.75, (-2.5, -2.0, 0.25, 2.0, 3.0)),
        (0.25, (0.5, -2.0, 0.25, 2.0, 3.0)),
    ],
)
def test_springs_with_a_zone_between(x: float, said: tuple[float, ...]) -> None:
    """Half a count to either side nothing, and then 3 in a count and a half."""
    assert detents_at(x, curve(**DETENTS, shape=SPRUNG, zone=1.0)) == pytest.approx(said)


def test_a_zone_between_springs_ends_with_the_detents() -> None:
    assert detents_at(1.25, curve(**DETENTS, shape=SPRUNG, zone=1.0, end=1.375)) == (0.0, 0.0, 0.125, 0.0, 0.0)


@pytest.mark.parametrize("shape", [SINE, TRIANGLE, SPRUNG])
def test_detents_end(shape: float) -> None:
    some = curve(**DETENTS, shape=shape, begin=-0.5, end=2.5)
    free = curve(**DETENTS, shape=shape)
    assert detents_at(-0.75, some) == (0.0, 0.0, 0.25, 0.0, 0.0)
    assert detents_at(3.25, some) == (0.0, 0.0, 0.75, 0.0, 0.0)
    for x, room in ((-0.5, 0.0), (-0.375, 0.125), (2.25, 0.25), (2.5, 0.0)):
        inside, endless = detents_at(x, some), detents_at(x, free)
        assert inside[:2] == endless[:2]
        assert inside[2:] == (min(room, endless[2]), *endless[3:])
    for one in (some, curve(**{**DETENTS, "detent": 0.5}, shape=shape, begin=-0.5, end=2.5)):
        assert [place_at(x, one) for x in (-9.0, -0.75, -0.5, 0.5, 2.5, 2.75, 9.0)] == [0, 0, 0, 1, 1, 2, 2]


def test_detents_number_places() -> None:
    assert [place_at(x, curve(**DETENTS, shape=SINE)) for x in (-1.1, -0.9, 2.9, 3.1, 7.1)] == [0, 1, 1, 2, 3]


def test_no_detents_bend_nothing() -> None:
    assert detents_at(0.3, curve()) == NOTHING
    assert bend_of(curve(**DETENTS, shape=SINE)) == pytest.approx(3.0 * (0.5 * pi) ** 2)
    assert bend_of(curve(**DETENTS, shape=SPRUNG)) == bend_of(None) == 0.0


@pytest.mark.parametrize(
    ("low", "high", "x", "said"),
    [
        (-2.0, 5.0, -3.5, (1.5, -1.0, 1.5, 1.0, 5.5)),
        (-2.0, 5.0, -2.0, (0.0, 0.0, 0.0, 0.0, 0.0)),
        (-2.0, 5.0, -0.5, (0.0, 0.0, 1.5, 0.0, 0.0)),
        (-2.0, 5.0, 4.0, (0.0, 0.0, 1.0, 0.0, 0.0)),
        (-2.0, 5.0, 5.0, (0.0, 0.0, 0.0, 0.0, 0.0)),
        (-2.0, 5.0, 7.0, (-2.0, -1.0, 2.0, 1.0, 12.0)),
        (-9.0, -1.0, -0.5, (-0.5, -1.0, 0.5, 1.0, 1.5)),
        (1.0, 9.0, 0.5, (0.5, -1.0, 0.5, 1.0, 1.5)),
        (1.0, 9.0, -0.5, (1.5, -1.0, 1.5, 1.0, 1.5)),
    ],
)
def test_stops(low: float, high: float, x: float, said: tuple[float, ...]) -> None:
    assert stops_at(x, curve(stop=1.0, low=low, high=high)) == said
    u, slope, room, steepest, size = stops_at(x, curve(stop=4.0, low=low, high=high))
    assert (u / 4.0, slope / 4.0, room, steepest / 4.0, size / 4.0) == said
    assert stops_at(x, curve()) == NOTHING
    for stop in (4.0, 0.5):
        assert place_at(x, curve(stop=stop, low=low, high=high)) == (x > low) + (x > high)


@pytest.mark.parametrize(
    ("x", "said"),
    [
        (1.0, (0.0, 0.0, 0.5, 0.0, 0.0)),
        (1.25, (0.0, 0.0, 0.25, 0.0, 0.0)),
        (1.5, (0.0, -4.0, 0.0, 4.0, 4.0)),
        (2.0, (-2.0, -4.0, 0.5, 4.0, 6.0)),
        (2.75, (-5.0, -4.0, 0.25, 4.0, 9.0)),
        (3.0, (-6.0, 0.0, 0.0, 0.0, 6.0)),
        (4.0, (-6.0, 0.0, 1.0, 0.0, 6.0)),
        (0.5, (0.0, -4.0, 0.0, 4.0, 4.0)),
        (0.25, (1.0, -4.0, 0.25, 4.0, 5.0)),
        (0.0, (2.0, -4.0, 0.5, 4.0, 6.0)),
        (-3.0, (6.0, 0.0, 2.0, 0.0, 6.0)),
    ],
)
def test_a_dead_zone(x: float, said: tuple[float, ...]) -> None:
    """Of a count about 1, a spring of 4 beyond it, and 6 at most."""
    numbers = {"spring": 4.0, "half": 0.5, "middle": 1.0, "most": 6.0}
    assert zone_at(x, curve(**numbers)) == said
    assert zone_at(x, curve()) == NOTHING
    for one in (numbers, {**numbers, "spring": 0.5}):
        assert place_at(x, curve(**one)) == (x - 1.0 > -0.5) + (x - 1.0 > 0.5)


def test_a_zone_without_a_width_has_no_knee() -> None:
    spring = curve(spring=1.0)
    assert zone_at(0.25, spring) == (-0.25, -1.0, inf, 1.0, 0.25)
    assert zone_at(-2.0, spring) == (2.0, -1.0, inf, 1.0, 2.0)


def test_parts_add_up() -> None:
    """A ramp, detents, stops and a zone at 1.5, and what is rounded there: their sizes, and angles by the slopes."""
    whole = curve(RAMP, **DETENTS, shape=TRIANGLE, stop=4.0, low=2.0, high=5.0, spring=4.0, middle=1.0, half=0.25,
                  most=6.0, far=7.0)  # fmt: skip
    parts = [part(1.5, whole) for part in (profile_at, detents_at, stops_at, zone_at)]
    assert all(part[0] != 0.0 for part in parts)
    u, slope, room, steepest, size = curve_at(1.5, whole)
    assert (u, slope, steepest, size) == tuple(sum(part[i] for part in parts) for i in (0, 1, 3, 4))
    assert room == min(part[2] for part in parts) == 0.25
    assert rounded_size(-1.5, whole) == curve_at(-1.5, whole)[4] + curve_at(-1.5, whole)[3] * (1.5 + 7.0)
    assert rounded_size(1.0, None) == 0.0
    assert curve_at(1.0, None) == NOTHING
    assert place_at(1.5, whole) == 1.0 + (0.0 + 2.0 - 1.0) + 0.0 + 2.0
