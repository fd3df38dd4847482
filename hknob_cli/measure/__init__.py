"""Measures of a proven orbit: extremes, integrals, energy.

- `orbit` all in SI
- of motion in arrays: `moments`, `forms` integrals, `leak` the work of the wall
- `unsampled` trials without a sample clock
- `growth` of energy from bounce to bounce
- `harmonics`, `general_harmonics` an orbit as a sum of sinusoids
- `buzz`, `swing` peaks between samples, `pitch` of a buzz, `principal_frequency`, `torque_rises`
"""
