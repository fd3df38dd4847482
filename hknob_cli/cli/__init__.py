"""The command line: one file per subcommand, nothing but talking to the user.

- `main`, `handover` from parsing to work, `app` the commands, of which those of stages are there
- `run`, `check` (with `explain`), `new`, `explore`
- `stage_run` what is said of a stage, `run_done` of a pipeline and of what to do next

Starting light. `hknob --help` loads neither numpy nor numba. `hknob sweep` parses its command line in a child process
while it loads the libraries of the work (`cli/handover.py`); validation models do not leave `specs/`, so that the
working process never loads pydantic. `hknob run` as make repeats it looks whether there is anything to do before typer
loads.
"""
