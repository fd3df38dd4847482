"""Drawings of remedies and of the senses: what they say, and what they refuse."""

import re
from typing import Any

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.figures import draw, theme
from hknob_cli.results.result_set import MissingError, ResultSet
from tests.page.claims.conftest import Made, cell, made

__all__ = ["made"]
NONE = ResultSet({})


def said(name: str, evidence: ResultSet, of: Any, options: dict[str, Any]) -> str:
    return theme.svg(draw(name, evidence, of, options), name="x", title="")


def tried(remedy: str, p2p: float | None, frequency: float | None, knock: float | None = 1.0) -> dict[str, Any]:
    row = {"case": "a case", "remedy": remedy, "hand": "a hand", "p2p_max_rad": p2p, "frequency_at_max_hz": frequency}
    return {**row, "p2p_rad": p2p or None, "stiffness_kept": 1.0, "knock_ratio": knock}


def test_remedies_stand_in_order_with_what_diverges_last(made: Made) -> None:
    rows = [
        tried("plain wall", 1e-3, 83.0),
        tried("away", None, None, None),
        tried("still", 0.0, None),
        tried("small", 2e-4, 83.0),
    ]
    svg = said("remedy_dots", made("a", {"cases": rows}), "a", {"case": "a case"})
    places = [svg.index(f">{name}<") for name in ("away", "plain wall", "small", "still")]
    assert places == sorted(places)  # from below upward
    for text in ("a hand", "peak to peak, mrad", "frequency, Hz", "at rest"):
        assert text in svg


def test_a_case_that_was_not_tried_is_missing(made: Made) -> None:
    with pytest.raises(MissingError, match="'a' has no case 'another'"):
        draw("remedy_dots", made("a", {"cases": [tried("plain wall", 1e-3, 83.0)]}), "a", {"case": "another"})


def test_contours_and_thresholds_need_no_result() -> None:
    svg = said("equal_loudness", NONE, None, {"phon": [40, 80]})
    for text in ("threshold", "40 phon", "80 phon", "sound pressure level, dB re 20", "frequency, Hz"):
        assert text in svg
    assert "60 phon" not in svg
    svg = said("touch_thresholds", NONE, None, {"sets": ["thenar"], "names": ["a thumb"]})
    assert "a thumb" in svg
    assert "threshold, µm peak" in svg


def test_what_is_not_published_is_refused() -> None:
    with pytest.raises(UsageError, match="20 to 90 phon, not 120"):
        draw("equal_loudness", NONE, None, {"phon": [120]})
    with pytest.raises(UsageError, match="no thresholds of touch 'elbow'"):
        draw("touch_thresholds", NONE, None, {"sets": ["elbow"]})


def test_the_logarithm_of_frequency_moves_the_trough(made: Made) -> None:
    """Sizes fall and pitches rise by equal factors: on logarithms they meet in the middle, else one step later."""
    cells = [cell(10.0**i, 512, 10.0**-i, 10.0**i) for i in range(2, 7)]
    evidence = made("a", {"cells": cells})
    plain = said("surface", evidence, "a", {})
    logs = said("surface", evidence, "a", {"log_pitch": True})
    assert "p: pitch (frequency)" in plain
    assert "p: pitch (log frequency)" in logs
    # Scaled sizes are 1, 3/4, 1/2, 1/4, 0; pitches nearly 0 except the last, or with logarithms 0, 1/4, 1/2, 3/4, 1.
    assert re.findall(r">(\d\.\d\d) [sp]<", plain) == ["1.00", "0.75", "0.50", "0.25", "1.00"]
    assert re.findall(r">(\d\.\d\d) [sp]<", logs) == ["1.00", "0.75", "0.50", "0.75", "1.00"]
