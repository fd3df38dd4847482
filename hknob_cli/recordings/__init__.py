"""Recordings of a knob: torque in, angle out, grip force beside; read, checked, written."""
