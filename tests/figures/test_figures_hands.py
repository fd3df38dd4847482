"""Figures of identified hands and calibrations, drawn from small virtual experiments."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hknob_cli.figures import draw, theme
from hknob_cli.figures.identification import plan_of, plant_of, pulsed, rows_of
from hknob_cli.figures.pulses import modelled
from hknob_cli.identify.second_order import respond
from hknob_cli.page.compose import chapters_of
from hknob_cli.results.result_set import MissingError, ResultSet
from tests import sysid_results as made
from tests.drawn import first_of_each

SPECS = (made.HANDS, made.FOURTH, made.MOTOR, made.GRIP_CELL, made.STUDY)

# Drawing, result, options, and what the figure says.
FIGURES: list[tuple[str, Any, dict[str, Any], tuple[str, ...]]] = [
    ("trial_thumbnails", "hands", {}, ("0.71 N, 4 trials", "14.2 N, 4 trials", "angle from rest, mrad")),
    ("pulse_vectors", "hands", {}, ("torque, mN·m", "acceleration, 10³ rad/s²", "velocity, rad/s", "angle, mrad")),
    ("identified_terms", "hands", {}, ("commanded", "sum", "inertia", "damping", "stiffness")),
    ("models_beside_data", "hands", {}, ("recorded", "model of these data", "model of block 2", "2.4 N")),
    ("one_person", "hands", {}, ("S1, mean and standard deviation over blocks", "damping ratio ζ")),
    ("all_persons", "hands", {}, ("2 people, a line each", "printed mean, Table 1")),
    ("grasp_parameters", "hands", {"tables": [1], "bars": True}, ("identified, of virtual people", "apparatus alone")),
    ("grasp_parameters", "hands", {"tables": [1], "translational": True}, ("inertia J, kg", "stiffness K, N/m")),
    ("normalised_grasp", "hands", {}, ("identified, of virtual people", "in proportion")),
    ("fourth_beside_second", "fourth", {}, ("second-order fit", "fourth-order model", "left over, µrad")),
    ("fourth_beside_second", "fourth", {"acceleration": True}, ("acceleration, 10³ rad/s²",)),
    ("motor_calibration", "motor", {}, ("slope 26.4 mN·m/A", "slope 28.4 mN·m/A", "dynamic friction")),
    ("grip_cell", "grip-cell", {}, ("3.18 mm from the end: 131 mV/N", "voltage of the cell, V")),
    ("bias_curves", "study", {}, ("inertia, %", "friction, mN·m", "least squares", "output error with friction")),
    ("bias_curves", "study", {"grip_n": 14.2, "causes": ["lag_s"]}, ("lag, µs",)),
    ("hidden_inertia", "study", {}, ("knob alone", "as the text assumes", "identified inertia, g·cm²")),
]


@pytest.fixture(scope="module")
def evidence(tmp_path_factory: pytest.TempPathFactory) -> ResultSet:
    root = tmp_path_factory.mktemp("results")
    folders = [made.identify(root, text) for text in SPECS]
    return ResultSet({folder.name: folder for folder in folders})


def drawn(evidence: ResultSet, name: str, of: Any, options: dict[str, Any]) -> str:
    return theme.svg(draw(name, evidence, of, options), name="figure", title=name)


@pytest.mark.parametrize(("name", "of", "options", "said"), first_of_each(FIGURES))
def test_figures_say_what_they_show(evidence: ResultSet, name: str, of: Any, options: dict, said: tuple) -> None:
    svg = drawn(evidence, name, of, options)
    words = set(re.findall(r"<text[^>]*>([^<]*)</text>", svg))
    for text in said:
        assert any(text in word for word in words), (text, words)
    assert "#000000" not in svg
    assert len(svg) < 200_000


@pytest.mark.one_in(30)
@pytest.mark.parametrize("figure", FIGURES)
def test_figures_are_the_same_twice(evidence: ResultSet, figure: Any) -> None:
    name, of, options, _ = figure
    assert drawn(evidence, name, of, options) == drawn(evidence, name, of, options)


@pytest.mark.parametrize(
    ("name", "of", "options", "why"),
    [
        ("trial_thumbnails", "hands", {"subject": "S9"}, "no recording of 'hands'"),
        ("trial_thumbnails", "motor", {}, "no recordings.parquet"),
        ("identified_terms", "hands", {"estimator": "fourth_order"}, "no fit of 'hands'"),
        ("models_beside_data", "hands", {"other": 7}, "no fit of 'hands' with"),
        ("all_persons", "hands", {"experiment": 3}, "no fit of 'hands'"),
        ("grasp_parameters", "hands", {"tables": [1, 2]}, "no fit of 'hands'"),
        ("motor_calibration", "grip-cell", {}, "no torque constant"),
        ("grip_cell", "motor", {}, "no grip cell slope"),
        ("bias_curves", "study", {"grip_n": 4.3}, "no bias of the inertia"),
        ("bias_curves", "study", {"causes": ["moon"]}, "no cause moon"),
        ("hidden_inertia", "hands", {}, "no hidden_inertia.parquet"),
    ],
)
def test_what_a_figure_lacks_is_named(evidence: ResultSet, name: str, of: Any, options: dict, why: str) -> None:
    with pytest.raises(MissingError, match=re.escape(why)):
        draw(name, evidence, of, options)


def test_the_model_of_the_data_lies_on_them_and_that_of_another_block_does_not(evidence: ResultSet) -> None:
    """Blocks differ by per cents; a mean of two trials is that of one hand to less than one."""
    result = evidence["hands"]
    one = pulsed(result, smooth=False, subject="S1", grip_target_n=0.71, block=1)[0]
    left = []
    for block in (1, 2):
        asked = {"subject": "S1", "grip_target_n": 0.71, "block": block, "estimator": "output_error"}
        angle = modelled(plant_of(rows_of(result, "trials", **asked)[0]), one)
        left.append(float(np.std(one.motion.angle_rad - angle)))
    assert left[1] > 10.0 * left[0]
    assert left[0] < 0.01 * np.max(one.motion.angle_rad)


def test_a_subtracted_apparatus_is_put_back(tmp_path: Path) -> None:
    """A motion is of hand and apparatus together, whichever of them the result speaks of."""
    text = made.HANDS.replace("name: hands", "name: alone\nsubtract_apparatus: 19.8 g*cm^2")
    whole = ResultSet({"a": made.identify(tmp_path, made.HANDS)})["a"]
    alone = ResultSet({"a": made.identify(tmp_path, text)})["a"]
    asked = {"subject": "S1", "grip_target_n": 0.71, "block": 1, "estimator": "output_error"}
    row, other = (rows_of(result, "trials", **asked)[0] for result in (whole, alone))
    assert other["inertia_kg_m2"] == pytest.approx(row["inertia_kg_m2"] - 1.98e-6, abs=1e-15)
    assert plant_of(other) == pytest.approx(plant_of(row), rel=1e-12)


def test_a_models_friction_is_the_known_one_where_none_was_fitted(evidence: ResultSet) -> None:
    one = pulsed(evidence["hands"], smooth=False)[0]
    plant = plant_of(rows_of(evidence["hands"], "trials", estimator="output_error")[0])
    known = respond(plant._replace(coulomb=5.6e-4), one.motion.torque_nm, one.motion.dt_s)
    assert modelled(plant, one, coulomb_nm=5.6e-4) == pytest.approx(known, rel=1e-12)
    assert np.max(np.abs(modelled(plant, one) - known)) > 1e-3


def test_only_identifications_have_their_plan(evidence: ResultSet) -> None:
    assert plan_of(evidence["hands"]).keep
    evidence["hands"].provenance["stage"] = "sweep"
    try:
        with pytest.raises(MissingError, match="not of an identification, but of sweep"):
            plan_of(evidence["hands"])
    finally:
        evidence["hands"].provenance["stage"] = "sysid"


def test_a_page_without_chapters_shows_what_was_identified(evidence: ResultSet) -> None:
    chapters = {chapter.title: chapter.figures for chapter in chapters_of(evidence)}
    shown = {title: [figure.draw for figure in figures] for title, figures in chapters.items()}
    assert shown["hands (sysid)"] == ["all_persons", "identified_values"]
    assert shown["motor (sysid)"] == ["motor_calibration"]
    assert shown["study (sysid)"] == ["bias_curves", "bias_curves", "hidden_inertia"]  # a figure each grip
    for figures in chapters.values():
        for figure in figures:
            assert draw(figure.draw, evidence, figure.of[0], figure.options)
