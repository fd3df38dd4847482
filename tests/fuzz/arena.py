"""A folder to try things in: specs among the files that they name, good and bad, and a watch over what is written."""

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.csv as pc
import pyarrow.parquet as pq

from tests.fuzz.seeds import CORPUS, ROOT
from tests.fuzz.watch import Watch

SPEC, TRIED = "spec.yaml", "tried"  # a file and a folder that are put there to be tried
SMALL = {
    "sweep": "sweep_people.yaml",
    "predict": "predict_case.yaml",
    "sysid": "sysid_everything.yaml",
    "report": "report_small.yaml",
    "claims": "claims_small.yaml",
    "case": "case_small.yaml",
}
GRID = """\
kind: sweep
name: grid
scene:
  knob: {inertia: 1.9e-6}
  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}
  wall: {stiffness: 0.27}
  bias: {torque: 0.001}
grid: {sample_rate_hz: [1000], counts_per_rev: [1024]}
starts: {phases: 4}
record: {duration: 0.02}
"""
HANDS = """\
kind: sysid
name: hands
virtual: {experiments: [1], subjects: 2, blocks: 1, trials: 1, grips: [0.71], rig: {ideal: true}}
keep_recordings: true
subtract_apparatus: 19.8 g*cm^2
"""
KNOB = """\
kind: hw-run
name: knob
grid: {sample_rate_hz: [500], counts_per_rev: [256]}
trial: {zero: 0.05, settle: 0.05, buzz: [0.1, 0.2], longest: 0.5}
person: {push: 1 mN*m, wandering_push: false, grip_wander: false}
"""
MADE = {"grid": ("sweep", GRID), "hands": ("sysid", HANDS), "knob": ("hw-run", KNOB)}


class Arena:
    """``specs``: where specs are and are tried; ``out``: where results belong; ``scratch``: for temporary files."""

    def __init__(self, folder: Path, watch: Watch | None = None) -> None:
        """Furnish a folder."""
        self.folder = folder.resolve()
        self.specs, self.out, self.scratch = (self.folder / name for name in ("specs", "out", "scratch"))
        self.watch = watch or Watch()
        self._tables: dict[str, pa.Table] = {}
        for path in (self.specs, self.scratch, self.folder / "data"):
            path.mkdir(parents=True)
        self._furnish()
        self.furniture = {SPEC, TRIED, *(path.name for path in self.specs.iterdir())}

    @cached_property
    def caches(self) -> tuple[Path, ...]:
        """Folders that anything may be written to: for temporary files, compiled code and fonts."""
        from hknob_cli.engine.jit import cache_directory

        compiled = cache_directory()
        fonts = [Path.home() / place / "matplotlib" for place in (".config", ".cache")]
        return (self.scratch, *fonts, *([compiled.parent] if compiled else []))

    @property
    def spec(self) -> Path:
        """The file to try."""
        return self.specs / SPEC

    def _furnish(self) -> None:
        from hknob_cli.cli.stage_run import run_stage
        from hknob_cli.specs.load import load
        from hknob_cli.stages.job import Job

        for path in (ROOT / "experiments").glob("*.yaml"):
            shutil.copy(path, self.specs)
        for name, file in SMALL.items():
            shutil.copy(CORPUS / file, self.specs / f"{name}.yaml")
        shutil.copy(CORPUS / SMALL["claims"], self.folder / "data" / "claims.yaml")
        self.spec.touch()
        for name, (kind, text) in MADE.items():
            spec = self.folder / "made.yaml"
            spec.write_text(text)
            with contextlib.redirect_stdout(None):
                run_stage(Job(kind=kind, plan=load(spec), out=self.specs / name, jobs=1, quiet=True))
        shutil.copy(self.specs / "hands" / "conditions.parquet", self.specs)
        shutil.copy(self.specs / "hands" / "recordings.parquet", self.specs)
        shutil.copy(self.specs / "knob" / "samples.parquet", self.specs)
        shutil.copytree(self.specs / "knob", self.specs / "folder")
        self._readings()
        pc.write_csv(self.table("recordings"), self.specs / "recordings.csv")
        self._odd_files()

    def _readings(self) -> None:
        """Of the motor and of the grip cell, before their calibration."""
        from hknob_cli.apparatus.experiment import record_grip_cell, record_motor_calibration
        from hknob_cli.apparatus.hand_recording import Rig

        motor: Any = record_motor_calibration(Rig(), seed=1)
        for name, found in (("motor", motor), ("grip_cell", record_grip_cell(seed=1))):
            pq.write_table(pa.table(dict(found._asdict())), self.specs / f"{name}.parquet")

    def table(self, name: str) -> pa.Table:
        """A table that the program has written, or reads."""
        if name not in self._tables:
            self._tables[name] = pq.read_table(self.specs / f"{name}.parquet")
        return self._tables[name]

    def _odd_files(self) -> None:
        whole = (self.specs / "conditions.parquet").read_bytes()
        (self.specs / "torn.parquet").write_bytes(whole[: len(whole) // 2])
        (self.specs / "empty.parquet").touch()
        (self.specs / "text.parquet").write_text("a,b\n1,2\n")
        (self.specs / "unreadable").touch(mode=0o000)
        (self.specs / "loop").symlink_to("loop")
        os.mkfifo(self.specs / "pipe")

    @contextlib.contextmanager
    def entered(self) -> Iterator[None]:
        """Work in the folder of specs, temporary files in that for them."""
        before, temporary = Path.cwd(), tempfile.tempdir
        os.chdir(self.specs)
        tempfile.tempdir = str(self.scratch)
        try:
            yield
        finally:
            os.chdir(before)
            tempfile.tempdir = temporary

    def left(self) -> list[str]:
        """What is there that was not, where nothing should be."""
        found = [path.name for path in (*self.specs.iterdir(), *self.scratch.iterdir())]
        return sorted({*found} - self.furniture)

    def clear_out(self) -> None:
        """Remove results."""
        shutil.rmtree(self.out, ignore_errors=True)

    def clear(self) -> None:
        """Make ready for the next."""
        self.clear_out()
        for name in self.left():
            for folder in (self.specs, self.scratch):
                shutil.rmtree(folder / name, ignore_errors=True)
                with contextlib.suppress(OSError):
                    (folder / name).unlink(missing_ok=True)
