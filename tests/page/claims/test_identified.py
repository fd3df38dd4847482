"""Checks of identified hands, of bias and of the finger, against rows and motions made by hand; verdicts by them."""

from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.identify.second_order import Plant, respond
from hknob_cli.page.claims.checks import compute
from hknob_cli.page.claims.verdict import judge_claim
from hknob_cli.printed import table
from hknob_cli.results.provenance import describe
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.results.store import write
from tests import sysid_results
from tests.ledger import claim
from tests.page.claims.conftest import Made

J, B, K, RATIO = "inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad", "damping_ratio"
STD = {J: "inertia_std_kg_m2", B: "damping_std_nm_s_per_rad", K: "stiffness_std_nm_per_rad", RATIO: "damping_ratio_std"}


def conditions(
    shift: dict[str, float] | None = None, *, persons: int = 4, own: float = 0.0, estimator: str = "least_squares"
) -> list[dict[str, Any]]:
    """Conditions of Table 1 as printed, moved by so many printed deviations; ``own``: apparatus subtracted."""
    rows = []
    for printed in table(1):
        values = {name: float(printed[name]) + (shift or {}).get(name, 0.0) * float(printed[STD[name]]) for name in STD}
        values[J] -= own
        base = {"experiment": "1", "grip_target_n": printed["grip_n"], "estimator": estimator}
        base |= {
            "apparatus_inertia_kg_m2": own or None,
            **values,
            **{f"{name}_std": 0.1 * values[name] for name in STD},
        }
        rows += [{**base, "level": "subject", "subject": f"S{i}"} for i in range(persons)]
        rows.append({**base, "level": "all", "subject": None})
    return rows


def test_means_within_two_standard_errors(made: Made) -> None:
    """Of four persons two standard errors are one printed deviation."""
    made("near", {"conditions": conditions({K: 0.99})})
    made("bare", {"conditions": conditions(own=1.98e-6)})
    evidence = made("far", {"conditions": conditions({K: 1.01})})
    asked = {"estimator": "least_squares"}
    assert compute("tables_within", evidence, {"result": "near", **asked}) == 100.0
    assert compute("tables_within", evidence, {"result": "bare", **asked}) == 100.0
    assert compute("tables_within", evidence, {"result": "far", **asked}) == 75.0
    assert compute("tables_within", evidence, {"result": "far", **asked, "quantities": [K]}) == 0.0


def test_what_is_not_told_is_not_within(made: Made) -> None:
    rows = [{**row, J: None} if row["level"] == "all" else row for row in conditions()]
    evidence = made("a", {"conditions": rows})
    assert compute("tables_within", evidence, {"result": "a", "estimator": "least_squares"}) == 75.0


def test_spread_beside_the_printed_one(made: Made) -> None:
    """A tenth of every value, over the printed 21 to 48 % of stiffness."""
    evidence = made("a", {"conditions": conditions()})
    asked = {"result": "a", "estimator": "least_squares", "columns": [K], "statistic": "largest"}
    printed = [float(row["stiffness_cv_percent"]) for row in table(1)]
    assert compute("variation_ratio", evidence, asked) == pytest.approx(10.0 / min(printed), rel=1e-6)


def test_changes_are_of_like_conditions(made: Made) -> None:
    """Inertia is of hand and apparatus on either side; a condition on one side only does not count."""
    other = [row for row in conditions(own=1.98e-6) if row["grip_target_n"] > 1.0]
    made("b", {"conditions": other})
    evidence = made("a", {"conditions": [{**row, B: 1.4 * row[B]} for row in conditions()]})
    asked = {"result": "a", "to": "b", "estimator": "least_squares"}
    assert compute("identified_change", evidence, {**asked, "column": B}) == pytest.approx(40.0)
    assert compute("identified_change", evidence, {**asked, "column": J}) == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(MissingError, match="no such row"):
        compute("identified_change", evidence, {**asked, "column": B, "where": {"grip_target_n": 99.0}})


def test_one_estimator_beside_another_by_a_third(made: Made) -> None:
    """Damping a tenth off by one, and four tenths by the other: a quarter."""
    off = {"a": 1.1, "b": 0.6, "c": 1.0}
    rows = [{**row, B: by * row[B], "estimator": name} for row in conditions() for name, by in off.items()]
    asked = {"result": "r", "estimator": "a", "to": "b", "against": "c", "column": B}
    assert compute("estimator_gain", made("r", {"conditions": rows}), asked) == pytest.approx(0.25)


def test_a_mean_hand_turns_by_the_middle_of_the_range(made: Made) -> None:
    rows = [{**row, "subject": "S1"} for row in conditions() if row["level"] == "all"]
    stiff = [{**row, K: 4.0 * row[K], B: 3.0 * row[B]} for row in rows]
    evidence = made("a", {"trials": [*rows, *stiff]})
    asked = {"result": "a", "estimator": "least_squares"}
    assert compute("displaced_share", evidence, {**asked, "low": 0.0899, "high": 0.0901}) == 50.0
    assert compute("displaced_share", evidence, {**asked, "low": 0.0, "high": 0.0899}) == 50.0


def test_bias_at_a_level(made: Made) -> None:
    rows = [
        {
            "grip_n": grip,
            "nuisance": "lag_s",
            "level": level,
            "estimator": "e",
            "parameter": "inertia",
            "bias_percent": b,
        }
        for grip, level, b in ((0.71, 0.0, 2.0), (0.71, 5e-5, 3.5), (14.2, 0.0, 7.0), (14.2, 5e-5, 4.0))
    ]
    evidence = made("a", {"bias": rows})
    asked = {"result": "a", "nuisance": "lag_s", "level": 5e-5, "parameters": ["inertia"], "estimator": "e"}
    assert compute("bias_by", evidence, asked) == pytest.approx(-0.75)
    assert compute("bias_by", evidence, {**asked, "statistic": "largest_size"}) == pytest.approx(3.0)
    assert compute("bias_by", evidence, {**asked, "change": False, "grips": [0.71]}) == pytest.approx(3.5)
    with pytest.raises(MissingError, match=r"no lag_s of 0\.001; it has 0, 5e-05"):
        compute("bias_by", evidence, {**asked, "level": 1e-3})


def test_regularisation_is_what_least_squares_do_with_a_noisy_acceleration() -> None:
    """Against 3,000 noisy fits: their mean is known to 0.1 points, and 300 samples are within a point of many."""
    hand = {"J": 2.11e-6, "B": 3.45e-4, "K": 0.04}
    nothing = ResultSet({})
    assert compute("regularised_inertia", nothing, {"where": hand, "noise_percent": 0}) == pytest.approx(
        100.0, rel=1e-9
    )
    found = compute("regularised_inertia", nothing, {"where": hand, "noise_percent": 50})
    time = np.arange(300) * 1e-4
    torque = np.where(time < 0.02, 1.0, 0.0)
    fine = respond(Plant(*hand.values()), np.repeat(torque, 100), 1e-6)
    velocity, angle = np.gradient(fine, 1e-6)[::100], fine[::100]
    acceleration = (torque - hand["B"] * velocity - hand["K"] * angle) / hand["J"]
    rng = np.random.default_rng(1)
    size = 0.5 * sqrt(np.mean(acceleration**2))
    fits = []
    for _ in range(3000):
        noisy = acceleration + size * rng.standard_normal(300)
        fits.append(np.linalg.lstsq(np.column_stack([noisy, velocity, angle]), torque, rcond=None)[0][0])
    assert found == pytest.approx(100.0 * float(np.mean(fits)) / hand["J"], abs=1.0)
    with pytest.raises(UsageError, match="must give J, B and K"):
        compute("regularised_inertia", nothing, {"where": {"J": 1.0}, "noise_percent": 1})


def recording(folder: Path, name: str, angles: list[float], velocities: list[float], fingers: list[float]) -> Path:
    """A recorded motion with a pulse over its first three rows."""
    import pyarrow as pa

    rows = [
        {"trial": 0, "time_s": 1e-3 * i, "angle_rad": a, "velocity_rad_s": v, "finger_velocity_rad_s": f}
        for i, (a, v, f) in enumerate(zip(angles, velocities, fingers, strict=True))
    ]
    out = folder / name
    out.mkdir()
    values = {"name": name, "grid": {}, "record": {"pulse": {"torque": 1.0, "duration": 3e-3}}}
    stamp = describe(stage="sweep", values=values, overrides=())
    write({out / "trajectories.parquet": pa.Table.from_pylist(rows)}, stamp)
    return out


def test_motions_beside_each_other(tmp_path: Path) -> None:
    one = recording(tmp_path, "one", [0.0, 1.0, 2.0, 1.0, 0.0], [0.0, 2.0, 1.0, -1.0, 0.0], [0.0, 0.2, 0.0, 0.0, 0.0])
    two = recording(tmp_path, "two", [0.0, 1.0, 1.9, 1.0, 0.0], [0.0, 1.0, -1.0, 1.0, 0.0], [0.0] * 5)
    evidence = ResultSet({"one": one, "two": two})
    assert compute("motion_difference", evidence, {"result": "two", "to": "one"}) == pytest.approx(5.0)
    asked = {"result": "two", "to": "one", "quantity": "acceleration"}
    assert compute("motion_difference", evidence, asked) == pytest.approx(100.0 * 4.0 / 2.0)
    assert compute("finger_share", evidence, {"result": "one"}) == pytest.approx(10.0)
    assert compute("dips", evidence, {"result": "one"}) == 0
    assert compute("dips", evidence, {"result": "two"}) == 1
    with pytest.raises(MissingError, match="no jerk"):
        compute("motion_difference", evidence, {**asked, "quantity": "jerk"})


def test_steps_that_fall_and_people_that_spread(made: Made) -> None:
    made("a", {"hidden_inertia": [{"ratio": r, "inertia_kg_m2": j} for r, j in ((10, 2.0), (1, 3.0), (100, 2.5))]})
    cells = [{"person": i, "p2p_rad": float(i), "counts_per_rev": 1024} for i in range(101)]
    evidence = made("b", {"cells": cells})
    asked = {"result": "a", "file": "hidden_inertia", "column": "inertia_kg_m2", "along": "ratio"}
    assert compute("share_falling", evidence, asked) == 50.0
    people = {"result": "b", "column": "p2p_rad"}
    assert compute("people_percentile", evidence, {**people, "percentile": 50}) == pytest.approx(50.5)
    assert compute("people_spread", evidence, {**people, "low": 0, "high": 100}) == pytest.approx(100.0)
    with pytest.raises(MissingError, match="fewer than two people"):
        compute("people_spread", evidence, {**people, "where": {"p2p_rad": {"above": 99}}})


def test_friction_is_taken_for_inertia_and_stiffness_of_a_bare_knob(tmp_path: Path) -> None:
    """A free knob that friction slows: what knows it finds the truth to a hundredth, least squares do not."""
    evidence = ResultSet({"apparatus": sysid_results.identify(tmp_path, sysid_results.APPARATUS)})
    asked = {"result": "apparatus", "statistic": "largest_size"}
    plain, knowing = ({**asked, "estimator": name} for name in ("least_squares", "output_error_friction"))
    assert compute("apparatus_error", evidence, knowing) < 1.0 < 5.0 < compute("apparatus_error", evidence, plain)
    stiffness = {"column": K}
    least = 0.02  # Table 2, lightest grip
    assert (
        compute("apparatus_share", evidence, {**plain, **stiffness}) is None
    )  # not told from zero, with honest errors
    ignorant = {**asked, "estimator": "output_error", **stiffness}
    assert compute("apparatus_share", evidence, ignorant) > 1.0
    trials = [row for row in evidence["apparatus"].rows("trials") if row["estimator"] == "output_error"]
    largest = max(abs(row[K]) for row in trials if row[K] is not None)
    assert compute("apparatus_share", evidence, ignorant) == pytest.approx(100.0 * largest / least)
    assert judge_claim(claim("appendix-c-stiffness"), evidence)["verdict"] == "contradicted"


@pytest.mark.parametrize(
    ("name", "file", "right", "wrong"),
    [
        ("ch4-inertia-return", "conditions", conditions(persons=9), conditions({J: 3.0}, persons=9)),
        ("ch4-damping-stiffness-return", "conditions", conditions(), conditions({B: 3.0, K: 3.0})),
        (
            "ch4-spread-of-people",
            "conditions",
            conditions(),
            [{**row, f"{B}_std": None} for row in conditions({K: -1.9})],
        ),
    ],
)
def test_other_hands_change_a_verdict(made: Made, name: str, file: str, right: list, wrong: list) -> None:
    made("hands", {file: right})
    wide = [{key: 10.0 * v if key.endswith("_std") and v else v for key, v in row.items()} for row in wrong]
    evidence = made("others", {file: wide})
    one = claim(name)
    assert judge_claim(one, evidence)["verdict"] in ("reproduced", "differs")
    others = ResultSet({"hands": evidence["others"].folder})
    assert judge_claim(one, others)["verdict"] == "contradicted"


def test_a_slower_amplifier_changes_a_verdict(made: Made) -> None:
    """What the lag does to inertia decides whether it disturbs."""

    def rows(bias: float) -> list[dict[str, Any]]:
        common = {"nuisance": "lag_s", "estimator": "least_squares", "grip_n": 0.71}
        return [
            {**common, "level": level, "parameter": name, "bias_percent": bias if level and name == "inertia" else 0.0}
            for level in (0.0, 5e-5)
            for name in ("inertia", "damping", "stiffness")
        ]

    one = claim("appendix-a-settling-disturbs")
    assert judge_claim(one, made("bias-study", {"bias": rows(3.0)}))["verdict"] == "reproduced"
    slow = made("slow", {"bias": rows(20.0)})
    assert judge_claim(one, ResultSet({"bias-study": slow["slow"].folder}))["verdict"] == "contradicted"


def test_nothing_is_left_for_a_higher_order_only_where_the_fit_is_near(made: Made) -> None:
    made("pulses-fourth", {"trials": [{"estimator": "output_error", "vaf": 1.0 - 5e-9}]})
    evidence = made("rough", {"trials": [{"estimator": "output_error", "vaf": 0.95}]})
    one = claim("ch4-higher-order")
    assert judge_claim(one, evidence)["verdict"] == "contradicted"
    assert judge_claim(one, ResultSet({"pulses-fourth": evidence["rough"].folder}))["verdict"] == "reproduced"
