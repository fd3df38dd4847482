"""Stage design: the cheapest design whose limit cycles nobody minds.

- `run` evaluates designs in the order of cost, and chooses the cheapest good one (of several, the least felt)
- `space` what can be chosen
- `evaluate` all people at once, `people` what they notice
- `ranking` of what was evaluated, and how sure an answer is
"""
