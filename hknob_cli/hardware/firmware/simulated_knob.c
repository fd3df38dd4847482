/* The simulated knob as a board has it: what stands behind encoder, motor and grip cell where there are none.

   It moves on by one sample interval from sample to sample, however late a sample is, so that a trial comes out the same
   on a busy machine; the target counts the overruns. */
#include "simulated_knob.h"

#include <math.h>

#include "board.h"
#include "plant.h"
#include "wall.h"

/* The dissertation's lightest grip on the small knob, pressed against the wall, until the host says another. */
static struct simulated person = {.inertia = 2.2e-6, .damping = 3.45e-4, .stiffness = 0.04, .angle_rad = 0.02,
                                  .push_nm = 0.001, .grip_n = 0.71, .grip_rise_s = 0.1};
static struct squeeze squeeze; /* nobody, until the host says somebody */
static struct plant plant;
static double torque;
static bool armed, first;

uint8_t board_simulate(const struct simulated *simulated)
{
    person = *simulated;
    squeeze.hand_count = 0u;
    return DONE;
}

uint8_t board_squeeze(const struct squeeze *squeezed)
{
    squeeze = *squeezed;
    return DONE;
}

bool board_armed(const struct settings *settings)
{
    armed = plant_begin(&plant, &person, settings->period_ns * 1e-9);
    if (armed && squeeze.hand_count > 0u) {
        armed = plant_squeezed(&plant, &squeeze);
    }
    return armed;
}

void board_started(void)
{
    plant_start(&plant);
    first = true;
}

void board_passed(double part, bool ends)
{
    if (armed && !first) {
        plant_advance(&plant, torque, part, ends);
    }
    first = false;
}

int32_t board_angle(void)
{
    if (!armed) {
        return 0;
    }
    double counts = floor(plant_angle(&plant) / TWO_PI * SIMULATED_NATIVE_COUNTS);
    /* Beyond what the encoder can count, and where the angle is not a number, it shows its end. */
    return counts > -2147483648.0 && counts < 2147483647.0 ? (int32_t)counts : counts < 0.0 ? INT32_MIN : INT32_MAX;
}

void board_torque(double torque_nm)
{
    torque = torque_nm;
}

double board_grip_n(void)
{
    return plant_grip(&plant);
}
