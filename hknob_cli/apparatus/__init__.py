"""A virtual apparatus to record from: knob, motor, amplifier, encoder, grip cell, and people who hold the knob."""
