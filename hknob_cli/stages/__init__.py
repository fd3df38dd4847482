"""The stages of the pipeline: spec in, result tables out."""
