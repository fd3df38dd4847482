"""Checks of single bounces, of senses and of remedies, against motions and tables made by hand."""

import itertools
from math import cos, log10, pi, sin
from typing import Any

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import compute
from hknob_cli.page.claims.checks.motion import Point, worst_delay
from hknob_cli.page.claims.verdict import judge_claim
from hknob_cli.results.result_set import ResultSet
from tests.page.claims.conftest import Made, cell

AFTER = {"result": "a", "after": 0.1}
NOTHING = ResultSet({})


def track(sizes: list[float], periods: list[float], trial: int = 0) -> list[dict[str, Any]]:
    """Bounces of so many rad and s one after the other, each a cosine from peak to peak, from 0.1 s on; peaks at 0."""
    rows, begin = [], 0.1
    for size, period in zip(sizes, periods, strict=True):
        for i in range(64):
            turn = 2.0 * pi * i / 64
            speed = -0.5 * size * sin(turn) * 2.0 * pi / period
            rows.append(row(trial, begin + period * i / 64, 0.5 * size * (cos(turn) - 1.0), speed))
        begin += period
    return rows


def row(trial: int, time: float, angle: float, velocity: float) -> dict[str, Any]:
    keys = {"sample_rate_hz": 1000.0, "counts_per_rev": 1000, "trial": trial, "event": "", "torque_nm": 0.0}
    return {**keys, "time_s": time, "angle_rad": angle, "velocity_rad_s": velocity}


def test_one_bounce_in_five_is_errant(made: Made) -> None:
    """Four of 1 mrad and 4 ms, one of 3 mrad and 9 ms, twelve times; a second trial of equal bounces of 5 ms."""
    sizes, periods = [1e-3] * 4 + [3e-3], [4e-3] * 4 + [9e-3]
    # The first row is at a peak, with no velocity before it: the first peak found is the next one, and the last bounce
    # has no end, so that two of sixty are not seen: the first usual and the last errant one.
    rows = [*track(12 * sizes, 12 * periods), *track([1e-3] * 60, [5e-3] * 60, trial=1)]
    evidence = made("a", {"trajectories": rows})
    assert compute("errant_trials", evidence, AFTER) == 50.0
    # They come every 25 ms, from row to row within 1/64 of a bounce.
    assert compute("errant_rate", evidence, AFTER) == pytest.approx(40.0, rel=0.01)
    assert compute("errant_rate", evidence, {**AFTER, "runs": True}) == pytest.approx(40.0, rel=0.01)
    # Peaks lie between rows by less than 1/64 of a bounce.
    assert compute("bounce_frequency", evidence, AFTER) == pytest.approx(
        (47 + 58) / (47 * 4e-3 + 58 * 5e-3), rel=1.0 / 64.0
    )
    assert compute("bounce_spread", evidence, {**AFTER, "statistic": "largest"}) == pytest.approx(3.0, rel=0.01)
    assert compute("bounce_spread", evidence, {**AFTER, "statistic": "least"}) == pytest.approx(1.0, rel=0.01)


def test_errant_bounces_in_a_row_may_count_as_one(made: Made) -> None:
    sizes, periods = [1e-3] * 4 + [3e-3] * 2, [5e-3] * 6
    evidence = made("a", {"trajectories": track(10 * sizes, 10 * periods)})
    every, runs = (compute("errant_rate", evidence, {**AFTER, "runs": runs}) for runs in (False, True))
    assert every is not None
    assert runs is not None
    # Ten pairs, of which the last has lost a bounce at the end: 18 follow the first in 275 ms, or 9 in 270 ms.
    assert every == pytest.approx(18 / 0.275, rel=0.02)
    assert runs == pytest.approx(9 / 0.270, rel=0.02)


def test_the_largest_excursion_follows_the_crossing_that_is_seen_latest() -> None:
    """Straight ways over the edge at 0, samples every ms: the way to the farthest point is seen 0.95 ms late."""
    turns = [(0.5, -0.3), (1.1, 0.3), (2.5, -0.3), (3.6, -0.1), (4.5, 0.8), (6.0, 2.0), (9.0, -0.4), (10.0, 0.2)]
    crossing = 3.6 + 0.9 / 9.0  # on the straight way from -0.1 to 0.8
    track = [Point(1e-3 * time, "", 1e-3 * angle, 0.0, 0.0) for time, angle in turns]
    track += [Point(1e-3 * (crossing + 0.95 + i), "sample", 0.0, 0.0, 0.0) for i in range(-3, 6)]
    kept = sorted(
        Point(one.time, one.event, _on(turns, 1e3 * one.time) * 1e-3, 0.0, 0.0) if one.event else one for one in track
    )
    assert worst_delay([one for one in kept if one.time >= 5e-4], 2.0 * pi / 100) == pytest.approx(0.95e-3, abs=1e-9)
    assert worst_delay(kept[:1], 1.0) is None


def _on(turns: list[tuple[float, float]], time: float) -> float:
    """Angle of the straight ways at a time."""
    for (a, x), (b, y) in itertools.pairwise(turns):
        if a <= time <= b:
            return x + (y - x) * (time - a) / (b - a)
    return turns[0][1] if time < turns[0][0] else turns[-1][1]


def test_a_faster_motion_is_more_slender(made: Made) -> None:
    made("slow", {"trajectories": track([1e-3] * 20, [10e-3] * 20)})
    evidence = made("a", {"trajectories": track([2e-3] * 40, [5e-3] * 40)})
    assert compute("phase_plane_aspect", evidence, {**AFTER, "against": "slow"}) == pytest.approx(2.0)
    later = {**AFTER, "after": 0.2, "against": "slow", "against_after": 0.15}
    assert compute("phase_plane_aspect", evidence, later) == pytest.approx(2.0)
    with pytest.raises(UsageError, match="'slow' is not recorded after 9 s"):
        compute("phase_plane_aspect", evidence, {**AFTER, "against": "slow", "against_after": 9.0})


def test_a_motion_without_bounces_has_no_frequency(made: Made) -> None:
    evidence = made("a", {"trajectories": [row(0, 0.1 + 1e-3 * i, 1e-3 * i, 1.0) for i in range(9)]})
    assert compute("bounce_frequency", evidence, AFTER) is None
    assert compute("errant_rate", evidence, AFTER) is None


def test_the_verdict_follows_the_recording(made: Made, ledger: Any) -> None:
    read = ledger(
        "  - {id: a, place: x, says: y, printed: 270, unit: Hz, check: bounce_frequency,\n"
        "     with: {result: a, after: 0.1}, holds: {within_percent: 10}, because: approximately}\n"
    )
    for period, verdict in ((1.0 / 262.0, "reproduced"), (1.0 / 170.0, "contradicted")):
        evidence = made(verdict, {"trajectories": track([1e-3] * 30, [period] * 30)})
        claim = read.claims[0].model_copy(update={"arguments": {**AFTER, "result": verdict}})
        assert judge_claim(claim, evidence)["verdict"] == verdict


def test_published_thresholds() -> None:
    none = ResultSet({})
    assert compute("touch_optimum", none, {"thresholds": "thenar"}) == 250.0
    assert compute("touch_optimum", none, {"thresholds": "cylinder"}) == 175.0
    # 25.1 to 0.653 um.
    drop = compute("touch_drop", none, {"thresholds": "thenar", "from_hz": 10, "to_hz": 250})
    assert drop == pytest.approx(31.7, abs=0.05)
    with pytest.raises(UsageError, match="no thresholds of touch 'elbow'"):
        compute("touch_optimum", none, {"thresholds": "elbow"})
    with pytest.raises(UsageError, match="400 Hz"):
        compute("touch_drop", none, {"thresholds": "thenar", "from_hz": 10, "to_hz": 400})


def test_the_rate_at_which_least_is_noticed(made: Made) -> None:
    """Per resolution the least of the larger level: 1000 Hz (30 dB) and 4000 Hz (felt only); a cell at rest is none."""

    def row(rate: float, counts: int, felt: float | None, heard: float | None) -> dict[str, Any]:
        return {"sample_rate_hz": rate, "counts_per_rev": counts, "touch_db": felt, "hearing_db": heard}

    coarse = [row(500.0, 256, 40.0, 10.0), row(1000.0, 256, 30.0, 20.0), row(4000.0, 256, 10.0, 35.0)]
    fine = [row(500.0, 512, 20.0, None), row(1000.0, 512, None, None), row(4000.0, 512, 15.0, -3.0)]
    made("quiet", {"cells": coarse + fine})
    evidence = made("loud", {"cells": [{**one, "hearing_db": (one["hearing_db"] or 0.0) + 20.0} for one in coarse]})
    assert compute("sensed_trough", evidence, {"result": "quiet", "statistic": "least"}) == 1000.0
    assert compute("sensed_trough", evidence, {"result": "quiet", "statistic": "largest"}) == 4000.0
    assert compute("sensed_trough", evidence, {"result": "loud"}) == 500.0
    arguments = {"result": "loud", "over": "quiet", "where": {"counts_per_rev": 256}}
    assert compute("sensed_trough", evidence, arguments) == pytest.approx(0.5)


def test_contours_of_hearing() -> None:
    """ISO 226:2023, Table 1: thresholds -5.9 at 3150 Hz, 12.2 at 10 kHz and so on; its contours are phon at 1 kHz."""
    none = ResultSet({})
    assert compute("hearing_optimum", none, {}) == pytest.approx(3150.0, rel=2e-3)
    assert compute("hearing_optimum", none, {"phon": 60}) == pytest.approx(3150.0, rel=2e-3)
    flat = {"from_hz": 600, "to_hz": 1500}
    threshold, loud = (compute("hearing_range", none, {**flat, **more}) for more in ({}, {"phon": 60}))
    assert threshold is not None
    assert loud is not None
    assert 0.0 < threshold < loud
    change = compute("hearing_change", none, {"from_hz": 3150, "to_hz": [3150, 1000]})
    assert change == pytest.approx(compute("hearing_range", none, {"from_hz": 1000, "to_hz": 3150}), abs=2.0)
    steep = compute("hearing_falloff", none, {"below_hz": 200, "above_hz": 5000})
    gentle = compute("hearing_falloff", none, {"below_hz": 200, "above_hz": 400})
    assert steep is not None
    assert gentle is not None
    assert gentle < 0.0 < steep


def test_levels_are_subtracted(made: Made) -> None:
    made("a", {"cells": [cell(1000, 360, 1e-3, 100.0, touch_db=12.0), cell(2000, 360, 1e-3, 100.0, touch_db=None)]})
    evidence = made("b", {"cells": [cell(1000, 2650, 1e-3, 100.0, touch_db=30.5)]})
    asked = {"column": "touch_db", "result": "a", "to": "b"}
    assert compute("level_difference", evidence, {**asked, "where": {"sample_rate_hz": 1000}}) == -18.5
    assert compute("level_difference", evidence, {**asked, "where": {"sample_rate_hz": 2000}}) is None


def test_remedies_count_if_they_help_every_hand(made: Made) -> None:
    def of(remedy: str, hand: str, p2p: float | None, ratio: float | None) -> dict[str, Any]:
        return {"case": "c", "remedy": remedy, "hand": hand, "p2p_max_rad": p2p, "p2p_ratio": ratio}

    rows = [of("plain wall", hand, 1e-3, 1.0) for hand in ("soft", "firm")]
    rows += [of("both", "soft", 1e-4, 10.0), of("both", "firm", 2e-4, 5.0)]
    rows += [of("rest", "soft", 0.0, None), of("rest", "firm", 1e-4, 10.0)]
    rows += [of("one", "soft", 1e-4, 10.0), of("one", "firm", 5e-4, 2.0)]
    rows += [of("away", "soft", None, None), of("away", "firm", 1e-4, 10.0)]
    evidence = made("a", {"cases": rows})
    asked = {"result": "a", "case": "c"}
    assert compute("remedies_that", evidence, asked) == 4
    assert compute("remedies_that", evidence, {**asked, "smaller": 5}) == 2
    assert compute("remedies_that", evidence, {**asked, "smaller": 6}) == 1


def test_the_level_of_a_torque_step() -> None:
    """A step of K 2 pi / N over 0.111 mN*m, the least published, or 7.851 mN*m, the largest."""
    given = {"stiffness_nm_per_rad": 0.27, "counts_per_rev": 360}
    step = 0.27 * 2.0 * pi / 360.0
    assert compute("torque_step_level", NOTHING, given) == pytest.approx(20.0 * log10(step / 1.11e-4))
    largest = compute("torque_step_level", NOTHING, {**given, "threshold": "largest"})
    assert largest == pytest.approx(20.0 * log10(step / 7.851e-3))
    with pytest.raises(UsageError, match="threshold: must be least or largest"):
        compute("torque_step_level", NOTHING, {**given, "threshold": "mean"})
