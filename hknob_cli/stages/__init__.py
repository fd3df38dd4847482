"""The stages of the pipeline: spec in, result tables out.

- `job` what to run, `work` what differs between stages, `make` what is the same: compute or reuse, write, draw
- of several stages: `compare` with a sweep, `lag_domain` where the bounded lag helps; `explain`

A stage is a row of `stage_table.py`, a model in `specs/` and a folder here (of `report` the folder is `page/`). In
every folder `work` has the stage's parts; `run` and `text` are there where a stage's computation, with its columns,
and words of its own. Words of bench, design, dfa and hw-run that others use, too, are in `report/`.
Measured and recorded results are sources: a pipeline's stage with a `folder` is never run.
"""
