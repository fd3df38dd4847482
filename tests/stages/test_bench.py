"""The references of a benchmark: they have an end, too."""

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.spec.load import load
from hknob_cli.stages.bench_run import reference_angles
from tests.conftest import EXPERIMENTS


def test_a_reference_that_takes_too_long_is_told() -> None:
    """A hand of 1e12 N·m/rad turns 1e5 times in a sample interval."""
    stiff = ("base.scene.hand.stiffness=1e12", "scenes={nominal: {}}")
    (trial,) = load(EXPERIMENTS / "bench_quick.yaml", stiff).scenes
    with pytest.raises(UsageError, match=r"scene nominal: reference: digits60 takes more than 0.1 s; make it shorter"):
        reference_angles(trial, limit_s=0.1)


def test_a_usual_one_does_not() -> None:
    trials = load(EXPERIMENTS / "bench_quick.yaml", ("base.duration=0.01",)).scenes
    assert len(reference_angles(trials[0], limit_s=100.0)) == 11
