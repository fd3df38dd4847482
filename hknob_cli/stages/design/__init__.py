"""Stage design: the cheapest design whose limit cycles nobody minds.

- `work` evaluates designs in the order of cost, and chooses the cheapest good one (of several, the least felt)
- `designs` what can be chosen, evaluated for all people at once
- `ranking` what they notice of what was evaluated, in which order that is, and how sure an answer is
"""
