"""Stage remedies: what can be done against the buzz, and what it costs.

- `run` tries each remedy, with the best value of what it tunes
"""
