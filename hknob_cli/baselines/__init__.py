"""Other ways to the same motion: SciPy, fixed steps, MuJoCo, and 60 digits. They share no formula with the engine."""
