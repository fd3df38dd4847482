"""Stage remedies: what can be done against the buzz, and what it costs.

- `trial`, with the best value of what one tunes
"""
