"""Plans that no memory holds, or that nobody could wait for: told before anything is computed."""

from pathlib import Path

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.load import load, validate
from hknob_cli.specs.source import parse
from tests.conftest import EXPERIMENTS

VIRTUAL = "kind: sysid\nname: x\nvirtual: {{{}}}\n"
STUDY = "kind: sysid\nname: x\nstudy: {{{}}}\n"
KNOB = "kind: hw-run\nname: x\ntrial: {{longest: {}}}\ngrid: {{sample_rate_hz: [1000, {}]}}\n"


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (VIRTUAL.format("subjects: 1000, blocks: 1000, trials: 1000"), "3:1: virtual: must make at most 50000 trials"),
        (VIRTUAL.format("experiments: [1, 1, 2], subjects: 100, blocks: 10, trials: 5"), "got 60000"),
        (STUDY.format("hidden_inertia: {ratios: {log: [1, 10, 1001]}}"), "must have at most 1000 values, got 1001"),
        (STUDY.format("bias: {nuisances: {lag_s: {lin: [0, 0.001, 2000]}}}"), "3:35: study.bias.nuisances.lag_s: must"),
        (KNOB.format(900, 100_000), "3:18: trial.longest: must be shorter: 9e+07 samples in a trial at 100000 Hz"),
    ],
)
def test_what_is_too_much(text: str, fault: str) -> None:
    with pytest.raises(SpecError) as caught:
        validate(parse(text, "spec.yaml"))
    assert fault in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        VIRTUAL.format("subjects: 92, blocks: 6"),
        VIRTUAL.format("experiments: [1, 1, 1], subjects: 1000, blocks: 2"),
        STUDY.format("hidden_inertia: {ratios: {log: [1, 10, 1000]}}"),
        KNOB.format(900, 20_000),
        "kind: sysid\nname: x\nwhat: motor\nvirtual: {subjects: 1000, blocks: 1000}\n",
    ],
)
def test_what_is_much_and_good(text: str) -> None:
    assert validate(parse(text, "spec.yaml"))


@pytest.mark.parametrize(
    ("overrides", "fault"),
    [
        (
            ("press.duration=1e6",),
            "press.duration: must be shorter: 5e+12 samples of a knock at 125000 Hz, at most 1000000",
        ),
        (
            ("base.grid.counts_per_rev={lin: [1, 1000, 1000]}", "base.grid.sample_rate_hz={log: [1, 1000, 1000]}"),
            "hands: must span at most 1000000 cells with the grid",
        ),
    ],
)
def test_remedies_that_are_too_much(overrides: tuple[str, ...], fault: str) -> None:
    with pytest.raises(SpecError) as caught:
        load(Path(EXPERIMENTS / "remedies.yaml"), overrides)
    assert fault in str(caught.value)
