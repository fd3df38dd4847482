/* The pulse that a grip fires, in the order of operations of hknob_cli/hardware/control.py, to the last bit. */
#include "pulse.h"

#include <math.h>

/* Fire, or go on waiting. */
static void wait_for_grip(const struct pulse *p, struct pulse_state *s, double grip)
{
    bool fires;
    if (p->dwell == 0u) {
        fires = grip >= p->grip_n;
    } else {
        bool held = fabs(grip - p->grip_n) <= p->band_n;
        s->stayed = held ? s->stayed + 1u : 0u;
        s->phase = held ? PULSE_HOLD : PULSE_SQUEEZE;
        fires = s->stayed > p->dwell;
    }
    if (fires) {
        s->phase = PULSE_ON;
        s->stayed = 0u;
    }
}

double pulse_step(const struct pulse *p, struct pulse_state *s, double cell_n, bool running)
{
    if (!running) {
        s->sum += cell_n;
        s->count++;
        return 0.0;
    }
    double grip = cell_n - (s->count > 0u ? s->sum / s->count : 0.0);
    if (s->phase == PULSE_ZERO || s->phase == PULSE_RELAX) {
        s->phase = grip < p->release_n ? PULSE_SQUEEZE : PULSE_RELAX;
    }
    if (s->phase == PULSE_SQUEEZE || s->phase == PULSE_HOLD) {
        wait_for_grip(p, s, grip);
    } else if (s->phase == PULSE_ON) {
        s->stayed++;
        s->phase = s->stayed < p->width ? PULSE_ON : PULSE_RELEASE;
    }
    if (s->phase == PULSE_RELEASE && grip < p->release_n) {
        s->phase = PULSE_DONE;
    }
    return s->phase == PULSE_ON ? p->torque_nm : 0.0;
}
