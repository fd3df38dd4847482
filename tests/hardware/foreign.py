"""A campaign with the target in Perl, as a user runs one: by the command, over a TCP port of this computer."""

import contextlib
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

TARGET = Path(__file__).with_name("foreign_target.pl")
SPEC = """\
kind: hw-run
name: foreign
device: {{driver: serial, url: "{url}"}}
grid: {{sample_rate_hz: {rates}, counts_per_rev: {counts}}}
trial: {{zero: 0.1, settle: 0.1, buzz: [0.3, 0.5], longest: {longest}}}
limits: {{watchdog: 50 ms}}
person: {{wandering_push: false, grip_wander: false}}
"""
# Computers on which tests run are so busy that a process waits for longer than the watchdog's time.
SLACK = "20"


@contextlib.contextmanager
def foreign_target(*options: str) -> Iterator[str]:
    """The target in a process of its own; its URL. Skips the test where there is no Perl, which git brings along."""
    perl = shutil.which("perl")
    if perl is None:
        pytest.skip("needs perl, in which the other target is written")
    with subprocess.Popen(
        [perl, TARGET, "--slack", SLACK, *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.stdin.close()
            try:
                process.wait(timeout=60)
            except subprocess.TimeoutExpired:
                process.kill()


def arranged(folder: Path, url: str, more: str = "", **changes: str) -> tuple[object, ...]:
    """Arguments of the command, its spec written: one trial at 1 kHz with 256 counts unless told otherwise."""
    text = SPEC.format(url=url, **{"rates": "[1000]", "counts": "[256]", "longest": "3", **changes})
    (folder / "spec.yaml").write_text(text + more)
    return "hw-run", folder / "spec.yaml", "-o", folder / "out"
