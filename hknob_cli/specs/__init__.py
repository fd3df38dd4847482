"""Specs: YAML to validated models, every fault with its place."""
