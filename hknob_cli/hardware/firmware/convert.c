/* Converters, in the order of operations of hknob_cli/hardware/trial_wall.py and of the engine's `send`. */
#include "convert.h"

#include <math.h>

#include "law_parts.h"
#include "wall.h"

enum { FLOOR, NEAREST, CEIL, TRUNCATE, ROUNDINGS };

int64_t convert_count(const struct converters *c, int32_t angle, uint32_t counts_per_rev, uint32_t native_counts)
{
    int64_t native = (int64_t)native_counts;
    int64_t count = wall_decimate(angle, counts_per_rev, native_counts);
    /* The part of a count above it, in parts of 1 / native_counts, less the offset; each half a count up to be nearest. */
    int64_t part = (int64_t)angle * (int64_t)counts_per_rev - count * native;
    part -= (int64_t)floor(c->offset_counts * (double)native_counts + 0.5);
    part += c->rounding == NEAREST ? native / 2 : 0;
    count += part < 0 ? -1 : part >= native ? 1 : 0;
    /* The knob is above the edge at which the target's own encoder shows what it does: up means the next count. */
    return c->rounding == CEIL || (c->rounding == TRUNCATE && count < 0) ? count + 1 : count;
}

double convert_send(const struct converters *c, double torque_nm)
{
    double sent = torque_nm;
    if (fabs(sent) < c->dead_band_nm) {
        sent = 0.0;
    }
    if (c->step_nm > 0.0) {
        sent = c->step_nm * floor(sent / c->step_nm + 0.5);
    }
    return c->limit_nm > 0.0 ? smaller(c->limit_nm, larger(-c->limit_nm, sent)) : sent;
}

static bool within(double value, double most)
{
    return value >= 0.0 && value <= most;
}

bool converters_in_range(const struct converters *c)
{
    return within(c->offset_counts, 1.0) && c->offset_counts < 1.0 && within(c->dead_band_nm, 10.0) &&
           within(c->step_nm, 10.0) && within(c->limit_nm, 10.0) && within(c->delay_samples, 1000.0) &&
           c->rounding < ROUNDINGS;
}
