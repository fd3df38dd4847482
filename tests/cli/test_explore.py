"""``hknob explore``: a page from any sweep that its engine follows, else a message; nothing is opened in a script."""

import json
from pathlib import Path

import pytest

from tests.conftest import EXPERIMENTS, SPEC

FIRST = "small: 1 knob of spec.yaml to change, see and hear"


def test_without_a_spec_it_writes_a_page_of_an_example(hknob, tmp_path: Path) -> None:
    done = hknob("explore")
    assert done.returncode == 0, done.stderr
    assert "wrote results/my-knob-explore.html" in done.stdout
    assert "next: open results/my-knob-explore.html in a browser" in done.stdout
    assert list((tmp_path / "results").iterdir()) == [tmp_path / "results" / "my-knob-explore.html"]


def test_a_spec_and_its_overrides_are_in_the_page(hknob, spec_file, tmp_path: Path) -> None:
    spec_file()
    done = hknob("explore", "spec.yaml", "-o", "page.html", "--set", "scene.wall.stiffness=0.31")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0] == FIRST
    text = (tmp_path / "page.html").read_text()
    assert '"stiffness":0.31' in text
    first = (tmp_path / "page.html").read_bytes()
    assert hknob("explore", "spec.yaml", "-o", "page.html", "--set", "scene.wall.stiffness=0.31").returncode == 0
    assert (tmp_path / "page.html").read_bytes() == first


def test_every_cell_of_a_grid_is_in_the_page(hknob) -> None:
    done = hknob("explore", EXPERIMENTS / "hand_on_knob.yaml", "--json", "-o", "page.html")
    assert json.loads(done.stdout) == {"kind": "explore", "name": "hand-on-knob", "cells": 49, "files": ["page.html"]}


def test_its_own_page_is_replaced_and_no_other_file(hknob, spec_file, tmp_path: Path) -> None:
    spec_file()
    (tmp_path / "mine.html").write_text("<p>mine")
    done = hknob("explore", "spec.yaml", "--out", "mine.html")
    assert done.returncode == 3
    assert done.stderr == ("mine.html: is there already and was not written by explore; name another file with --out\n")
    assert (tmp_path / "mine.html").read_text() == "<p>mine"
    (tmp_path / "folder").mkdir()
    done = hknob("explore", "spec.yaml", "--out", "folder")
    assert (done.returncode, done.stderr) == (2, "--out: folder is a folder; must name a file\n")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "mine.html", "spec.yaml"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "bias: {torque: 0.001}",
            "actuator: {time_constant: 1.0e-4}",
            "scene.actuator.time_constant: actuator lag is not in explore: the engine of its page has no such part",
        ),
        (
            "bias: {torque: 0.001}",
            "detents: {per_revolution: 12, torque: 0.002}",
            "scene.detents: a pattern of detents is not in explore: its torque is that of a wall",
        ),
        (
            "bias: {torque: 0.001}",
            "controller: {kind: phase_damping, estimate: kalman}",
            "scene.controller.kind: 'phase_damping' is not in explore; there are: bounded_lag, first_order_hold",
        ),
        (
            "bias: {torque: 0.001}",
            "controller: {kind: velocity_damping, damping: 1.0e-4, cut_off: 10}",
            "scene.controller.cut_off: it is not in explore, which has of velocity_damping damping, window, low_pass",
        ),
        (
            "bias: {torque: 0.001}",
            "controller: {kind: first_order_hold, steps: 4}",
            "scene.controller.steps: it is not in explore, which has of first_order_hold correct",
        ),
        (
            "bias: {torque: 0.001}",
            "controller: {kind: half_sample, velocity: sensor}",
            "scene.controller.velocity: a controller that reads a velocity sensor is not in explore",
        ),
    ],
)
def test_what_the_page_does_not_follow_is_refused(hknob, spec_file, tmp_path: Path, old, new, said) -> None:
    spec_file(SPEC.replace(old, new))
    done = hknob("explore", "spec.yaml")
    assert done.returncode == 2
    assert f"spec.yaml: {said}" in done.stderr
    assert done.stderr.splitlines()[-1] == "spec.yaml: hknob sweep computes this scene"
    assert not (tmp_path / "results").exists()


def test_another_kind_and_a_bad_spec_are_faults(hknob, spec_file) -> None:
    spec_file(SPEC.replace("kind: sweep", "kind: predict").replace("starts: {angle: 0.02, phases: 8}", ""))
    assert hknob("explore", "spec.yaml").returncode == 2
    spec_file(SPEC.replace("stiffness: 0.27", "stiffness: -0.27"))
    done = hknob("explore", "spec.yaml")
    assert done.returncode == 2
    assert done.stderr.startswith("spec.yaml:6:")
    assert hknob("explore", "none.yaml").returncode == 2


def test_what_a_spec_asks_for_beyond_the_page_is_said(hknob, spec_file) -> None:
    spec_file(SPEC.replace("starts: {angle: 0.02, phases: 8}", "starts: anywhere"))
    done = hknob("explore", "spec.yaml", "-o", "page.html")
    assert "The spec asks for starts anywhere. This page follows one start at a time" in done.stderr
    assert hknob("explore", "spec.yaml", "-o", "page.html", "-q").stderr == ""


def test_the_page_is_written_through_no_link(hknob, tmp_path: Path) -> None:
    other = tmp_path / "other.txt"
    other.write_text("mine")
    (tmp_path / ".page.html.part").symlink_to(other)
    assert hknob("explore", "-o", "page.html", "-q").returncode == 0
    assert other.read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []
    assert (tmp_path / "page.html").stat().st_size > 50_000
