"""Scenes reduced to the smallest set of numbers that the engine runs on.

- `sampled_knob`: one cell, dimensionless (counts and sample periods), or many at once
- `general_knob`: one with more in it; `general_body` what moves, `increments` of its linear motion
- `trial`: one trial, sample by sample
- `random_starts` drawn where not all can be followed
- `unsampled_knob`: a scene without a sample clock

Count units. The engine measures angle in encoder counts and time in samples: encoder edges are whole numbers,
exactly, and one kernel serves every scale from 1 Hz to 10 MHz. Positions advance by increments (`x + S v + G y`),
which keep their digits when a hold is a millionth of a time constant.
"""
