"""Other Pythons and other versions of what hknob stands on: see `tests.matrix.run`."""
