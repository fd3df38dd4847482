/* Controllers of the wall, in the order of operations of hknob_cli/engine/general/laws/, to the last bit.

   A law takes the reading `shown`, its memory `past`, then in it the last reading, and its numbers `fixed`, the first of
   which is the offset of the counts. Those of an estimated speed are in law_speeds.c. */
#include "law.h"

#include <math.h>

#include "law_parts.h"
#include "wall.h"

#define LONGEST 4096.0
#define MEAN_SAMPLES 64.0
#define UNSURE (1.0 / 6.0)
#define DRIFT 0.05
#define WINDOW_MOST 64 /* PARTS_MOST and LOOKS_MOST + 1, too */

enum { BOUNDED_LAG = 1, FIRST_ORDER_HOLD, PASSIVITY, PHASE_DAMPING, STIFFENING, VELOCITY_DAMPING, DIFFERENCED_VELOCITY,
       TIMED_VELOCITY, ADAPTIVE_VELOCITY, TRACKED_VELOCITY, IMPULSE_DAMPING, HALF_SAMPLE, MATCHED_WALL, LAWS };

static double bounded_lag(double shown, double *past, const double *fixed)
{
    double w = depth_of(shown, fixed[0]);
    past[0] = past[0] + fixed[1] * (w - past[0]);
    return w - (1.0 - fixed[2]) * smaller(larger(w - past[0], -1.0), 1.0);
}

static double first_order_hold(double shown, double *past, const double *fixed, double *parts)
{
    double now = depth_of(shown, fixed[0]), before = past[0];
    double mean = 1.5 * now - 0.5 * before, acted = 0.5 * (now + before);
    int count = (int)fixed[2] + 1;
    if (count > 1) {
        double total = 0.0, moment = 0.0;
        for (int k = 0; k <= count; k++) {
            double w = k == 0 ? before : k == count ? now : depth_of(past[2 + k], fixed[0]);
            total = total + w;
            moment = moment + (k - 0.5 * count) * w;
        }
        double slope = moment * (12.0 / ((count + 1) * (count + 2)));
        mean = 0.5 * (now + (total / (count + 1) + 1.5 * slope));
        acted = (total - 0.5 * (before + now)) / count;
    }
    double missed = fixed[1] > 0.0 ? acted - past[1] : 0.0;
    past[0] = now;
    past[1] = mean;
    int steps = (int)fixed[3];
    double rise = 2.0 * (mean - now);
    for (int k = 0; k < steps; k++) {
        parts[k] = now + (k + 0.5) / steps * rise + missed;
    }
    return steps > 1 ? parts[0] : mean + missed;
}

static double impulse_damping(double shown, double *past, const double *fixed, double *parts)
{
    double now = depth_of(shown, fixed[0]), before = past[0], missed = 0.5 * (now - before);
    int looks = (int)fixed[3];
    if (looks > 0) {
        int count = looks + 1;
        double between = 0.0;
        for (int i = 0; i < looks; i++) {
            between += depth_of(past[2 + i], fixed[0]);
        }
        missed = (0.5 * now - (count - 0.5) * before + between) / count;
    }
    past[0] = now;
    parts[1] = now;
    return now + fixed[2] * missed / fixed[1];
}

/* The wall for the middle of the interval, by a model of knob and hand; without a sensor of the speed. */
static double half_sample(double shown, double *past, const double *fixed)
{
    double at = shown + fixed[0], pace = at - past[0];
    double middle = (fixed[2] * at + fixed[1] * pace) * fixed[3];
    past[0] = at;
    return larger(-middle, 0.0);
}

/* Without a sensor of the speed. */
static double matched_wall(double shown, double *past, const double *fixed)
{
    double at = shown + fixed[0], pace = at - past[0];
    past[0] = at;
    return shown < 0.0 ? -(fixed[1] * at + fixed[2] * pace) : 0.0;
}

static double passivity(double shown, double *past, const double *fixed)
{
    double now = depth_of(shown, fixed[0]), at = shown + fixed[0];
    double travel = at - past[0];
    double energy = past[2] - past[1] * travel;
    double torque = now;
    if (energy < 0.0 && travel != 0.0) {
        torque = now - smaller(-energy / (travel * travel), fixed[1]) * travel;
    }
    past[3] = 0.0;
    if (fixed[2] > 0.0 && now == 0.0 && travel == 0.0) {
        energy = 0.0;
        past[3] = 1.0;
    }
    past[0] = at;
    past[1] = torque;
    past[2] = energy;
    return torque;
}

/* A time between crossings, taken into its estimate. */
static void take_time(double *past, int row, int variance, double time, double kalman)
{
    if (!(time < LONGEST)) {
        return;
    }
    if (kalman == 0.0) {
        past[row] = time;
        return;
    }
    double spread = past[variance] + DRIFT;
    double gain = spread / (spread + UNSURE);
    past[row] = past[row] + gain * (time - past[row]);
    past[variance] = (1.0 - gain) * spread;
}

static double phase_damping(double shown, double *past, const double *fixed)
{
    double now = depth_of(shown, fixed[0]), before = past[0], last_mean = past[1];
    double mean = last_mean + (now - last_mean) / MEAN_SAMPLES;
    double since = smaller(past[2] + 1.0, LONGEST), way = 1.0, turn = 0.0;
    bool entered = now > mean && before <= last_mean, left = now <= mean && before > last_mean, known;
    if (fixed[3] > 0.0) {
        if (entered) {
            take_time(past, 4, 6, since, fixed[4]);
            past[7] = 1.0;
        }
        if (left) {
            take_time(past, 3, 5, since, fixed[4]);
            past[7] = -1.0;
        }
        since = entered || left ? 0.0 : since;
        way = past[7];
        double half = way > 0.0 ? past[3] : past[4];
        known = half > 0.0 && way != 0.0;
        turn = known ? 0.5 * (since + 0.5) / half : 0.0;
    } else {
        if (entered) {
            take_time(past, 3, 5, since, fixed[4]);
            past[7] = 1.0;
            since = 0.0;
        }
        known = past[3] > 0.0 && past[7] != 0.0;
        turn = known ? (since + 0.5) / past[3] : 0.0;
    }
    past[0] = now;
    past[1] = mean;
    past[2] = since;
    return known && turn <= fixed[2] ? now + fixed[1] * way * cos(TWO_PI * turn) : now;
}

static double stiffening(double shown, const double *fixed)
{
    double now = depth_of(shown, fixed[0]);
    return now * (fixed[2] + (1.0 - fixed[2]) * smaller(now * fixed[1], 1.0));
}

static double velocity_damping(double shown, double *past, const double *fixed)
{
    int window = (int)fixed[4];
    double at = shown + fixed[0], pace = (at - past[window - 1]) / window;
    push(past, window, at);
    if (fixed[5] > 0.0) {
        pace = past[window] + fixed[5] * (pace - past[window]);
        past[window] = pace;
    }
    if (fabs(pace) > fixed[6]) {
        return 0.0;
    }
    double wall = depth_of(shown, fixed[0]);
    return fixed[3] > 0.0 || shown < 0.0 ? wall + fixed[1] * pace : wall;
}

double law_act(const struct control *c, double *past, double count, double *parts)
{
    const double *fixed = c->numbers;
    double found = 0.0;
    switch (c->law) {
    case BOUNDED_LAG:
        found = bounded_lag(count, past, fixed);
        break;
    case FIRST_ORDER_HOLD:
        found = first_order_hold(count, past, fixed, parts);
        break;
    case PASSIVITY:
        found = passivity(count, past, fixed);
        break;
    case PHASE_DAMPING:
        found = phase_damping(count, past, fixed);
        break;
    case STIFFENING:
        found = stiffening(count, fixed);
        break;
    case VELOCITY_DAMPING:
        found = velocity_damping(count, past, fixed);
        break;
    case DIFFERENCED_VELOCITY:
        found = differenced_velocity(count, past, fixed);
        break;
    case TIMED_VELOCITY:
        found = timed_velocity(count, past, fixed);
        break;
    case ADAPTIVE_VELOCITY:
        found = adaptive_velocity(count, past, fixed);
        break;
    case TRACKED_VELOCITY:
        found = tracked_velocity(count, past, fixed);
        break;
    case HALF_SAMPLE:
        found = half_sample(count, past, fixed);
        break;
    case MATCHED_WALL:
        found = matched_wall(count, past, fixed);
        break;
    default:
        found = impulse_damping(count, past, fixed, parts);
        break;
    }
    past[c->row_count] = count;
    parts[0] = found;
    return found;
}

uint32_t law_parts(const struct control *c, double *begins)
{
    uint32_t count = c->law == FIRST_ORDER_HOLD ? (uint32_t)c->numbers[3] : 1u;
    for (uint32_t k = 0; k < count; k++) {
        begins[k] = (double)k / (double)count;
    }
    if (c->law == IMPULSE_DAMPING && c->numbers[1] < 1.0) {
        begins[count++] = c->numbers[1];
    }
    return count;
}

uint32_t law_looks(const struct control *c)
{
    switch (c->law) {
    case FIRST_ORDER_HOLD:
        return (uint32_t)c->numbers[2];
    case IMPULSE_DAMPING:
        return (uint32_t)c->numbers[3];
    case TIMED_VELOCITY:
        return (uint32_t)c->numbers[OWN] - 1u;
    default:
        return 0u;
    }
}

uint32_t law_known(void)
{
    return (1u << LAWS) - 2u;
}

void law_begin(const struct control *c, double *past, double count)
{
    for (unsigned i = 0; i < c->row_count; i++) {
        past[i] = i < c->places ? count + c->numbers[0] : c->rows[i];
    }
    for (unsigned i = 0; i <= law_looks(c); i++) {
        past[c->row_count + i] = count;
    }
}

/* A number of samples: whole, and within the memory; 0 if it is not. */
static unsigned window_of(double samples)
{
    return samples >= 1.0 && samples <= WINDOW_MOST && samples == floor(samples) ? (unsigned)samples : 0u;
}

/* Rows and places that a law takes with these numbers; false where they are none of its own. */
static bool shape_of(const struct control *c, unsigned *rows, unsigned *places)
{
    static const uint8_t numbers[LAWS] = {0u, 3u, 4u, 3u, 5u, 3u, 7u, 8u, 9u, 8u, 9u, 4u, 5u, 4u};
    static const uint8_t usual_rows[LAWS] = {0u, 1u, 2u, 4u, 8u, 0u, 0u, 0u, 2u, 0u, 2u, 1u, 1u, 1u};
    const double *fixed = c->numbers;
    if (c->law == 0u || c->law >= LAWS || c->number_count != numbers[c->law]) {
        return false;
    }
    bool estimates = c->law >= DIFFERENCED_VELOCITY && c->law <= TRACKED_VELOCITY;
    bool filters = estimates && c->law != TRACKED_VELOCITY && fixed[GOES] != 0.0;
    unsigned window = 1u;
    *rows = usual_rows[c->law];
    *places = c->law == PASSIVITY || c->law == HALF_SAMPLE || c->law == MATCHED_WALL ? 1u : 0u;
    if (c->law == VELOCITY_DAMPING) {
        window = window_of(fixed[4]);
        *rows = window + (fixed[5] > 0.0 ? 1u : 0u);
        *places = window;
    } else if (c->law == DIFFERENCED_VELOCITY || c->law == ADAPTIVE_VELOCITY) {
        window = window_of(fixed[OWN]);
        *rows = window - 1u;
    }
    *rows += filters ? (fixed[FILTERED] > 0.0 ? 2u : 1u) : 0u;
    if (window == 0u || (estimates && fixed[LAST] != (double)*rows)) {
        return false;
    }
    /* Of readings there is room for LOOKS_MOST beside the sample's; and there is no sensor of the speed. */
    bool takes = (c->law != TIMED_VELOCITY || window_of(fixed[OWN]) > 0u) && (c->law != VELOCITY_DAMPING || fixed[2] == 0.0);
    takes = takes && (c->law != FIRST_ORDER_HOLD || (window_of(fixed[2] + 1.0) > 0u && window_of(fixed[3]) > 0u));
    takes = takes && (c->law != HALF_SAMPLE || fixed[4] == 0.0) && (c->law != MATCHED_WALL || fixed[3] == 0.0);
    return takes && (c->law != IMPULSE_DAMPING || (fixed[1] > 0.0 && fixed[1] <= 1.0 && window_of(fixed[3] + 1.0) > 0u));
}

bool control_in_range(const struct control *c)
{
    unsigned rows = 0u, places = 0u;
    if (c->number_count > LAW_NUMBERS_MOST || c->row_count > LAW_ROWS_MOST) {
        return false;
    }
    for (unsigned i = 0; i < c->number_count; i++) {
        if (c->numbers[i] - c->numbers[i] != 0.0) {
            return false;
        }
    }
    for (unsigned i = 0; i < c->row_count; i++) {
        if (c->rows[i] - c->rows[i] != 0.0) {
            return false;
        }
    }
    return shape_of(c, &rows, &places) && c->row_count == rows && c->places == places;
}
