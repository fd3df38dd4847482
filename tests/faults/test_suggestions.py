"""A name that is not known: the option and the value are named, and what was probably meant."""

import json
import os
import subprocess

import pytest

from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.stage_table import SCHEMAS
from tests.conftest import HKNOB

PIPELINE = "kind: pipeline\nname: two\nstages:\n  grid: {spec: spec.yaml}\n  other: {spec: spec.yaml}\n"


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("wall.stiffness=0.5", "scene.wall.stiffness"),
        ("wall.stifness=0.5", "scene.wall.stiffness"),
        ("stiffness=0.5", "scene.wall.stiffness"),
        ("phases=8", "starts.phases"),
    ],
)
def test_set_without_the_first_keys_is_told_the_whole_path(hknob, spec_file, given: str, meant: str) -> None:
    done = hknob("sweep", spec_file(), "--set", given)
    key = given.split("=")[0]
    assert done.returncode == 2
    assert done.stderr.startswith(f"--set {given}: {key}: unknown key; did you mean '{meant}'")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(("given", "meant"), [("knob.friction", "coulomb_torque"), ("actuator.delay", "delay_samples")])
def test_another_word_for_a_key_is_understood(hknob, spec_file, given: str, meant: str) -> None:
    done = hknob("check", spec_file(), "--set", f"scene.{given}=1")
    assert done.returncode == 2
    assert f"scene.{given}: unknown key; did you mean '{meant}'?" in done.stderr


def test_set_of_what_nothing_is_like_lists_the_keys(hknob, spec_file) -> None:
    done = hknob("sweep", spec_file(), "--set", "foo=1")
    assert done.stderr.startswith("--set foo=1: foo: unknown key; allowed: kind, name, scene, grid")


def test_set_of_a_pipeline_is_told_where_a_stage_has_it(hknob, spec_file) -> None:
    spec_file()
    done = hknob("run", spec_file(PIPELINE, "two.yaml"), "--set", "scene.wall.stiffness=1")
    assert "did you mean 'stages.grid.set.scene.wall.stiffness'?" in done.stderr


def test_until_an_unknown_stage_suggests_the_nearest(hknob, spec_file) -> None:
    spec_file()
    done = hknob("run", spec_file(PIPELINE, "two.yaml"), "--until", "gird")
    assert done.returncode == 2
    assert done.stderr == "--until: unknown stage 'gird'; did you mean 'grid'? allowed: grid, other\n"


def test_a_result_of_an_unknown_name_suggests_the_nearest(tmp_path) -> None:
    with pytest.raises(MissingError, match="no result 'gird'; did you mean 'grid'"):
        ResultSet({"grid": tmp_path, "laws": tmp_path})["gird"]
    with pytest.raises(MissingError, match=r"^no result 'grid'$"):
        ResultSet({"grid": tmp_path / "nothing"})["grid"]


def test_kinds_are_the_same_in_help_message_schema_and_completion(hknob, spec_file) -> None:
    wrong = hknob("schema", "swep")
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert wrong.stderr == f"unknown kind 'swep'; did you mean 'sweep'? allowed: {', '.join(SCHEMAS)}\n"
    said = " ".join(hknob("schema", "-h", columns=300).stdout.split())
    assert ", ".join(SCHEMAS) in said
    words = {"_HKNOB_COMPLETE": "complete_bash", "COMP_WORDS": "hknob schema ", "COMP_CWORD": "2"}
    found = subprocess.run([HKNOB], env={**os.environ, **words}, capture_output=True, text=True, check=False)
    assert found.stdout.split() == list(SCHEMAS)
    for kind in SCHEMAS:
        assert json.loads(hknob("schema", kind).stdout)["$schema"]
    done = hknob("check", spec_file(), "--set", "kind=swep")
    assert f"must be one of: {', '.join(SCHEMAS[:-1])}; got 'swep'; did you mean 'sweep'?" in done.stderr
