"""Identification: from recorded motion to inertia, damping and stiffness, with how sure they are.

- `motion`, `prepare` (align, smooth, differentiate)
- `least_squares`, `output_error`, `fourth_order`
- `second_order` where a search begins, `nearest` how it goes on, `fit` how sure
- `identified` calibrations, and from fits to a person
- `studies` what the estimators are worth
"""
