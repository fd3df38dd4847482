"""What a run says beside its numbers: reasons, warnings of odd values, what a comparison does not cover."""

import json

from tests.conftest import SPEC

DFA = SPEC.replace("kind: sweep", "kind: dfa").replace("name: small", "name: laws")
DFA = DFA.replace("starts: {angle: 0.02, phases: 8}\n", "")
SHORT = ("--set", "limits.max_samples=100")
TWO = ("--set", "grid.sample_rate_hz=[1000, 2000]")


def test_undecided_trials_are_counted_and_their_reason_is_printed(hknob, spec_file) -> None:
    done = hknob("sweep", spec_file(), *SHORT)
    assert "1 cell, 8 undecided trials, 0 % of trials proven" in done.stdout
    why = "the slowest mode needs more samples than the limit (limits.max_samples)"
    assert f"? 8 trials undecided: {why} (8 in 1 cell)" in done.stdout
    found = json.loads(hknob("sweep", spec_file(), *SHORT, "--json").stdout)["undecided"]
    assert found == [{"reason": why, "cells": 1, "trials": 8}]
    said, _, _ = hknob("sweep", spec_file(), "-o", "decided").stdout.partition("next:")
    assert "undecided" not in said


def test_a_partial_overlap_with_the_sweep_is_announced(hknob, spec_file) -> None:
    hknob("sweep", spec_file(), "-o", "swept")
    for kind in ("dfa", "predict"):
        spec = spec_file(DFA.replace("kind: dfa", f"kind: {kind}"), f"{kind}.yaml")
        partly = ("--set", "against=swept", *TWO, "-o", kind)
        said = "1 of 2 cells are in the sweep, too; only these are compared with it"
        assert said in hknob(kind, spec, *partly).stdout
        assert json.loads(hknob(kind, spec, *partly, "--json").stdout)["overlap"] == {"cells": 2, "with_partner": 1}
        assert said not in hknob(kind, spec, "--set", "against=swept", "-o", f"{kind}-whole").stdout
        assert "overlap" not in json.loads(hknob(kind, spec, "-o", f"{kind}-alone", "--json").stdout)


def test_an_inertia_of_120_is_warned_of_with_the_usual_range(hknob, spec_file) -> None:
    odd = ("--set", "scene.knob.inertia=120", "--set", "scene.wall.stiffness=1e5", *SHORT)
    done = hknob("sweep", spec_file(), *odd)
    assert done.returncode == 0
    inertia, stiffness = (line for line in done.stderr.splitlines() if not line.startswith("compil"))
    assert inertia.startswith("small: warning: knob.inertia: 120 kg*m^2 is unusually large; usual are 1e-08 to 0.001 (")
    assert inertia.endswith("; if 120 g*cm^2 is meant, write the unit")
    assert stiffness.startswith("small: warning: wall.stiffness: 100000 N*m/rad is unusually large; usual are ")
    assert hknob("sweep", spec_file(), *odd, "-q").stderr == ""
    checked = hknob("check", spec_file(), *odd[:4])
    assert (checked.returncode, checked.stderr.count("is unusually large")) == (0, 2)
    assert hknob("check", spec_file(), *odd[:4], "-q").stderr == ""
    assert hknob("check", spec_file()).stderr == ""


def test_a_sweep_outside_the_domain_of_its_bounded_lag_is_warned_of(hknob, spec_file) -> None:
    lag = "  controller: {kind: bounded_lag, keep: 0.15, time_constant: 0.05}\n"
    spec = SPEC.replace("grid:\n", lag + "grid:\n  knob.inertia: [1.9e-6, 1.0e-4]\n", 1)
    done = hknob("sweep", spec_file(spec))
    assert (done.returncode, done.stderr.count("outside its domain")) == (0, 1)
    assert "small: bounded_lag with keep 0.15 is outside its domain for 1 of 2 hands and knobs" in done.stderr
    within = hknob("sweep", spec_file(spec.replace("[1.9e-6, 1.0e-4]", "[1.9e-6]")), "-o", "within")
    assert (within.returncode, within.stderr.count("domain")) == (0, 0)


def test_an_odd_value_of_an_axis_is_warned_of(hknob, spec_file) -> None:
    done = hknob("check", spec_file(SPEC.replace("[1024]", "[1024]\n  hand.stiffness: [0.04, 7e4]")))
    assert done.stderr.count("hand.stiffness: 70000 N*m/rad is unusually large") == 1
    assert done.returncode == 0


def test_rest_without_a_push_is_remarked_upon_in_one_line(hknob, spec_file) -> None:
    still = SPEC.replace("  bias: {torque: 0.001}\n", "").replace("stiffness: 0.04", "stiffness: 0.4")
    still = still.replace("[1024]", "[8192]").replace("damping: 3.45e-4", "damping: 3.45e-3")
    done = hknob("sweep", spec_file(still))
    said = "the knob is not pushed into the wall (no bias is given); where it rests, it may buzz under a push"
    assert "rest point" in done.stdout
    assert said in done.stdout.splitlines()
    assert json.loads(hknob("sweep", spec_file(still), "--json").stdout)["notes"] == [said]
    assert said not in hknob("sweep", spec_file(), "-o", "pushed").stdout
