/* The simulated knob as a board has it: what stands behind encoder, motor and grip cell where there are none. */
#ifndef SIMULATED_KNOB_H
#define SIMULATED_KNOB_H

/* As of the encoder of the HREF knob (Section 3.2 of the dissertation). */
#define SIMULATED_NATIVE_COUNTS 640000u

#endif
