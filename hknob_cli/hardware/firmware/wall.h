/* The sample: decimated encoder and virtual wall. */
#ifndef WALL_H
#define WALL_H

#include <stdint.h>

#define TWO_PI 6.283185307179586476925286766559

/* floor(angle counts_per_rev / native_counts) in whole numbers; exact for every angle, counts_per_rev <= native_counts. */
int64_t wall_decimate(int32_t angle, uint32_t counts_per_rev, uint32_t native_counts);

/* Torque in N·m at `count`, `before` that of the sample before; quantum_rad of a count, interval_s between samples; a count
   tells an angle so much above it. */
double wall_torque(int64_t count, int64_t before, double offset_counts, double quantum_rad, double interval_s,
                   double stiffness, double damping);

/* Torque in N·m that the damping takes at `count`, inside the wall. */
double wall_brake(int64_t count, int64_t before, double quantum_rad, double interval_s, double damping);

/* Torque in N·m where a controller gives `depth`, in counts of the spring; the damping acts beside it, inside the wall. */
double wall_controlled(double depth, int64_t count, int64_t before, double quantum_rad, double interval_s, double stiffness,
                       double damping);

/* The torque cut off at plus and minus the limit; not a number stays what it is. */
double wall_limit(double torque_nm, double limit_nm);

#endif
