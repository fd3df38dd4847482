"""Stage sysid: the hand that holds a knob, identified.

- `calibration`, `against` the estimators beside the truth, `remarks`
"""
