"""The same campaign on the virtual device, and through the wire on the target's firmware: the same samples.

In real time, so that a busy computer may be late by more than the watchdog allows: then the torque goes off, the trial
is broken off, and the command goes on with it when it is run again, which is what is done here.
"""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from tests.conftest import HKNOB

TRIES = 12
SPEC = """\
kind: hw-run
name: bench
device: {driver: serial, target: TARGET}
grid: {sample_rate_hz: RATES, counts_per_rev: [256, 1024]}
trial: {zero: 0.1, settle: 0.1, buzz: [0.3, 0.3], longest: 1}
limits: {watchdog: 50 ms}
seed: 3
"""
NEEDED = {
    "host": [("cc", "gcc", "clang")],
    "qemu": [("qemu-system-arm",), ("arm-none-eabi-gcc",)],
}


def runs(spec: Path, out: Path, *more: str) -> None:
    """Run a campaign, again where the watchdog broke it off."""
    said = []
    for _ in range(TRIES):
        done = subprocess.run(
            [HKNOB, "hw-run", spec, "-o", out, "-q", *more], capture_output=True, text=True, check=False
        )
        said.append(done.stderr)
        if done.returncode == 0:
            return
        assert done.returncode == 4, done.stderr
        assert "watchdog" in done.stderr or "no samples" in done.stderr or "silent" in done.stderr, done.stderr
    pytest.fail(f"{TRIES} times broken off: {said}")


LAG = "controller: {kind: bounded_lag, keep: 0.15}\n"


@pytest.mark.long
@pytest.mark.parametrize(
    ("target", "rates", "more"),
    [("host", "[1000, 4000]", ""), ("host", "[1000, 2000]", LAG), ("qemu", "[455, 1000]", "")],
)
def test_a_target_gives_the_samples_of_the_virtual_device(tmp_path: Path, target: str, rates: str, more: str) -> None:
    for names in NEEDED[target]:
        if not any(shutil.which(name) for name in names):
            pytest.skip(f"needs {' or '.join(names)}: make firmware says how to get it")
    spec = tmp_path / "spec.yaml"
    spec.write_text(SPEC.replace("TARGET", target).replace("RATES", rates) + more)
    runs(spec, tmp_path / "wire")
    runs(spec, tmp_path / "virtual", "--set", "device={driver: virtual}")
    wire, virtual = (pq.read_table(tmp_path / name / "samples.parquet").to_pandas() for name in ("wire", "virtual"))
    assert wire["trial"].nunique() == 4
    for (_, one), (_, other) in zip(wire.groupby("trial"), virtual.groupby("trial"), strict=True):
        assert not np.diff(one["sample"]).max() > 1
        held, expected = one[one["running"]], other[other["running"]]
        count = min(len(held), len(expected))
        # The trial goes on for a little after the host says stop, and every sample up to it is there.
        assert count >= 0.4 * one["sample_rate_hz"].iloc[0]
        for column in ("torque_nm", "angle_counts"):
            assert np.array_equal(held[column][:count], expected[column][:count])
        # The zero is subtracted from the grip: means of more or fewer samples of the same number, in f32.
        assert np.allclose(held["grip_n"][:count], expected["grip_n"][:count], rtol=0.0, atol=2.0**-23)
