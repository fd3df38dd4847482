"""The table of stages, one row each: commands, kinds of specs, schemas, completion and messages come from it.

It imports nothing of the program. What a row names by a path, ``module:name``, is loaded when it is needed.
``python -m hknob_cli.stage_table`` prints every kind that has a schema.
"""

from importlib import import_module
from typing import Any, NamedTuple


class Stage(NamedTuple):
    """A stage of the pipeline.

    ``name`` is its command and the `kind` of its spec, ``summary`` says what it does and ``picture`` what ``--plot``
    draws. ``model`` validates its spec, and ``validate`` makes a plan of one; without it the spec is of a scene over a
    grid. ``work`` is its `stages.work.Work`. ``spread``: whether a cluster can share the work. ``command``: its own
    command, where that takes more options than others. ``panel``: where the help lists it. ``then``: the kind of spec
    that a user would write after it.
    """

    name: str
    summary: str
    picture: str
    model: str
    work: str
    validate: str = ""
    spread: bool = False
    command: str = ""
    panel: str = "Find out"
    then: str = ""


_ROWS = (
    Stage(
        "sysid",
        "Identify the hand that holds a knob, with error bars, from recordings of torque pulses.",
        "Draw the hand over grip force, a calibration or studies into sysid.png, calibration.png, bias.png, ...",
        model="hknob_cli.specs.sysid:SysidSpec",
        validate="hknob_cli.specs.sysid:validate_sysid",
        work="hknob_cli.stages.sysid.work:WORK",
        panel="Measure",
        then="sweep",
    ),
    Stage(
        "sweep",
        "Find every limit cycle of a grid of sample rates and encoder resolutions, with its size, pitch and share.",
        "Draw the grid into grid.png beside the results.",
        model="hknob_cli.specs.sweep:SweepSpec",
        work="hknob_cli.stages.sweep.work:WORK",
        spread=True,
        then="remedies",
    ),
    Stage(
        "dfa",
        "Predict limit cycles from the frequency response: describing functions, Tsypkin's locus, the sampled relay.",
        "Draw Nyquist curves, sizes and differences into dfa.png beside the results.",
        model="hknob_cli.specs.bench:DfaSpec",
        work="hknob_cli.stages.dfa.work:WORK",
        then="sweep",
    ),
    Stage(
        "predict",
        "Estimate limit cycles by closed laws, say how far to trust them, and which stability limit binds.",
        "Draw every law into predict.png beside the results.",
        model="hknob_cli.specs.bench:PredictSpec",
        work="hknob_cli.stages.predict.work:WORK",
        then="sweep",
    ),
    Stage(
        "remedies",
        "Try remedies against the buzz: how much smaller, at what pitch, and what stiffness is left.",
        "Draw every case, and remedies over every further axis, into PNG files beside the results.",
        model="hknob_cli.specs.remedies:RemediesSpec",
        validate="hknob_cli.specs.remedies:validate_remedies",
        work="hknob_cli.stages.remedies.work:WORK",
        panel="Fix",
        then="design",
    ),
    Stage(
        "design",
        "Find the cheapest design whose limit cycles nobody minds, with proof, and say what binds it.",
        "Draw cost against level, and the grid, into design.png beside the results.",
        model="hknob_cli.specs.design:DesignSpec",
        validate="hknob_cli.specs.design:validate_design",
        work="hknob_cli.stages.design.work:WORK",
        panel="Fix",
        then="hw-run",
    ),
    Stage(
        "hw-run",
        "Run trials over a grid on a knob, real or simulated: record them, and measure how it buzzes.",
        "Draw the grid, the grip and the motions into hw_run.png, the sample clock into timing.png, remedies into "
        "remedies.png.",
        model="hknob_cli.specs.hw_run:HwRunSpec",
        validate="hknob_cli.specs.hw_run:validate_hw_run",
        work="hknob_cli.stages.hw_run.work:WORK",
        command="hknob_cli.cli.app:hw_run",
        panel="Measure",
        then="report",
    ),
    Stage(
        "bench",
        "Compare the engine with SciPy, fixed steps and MuJoCo, scene by scene: error against run time.",
        "Draw error against time into bench.png, and into bench_SCENE.png for each scene, beside the results.",
        model="hknob_cli.specs.bench:BenchSpec",
        validate="hknob_cli.specs.bench:validate_bench",
        work="hknob_cli.stages.bench.work:WORK",
        panel="Check",
    ),
    Stage(
        "report",
        "Put results on one page, with figures, and judge the claims of a text by them.",
        "No effect: the page has figures.",
        model="hknob_cli.specs.report:ReportSpec",
        validate="hknob_cli.specs.report:validate_report",
        work="hknob_cli.page.work:WORK",
        panel="Automate",
    ),
)

STAGES = {row.name: row for row in _ROWS}
KINDS = tuple(STAGES)
PIPELINE = "pipeline"
CLAIMS = "claims"  # a ledger, which names no kind
SPECS = (*KINDS, PIPELINE)  # what `kind:` may say
SCHEMAS = (*SPECS, CLAIMS)


def loaded(path: str) -> Any:
    """What a path of the table, ``module:name``, names."""
    module, _, name = path.partition(":")
    return getattr(import_module(module), name)


if __name__ == "__main__":
    print("\n".join(SCHEMAS))
