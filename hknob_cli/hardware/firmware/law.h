/* Controllers of the wall: one reading a sample or more, and one torque or more (docs/reference/wire.md, "Controllers"). */
#ifndef LAW_H
#define LAW_H

#include <stdbool.h>

#include "messages.h"

/* Whether the target can run this controller: a law that it knows, with as many numbers and rows as that law takes. */
bool control_in_range(const struct control *control);

/* Memory before the first sample with the wall on; the knob has stood at `count`. Behind its rows the memory has the last
   reading, then those made since, within the interval: room for LAW_PAST_MOST. */
#define LAW_PAST_MOST (LAW_ROWS_MOST + 1u + LOOKS_MOST)
void law_begin(const struct control *control, double *past, double count);

/* What the law gives at `count`, in counts of the plain wall's spring: one for each part of the interval. Its memory is
   renewed; the first of them is returned, too. */
double law_act(const struct control *control, double *past, double count, double *parts);

/* How many parts the interval has, and where each begins; of the plain wall one, at 0. Room for PARTS_MOST. */
uint32_t law_parts(const struct control *control, double *begins);

/* How many readings the law takes within an interval, evenly from sample to sample; of the plain wall none. */
uint32_t law_looks(const struct control *control);

/* The laws that this target has, a bit each. */
uint32_t law_known(void);

#endif
