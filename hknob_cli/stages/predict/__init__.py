"""Stage predict: limit cycles by closed laws, and the limits of stability."""
