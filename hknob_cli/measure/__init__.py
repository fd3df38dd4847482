"""Measures of a proven orbit: extremes, integrals, energy.

- `orbit` all in SI, `general_orbit` beyond the plain loop, with the work of the wall
- `forms` integrals of motion in arrays
- `unsampled` trials without a sample clock
- `growth` of energy from bounce to bounce
- `harmonics` an orbit as a sum of sinusoids, `pieces` beyond the plain loop
"""
