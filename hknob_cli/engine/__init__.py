"""The engine: exact propagation from sample to sample, and proofs of where trials end."""
