/* The target: states, sample, watchdog and limits of docs/reference/wire.md, on any board. */
#ifndef TARGET_H
#define TARGET_H

#include <stdbool.h>

/* Once, before anything else; torque off. */
void target_begin(void);

/* The sample. The sample clock calls it when the time given to board_call_at() has come. */
void target_sample(void);

/* The rest: bytes from and to the host, watchdog between samples. The main loop calls it again and again, at least every
   5 ms and whenever bytes came; it never waits. Whether bytes are left that the host did not take. */
bool target_serve(void);

/* Whether the sample clock runs or something is to be repeated: the main loop should not sleep for longer than 1 ms. */
bool target_busy(void);

#endif
