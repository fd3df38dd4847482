"""Tones in noise: against the printed examples of ISO/PAS 20065:2016, Annex E, and tables of DIN 45681:2005."""

from math import log10

import numpy as np
import pytest

from hknob_cli.perception.hearing import (
    LEAST_HZ,
    band_level,
    critical_band,
    critical_bandwidth,
    hearing_threshold,
    judge,
    masked_threshold,
    masking_index,
)
from hknob_cli.specs.perception import Background

# ISO/PAS 20065, Annex E, Tables E.1 and E.2: an engine's spectrum, as github.com/jmrplens/phonometry
# has it. Frequency of a tone (Hz), mean level of a line of noise, level of the tone, level of the noise in the critical
# band, masking index, audibility (dB), and the first and the last line within the band (Hz).
LINE_HZ = 2.6917  # printed as 2.7 there, and to four decimals in DIN 45681
ENGINE = [
    (118.4, 48.91, 64.56, 64.66, -2.01, 1.92, 80.7, 177.6),
    (137.3, 49.22, 67.96, 64.98, -2.02, 4.99, 96.9, 196.5),
    (158.8, 50.50, 68.63, 66.28, -2.02, 4.37, 118.4, 215.3),
    (314.9, 52.85, 68.50, 68.84, -2.12, 1.78, 266.5, 371.4),
    (433.4, 58.29, 73.17, 74.52, -2.23, 0.87, 382.2, 492.6),
    (592.2, 59.53, 78.31, 76.16, -2.40, 4.55, 535.6, 656.8),
    (629.8, 59.71, 75.00, 76.44, -2.44, 1.01, 570.6, 694.4),
    (643.3, 61.98, 79.75, 78.74, -2.46, 3.47, 584.1, 707.9),
    (1582.7, 54.16, 71.07, 73.60, -3.27, 0.73, 1469.6, 1703.8),
]
# DIN 45681, Table A.1: width of the critical band, whole Hz. Its formula does not give two rows, which
# are left out: 105 at 250 Hz (104.5), and 3469 at 13.5 kHz (3467.9).
WIDTHS = [
    *((100, 101), (150, 102), (350, 109), (450, 114), (570, 122), (700, 133), (840, 145), (1000, 162), (1170, 182)),
    *((1370, 207), (1600, 239), (1850, 277), (2150, 325), (2500, 386), (2900, 460), (3400, 559), (4000, 685)),
    *((4800, 867), (5800, 1111), (7000, 1426), (8500, 1851), (10500, 2463)),
]  # fmt: skip


@pytest.mark.parametrize(("frequency", "width"), WIDTHS)
def test_critical_bands_are_as_wide_as_printed(frequency: float, width: float) -> None:
    assert float(critical_bandwidth(frequency)) == pytest.approx(width, abs=0.5)


@pytest.mark.parametrize(("frequency", "line", "tone", "band", "index", "audible", "first", "last"), ENGINE)
def test_the_printed_example_of_an_engine(
    frequency: float, line: float, tone: float, band: float, index: float, audible: float, first: float, last: float
) -> None:
    """Two decimals are printed: of a level and its sum with another, half a hundredth and a whole one."""
    width, (low, high) = float(critical_bandwidth(frequency)), critical_band(frequency)
    assert first - LINE_HZ < low <= first + 0.05
    assert last - 0.05 <= high < last + LINE_HZ
    noise = line + 10.0 * log10(width / LINE_HZ)
    assert noise == pytest.approx(band, abs=0.015)
    assert float(masking_index(frequency)) == pytest.approx(index, abs=0.0051)
    assert tone - noise - float(masking_index(frequency)) == pytest.approx(audible, abs=0.03)


def test_a_white_background_of_the_engines_line_masks_as_the_engine_does() -> None:
    """Noise of 49.22 dB in each line is 87.9 dB from 20 Hz to 20 kHz."""
    white = Background(49.22 + 10.0 * log10(19_980.0 / LINE_HZ), "white")
    assert 67.96 - float(masked_threshold(137.3, white)) == pytest.approx(4.99, abs=0.03)


@pytest.mark.parametrize("spectrum", ["white", "pink"])
def test_the_power_of_a_background_is_that_of_its_bands(spectrum: str) -> None:
    """Bands of three tones side by side have the power of their density, summed by quadrature over fine steps."""
    noise = Background(60.0, spectrum)  # type: ignore[arg-type]
    edges = np.geomspace(20.0, 20e3, 200_001)
    centres, steps = np.sqrt(edges[1:] * edges[:-1]), np.diff(edges)
    density = np.ones_like(centres) if spectrum == "white" else 1.0 / centres
    power = density * steps / (density * steps).sum()
    for frequency in (60.0, 440.0, 5000.0):
        low, high = critical_band(frequency)
        share = power[(centres > low) & (centres < high)].sum()
        assert float(band_level(frequency, noise)) == pytest.approx(60.0 + 10.0 * log10(share), abs=0.01)


def test_a_faint_background_masks_nothing_and_a_loud_one_decides() -> None:
    frequency, level = np.array([100.0, 1000.0]), np.array([40.0, 40.0])
    silent = judge(frequency, level)
    faint = judge(frequency, level, masked_db=masked_threshold(frequency, Background(-20.0)))
    assert faint == silent
    loud = Background(70.0)
    heard = judge(frequency, level, masked_db=masked_threshold(frequency, loud))
    assert float(heard.level_db) == pytest.approx(float((level - masked_threshold(frequency, loud)).max()))
    assert float(heard.level_db) < float((level - hearing_threshold(frequency)).max())


def test_below_50_hz_nothing_is_said_unless_asked_for() -> None:
    noise = Background(60.0)
    assert np.isnan(masked_threshold([20.0, LEAST_HZ - 1.0], noise)).all()
    assert np.isfinite(masked_threshold([20.0, LEAST_HZ], noise, extrapolate=True)).all()
    assert np.isfinite(masked_threshold(LEAST_HZ, noise))
