/* The pulse that a grip fires: the state machine of docs/reference/wire.md, "Pulses". */
#ifndef PULSE_H
#define PULSE_H

#include <stdbool.h>

#include "messages.h"

/* What a trial is at, in the order of hknob_cli/hardware/control.py. */
enum { PULSE_ZERO = 0, PULSE_RELAX, PULSE_SQUEEZE, PULSE_HOLD, PULSE_ON, PULSE_RELEASE, PULSE_DONE };

struct pulse_state {
    double sum; /* of the cell before the start, over `count` samples */
    uint32_t count, stayed;
    uint8_t phase;
};

/* Torque from this sample on, N·m, at which the grip cell shows `cell_n`; `running`: whether the trial has started. */
double pulse_step(const struct pulse *pulse, struct pulse_state *state, double cell_n, bool running);

#endif
