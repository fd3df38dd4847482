"""Stage hw-run: trials on a knob, real or simulated.

- `strip` the line that shows a trial as it runs
- `remedies` what each remedy left of the buzz, beside what was computed
"""
