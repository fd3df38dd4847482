"""Stage remedies: what can be done against the buzz, and what it costs."""
