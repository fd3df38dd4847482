/* Torque over the measured angle, in the order of operations of hknob_cli/engine/general/torque_table.py. */
#include "over_angle.h"

#include <math.h>

static bool is_number(double value)
{
    return value - value == 0.0;
}

bool over_angle_begin(struct over_angle_table *t, const struct over_angle *head)
{
    if (head->size < 1u || head->size > OVER_ANGLE_MOST || head->turn < 1u || head->turn > head->size ||
        !is_number(head->below) || !is_number(head->above)) {
        return false;
    }
    t->head = *head;
    t->filled = 0u;
    return true;
}

bool over_angle_take(struct over_angle_table *t, const struct torques *piece)
{
    if (piece->count < 1u || piece->at != t->filled || piece->count > t->head.size - t->filled) {
        return false;
    }
    for (unsigned i = 0; i < piece->count; i++) {
        if (!is_number(piece->values[i])) {
            return false;
        }
    }
    for (unsigned i = 0; i < piece->count; i++) {
        t->torques[t->filled++] = piece->values[i];
    }
    return true;
}

double over_angle_torque(const struct over_angle_table *t, int64_t count)
{
    double place = (double)count - (double)t->head.first, turns = 0.0;
    double size = (double)t->head.size, turn = (double)t->head.turn;
    if (place < 0.0) {
        turns = floor(place / turn);
    } else if (place >= size) {
        turns = floor((place - size) / turn) + 1.0;
    }
    place -= turns * turn;
    /* Within the table by the above; kept there, too, if a rounding should say otherwise. */
    place = place > 0.0 ? place : 0.0;
    place = place < size - 1.0 ? place : size - 1.0;
    return t->torques[(uint32_t)place] + turns * (turns < 0.0 ? t->head.below : t->head.above);
}
