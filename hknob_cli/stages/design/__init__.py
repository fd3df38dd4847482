"""Stage design: the cheapest design whose limit cycles nobody minds.

- `run` searches and chooses
- `space` what can be chosen
- `evaluate` all people at once, `people` what they notice, and how sure an answer is
"""
