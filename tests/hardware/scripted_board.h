/* What a test says to the scripted board, and what it is told. */
#ifndef SCRIPTED_BOARD_H
#define SCRIPTED_BOARD_H

#include <stddef.h>
#include <stdint.h>

#include "messages.h"

extern uint64_t scripted_now, scripted_call_at;
extern int32_t scripted_angle;
extern double scripted_torque, scripted_grip, scripted_passed;
extern uint32_t scripted_samples, scripted_boot, scripted_trials, scripted_starts, scripted_locks;
extern uint8_t scripted_emergency, scripted_unable, scripted_in[65536], scripted_out[262144];
extern size_t scripted_in_count, scripted_in_at, scripted_out_count, scripted_out_room;

/* Angles and speeds of the simulated knob before each torque and after the last; 0 if it cannot be followed. */
int scripted_follow(const struct simulated *person, double interval_s, size_t count, const double *torque_nm,
                    double *angle_rad, double *speed_rad_s);

/* Push of the person and what the grip cell shows, at the samples of a trial. */
void scripted_person(const struct simulated *person, double interval_s, size_t count, double *push_nm, double *grip_n);

#endif
