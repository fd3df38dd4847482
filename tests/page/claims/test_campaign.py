"""Checks that set a campaign on a knob beside sweeps: like with like, and verdicts that follow."""

from math import pi
from typing import Any

import pytest

from hknob_cli.page.claims.checks import compute
from hknob_cli.page.claims.verdict import judge_claim
from hknob_cli.results.result_set import MissingError, ResultSet
from tests.ledger import claim
from tests.page.claims.conftest import SCENE, Made, cell

GRID = [(rate, counts) for rate in (1000.0, 4000.0) for counts in (256, 1024)]


def trial(rate: float, counts: int, p2p: float, cycles: float, **more: Any) -> dict[str, Any]:
    """A row of trials.parquet whose spectrum peaks elsewhere than at its cycles; at rest where ``p2p`` is 0."""
    return {
        "sample_rate_hz": rate,
        "counts_per_rev": counts,
        "block": 1,
        "sustained": p2p > 0.0,
        "p2p_rad": p2p,
        "rms_rad": 0.35 * p2p,
        "frequency_hz": cycles,
        "spectral_hz": 0.7 * cycles,
        "ended": "buzz" if p2p > 0.0 else "rest",
        "grip_mean_n": 0.7,
        "wall_torque_nm": 1e-3,
        **more,
    }


def size(rate: float, counts: int) -> float:
    return 500.0 * 2.0 * pi / counts / rate


def simulated(made: Made, **more: Any) -> ResultSet:
    """A sweep by the law, 100 Hz everywhere."""
    return made("sim", {"cells": [cell(rate, counts, size(rate, counts), 100.0) for rate, counts in GRID]}, **more)


def campaign(made: Made, name: str, pitch: float, factor: float, steeper: float = 0.0) -> ResultSet:
    """Trials at so many times its pitch and size, smaller by a further power of the resolution; the last rests."""
    rows = [
        trial(rate, counts, factor * size(rate, counts) * counts**-steeper, 100.0 * pitch) for rate, counts in GRID[:-1]
    ]
    return made(name, {"trials": [*rows, trial(*GRID[-1], 0.0, 0.0)]}, stage="hw-run")


def test_trials_are_compared_as_cells_of_a_sweep(made: Made) -> None:
    simulated(made)
    evidence = campaign(made, "knob", pitch=2.1, factor=0.25)
    beside = {"result": "knob", "against": "sim"}
    assert compute("ratio", evidence, {**beside, "quantity": "frequency"}) == pytest.approx(2.1)
    assert compute("difference", evidence, beside) == pytest.approx(-75.0)
    assert compute("difference", evidence, {**beside, "statistic": "count"}) == 3
    buzzing = {"result": "knob", "having": {"at_rest_fraction": {"below": 1}}}
    assert compute("count_of_cells", evidence, buzzing) == 3
    spectral = {"result": "knob", "column": "spectral_hz", "where": {"p2p_rad": {"above": 0}}}
    assert compute("cell_statistic", evidence, spectral) == pytest.approx(0.7 * 210.0)


def test_a_campaign_may_be_what_others_are_compared_with(made: Made) -> None:
    campaign(made, "plain", pitch=1.0, factor=1.0)
    evidence = campaign(made, "knob", pitch=1.5, factor=0.5)
    beside = {"result": "knob", "against": "plain"}
    assert compute("ratio", evidence, {**beside, "quantity": "frequency"}) == pytest.approx(1.5)
    assert compute("ratio", evidence, beside) == pytest.approx(0.5)


def test_repeated_trials_are_averaged_and_those_at_rest_are_no_cycle(made: Made) -> None:
    simulated(made)
    rows = [trial(1000.0, 256, 1.0, 100.0), trial(1000.0, 256, 3.0, 300.0), trial(1000.0, 256, 0.0, 0.0)]
    evidence = made("knob", {"trials": rows}, stage="hw-run")
    (found,) = evidence["knob"].rows("cells")
    assert (found["trials"], found["at_rest_fraction"]) == (3, pytest.approx(1.0 / 3.0))
    assert (found["p2p_rad"], found["frequency_hz"], found["spectral_hz"]) == (2.0, 200.0, pytest.approx(140.0))
    assert (found["p2p_max_rad"], found["frequency_at_max_hz"]) == (3.0, 300.0)
    pitch = {"result": "knob", "against": "sim", "quantity": "frequency"}
    assert compute("ratio", evidence, pitch) == pytest.approx(2.0)  # the mean of 100 and 300, over 100


def test_a_campaign_of_an_earlier_version_says_what_it_lacks(made: Made) -> None:
    row = trial(1000.0, 256, 1.0, 100.0)
    del row["spectral_hz"]
    evidence = made("knob", {"trials": [row]}, stage="hw-run")
    with pytest.raises(MissingError, match=r"no column spectral_hz in trials of 'knob'"):
        evidence["knob"].table("cells")


def test_its_axes_need_not_stand_in_its_spec(made: Made) -> None:
    evidence = made("knob", {"trials": [trial(1000.0, 256, 1.0, 100.0)]}, stage="hw-run", axes=())
    assert evidence["knob"].axes == ["sample_rate_hz", "counts_per_rev"]


@pytest.mark.parametrize(("along", "expected"), [("counts_per_rev", 0.8), ("sample_rate_hz", 0.0)])
def test_sensitivities_differ_by_the_power_put_in(made: Made, along: str, expected: float) -> None:
    simulated(made)
    evidence = campaign(made, "knob", pitch=1.0, factor=1.0, steeper=0.8)
    asked = {"result": "knob", "against": "sim", "column": "p2p_rad", "along": along}
    assert compute("slope_difference", evidence, asked) == pytest.approx(expected, abs=1e-9)


def test_sensitivities_do_not_depend_on_the_order_of_rows(made: Made) -> None:
    rows = [cell(rate, counts, size(rate, counts), 100.0) for rate, counts in reversed(GRID)]
    made("sim", {"cells": rows})
    evidence = campaign(made, "knob", pitch=1.0, factor=1.0, steeper=0.3)
    asked = {"result": "knob", "against": "sim", "column": "p2p_rad", "along": "counts_per_rev"}
    assert compute("slope_difference", evidence, asked) == pytest.approx(0.3)


def test_torque_balance(made: Made) -> None:
    """K q / (32 J f^2), J of knob and hand; what is beyond it, and the pitch at which it would not be."""
    evidence = made("whine", {"cells": [cell(25000, 360, 1e-5, 1500.0)]}, scene=SCENE)
    reach = 0.27 * 2.0 * pi / 360.0 / (32.0 * 2.2e-6 * 2200.0**2)
    asked = {"result": "whine", "frequency_hz": 2200, "p2p_rad": 0.0014}
    assert compute("beyond_reach", evidence, asked) == pytest.approx(0.0014 / reach)
    pitch = compute("pitch_of_swing", evidence, {"result": "whine", "p2p_rad": 0.0014})
    assert pitch is not None
    assert compute("swing_at", evidence, {"result": "whine", "frequency_hz": pitch}) == pytest.approx(0.0014)
    assert compute("pitch_of_swing", evidence, {"result": "whine", "p2p_rad": 0.0}) is None


@pytest.mark.parametrize(
    ("name", "result", "pitch", "factor", "verdict"),
    [
        ("sec-8.3-doubles-everywhere", "hardware", 2.0, 1.0, "reproduced"),
        ("sec-8.3-doubles-everywhere", "hardware", 1.3, 1.0, "contradicted"),
        ("sec-8.4-bias-in-trials", "hardware-push", 1.95, 1.0, "reproduced"),
        ("sec-8.4-bias-in-trials", "hardware-push", 1.6, 1.0, "differs"),
        ("sec-8.4-bias-in-trials", "hardware-push", 1.1, 1.0, "contradicted"),
        ("sec-8.3-factor-two", "hardware", 1.0, 1.9, "reproduced"),
        ("sec-8.3-factor-two", "hardware", 1.0, 0.4, "contradicted"),
        ("sec-8.3-friction-shrinks", "hardware", 1.0, 1.2, "reproduced"),
        ("sec-8.3-friction-shrinks", "hardware", 1.0, 0.2, "contradicted"),
    ],
)
def test_other_trials_give_other_verdicts(
    made: Made, name: str, result: str, pitch: float, factor: float, verdict: str
) -> None:
    """Where the campaign is all there is, its reading decides."""
    cells = [cell(rate, counts, size(rate, counts), 100.0) for rate, counts in GRID]
    made("chapter-8-push", {"cells": cells})
    row = judge_claim(claim(name), campaign(made, result, pitch, factor))
    assert row["verdict"] == verdict
    assert result in row["data"]


def test_a_grip_that_persons_are_built_from_confirms_nothing() -> None:
    for name in ("sec-8.3-grip-held", "sec-8.3-grip-constant", "sec-8.2-just-enough-torque"):
        assert judge_claim(claim(name), ResultSet({}))["verdict"] == "not testable"
