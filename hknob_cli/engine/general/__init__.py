"""The loop with whatever else a scene lists: friction, finger, lag, limits, virtual damping, a continuous sensor.

- `body`, `controller` (encoder and wall), `torque_table`, `torque_curve` of a continuous sensor, `torque_range` of
  either far out: the scene in numbers
- `interval` a sample interval, whose clock may jitter, `advance` from event to event, `hysteresis` of the count on the
  way
- `teeth` of a gear, one mode of their motion, `flanks` from mode to mode, `flank_rest`: how long they stay on one
- `cogging` on one slope, `slopes` from slope to slope, `slope_columns` with the derivative, `cog_rest` on one;
  `piece_marks` how slow it slides, and how nearly it is held
- `period_map` the map over a period, and how fast motions part that do not repeat, `powers` of its derivative,
  `orbit_proof` the proof, `corners` over those of cogging
- `looks` at a trial on its way, `inner_region` rest that is never reached, `captured` by an orbit that is known, or
  back where it was
- `outlook`: how far trials are followed; `search`: what they come to
- `every_clock` a bound for all clocks that jitter so much, by `clock_cells`
- `laws/` the same loop under a controller

Beyond the plain loop (`engine/general/`). Between events the motion is linear; the events are zeros of the velocity
and the release of a held knob. Two states have closed forms; with more, a step is halved until the energy of the
rates, which never grows, shows that the velocity keeps its sign or is monotone. The certificate is the same in kind:
friction is a monotone function of speed, so the energy of the difference of two motions with the same readings never
grows. The fixed point is found by Newton's method with the derivative carried through every event (saltation). Its
error bound is first order: inverse of the derivative times residual and roundings, with marks for events that could
go another way within it; it is not an interval enclosure. With a continuous sensor the bound on a difference comes
from the derivative's powers; where teeth press it must not reach the end of a flank. Corners of cogging add to a
difference what is of second order in it, and leave a room in which the derivative decides. A
scene that lists none of this runs in the plain loop, whose source does not know of the other.

Rest that is never reached (`engine/general/inner_region.py`). An overdamped hand with friction creeps to the edge of
the zone in which friction can hold the knob, for ever. It would rest at any point of that zone, and its distance from
such a rest, by energy, never grows: once it is below the distance to the next count edge, all later samples get one
reading, and friction and damping bring the knob to rest. With a continuous sensor the wall's spring is part of that
energy, which needs b ≥ KT/2. Without friction the loop of a continuous sensor is linear; P = Σ (Mᵏ)ᵀ Mᵏ, summed by
doubling and then checked against its roundings, gives an ellipse that bounds every later difference, however slow the
loop.
"""
