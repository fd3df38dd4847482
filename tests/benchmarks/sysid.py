"""Identification: five experiments of nine people and 54 trials, by every second-order estimator; and ten million rows.

The first is the whole command in a fresh process, virtual recording and files included, and its parts by one process.
The second, with any argument: a Parquet file as a long day of recording makes it, identified by output error. CPU time
is that of all threads, and tells what a busy machine would take alone.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pyarrow.parquet as pq
from record import put

from hknob_cli.apparatus.experiment import Schedule, record_experiments
from hknob_cli.apparatus.hand_recording import Rig
from hknob_cli.recordings.files import table
from hknob_cli.recordings.read import read
from hknob_cli.recordings.trial import Trial
from hknob_cli.specs.load import load
from hknob_cli.stages.sysid.run import SysidStage

ROOT = Path(__file__).parents[2]
SPEC = ROOT / "experiments/five_experiments.yaml"
ESTIMATORS = ("least_squares", "least_squares_friction", "output_error", "output_error_friction")
CEILING_S = 20.0
ROWS = 10_000_000


def everything(estimators: str, out: Path) -> tuple[float, float]:
    """Wall and CPU time of the command in a fresh process."""
    command = [Path(sys.executable).with_name("hknob"), "sysid", SPEC, "-o", out, "-q", "--force"]
    command += ["--set", "virtual.subjects=9", "--set", f"estimators=[{estimators}]"]
    begin, before = time.perf_counter(), os.times()
    subprocess.run(command, check=True, capture_output=True)
    after = os.times()
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return time.perf_counter() - begin, cpu


def many_rows(folder: Path) -> None:
    """Identify ten million rows that are read from a file."""
    trials: list[Trial] = []
    subject = 0
    length = 0
    while length < ROWS:
        subject += 1
        new = record_experiments(Rig(), Schedule(subjects=[subject]))
        trials += new
        length += sum(len(trial.time_s) for trial in new)
    path = folder / "many.parquet"
    pq.write_table(table(trials), path)
    del trials
    begin = time.process_time()
    found = read([path])
    print(
        f"{length:,} rows, {path.stat().st_size / 1e6:.0f} MB: read in {time.process_time() - begin:.1f} s of CPU",
        end="",
    )
    stage = SysidStage(load(SPEC, ["estimators=[output_error]"]))
    begin = time.process_time()
    fits, _ = stage.run(found)
    print(f", {fits.num_rows} fits by output error in {time.process_time() - begin:.1f} s")


def main() -> None:
    """Print times, and the first beside its ceiling."""
    runs = 3
    with tempfile.TemporaryDirectory() as name:
        pairs = [everything(", ".join(ESTIMATORS), Path(name) / "out") for _ in range(runs)]
        wall, cpu = (statistics.median(pair[i] for pair in pairs) for i in (0, 1))
        print(f"five experiments x 9 persons x 54 trials, four estimators: {wall:.1f} s, CPU {cpu:.1f} s", end="")
        print(f"; ceiling {CEILING_S:.0f} s")
        put("sysid", cpu / CEILING_S)
        for estimator in ESTIMATORS:
            stage = SysidStage(load(SPEC, ["virtual.subjects=9", f"estimators=[{estimator}]"]))
            begin = time.process_time()
            trials = stage.trials()
            recorded = time.process_time()
            fits, _ = stage.run(trials)
            done = time.process_time()
            print(
                f"  {estimator:24}{fits.num_rows} fits of {len(trials)} trials in {done - recorded:5.2f} s of CPU, "
                f"{1e3 * (done - recorded) / fits.num_rows:.2f} ms each; recorded in {recorded - begin:.2f} s"
            )
        if len(sys.argv) > 1:
            many_rows(Path(name))


if __name__ == "__main__":
    main()


# Results, 2026-11-21, 2-core AMD EPYC (Zen 4) virtual machine, Python 3.11, busy with four times as many
# processes as cores, so that CPU time is what counts: one of two cores is used.
#
# five experiments x 9 persons x 54 trials, four estimators: 47.9 s, CPU 15.6 s; ceiling 20 s
#   least_squares           810 fits of 2430 trials in  5.61 s of CPU, 6.92 ms each; recorded in 0.94 s
#   least_squares_friction  810 fits of 2430 trials in  4.43 s of CPU, 5.47 ms each; recorded in 0.88 s
#   output_error            810 fits of 2430 trials in  4.13 s of CPU, 5.10 ms each; recorded in 0.86 s
#   output_error_friction   810 fits of 2430 trials in  4.91 s of CPU, 6.06 ms each; recorded in 1.00 s
# 10,018,890 rows, 105 MB: read in 2.1 s of CPU, 5130 fits by output error in 25.2 s
