"""Identification: from recorded motion to inertia, damping and stiffness, with how sure they are.

- `prepare` (align, smooth, differentiate)
- `least_squares`, `output_error`, `fourth_order` (`finger_network`)
- `readings`, `covariance`, `profile`, `quality` how sure, `misfit` what a model that does not fit does to standard
  errors
- `running_start` where a search begins
- `models`, `combine`
- `calibration`
- `bias_study`, `fourth_study` what the estimators are worth
"""
