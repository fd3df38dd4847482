"""Controllers in the compiled general loop: beside friction, finger, lag, delay, limits, steps and virtual damping.

- `law` what the loop knows of one, `step` a sample interval under it, and a period written down
- `cascade` how far two motions with the same readings part
- `period` the proof, `sensed` that of a law that reads the velocity, and how fast motions part, `rest`, `follow` a
  trial, `trials` a cell

A law is a function, compiled alone and called by address, from what the sensor shows and what is remembered to the
torques of an interval: ``act(shown, speed, past, fixed, out)``. ``shown``: the encoder's count; ``speed``: of a
velocity sensor, counts a sample; ``past``: memory, which a law rewrites in place, then the last reading and those at
the looks into the last interval; ``fixed``: numbers of its own, first the offset of the counts; ``out``: takes the
torques of the parts of the interval, in steps of the wall, and of a law that senses the speed, which has one part, the
torque's slope by it. What is returned is how far the number that fades, the sum that drifts, or the speed that is
sensed may move before the law acts otherwise; inf where it may be anything. Each is in its own file of `controllers`.

What a controller remembers follows from the readings alone, so the loop is a cascade: readings, memory, torque, plant.
Of the memory most is counted: a place, a time, a torque of the last samples, the same numbers in all motions with the
same readings. One number may fade: a running mean, whose difference in two motions shrinks by one factor a sample,
whatever they read, so that all torques that are still to come differ by at most a known sum. Two may fade together,
as those of a second-order filter: in a norm of both. The energy of the
difference of two plants never grows under the same torques (`general.body`), and by no more than that sum under these.
A repeating sequence of readings therefore has one periodic memory and one periodic motion of the plant. Where that
motion has these readings, by more than all errors, it is a limit cycle; where a trial's distance, with the sum, is less
than the margin, and the number that fades is nearer to the orbit's than any guard is to 0, the trial stays with it.

What a Kalman filter estimates follows from the readings as well, and comes to numbers that repeat to the last bit. The
sum of energy of a passivity controller may drift. Where the controller owes more than its damper can give back at any
sample, and owes more after each period, its torques no longer depend on how much it is.

A controller that reads the velocity is no such cascade: two motions with the same readings get other torques. Without
friction a period is an affine map between edges, and its powers bound how far two motions part. With friction what
repeats is labelled as not proven. So is all that repeats under a law that reads a continuous sensor, whose memory
follows the motion, too.

Under a sample clock that jitters a law reckons with the period that is meant, and the pieces of an interval are longer
or shorter with it. Rest is proven as before: what is remembered goes by samples, and no torque acts longer than the
longest interval, which is the unit of time. Of a law that is no cascade a standstill is seen, and labelled.
"""
