"""Stage sysid: the hand that holds a knob, identified.

- `against` the truth, and other tables beside those of hands; `remarks`
"""
