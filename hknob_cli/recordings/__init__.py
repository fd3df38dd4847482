"""Recordings of a knob: torque in, angle out, grip force beside; read, checked, written.

- `trial` and its torque pulse
- `columns` what a recording must be, `read` with the row of every fault
- `health` what is doubtful
- `files` batches of rows, and readings of a calibration; recordings written
- `measured_cycle` whether a trial buzzes, and how large, `spectrum` its pitch and harmonics
"""
