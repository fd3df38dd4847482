"""Stage remedies: what can be done against the buzz, and what it costs.

- `trial`, `tuning` the best value of what one tunes
"""
