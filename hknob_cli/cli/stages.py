"""The stage commands, ``hknob sweep`` and the others: one way to be called, told apart by kind."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from hknob_cli.cli.console import reporting
from hknob_cli.cli.handover import submit
from hknob_cli.cli.options import (
    DryRun,
    Executor,
    ExecutorName,
    Force,
    Jobs,
    Json,
    Out,
    Quiet,
    Scheduler,
    Sets,
    SpecFile,
    Verbose,
    unspreadable,
)
from hknob_cli.errors import UsageError

# Kind, what it does, what it draws.
STAGES = {
    "sysid": (
        "Identify the hand that holds a knob, with error bars, from recordings of torque pulses.",
        "Draw the hand over grip force, a calibration or studies into sysid.png, calibration.png, bias.png, ...",
    ),
    "sweep": (
        "Find every limit cycle of a grid of sample rates and encoder resolutions, with its size, pitch and share.",
        "Draw the grid into grid.png beside the results.",
    ),
    "dfa": (
        "Predict limit cycles from the frequency response: describing functions, Tsypkin's locus, the sampled relay.",
        "Draw Nyquist curves, sizes and differences into dfa.png beside the results.",
    ),
    "predict": (
        "Estimate limit cycles by closed laws, say how far to trust them, and which stability limit binds.",
        "Draw every law into predict.png beside the results.",
    ),
    "remedies": (
        "Try remedies against the buzz: how much smaller, at what pitch, and what stiffness is left.",
        "Draw every case, and remedies over every further axis, into PNG files beside the results.",
    ),
    "design": (
        "Find the cheapest design whose limit cycles nobody minds, with proof, and say what binds it.",
        "Draw cost against level, and the grid, into design.png beside the results.",
    ),
    "bench": (
        "Compare the engine with SciPy, fixed steps and MuJoCo, scene by scene: error against run time.",
        "Draw error against time into bench.png, and into bench_SCENE.png for each scene, beside the results.",
    ),
    "report": (
        "Put results on one page, with figures, and judge the claims of a text by them.",
        "No effect: the page has figures.",
    ),
}


def submit_stage(
    kind: str, spec: Path, out: Path | None, sets: list[str] | None, *, refuse: str, **options: Any
) -> None:
    """Read a spec and submit its job, with ``options`` of `Job`; ``refuse``: why it cannot be spread so."""
    with reporting():
        if refuse:
            raise UsageError(refuse)
        from hknob_cli.cli.job import Job
        from hknob_cli.specs.load import load

        plan = load(spec, tuple(sets or ()), kind=kind)
        where = out or Path("results") / plan.name
        submit(Job(kind=kind, plan=plan, out=where, overrides=tuple(sets or ()), **options))


def stage_command(kind: str) -> Callable[..., None]:
    """The command of one kind of stage."""
    summary, picture = STAGES[kind]

    def command(
        spec: SpecFile,
        out: Out = None,
        sets: Sets = None,
        plot: Annotated[bool, typer.Option("--plot", help=picture)] = False,
        jobs: Jobs = None,
        executor: Executor = ExecutorName.local,
        scheduler: Scheduler = None,
        force: Force = False,
        dry_run: DryRun = False,
        as_json: Json = False,
        quiet: Quiet = False,
        verbose: Verbose = False,
    ) -> None:
        submit_stage(
            kind,
            spec,
            out,
            sets,
            refuse=unspreadable(kind, executor, scheduler),
            plot=plot,
            jobs=jobs,
            scheduler=scheduler,
            force=force,
            dry_run=dry_run,
            as_json=as_json,
            quiet=quiet,
            verbose=verbose,
        )

    command.__doc__ = summary
    return command
