/* Controllers of the wall: one reading and one torque a sample (docs/reference/wire.md, "Controllers"). */
#ifndef LAW_H
#define LAW_H

#include <stdbool.h>

#include "messages.h"

/* Whether the target can run this controller: a law that it knows, with as many numbers and rows as that law takes. */
bool control_in_range(const struct control *control);

/* Memory before the first sample with the wall on; the knob has stood at `count`. Room for LAW_ROWS_MOST + 1. */
void law_begin(const struct control *control, double *past, double count);

/* What the law gives at `count`, in counts of the plain wall's spring; its memory is renewed. */
double law_act(const struct control *control, double *past, double count);

#endif
