/* The simulated knob, hand and person of hknob_cli/hardware/port.py, exact from sample to sample. */
#ifndef PLANT_H
#define PLANT_H

#include <stdbool.h>
#include <stdint.h>

#include "messages.h"

/* Time is counted in sample intervals: speed in rad per interval, the rates without dimension. */
struct plant {
    struct simulated person;
    double interval_s;
    double per_torque;      /* interval^2 / inertia */
    double spring, drag;    /* stiffness and damping, in these units */
    double step[2][2];      /* integral of exp(A u) over one interval */
    double angle, speed;
    uint32_t passed;        /* samples since the person took hold */
    bool held;              /* by nobody: at rest at the angle of the start */
    struct squeeze squeeze; /* of no hands: a knob with a wall */
    double rest;            /* angle at which a knob that pulses rests, about which `angle` is then counted */
    double fired_s;         /* when its pulse came; infinite before */
};

/* At rest, held by nobody. False if the motion is too fast for this interval to follow. */
bool plant_begin(struct plant *plant, const struct simulated *person, double interval_s);

/* After plant_begin: the knob rests until a torque comes, and then is held as the grip of that sample says. False if the
   motion of one of the hands is too fast. */
bool plant_squeezed(struct plant *plant, const struct squeeze *squeeze);

/* The person takes hold; this is the sample at t = 0. */
void plant_start(struct plant *plant);

/* On by a part of an interval, under a torque in N·m; `ends`: to the next sample. */
void plant_advance(struct plant *plant, double torque_nm, double part, bool ends);

/* The angle at this sample, in rad. */
double plant_angle(const struct plant *plant);

/* At this sample: push in N·m into the wall, and what the grip cell shows, in N. */
double plant_push(const struct plant *plant);
double plant_grip(const struct plant *plant);

#endif
