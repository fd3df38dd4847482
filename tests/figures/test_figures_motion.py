"""Figures of motion and of hands, drawn from short recordings: what they say, and that they say it the same twice."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hknob_cli.figures import draw, theme
from hknob_cli.figures.motion import _added
from hknob_cli.figures.panel import key
from hknob_cli.figures.recording import one_recording, recordings
from hknob_cli.results.provenance import describe
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.results.store import write
from hknob_cli.specs.load import load
from hknob_cli.stages.sweep.record import record_one, record_sweep
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import EXPERIMENTS
from tests.drawn import first_of_each

NAMES = (
    "bouncing_ball",
    "bouncing_ball_contact",
    "encoder_wall_damped",
    "grip_pulse",
    "grip_pulse_finger",
    "light_contact_fine",
    "light_contact_half_quantum",
    "short_contact",
    "short_contact_analog",
    "stiff_wall",
)
GRIPS = ["grip-pulse", "grip-pulse-finger"]
MOTOR = {"knob.inertia": 1.98e-6}
SHORT = ["short-contact", "short-contact-analog"]

# Drawing, results, options, and what the figure says.
FIGURES: list[tuple[str, Any, dict[str, Any], tuple[str, ...]]] = [
    ("time_response", "bouncing-ball", {"bounces": True}, ("angle, mrad", "energy, mJ", "bounce peaks", "mJ/s²")),
    ("time_response", "bouncing-ball-contact", {"scaled": True, "samples": True}, ("samples", "torque, mN·m")),
    ("time_response", "encoder-wall-damped", {"to_s": 0.05}, ("time, ms", "torque, mN·m", "knob")),
    ("time_response", "stiff-wall", {"labels": ["high", "middle", "low"]}, ("high", "middle", "low", "torque, N·m")),
    ("time_response", GRIPS, {"at": MOTOR, "labels": ["2nd", "4th"]}, ("2nd", "4th", "finger of 4th", "torque, mN·m")),
    ("time_response", GRIPS, {"at": MOTOR, "acceleration": True}, ("acceleration,", "10³ rad/s²", "time, ms")),
    (
        "time_response",
        "light-contact-fine",
        {"peaks_lines": True, "from_s": 0.18},
        ("mean of ten peaks", "mean trough, 0.224 mrad below"),
    ),
    ("phase_plane", "light-contact-half-quantum", {"from_s": 0.02}, ("velocity, rad/s", "way in", "edge of the wall")),
    ("pulse_terms", "grip-pulse", {"at": MOTOR}, ("commanded", "sum", "inertia", "damping", "stiffness", "time, ms")),
    ("contact_energy", SHORT, {"labels": ["counts", "none"]}, ("48.3 µJ", "25.5 µJ", "late exit", "energy added, µJ")),
    ("schematic", None, {"kind": "second"}, ("K", "B", "J", "torque T")),
    ("schematic", None, {"kind": "fourth"}, ("K₁", "B₂", "fingerpad")),
    ("schematic", None, {"kind": "network"}, ("K₁", "B₂", "J₂", "T", "θ₁", "ground")),
    ("schematic", None, {"kind": "wall"}, ("outside the wall", "inside the wall", "push g")),
    ("apparatus_drawing", None, {"kind": "rig"}, ("640,000 counts", "reaction torque cell", "10 kHz")),
    ("apparatus_drawing", None, {"kind": "pinch"}, ("thumb", "forefinger", "17.8 mm", "grip cell")),
    ("apparatus_drawing", None, {"kind": "grasps"}, ("(a) key pinch, 17.8 mm", "(d) three fingers, 29.9 mm", "middle")),
    ("apparatus_drawing", None, {"kind": "calibration"}, ("feels 2 W", "3.18", "9.53", "flexure, 1.9 mm", "load cell")),
    ("amplifier_step", None, {}, ("commanded", "current, A", "within 2 % after 196 \u00b5s")),
    ("grasp_parameters", None, {"tables": [1]}, ("inertia J, 10⁻⁶ kg·m²", "apparatus alone", "grip force, N")),
    (
        "grasp_parameters",
        None,
        {"translational": True},
        ("inertia J, kg", "stiffness K, N/m", "three fingers, 29.9 mm"),
    ),
    ("normalised_grasp", None, {}, ("damping B / its middle, 1", "in proportion")),
    ("grip_forces", None, {}, ("sample rate, Hz", "counts per revolution", "0.79", "2048")),
]


@pytest.fixture(scope="module")
def evidence(tmp_path_factory: pytest.TempPathFactory) -> ResultSet:
    """Recordings of the experiments, without their limit cycles."""
    root, folders = tmp_path_factory.mktemp("results"), {}
    for name in NAMES:
        plan = load(EXPERIMENTS / f"{name}.yaml", ())
        folder = folders[plan.name] = root / plan.name
        folder.mkdir()
        table = record_sweep(plan)
        write({folder / "trajectories.parquet": table}, describe(stage="sweep", values=plan.values, overrides=()))
    return ResultSet(folders)


def drawn(evidence: ResultSet, name: str, of: Any, options: dict[str, Any]) -> str:
    return theme.svg(draw(name, evidence, of, options), name="figure", title=name)


@pytest.mark.parametrize(("name", "of", "options", "said"), first_of_each(FIGURES))
def test_figures_say_what_they_show(evidence: ResultSet, name: str, of: Any, options: dict, said: tuple) -> None:
    svg = drawn(evidence, name, of, options)
    words = set(re.findall(r"<text[^>]*>([^<]*)</text>", svg))
    for text in said:
        assert any(text in word for word in words), (text, words)
    assert "<image" not in svg
    assert "#000000" not in svg
    assert len(svg) < 150_000


@pytest.mark.one_in(30)
@pytest.mark.parametrize("figure", FIGURES)
def test_figures_are_the_same_twice(evidence: ResultSet, figure: Any) -> None:
    name, of, options, _ = figure
    assert drawn(evidence, name, of, options) == drawn(evidence, name, of, options)


@pytest.mark.parametrize(
    ("name", "of", "options", "why"),
    [
        ("time_response", "bouncing-ball", {"from_s": 0.4, "to_s": 0.7}, "from 0 to 0.5 s, not from 0.4 to 0.7 s"),
        ("time_response", "bouncing-ball", {"from_s": 0.3, "to_s": 0.2}, "not from 0.3 to 0.2 s"),
        ("time_response", "bouncing-ball", {"from_s": 0.4, "bounces": True}, "a parabola needs three"),
        ("time_response", "bouncing-ball", {"peaks_lines": True}, "fewer than 10 bounces"),
        ("time_response", "stiff-wall", {"labels": ["one"]}, "3 recordings, but 1 labels"),
        ("time_response", "stiff-wall", {"scaled": True}, "of one recording"),
        ("time_response", "stiff-wall", {"at": {"start_rad": 0.3}}, "no recording of 'stiff-wall'"),
        ("phase_plane", "stiff-wall", {}, "pick one with 'at'"),
        ("phase_plane", "bouncing-ball", {"steady_s": 0.5}, "more than the window shown"),
        ("pulse_terms", "grip-pulse-finger", {}, "hand of second order"),
        ("pulse_terms", "bouncing-ball", {}, "not a pulse"),
        ("contact_energy", "encoder-wall-damped", {}, "is damped"),
        ("time_response", "nothing", {}, "no result 'nothing'"),
        ("grasp_parameters", None, {"tables": [7]}, "no grasps in table 7"),
        ("normalised_grasp", None, {"tables": [9]}, "no grasps in table 9"),
        ("schematic", None, {"kind": "third"}, "no schematic 'third'"),
        ("apparatus_drawing", None, {"kind": "photo"}, "no drawing 'photo' of the apparatus; there are rig, pinch"),
    ],
)
def test_what_a_figure_lacks_is_named(evidence: ResultSet, name: str, of: Any, options: dict, why: str) -> None:
    with pytest.raises(MissingError, match=re.escape(why)):
        draw(name, evidence, of, options)


@pytest.mark.parametrize("name", ["time_response", "phase_plane", "pulse_terms", "contact_energy"])
def test_a_result_without_recording_has_no_figure_of_motion(tmp_path: Path, name: str) -> None:
    plan = load(EXPERIMENTS / "short_contact.yaml", ())
    provenance = describe(stage="sweep", values=plan.values, overrides=())
    write({tmp_path / "cells.parquet": record_sweep(plan)}, provenance)
    with pytest.raises(MissingError, match=r"no trajectories\.parquet"):
        draw(name, ResultSet({"short-contact": tmp_path}), "short-contact", {})


def test_energy_added_is_what_the_contact_gains(evidence: ResultSet) -> None:
    """Outside the wall before and after, an immediate wall does no work: what is added is what the knob gains.

    A hold never takes away: its work is torque times way, more than the immediate wall's, whose potential is convex.
    With counts all is added while the torque is late, at either end; between, nothing is. Rounding is of 1e-4 J.
    """
    for name in SHORT:
        one = one_recording(evidence, name)
        added = _added(one)
        assert added[-1] == pytest.approx(one.energy[-1] - one.energy[0], rel=0, abs=1e-18)
        assert np.diff(added[one.samples]).min() > -1e-18
    one = one_recording(evidence, "short-contact")
    symmetric = (one.acts[:-1] > 0.0) & (one.angle[:-1] < 0.0) & (one.angle[1:] < 0.0)
    assert np.abs(np.diff(_added(one))[symmetric]).max() < 1e-18


def test_turns_of_a_ballistic_flight_are_exact(evidence: ResultSet) -> None:
    """Between contacts nothing but the push acts: the energy of a flight is the push times its peak."""
    one = one_recording(evidence, "bouncing-ball")
    times, angles, up = one.turns
    energy = np.interp(times, one.time, one.energy)
    outside = up & (angles > 0.0)
    assert outside.sum() == 6
    assert angles[outside] * 0.001 == pytest.approx(energy[outside], rel=1e-9)


def test_recordings_are_told_apart_by_cell_and_start(evidence: ResultSet) -> None:
    assert [one.cell["start_rad"] for one in recordings(evidence, "stiff-wall")] == [0.02, 0.01, 0.005]
    found = recordings(evidence, GRIPS, at=MOTOR)
    assert [one.scene.knob.inertia for one in found] == [1.98e-6, 1.98e-6]
    assert found[0].pulse is not None
    assert (found[0].finger is None, found[1].finger is None) == (True, False)


@pytest.mark.parametrize("width", [5.6, theme.WIDTH])
def test_a_key_of_five_entries_stays_within_its_figure(width: float) -> None:
    def with_key() -> Any:
        drawn = theme.figure(4.0, width)
        panel = drawn.subplots()
        for name in ("way in", "steady", "samples", "edge of the wall", "edge of a count"):
            panel.plot([0.0, 1.0], [0.0, 1.0], label=name)
        key(panel)
        drawn.canvas.draw()
        return drawn

    drawn = theme.styled(with_key)()
    assert drawn.axes[0].get_legend().get_window_extent().x1 <= drawn.bbox.x1


@pytest.mark.parametrize("change", ["", "scene.controller={kind: bounded_lag, keep: 0.15, time_constant: 0.2}"])
def test_of_the_trials_of_one_cell_the_periods_that_are_drawn_are_kept(change: str) -> None:
    """They are the last rows of all; where nothing cycles, all are kept."""
    overrides = ("grid.sample_rate_hz=1000", "grid.counts_per_rev=512", "starts={angle: 0.02, phases: 2}", change)
    plan = load(EXPERIMENTS / "hand_on_knob.yaml", tuple(filter(None, overrides)))
    orbits = SweepStage(plan).run().orbits.to_pylist()
    longest = max(row["cycles_per_period"] / row["frequency_hz"] for row in orbits if row["outcome"] == "cycle")
    rows, all_rows = (record_one(plan, orbits, last=last).to_pylist() for last in (3, 10**6))
    for trial in (0, 1):
        kept, whole = ([row for row in some if row["trial"] == trial] for some in (rows, all_rows))
        assert kept[-1]["time_s"] - 3.0 * longest >= kept[0]["time_s"] > kept[-1]["time_s"] - 3.1 * longest
        assert len(kept) < 0.6 * len(whole)
        for row, same in zip(kept, whole[-len(kept) :], strict=True):
            assert (row["time_s"], row["event"]) == (same["time_s"], same["event"])
            assert row["angle_rad"] == pytest.approx(same["angle_rad"], abs=1e-12)
    resting = [row for row in orbits if row["outcome"] != "cycle"]
    assert record_one(plan, resting, last=3)["time_s"][0].as_py() == 0.0
