"""The knob without a sample clock: an exact state machine, from one encoder edge to the next.

- `state_machine` from event to event, `settling` to the end of a trial

Without a sample clock the wall's torque is a function of the angle that never falls with depth, so the potential is
convex: where the knob can rest is known before it moves, and chatter over a count edge need not be followed through
its infinitely many crossings. Positions are told from the nearest edge and set to it exactly when it is crossed; the
velocity there comes from the energy where nothing damps, so that a million bounces keep it to rounding.
"""
