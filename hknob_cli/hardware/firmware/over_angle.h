/* Torque over the measured angle: a torque for every count, from a table (docs/reference/wire.md, "Torque over the angle"). */
#ifndef OVER_ANGLE_H
#define OVER_ANGLE_H

#include <stdbool.h>

#include "messages.h"

/* Counts that there is room for, 8 bytes each: 4,096 counts a turn, all the way round. A board with less memory has less. */
#ifndef OVER_ANGLE_MOST
#define OVER_ANGLE_MOST 16640u
#endif

struct over_angle_table {
    struct over_angle head;
    uint32_t filled; /* torques that have come so far */
    double torques[OVER_ANGLE_MOST];
};

/* Begin a table; false, and the table stays, where its numbers are none or there is no room. */
bool over_angle_begin(struct over_angle_table *table, const struct over_angle *head);

/* Take the next piece; false, and the table stays, where it is not the next or a torque is not a number. */
bool over_angle_take(struct over_angle_table *table, const struct torques *piece);

/* Torque in N·m at a count, before the limit; all torques have come. */
double over_angle_torque(const struct over_angle_table *table, int64_t count);

#endif
