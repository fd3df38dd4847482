"""Scenes reduced to the smallest set of numbers that the engine runs on.

- `plain_knob`: one cell, dimensionless (counts and sample periods), or many at once; one without a sample clock
- `general_knob`: one with more in it, and one trial, sample by sample; `general_body` what moves, `increments` of its
  linear motion

Count units. The engine measures angle in encoder counts and time in samples: encoder edges are whole numbers,
exactly, and one kernel serves every scale from 1 Hz to 10 MHz. Positions advance by increments (`x + S v + G y`),
which keep their digits when a hold is a millionth of a time constant.
"""
