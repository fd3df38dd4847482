"""A knob to run trials on: the device port, its drivers, the wire to a target, and the campaign of trials.

- `port` what a driver does
- `virtual`, `replay`, `serial_device` (over `wire/`) the drivers, `drivers` their choice
- `simulated`, `person` who holds a knob that is not there
- `firmware/` the target in C99, `build_target`, `run_target`. A campaign: `order`, `campaign` what is left to do,
  `trial_run` one trial, `trial_phases` when it is enough, `safety` with `wall_law`, `sample_clock`, `clock_drift`,
  `undisturbed` while the torque goes off, `journal` what was received, `archive` and `sources` what is kept,
  `operator` who watches
- `tables`, `timing` what it amounts to

A journal, then a file. A block of samples is appended to the trial's journal, with length and CRC, before anything is
concluded from it; a finished trial is a file of its own; the results are made of these files alone. So a campaign
goes on after a kill, and results are made again, by a later version too, without the device. What ends a trial
depends on its samples, never on when they arrive, so that a simulated campaign gives the same bytes however often it
was cut short.
"""
