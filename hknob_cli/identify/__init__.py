"""Identification: from recorded motion to inertia, damping and stiffness, with how sure they are.

- `motion`, `prepare` (align, smooth, differentiate)
- `least_squares`, `output_error`, `fourth_order` (`finger_network`)
- `readings`, `covariance`, `profile`, `fit` how sure
- `start` where a search begins
- `identified` from fits to a person
- `calibration`
- `studies` what the estimators are worth
"""
