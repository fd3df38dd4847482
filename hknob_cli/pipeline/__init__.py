"""The pipeline: steps that run in the order of their inputs, and only where something has changed."""
