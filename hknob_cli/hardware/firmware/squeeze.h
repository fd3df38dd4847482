/* A simulated person who squeezes until the knob pulses, and lets go: hknob_cli/hardware/person.py. */
#ifndef SQUEEZE_H
#define SQUEEZE_H

#include "messages.h"

/* Grip force in N at `time_s` since the start; `fired_s`: when the pulse came, infinite where it has not. */
double squeeze_force(const struct squeeze *squeeze, double time_s, double fired_s);

/* Inertia, damping and stiffness of knob and hand at a grip force, on the straight line between two rows. */
void squeeze_hand(const struct squeeze *squeeze, double grip_n, double hand[3]);

#endif
