/* A simulated person who squeezes until the knob pulses, and lets go. */
#include "squeeze.h"

#include <math.h>

#include "wall.h"

double squeeze_force(const struct squeeze *s, double time_s, double fired_s)
{
    double lets_go_s = fired_s + s->reaction_s;
    double t = fmax(fmin(time_s, lets_go_s) - s->reaction_s, 0.0);
    double force;
    if (s->climbs != 0u) {
        force = s->aim_n * t / s->rise_s;
    } else {
        /* The first maximum is at rise_s, that much above the aim. */
        double decay = -log(s->overshoot) / s->rise_s;
        double turn = 0.5 * TWO_PI * t / s->rise_s;
        double swing = cos(turn) + decay * s->rise_s / (0.5 * TWO_PI) * sin(turn);
        force = s->aim_n * (1.0 - exp(-decay * t) * swing);
    }
    double wander = 0.0;
    for (unsigned i = 0; i < s->sine_count; i++) {
        const struct sine *one = &s->sines[i];
        wander += one->amplitude * sin(TWO_PI * one->frequency_hz * t + one->phase);
    }
    force = fmin(force * (1.0 + wander), s->strength_n);
    return force * exp(-fmax(time_s - lets_go_s, 0.0) / s->relax_s);
}

void squeeze_hand(const struct squeeze *s, double grip_n, double hand[3])
{
    unsigned above = 0u;
    while (above < s->hand_count && !(grip_n < s->hands[above][0])) {
        above++;
    }
    for (unsigned k = 0; k < 3u; k++) {
        if (above == 0u) {
            hand[k] = s->hands[0][k + 1u];
        } else if (above == s->hand_count) {
            hand[k] = s->hands[above - 1u][k + 1u];
        } else {
            const double *low = s->hands[above - 1u], *high = s->hands[above];
            double slope = (high[k + 1u] - low[k + 1u]) / (high[0] - low[0]);
            hand[k] = slope * (grip_n - low[0]) + low[k + 1u];
        }
    }
}
