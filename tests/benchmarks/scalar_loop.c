/* The rival of throughput.py: the sampled loop as a plain scalar C loop, one trial after the other.
 *
 * Written for the cells at hand (floor encoder without offset, no delay, underdamped plant), so it does less than the
 * engine's kernel, whose encoder is general. Arithmetic and its order are the engine's; where nothing is fused, so are
 * the results to the last bit.
 */
#include <math.h>

struct loop {
    double alpha, beta, kappa, gamma; /* as in hknob_cli/engine/loop.py */
    double s, g, f;                   /* the plant over one sample */
};

static inline double drive_at(double x, const struct loop *p)
{
    double level = floor(x);
    return level < 0.0 ? -p->kappa * level - p->gamma : -p->gamma;
}

static inline double step(double *x, double *v, const struct loop *p)
{
    double y = drive_at(*x, p) - p->beta * *x;
    double x1 = *x + (p->s * *v + p->g * y);
    *v = p->f * *v + p->s * y;
    *x = x1;
    return y;
}

/* Recursion only. Not inlined, so that no compiler lays trials side by side. */
static __attribute__((noinline)) void recur(double *px, double *pv, long steps, const struct loop *given)
{
    const struct loop p = *given;
    double x = *px, v = *pv;
    for (long i = 0; i < steps; i++)
        step(&x, &v, &p);
    *px = x;
    *pv = v;
}

/* Recursion for `skip` samples, then for `window` with every extremum between samples in closed form: where the
 * velocity changes sign it is zero at t, tan(w t) = -v / rate with w t < pi / 2 here, and the acceleration there is
 * the amplitude of (v, rate) times w, decayed over t. */
static __attribute__((noinline)) void settle(double *px, double *pv, long skip, long window, const struct loop *given,
                                             double *highest, double *lowest)
{
    const struct loop p = *given;
    const double a = 0.5 * p.alpha, w = sqrt(p.beta - a * a), fade = a / w;
    double high = -INFINITY, low = INFINITY;
    recur(px, pv, skip, given);
    double x = *px, v = *pv;
    for (long i = 0; i < window; i++) {
        double x0 = x, v0 = v;
        double y = step(&x, &v, &p);
        if ((v0 > 0.0) == (v > 0.0))
            continue;
        double rate = (y - a * v0) / w;
        double size = exp(-fade * atan(-v0 / rate)) * sqrt(v0 * v0 + rate * rate) * w;
        if (v0 > 0.0) {
            double top = x0 + (y + size) / p.beta;
            if (top > high)
                high = top;
        } else {
            double bottom = x0 + (y - size) / p.beta;
            if (bottom < low)
                low = bottom;
        }
    }
    *px = x;
    *pv = v;
    *highest = high;
    *lowest = low;
}

void advance(double *x, double *v, long trials, long steps, const struct loop *p)
{
    for (long j = 0; j < trials; j++)
        recur(x + j, v + j, steps, p);
}

void measure(double *x, double *v, long trials, long skip, long window, const struct loop *p, double *highest,
             double *lowest)
{
    for (long j = 0; j < trials; j++)
        settle(x + j, v + j, skip, window, p, highest + j, lowest + j);
}
