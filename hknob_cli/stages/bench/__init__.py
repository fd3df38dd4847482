"""Stage bench: the engine beside other methods, error against run time.

- `timed` runs
"""
