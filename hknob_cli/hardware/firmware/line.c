/* The line, in the order of operations of hknob_cli/hardware/trial_wall.py. */
#include "line.h"

#include <math.h>

bool line_begin(struct line *line, uint32_t parts, const double *begins, double delay_samples)
{
    double whole = floor(delay_samples), split = delay_samples - whole;
    line->parts = parts;
    line->rows = (uint32_t)whole + 2u;
    line->newest = line->slot_count = 0u;
    if (parts > PARTS_MOST || line->rows * parts > LINE_MOST) {
        return false;
    }
    for (uint32_t i = 0; i < line->rows * parts; i++) {
        line->torques[i] = 0.0;
    }
    /* The parts of older torques go on until those of the newer begin: the last of these before all others. */
    for (int late = 1; late >= 0; late--) {
        for (uint32_t i = 0; i < parts; i++) {
            double at = begins[i] + split - late, end = (i + 1u < parts ? begins[i + 1u] : 1.0) + split - late;
            if (at < 1.0 && end > 0.0) {
                struct slot *slot = &line->slots[line->slot_count++];
                slot->begins = at > 0.0 ? at : 0.0;
                slot->age = (uint32_t)whole + (uint32_t)late;
                slot->part = i;
            }
        }
    }
    return true;
}

void line_put(struct line *line, const double *torques)
{
    line->newest = (line->newest + 1u) % line->rows;
    for (uint32_t i = 0; i < line->parts; i++) {
        line->torques[line->newest * line->parts + i] = torques[i];
    }
}

double line_torque(const struct line *line, uint32_t slot)
{
    const struct slot *s = &line->slots[slot];
    uint32_t row = (line->newest + line->rows - s->age) % line->rows;
    return line->torques[row * line->parts + s->part];
}
