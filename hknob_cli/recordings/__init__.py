"""Recordings of a knob: torque in, angle out, grip force beside; read, checked, written.

- `trial`, its torque pulse, and what is doubtful of it
- `columns` what a recording must be, `read` with the row of every fault
- `files` batches of rows, and readings of a calibration; recordings written
- `measured_cycle` whether a trial buzzes, and how large, `spectrum` its pitch and harmonics
"""
