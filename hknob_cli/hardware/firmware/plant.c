/* The simulated knob: exact from sample to sample, with Coulomb friction, stick and slip.

   Within a hold the torques are constant. Sliding one way, z = (angle, speed) obeys z' = A z + c, so
   z(u) = z0 + D(u) z0' with D the integral of exp(A u); the speed is a damped sine or a difference of exponentials, whose
   first zero has a closed form. There friction holds the knob, for the rest of the hold, or it turns round. */
#include "plant.h"

#include <math.h>

#include "squeeze.h"
#include "wall.h"

/* Faster motion turns round so often in one hold that nothing of it can be seen in the samples. */
#define FASTEST_SPRING 1e4
#define FASTEST_DRAG 1e4

/* D(u) and by it exp(A u) = 1 + A D: a series where u is short, and doubling. */
static void integral(double d[2][2], double spring, double drag, double u)
{
    int doublings = 0;
    double size = u * (1.0 + spring + drag);
    while (size > 0.5) {
        size *= 0.5;
        u *= 0.5;
        doublings++;
    }
    /* Terms A^k u^(k+1) / (k+1)!, of which the first column is that of the second before, times minus spring. */
    double t00 = u, t01 = 0.0, t10 = 0.0, t11 = u;
    d[0][0] = u;
    d[0][1] = d[1][0] = 0.0;
    d[1][1] = u;
    for (int k = 2; k < 17; k++) {
        double f = u / k;
        double n00 = t10 * f, n01 = t11 * f;
        double n10 = -(spring * t00 + drag * t10) * f, n11 = -(spring * t01 + drag * t11) * f;
        t00 = n00;
        t01 = n01;
        t10 = n10;
        t11 = n11;
        d[0][0] += t00;
        d[0][1] += t01;
        d[1][0] += t10;
        d[1][1] += t11;
    }
    double e00 = 1.0 + d[1][0], e01 = d[1][1];
    double e10 = -(spring * d[0][0] + drag * d[1][0]), e11 = 1.0 - (spring * d[0][1] + drag * d[1][1]);
    for (; doublings > 0; doublings--) {
        double a00 = d[0][0] + e00 * d[0][0] + e01 * d[1][0], a01 = d[0][1] + e00 * d[0][1] + e01 * d[1][1];
        double a10 = d[1][0] + e10 * d[0][0] + e11 * d[1][0], a11 = d[1][1] + e10 * d[0][1] + e11 * d[1][1];
        double f00 = e00 * e00 + e01 * e10, f01 = e00 * e01 + e01 * e11;
        double f10 = e10 * e00 + e11 * e10, f11 = e10 * e01 + e11 * e11;
        d[0][0] = a00;
        d[0][1] = a01;
        d[1][0] = a10;
        d[1][1] = a11;
        e00 = f00;
        e01 = f01;
        e10 = f10;
        e11 = f11;
    }
}

/* The numbers of a knob and hand together. */
static bool take_hand(struct plant *p, double inertia, double damping, double stiffness)
{
    double interval_s = p->interval_s;
    p->per_torque = interval_s * interval_s / inertia;
    p->spring = stiffness * p->per_torque;
    p->drag = damping * interval_s / inertia;
    if (!(p->spring <= FASTEST_SPRING && p->drag <= FASTEST_DRAG)) {
        return false;
    }
    integral(p->step, p->spring, p->drag, 1.0);
    return true;
}

bool plant_begin(struct plant *p, const struct simulated *person, double interval_s)
{
    p->person = *person;
    p->interval_s = interval_s;
    p->angle = person->angle_rad;
    p->speed = 0.0;
    p->passed = 0u;
    p->held = false;
    p->squeeze.hand_count = 0u;
    p->rest = 0.0;
    return take_hand(p, person->inertia, person->damping, person->stiffness);
}

bool plant_squeezed(struct plant *p, const struct squeeze *squeeze)
{
    p->squeeze = *squeeze;
    p->rest = p->angle;
    p->angle = 0.0;
    p->fired_s = HUGE_VAL;
    /* Nobody pushes; and between two rows spring and drag are between those of the rows. */
    p->person.push_nm = 0.0;
    p->person.push_count = 0u;
    for (unsigned i = 0; i < squeeze->hand_count; i++) {
        const double *hand = squeeze->hands[i];
        if (!take_hand(p, hand[1], hand[2], hand[3])) {
            return false;
        }
    }
    return true;
}

double plant_angle(const struct plant *p)
{
    return p->rest + p->angle;
}

void plant_start(struct plant *p)
{
    p->held = true;
    p->passed = 0u;
}

static double sines(const struct plant *p, unsigned first, unsigned count)
{
    double t = p->passed * p->interval_s, sum = 0.0;
    for (unsigned i = first; i < first + count; i++) {
        const struct sine *one = &p->person.sines[i];
        sum += one->amplitude * sin(TWO_PI * one->frequency_hz * t + one->phase);
    }
    return sum;
}

double plant_push(const struct plant *p)
{
    double push = p->person.push_nm + sines(p, 0u, p->person.push_count);
    return push > 0.0 ? push : 0.0;
}

double plant_grip(const struct plant *p)
{
    if (!p->held) {
        return p->person.grip_offset_n;
    }
    double t = p->passed * p->interval_s;
    if (p->squeeze.hand_count > 0u) {
        return squeeze_force(&p->squeeze, t, p->fired_s) + p->person.grip_offset_n;
    }
    double risen = p->person.grip_rise_s > 0.0 ? -expm1(-t / p->person.grip_rise_s) : 1.0;
    return p->person.grip_n * risen + sines(p, p->person.push_count, p->person.grip_count) + p->person.grip_offset_n;
}

/* When the speed, `speed` > 0 now and changing at `rate`, first vanishes; infinite if it never does. */
static double time_to_rest(const struct plant *p, double speed, double rate)
{
    /* The speed goes as exp(-drag u / 2) (speed cos(w u) + fall / w sin(w u)), w^2 = -bend. */
    double fall = rate + 0.5 * p->drag * speed;
    double bend = 0.25 * p->drag * p->drag - p->spring;
    if (bend < 0.0) {
        double w = sqrt(-bend);
        return atan2(speed * w, -fall) / w;
    }
    if (fall >= 0.0) {
        return HUGE_VAL;
    }
    if (bend == 0.0) {
        return speed / -fall;
    }
    double w = sqrt(bend), ratio = speed * w / -fall;
    return ratio < 1.0 ? atanh(ratio) / w : HUGE_VAL;
}

static void slide(struct plant *p, double rate, double u)
{
    double d[2][2];
    const double(*by)[2] = (const double(*)[2])p->step;
    if (u != 1.0) {
        integral(d, p->spring, p->drag, u);
        by = (const double(*)[2])d;
    }
    double speed = p->speed;
    p->angle += by[0][0] * speed + by[0][1] * rate;
    p->speed += by[1][0] * speed + by[1][1] * rate;
}

void plant_advance(struct plant *p, double torque_nm, double part, bool ends)
{
    if (!p->held) {
        return;
    }
    if (p->squeeze.hand_count > 0u && p->fired_s == HUGE_VAL) {
        if (torque_nm == 0.0) {
            p->passed += ends ? 1u : 0u;
            return;
        }
        double hand[3], t = p->passed * p->interval_s;
        squeeze_hand(&p->squeeze, squeeze_force(&p->squeeze, t, HUGE_VAL), hand);
        p->fired_s = t;
        (void)take_hand(p, hand[0], hand[1], hand[2]);
    }
    double torque = (torque_nm - plant_push(p)) * p->per_torque;
    double friction = p->person.coulomb_nm * p->per_torque;
    double left = part;
    p->passed += ends ? 1u : 0u;
    /* Of a motion that begins at rest the speed next vanishes half a turn later: an end of events there is. */
    while (left > 0.0) {
        double pull = torque - p->spring * p->angle;
        int way = p->speed > 0.0 ? 1 : p->speed < 0.0 ? -1 : pull > friction ? 1 : pull < -friction ? -1 : 0;
        if (way == 0) {
            return;
        }
        double rate = pull - p->drag * p->speed - way * friction;
        double u = friction > 0.0 ? time_to_rest(p, fabs(p->speed), way * rate) : HUGE_VAL;
        if (!(u < left)) {
            slide(p, rate, left);
            return;
        }
        slide(p, rate, u);
        p->speed = 0.0;
        left -= u;
    }
}
