"""Stage hw-run: trials on a knob, real or simulated.

- `strip` the line that shows a trial as it runs
"""
