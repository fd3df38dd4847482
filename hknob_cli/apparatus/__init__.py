"""A virtual apparatus to record from: knob, motor, amplifier, encoder, grip cell, and people who hold the knob.

- `people` from the printed tables (means, spread, and the correlation that the spread of ζ
  implies), `hand` with its exact motion, with friction and lag, `hand_recording` a pulse as recorded by an
  apparatus with its nuisances, `experiment` what is recorded, with the benches
"""
