/* Laws of a spring and a damper whose speed is estimated, as hknob_cli/controllers/estimated_velocity.py; see law.c. */
#include <math.h>

#include "law_parts.h"

static double spring_and_damper(double shown, double pace, double behind, const double *fixed)
{
    double deep = depth_of(shown, fixed[OFFSET]);
    bool inside = shown < 0.0;
    if (fixed[FILTERED] > 0.0) {
        double at = shown + fixed[OFFSET] + behind;
        deep = larger(-at, 0.0);
        inside = at < 0.0;
    }
    if (fixed[EVERYWHERE] > 0.0 || inside) {
        deep = deep + fixed[GAIN] * pace;
    }
    return fabs(pace) > fixed[MOST] ? 0.0 : deep;
}

/* The pace, and the angle if the spring acts on it, through the low-pass, whose memory begins at `own`. */
static double filter_and_act(double shown, double pace, double moved, double *own, const double *fixed)
{
    if (fixed[GOES] == 0.0) {
        return spring_and_damper(shown, pace, 0.0, fixed);
    }
    pace = own[0] + fixed[GOES] * (pace - own[0]);
    own[0] = pace;
    double behind = 0.0;
    if (fixed[FILTERED] > 0.0) {
        behind = (1.0 - fixed[GOES]) * (own[1] - moved);
        own[1] = behind;
    }
    return spring_and_damper(shown, pace, behind, fixed);
}

double differenced_velocity(double shown, double *past, const double *fixed)
{
    double moved = shown - past[(int)fixed[LAST]], total = moved;
    int window = (int)fixed[OWN];
    for (int j = window - 2; j >= 0; j--) {
        total += past[j];
    }
    push(past, window - 1, moved);
    return filter_and_act(shown, total / window, moved, past + window - 1, fixed);
}

double timed_velocity(double shown, double *past, const double *fixed)
{
    int last = (int)fixed[LAST], ticks = (int)fixed[OWN];
    double before = past[last], time = past[0], moved = shown - before, changed = 0.0;
    for (int i = 0; i < ticks; i++) {
        double now = i < ticks - 1 ? past[last + 1 + i] : shown;
        time = smaller(time + 1.0, fixed[NEXT]);
        if (now != before) {
            changed += time;
            time = 0.0;
        }
        before = now;
    }
    if (changed > 0.0) {
        past[1] = moved * ticks / smaller(changed, fixed[NEXT]);
    }
    past[0] = time;
    if (time > 0.0) { /* a count more would have been seen */
        past[1] = smaller(larger(past[1], -ticks / time), ticks / time);
    }
    if (time >= fixed[NEXT]) {
        past[1] = 0.0;
    }
    return filter_and_act(shown, past[1], moved, past + 2, fixed);
}

double adaptive_velocity(double shown, double *past, const double *fixed)
{
    double moved = shown - past[(int)fixed[LAST]], total = moved, pace = moved;
    int longest = (int)fixed[OWN];
    /* Slopes that pass within a count of the readings so far: bounds as fractions of whole numbers, which are exact. */
    double low = -1.0, low_over = 0.0, high = 1.0, high_over = 0.0;
    for (int n = 2; n <= longest; n++) {
        if ((total - 1.0) * low_over > low * (n - 1)) {
            low = total - 1.0;
            low_over = n - 1.0;
        }
        if ((total + 1.0) * high_over < high * (n - 1)) {
            high = total + 1.0;
            high_over = n - 1.0;
        }
        total += past[n - 2];
        if (total * low_over < low * n || total * high_over > high * n) {
            break;
        }
        pace = total / n;
    }
    push(past, longest - 1, moved);
    return filter_and_act(shown, pace, moved, past + longest - 1, fixed);
}

double tracked_velocity(double shown, double *past, const double *fixed)
{
    double ahead = past[0] + past[1] - (shown - past[(int)fixed[LAST]]);
    past[0] = (1.0 - fixed[OWN]) * ahead;
    past[1] = past[1] - fixed[NEXT] * ahead;
    return spring_and_damper(shown, past[1], past[0], fixed);
}
