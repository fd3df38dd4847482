"""Recordings through the installed command: tables and pictures of every kind of trajectory."""

from pathlib import Path

import pytest

from tests.conftest import EXPERIMENTS


@pytest.mark.long
@pytest.mark.parametrize("name", ["grip_pulse_finger", "stiff_wall", "short_contact_analog"])
def test_trajectories_are_drawn(hknob, tmp_path: Path, name: str) -> None:
    """A pulse without a wall, a torque with a scale of its own, and one on the scale of the motion."""
    done = hknob("sweep", EXPERIMENTS / f"{name}.yaml", "--plot", "-o", "out")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "wrote out/trajectories.parquet" in done.stdout
    assert (tmp_path / "out" / "trajectories.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
