"""The claims ledger: what a text prints, the computation that checks it, and the verdict."""
