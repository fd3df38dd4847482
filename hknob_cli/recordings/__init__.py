"""Recordings of a knob: torque in, angle out, grip force beside; read, checked, written.

- `trial`
- `read` with the row of every fault, `write`
- `pulse`, `health` what is doubtful, `running_health` of records without a pulse
- `calibration`
- `measured_cycle` size and pitch of a recorded buzz, `harmonics` of it
"""
