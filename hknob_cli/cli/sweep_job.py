"""A sweep as asked for on the command line: small enough to hand from one process to another."""

from pathlib import Path
from typing import NamedTuple

from hknob_cli.spec.plan import SweepPlan


class SweepJob(NamedTuple):
    """A sweep as asked for on the command line."""

    plan: SweepPlan
    out: Path
    overrides: tuple[str, ...]
    plot: bool
    jobs: int | None
    force: bool
    dry_run: bool
    as_json: bool
    quiet: bool
    verbose: bool

    def run(self) -> None:
        """Do it; print results on stdout. Raises `RefusedError` or `ComputationError`."""
        from hknob_cli.cli.sweep_run import run_sweep

        run_sweep(self)
