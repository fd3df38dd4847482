/* The line: torques that are under way to the motor, by their delay and the parts of a sample interval. */
#ifndef LINE_H
#define LINE_H

#include <stdbool.h>
#include <stdint.h>

#include "messages.h"

/* Torques that there is room for, 8 bytes each. A board with less memory defines less. */
#ifndef LINE_MOST
#define LINE_MOST 1024u
#endif

/* When in an interval a torque goes out: of which part, and of how many samples ago. */
struct slot {
    double begins;
    uint32_t age, part;
};

struct line {
    uint32_t parts, rows, newest, slot_count;
    struct slot slots[PARTS_MOST + 1u];
    double torques[LINE_MOST]; /* a row a sample, round and round */
};

/* No torque is under way. `begins` of each part of an interval, in parts of it, rising from 0. False without the room. */
bool line_begin(struct line *line, uint32_t parts, const double *begins, double delay_samples);

/* The torques of a sample, one a part. */
void line_put(struct line *line, const double *torques);

/* The torque of one of the slots, of which the first begins with the sample. */
double line_torque(const struct line *line, uint32_t slot);

#endif
