/* What a target takes: the ranges of docs/reference/wire.md. */
#include "messages.h"

/* Comparisons that a NaN fails. */
static bool within(double value, double most)
{
    return value >= 0.0 && value <= most;
}

static bool positive(double value, double most)
{
    return value > 0.0 && value <= most;
}

bool settings_in_range(const struct settings *s, const struct identity *i)
{
    return s->period_ns >= i->shortest_period_ns && s->period_ns <= 1000000000u && s->counts_per_rev >= 1u &&
           s->counts_per_rev <= i->native_counts && within(s->wall_stiffness, 1e3) && within(s->wall_damping, 1e3) &&
           positive(s->torque_limit_nm, 10.0) && positive(s->speed_limit_rad_s, 1e4) && s->watchdog_us >= 1000u &&
           s->watchdog_us <= 50000u && s->block_samples >= 1u && s->block_samples <= BLOCK_SAMPLES_MOST;
}

bool simulated_in_range(const struct simulated *s)
{
    struct simulated copy = *s;
    for (unsigned i = 0; i < SIMULATED_NUMBERS; i++) {
        double value = *simulated_number(&copy, i);
        if (!within(value < 0.0 ? -value : value, 1e6)) {
            return false;
        }
    }
    for (unsigned i = 0; i < (unsigned)s->push_count + s->grip_count; i++) {
        const struct sine *one = &s->sines[i];
        if (!(one->amplitude * one->amplitude <= 1e12 && one->frequency_hz * one->frequency_hz <= 1e12 &&
              one->phase * one->phase <= 1e12)) {
            return false;
        }
    }
    return s->inertia > 0.0 && s->damping >= 0.0 && s->stiffness >= 0.0 && s->coulomb_nm >= 0.0 && s->grip_rise_s >= 0.0;
}

/* Longest pulse: half a second, to the nearest sample. What a hand cannot do, no pulse waits for. */
#define PULSE_LONGEST_NS 500000000u
#define FIRMEST_N 1000.0

bool pulse_in_range(const struct pulse *p, const struct settings *s)
{
    return positive(p->grip_n, FIRMEST_N) && within(p->band_n, p->grip_n) && positive(p->release_n, p->grip_n) &&
           p->release_n < p->grip_n && positive(p->torque_nm, s->torque_limit_nm) && p->width >= 1u &&
           (uint64_t)(p->width - 1u) * s->period_ns < PULSE_LONGEST_NS && p->dwell <= INT32_MAX;
}

bool squeeze_in_range(const struct squeeze *s)
{
    struct squeeze copy = *s;
    for (unsigned i = 0; i < SQUEEZE_NUMBERS; i++) {
        if (!positive(*squeeze_number(&copy, i), 1e6)) {
            return false;
        }
    }
    for (unsigned i = 0; i < s->hand_count; i++) {
        const double *hand = s->hands[i];
        bool ok = within(hand[0], 1e6) && positive(hand[1], 1e6) && within(hand[2], 1e6) && within(hand[3], 1e6);
        if (!ok || (i > 0u && !(hand[0] > s->hands[i - 1u][0]))) {
            return false;
        }
    }
    for (unsigned i = 0; i < s->sine_count; i++) {
        const struct sine *one = &s->sines[i];
        if (!(one->amplitude * one->amplitude <= 1e12 && one->frequency_hz * one->frequency_hz <= 1e12 &&
              one->phase * one->phase <= 1e12)) {
            return false;
        }
    }
    return s->hand_count >= 1u && s->overshoot < 1.0 && s->climbs <= 1u;
}
