"""Measures of a proven orbit: extremes, integrals, energy.

- `orbit` all in SI, and an orbit as a sum of sinusoids; `general_orbit` beyond the plain loop, with the work of the
  wall
- `forms` integrals of motion in arrays
- `unsampled` trials without a sample clock
- `growth` of energy from bounce to bounce, and a bound under every clock
- `pieces` an orbit beyond the plain loop as a sum of sinusoids
"""
