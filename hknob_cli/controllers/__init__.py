"""Controllers beside the plain virtual wall. Each turns the numbers of a spec into those of its compiled law.

- one file a controller, with its source
- `controller` what a controller is
- `scalar_law` one of them in a cell, as the compiled general loop runs it

The functions are in `engine.general.laws`, and so are the proofs; all starts at once are in `engine.general.sets`.
"""
