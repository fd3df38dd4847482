/* The sample: decimated encoder and virtual wall (docs/reference/wire.md, "What a target does"). */
#include "wall.h"

int64_t wall_decimate(int32_t angle, uint32_t counts_per_rev, uint32_t native_counts)
{
    /* Below 2^31 times below 2^32: a signed 64-bit number holds it. C's division rounds toward zero. */
    int64_t product = (int64_t)angle * (int64_t)counts_per_rev;
    int64_t quotient = product / (int64_t)native_counts;
    return product % (int64_t)native_counts < 0 ? quotient - 1 : quotient;
}

double wall_torque(int64_t count, int64_t before, double offset_counts, double quantum_rad, double interval_s,
                   double stiffness, double damping)
{
    if (count >= 0) {
        return 0.0;
    }
    return -stiffness * (((double)count + offset_counts) * quantum_rad) -
           damping * ((double)(count - before) * quantum_rad) / interval_s;
}

double wall_brake(int64_t count, int64_t before, double quantum_rad, double interval_s, double damping)
{
    return count < 0 ? damping * ((double)(count - before) * quantum_rad) / interval_s : 0.0;
}

double wall_controlled(double depth, int64_t count, int64_t before, double quantum_rad, double interval_s, double stiffness,
                       double damping)
{
    return stiffness * (depth * quantum_rad) - wall_brake(count, before, quantum_rad, interval_s, damping);
}

double wall_limit(double torque_nm, double limit_nm)
{
    return torque_nm > limit_nm ? limit_nm : torque_nm < -limit_nm ? -limit_nm : torque_nm;
}
