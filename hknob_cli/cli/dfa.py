"""``hknob dfa``: predict limit cycles by describing functions and exact relay cycles."""

from pathlib import Path
from typing import Annotated

import typer

from hknob_cli.cli.console import reporting
from hknob_cli.cli.handover import submit
from hknob_cli.cli.options import DryRun, Force, Json, Out, Quiet, Sets, SpecFile, Verbose


def dfa(
    spec: SpecFile,
    out: Out = None,
    sets: Sets = None,
    plot: Annotated[bool, typer.Option("--plot", help="Draw Nyquist curves and sizes into dfa.png.")] = False,
    force: Force = False,
    dry_run: DryRun = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Predict limit cycles from the frequency response: describing functions, Tsypkin's locus, the sampled relay."""
    with reporting():
        from hknob_cli.cli.job import Job
        from hknob_cli.spec.load import load

        plan = load(spec, tuple(sets or ()), kind="dfa")
        job = Job(
            kind="dfa",
            plan=plan,
            out=out or Path("results") / plan.name,
            overrides=tuple(sets or ()),
            plot=plot,
            force=force,
            dry_run=dry_run,
            as_json=as_json,
            quiet=quiet,
            verbose=verbose,
        )
        submit(job)
