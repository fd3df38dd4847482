"""A knob to run trials on: the device port, its drivers, the wire to a target, and the campaign of trials."""
