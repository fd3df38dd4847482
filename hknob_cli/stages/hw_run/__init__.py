"""Stage hw-run: trials on a knob, real or simulated.

- `strip` what the operator sees
"""
