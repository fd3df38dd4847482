"""The claims ledger: what a text prints, the computation that checks it, and the verdict.

- `ledger` claims with readings and tolerances
- `verdict` the rule
- `text` one claim for the terminal
- `checks/` the computations, one file a subject, found by being there

Verdicts are computed. A claim names a check and its arguments; checks read results, whose scene supplies every
constant, and the printed tables. `reproduced`: a reading that the print allows is within the tolerance; `differs`:
within the wider one; `contradicted`: none is. Excluded readings are computed and shown, and decide nothing.
"""
