"""Stage sysid: the hand that holds a knob, identified.

- `calibration`, `study` of the estimators, `remarks`
"""
