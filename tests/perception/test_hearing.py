"""Hearing: ISO 226 at the values that its Annex B prints, and the properties of its formulae."""

from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.errors import UsageError
from hknob_cli.perception.hearing import (
    REFERENCE_PA,
    heard_level,
    hearing_threshold,
    in_range,
    judge,
    loudness_level,
    parameters,
    response,
    sensation_level,
    sound_pressure_level,
)
from hknob_cli.perception.level import columns, published

EDITIONS = (2003, 2023)
# ISO 226:2023, Table B.1: (phon, Hz, dB), printed to 0.1 dB, as the tests of github.com/jmrplens/phonometry quote it.
TABLE_B1 = (
    (20, 20, 89.5), (20, 1000, 20.0), (20, 12500, 33.0), (40, 20, 99.7), (40, 63, 73.0), (40, 250, 50.3),
    (40, 1000, 40.0), (40, 4000, 36.7), (40, 8000, 51.6), (60, 100, 78.5), (60, 500, 62.1), (60, 2000, 60.0),
    (80, 20, 118.9), (80, 1000, 80.0), (80, 12500, 85.6), (90, 20, 123.6), (90, 4000, 88.8),
)  # fmt: skip
# Table B.2: (dB, Hz, phon).
TABLE_B2 = ((60, 63, 21.6), (40, 1000, 40.0), (80, 8000, 68.6), (90, 20, 20.8), (70, 400, 67.1), (50, 3150, 53.9))
THIRD_OCTAVES = columns("iso226_2023.csv")["frequency_hz"]


@pytest.mark.parametrize(("phon", "hertz", "level"), TABLE_B1)
def test_levels_of_the_2023_edition(phon: float, hertz: float, level: float) -> None:
    assert sound_pressure_level(hertz, phon) == pytest.approx(level, abs=0.05)


@pytest.mark.parametrize(("level", "hertz", "phon"), TABLE_B2)
def test_loudness_of_the_2023_edition(level: float, hertz: float, phon: float) -> None:
    assert loudness_level(hertz, level) == pytest.approx(phon, abs=0.05)


def test_60_phon_at_100_hz_is_785_db_in_the_2023_edition_and_787_in_the_2003_edition() -> None:
    assert sound_pressure_level(100.0, 60.0, edition=2023) == pytest.approx(78.5, abs=0.05)
    assert sound_pressure_level(100.0, 60.0, edition=2003) == pytest.approx(78.7, abs=0.05)


def test_at_1_khz_a_phon_is_a_decibel() -> None:
    """Exactly so by the 2023 edition; the constants of 2003 leave 0.02 dB, which Parmanen (2012) remarks on."""
    phon = np.linspace(20.0, 90.0, 15)
    assert sound_pressure_level(1000.0, phon) == pytest.approx(phon, abs=1e-9)
    assert sound_pressure_level(1000.0, phon, edition=2003) == pytest.approx(phon, abs=0.02)


@pytest.mark.parametrize("edition", EDITIONS)
def test_tables_have_the_third_octaves_and_the_threshold_of_iso_389_7(edition: int) -> None:
    table = columns(published("hearing")["editions"][edition]["file"])
    assert table["frequency_hz"] == THIRD_OCTAVES
    assert len(THIRD_OCTAVES) == 29
    # Nominal frequencies of ISO 266 round the powers of 10^0.1 to two or three digits, at most 2 %.
    exact = 10.0 ** (0.1 * np.arange(13, 42))
    assert np.array(THIRD_OCTAVES) == pytest.approx(exact, rel=0.02)
    assert table["transfer_db"][THIRD_OCTAVES.index(1000.0)] == 0.0  # by definition
    assert table["threshold_db"][THIRD_OCTAVES.index(1000.0)] == 2.4
    assert THIRD_OCTAVES[int(np.argmin(table["threshold_db"]))] == 3150.0  # the notch at 3 kHz of sec. 10.3


def test_editions_differ_in_every_exponent_and_in_one_threshold() -> None:
    old, new = (columns(f"iso226_{year}.csv") for year in EDITIONS)
    assert all(a < b for a, b in zip(old["alpha"], new["alpha"], strict=True))
    changed = [f for f, a, b in zip(THIRD_OCTAVES, old["threshold_db"], new["threshold_db"], strict=True) if a != b]
    assert changed == [20.0]
    assert old["alpha"][THIRD_OCTAVES.index(1000.0)] == 0.25
    assert new["alpha"][THIRD_OCTAVES.index(1000.0)] == 0.3


@given(hertz=st.floats(20.0, 12500.0), phon=st.floats(20.0, 80.0), edition=st.sampled_from(EDITIONS))
def test_loudness_and_level_are_inverse(hertz: float, phon: float, edition: int) -> None:
    level = sound_pressure_level(hertz, phon, edition=edition)
    # The difference from the power at threshold loses up to four digits of sixteen near 20 phon.
    assert loudness_level(hertz, level, edition=edition, extrapolate=True) == pytest.approx(phon, abs=1e-8)


@given(
    hertz=st.floats(20.0, 12500.0),
    low=st.floats(3.0, 100.0),
    more=st.floats(0.1, 20.0),
    edition=st.sampled_from(EDITIONS),
)
def test_louder_is_more(hertz: float, low: float, more: float, edition: int) -> None:
    levels = sound_pressure_level(hertz, [low, low + more], edition=edition, extrapolate=True)
    assert levels[1] > levels[0]


@pytest.mark.parametrize("edition", EDITIONS)
def test_the_threshold_is_the_contour_of_least_loudness(edition: int) -> None:
    """10^0.072 in the later formula is 2.4 phon; in the earlier, 1.15 is 10^(0.025 * 2.43), known to half a digit."""
    at = sound_pressure_level(THIRD_OCTAVES, 2.4, edition=edition, extrapolate=True)
    # dL/dphon is at most 1.3 dB per phon at threshold; 0.005 of 1.15 is 0.076 phon.
    assert at == pytest.approx(hearing_threshold(THIRD_OCTAVES, edition=edition), abs=1e-9 if edition == 2023 else 0.1)


def test_between_third_octaves_parameters_lie_between_their_neighbours() -> None:
    low, middle, high = parameters([100.0, 112.0, 125.0], edition=2023).threshold_db
    assert high < middle < low
    assert parameters(100.0).alpha == 0.433


def test_frequencies_beyond_the_standard_are_refused() -> None:
    for hertz in (19.9, 12501.0, 0.0, float("nan")):
        with pytest.raises(UsageError, match="outside 20 to 12500 Hz"):
            loudness_level(hertz, 60.0, extrapolate=True)
    assert in_range([19.9, 20.0, 12500.0, 12501.0]).tolist() == [False, True, True, False]


def test_loudness_beyond_the_standard_is_refused_unless_asked_for() -> None:
    for hertz, phon in ((1000.0, 19.0), (1000.0, 91.0), (5000.0, 81.0), (4500.0, 81.0)):
        with pytest.raises(UsageError, match="outside 20 to"):
            sound_pressure_level(hertz, phon)
        level = sound_pressure_level(hertz, phon, extrapolate=True)
        with pytest.raises(UsageError, match="outside 20 to"):
            loudness_level(hertz, level)
        assert loudness_level(hertz, level, extrapolate=True) == pytest.approx(phon, abs=1e-8)
    assert sound_pressure_level(4000.0, 90.0) == pytest.approx(88.8, abs=0.05)
    with pytest.raises(UsageError, match="no edition 1987"):
        loudness_level(1000.0, 60.0, edition=1987)


def test_below_threshold_there_is_no_loudness() -> None:
    assert np.isnan(loudness_level(100.0, 26.4, extrapolate=True))
    with pytest.raises(UsageError, match="below threshold"):
        loudness_level(100.0, 26.4)
    assert sensation_level(100.0, 26.4) == pytest.approx(-0.1)


def test_the_most_audible_tone_decides_and_others_out_of_range_do_not() -> None:
    """At 40 dB, 1 kHz is 37.6 dB above threshold, 100 Hz only 13.5."""
    found = judge([10.0, 100.0, 1000.0, 20000.0], [200.0, 40.0, 40.0, 200.0])
    assert (found.frequency_hz, found.level_db) == (1000.0, pytest.approx(37.6))
    assert np.isnan(judge([10.0], [200.0]).level_db)


def test_sound_is_by_the_gain_that_the_user_gives() -> None:
    """A gain of 1 Pa per rad/s and a peak of sqrt(2) times 20 uPa: 0 dB; the gain that one measurement gives."""
    assert heard_level(sqrt(2.0) * REFERENCE_PA, gain_pa_s_per_rad=1.0) == pytest.approx(0.0, abs=1e-12)
    assert heard_level([1.0, 10.0], gain_pa_s_per_rad=0.02) == pytest.approx([56.99, 76.99], abs=0.005)
    gain = sqrt(2.0) * REFERENCE_PA * 10.0 ** (56.0 / 20.0) / 0.3  # as docs/explanation/perception.md says
    assert heard_level(0.3, gain_pa_s_per_rad=gain) == pytest.approx(56.0)
    for bad in (0.0, -1.0):
        with pytest.raises(UsageError, match="gain"):
            heard_level(1.0, gain_pa_s_per_rad=bad)


def test_a_response_is_a_power_law_between_its_points() -> None:
    """Through (100 Hz, 0.01) and (1000 Hz, 0.1) the gain is 1e-4 f; from there to (4 kHz, 0.025) it is 100 / f."""
    points = ((100.0, 0.01), (1000.0, 0.1), (4000.0, 0.025))
    inside = [100.0, 250.0, 1000.0, 1600.0, 4000.0]
    assert response(inside, points) == pytest.approx([0.01, 0.025, 0.1, 0.0625, 0.025], rel=1e-12)
    assert np.isnan(response([0.0, 99.0, 4001.0], points)).all()
    assert response([0.0, 99.0, 4001.0], points, extrapolate=True) == pytest.approx([0.01, 0.01, 0.025])
    levels = heard_level([1.0, 1.0, 1.0], gain_pa_s_per_rad=response([99.0, 100.0, 1000.0], points))
    assert np.isnan(levels[0])
    assert levels[2] - levels[1] == pytest.approx(20.0)
