"""The engine: exact propagation from sample to sample, and proofs of where trials end.

- `propagator` the plant over a hold
- `loop` encoder (rounding to nearest is a shift made in `scene`), wall, delay, zero-order hold
- `turning` points of the motion, and peaks outside the wall
- `certificate` the proof of an orbit
- `relay_cycles` two-level orbits, enumerated
- `rest` the proof of a rest point
- `follow` one trial to its end
- `ensemble` all phases of a cell, within its `budget` of samples
- `orbit_holds` one period, `orbit_cycle` what it amounts to: peaks between samples, integrals, work of the wall
- `attractors` of a cell, with their shares
- `cells` many of them without leaving compiled code, `cell_run` as columns
- `jit` the same source compiled, `kept_code` on the disk, `compiling` what is said of it, `linking` what is optimised,
  `absent` what is left out
- `alarm` the time a cell may take

One source, interpreted or compiled. Engine functions are plain Python over floats. `jit.py` compiles copies of them
with numba when a job is long enough to repay its loading (about 0.2 s). Where no compiled code is kept yet, compiling
takes many seconds; the interpreter then goes on until it has taken as long, so that a short job never waits for a
compiler. Neither side fuses or reorders arithmetic, so results are equal to the last bit, and a test says so. The few
functions that Python calls are optimised with all that they call; the others are only translated (`linking.py`).
What a scene lacks is not compiled (`absent.py`). Compiled code is cached by a digest of the sources.

Cell by cell, or many in one call (`engine/cells.py`). A sweep of many cheap cells would spend most of its time
between kernels. So cells that are all plain are reduced as arrays (`scene.plain_knob.reduce_scene` is the same
arithmetic over numbers and arrays), run, measured and ranked in one compiled function, which returns now and then so
that an interruption is heard, and laid out as tables from columns. It calls the functions that one cell does, in the
same order: tables are the same to the last bit, and a test says so.

Lanes, then one by one (`ensemble`, then `follow`). The transient (ten time constants) is run branch-free with 64
trials side by side, bound by the vector units; what follows, up to the proof, is scalar. Memory depends neither on
the length of the motion nor on the number of trials.

The certificate (`engine/certificate.py`). Same levels for one period determine one periodic motion (I - Φⁿ is
invertible with b > 0, k > 0). Solved and refined, it must visit the same levels with a margin above an error bound. A
trial is captured when sqrt(e² + ė²/β) of its distance is below the margin: that bounds the distance at all later
times. Without hand stiffness cycles form a continuum and are labelled so; without damping nothing settles.

A limit on the clock. `limits.seconds_per_cell` is none by default, because results must not depend on how fast a
machine is. The trials that are done when the time is over count; the others are undecided and say so. A timer sets a
flag that the general loop looks at, at every sample and every step of a slide; the plain loop runs a few trials at a
time.

Periods by constant memory. Brent's cycle finding at the samples where the wall steps deeper: a checkpoint is moved on
after 1, 2, 4, … of them, and a near return to it is a candidate period.
"""
