/* The board: all that a target needs from the machine it runs on. A board is one file with these functions. */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "messages.h"

#define BOARD_NEVER UINT64_MAX

/* Who this is; shortest_period_ns is what the sample clock can keep. */
extern const struct identity board_identity;

/* Another number after every start. */
uint32_t board_boot(void);

/* Time since some moment, in ns: never goes back, never wraps. Called from the sample clock and from the main loop. */
uint64_t board_now_ns(void);

/* Have the sample clock call target_sample() once, as soon as this time has come; BOARD_NEVER: not at all. It is asked
   for more than once an interval where a torque changes within it, or the encoder is read. */
void board_call_at(uint64_t time_ns);

/* Counts of the knob's encoder at this moment, growing outwards, 0 at the wall's edge. Called once a sample, and at each
   reading within an interval that a controller asks for. */
int32_t board_angle(void);

/* Torque in N·m from now on, positive outwards. 0 must take effect at once. */
void board_torque(double torque_nm);

/* Grip force in N; 0 without a cell. */
double board_grip_n(void);

/* Whether the emergency stop is pressed. */
bool board_emergency(void);

/* Bytes from and to the host, without waiting; each returns how many it moved. */
size_t board_receive(uint8_t *bytes, size_t most);
size_t board_send(const uint8_t *bytes, size_t count);

/* Between these two the sample clock does not call; never nested. target_sample() itself is called as if between them. */
void board_lock(void);
void board_unlock(void);

/* A trial is armed, or its wall is switched on with the next sample: a simulated knob rests, or is taken hold of. */
bool board_armed(const struct settings *settings);
void board_started(void);

/* So much of a sample interval has passed under the torque that was last set: a simulated knob moves. `ends`: a sample
   comes next, else another torque or a reading within the interval. Nothing where the knob is real. */
void board_passed(double part, bool ends);

/* Take on another simulated knob; the status of the answer: NOT_KNOWN where the knob is real. */
uint8_t board_simulate(const struct simulated *simulated);

/* Have somebody squeeze the simulated knob from now on, until the next board_simulate(); NOT_KNOWN where it is real. */
uint8_t board_squeeze(const struct squeeze *squeeze);

#endif
