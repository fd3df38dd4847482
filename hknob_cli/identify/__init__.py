"""Identification: from recorded motion to inertia, damping and stiffness, with how sure they are.

- `motion`, `prepare` (align, smooth, differentiate)
- `least_squares`, `output_error`, `fourth_order` (`finger_network`)
- `second_order` where a search begins, `nearest` how it goes on, `fit` how sure
- `identified` from fits to a person
- `calibration`
- `studies` what the estimators are worth
"""
