"""Stage design: the cheapest design whose limit cycles nobody minds.

- `run` evaluates designs in the order of cost, ranks the good ones (by cost, then by how little is felt) and chooses
- `space` what can be chosen
- `evaluate` all people at once, `people` what they notice, and how sure an answer is
"""
