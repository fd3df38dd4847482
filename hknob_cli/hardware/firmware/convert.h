/* Converters: how the wall reads the encoder, and what is sent of its torque (docs/reference/wire.md, "Converters"). */
#ifndef CONVERT_H
#define CONVERT_H

#include "messages.h"

/* The wall's count at an angle in counts of the target's own encoder; exact. */
int64_t convert_count(const struct converters *converters, int32_t angle, uint32_t counts_per_rev, uint32_t native_counts);

/* What is sent of a torque: nothing in the dead band; then whole steps; then cut off. The torque is a number. */
double convert_send(const struct converters *converters, double torque_nm);

#endif
