"""The command that a user would want after a stage: its picture, its page in a browser, or the next question."""

import shlex
from pathlib import Path
from typing import Any

from hknob_cli.stage_table import STAGES
from hknob_cli.stages.job import Job
from hknob_cli.stages.work import Work


def next_step(job: Job, work: Work, summary: dict[str, Any]) -> str:
    """The command line; empty where there is none, as of a job that no command named.

    What it writes is not there yet. A knob that does not buzz needs no remedies.
    """
    if job.spec in ("", "-"):
        return ""
    if pages := [name for name in work.texts(job) if name.endswith(".html")]:
        return shlex.join(["python3", "-m", "webbrowser", str(job.out / pages[0])])
    if work.pictures(job) and not job.plot:
        out = [] if job.out == Path("results") / job.plan.name else ["--out", str(job.out)]
        sets = [word for one in job.overrides for word in ("--set", one)]
        return shlex.join(["hknob", job.kind, job.spec, "--plot", *out, *sets])
    then = STAGES[job.kind].then
    file = f"{job.plan.name}-{then}.yaml"
    if not then or Path(file).exists() or not summary.get("orbits", {"cycle": 1})["cycle"]:
        return ""
    return shlex.join(["hknob", "new", then, "--out", file])
