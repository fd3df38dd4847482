"""A knob to run trials on: the device port, its drivers, the wire to a target, and the campaign of trials.

- `port` what a driver does, and who holds a knob that is simulated
- `virtual`, `replay`, `serial_device` (over `wire/`) the drivers, which `campaign` chooses from
- `person` who draws the hands of a simulated campaign
- `firmware/` the target in C99, `reference_target` built and run. A campaign: `order`, `campaign` what is left to do,
  `trial_run` one trial and who watches it, `trial_phases` when it is enough, `safety`, `sample_clock` and its audit,
  `journal` what was received, `archive` what is kept
- `tables` what it amounts to

A journal, then a file. A block of samples is appended to the trial's journal, with length and CRC, before anything is
concluded from it; a finished trial is a file of its own; the results are made of these files alone. So a campaign
goes on after a kill, and results are made again, by a later version too, without the device. What ends a trial
depends on its samples, never on when they arrive, so that a simulated campaign gives the same bytes however often it
was cut short.
"""
