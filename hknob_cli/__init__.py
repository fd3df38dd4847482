"""hknob: limit cycles of a haptic knob held against a virtual wall, proven and measured."""

__version__ = "0.1.0"
