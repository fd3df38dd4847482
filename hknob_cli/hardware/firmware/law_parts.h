/* What the laws share: the arithmetic of Python's min and max, memory, and the laws of an estimated speed. */
#ifndef LAW_PARTS_H
#define LAW_PARTS_H

#include <stdbool.h>

/* Numbers of the laws of an estimated speed. */
enum { OFFSET, GAIN, EVERYWHERE, GOES, MOST, FILTERED, LAST, OWN, NEXT };

/* Of two that are equal, and of what is no number, the first: as min and max of Python. */
static inline double smaller(double a, double b)
{
    return b < a ? b : a;
}

static inline double larger(double a, double b)
{
    return b > a ? b : a;
}

static inline double depth_of(double count, double offset)
{
    return count < 0.0 ? -(count + offset) : 0.0;
}

/* The newest of `count` values in front, the oldest gone. */
static inline void push(double *past, int count, double newest)
{
    for (int j = count - 1; j > 0; j--) {
        past[j] = past[j - 1];
    }
    if (count > 0) {
        past[0] = newest;
    }
}

/* In law_speeds.c. */
double differenced_velocity(double shown, double *past, const double *fixed);
double timed_velocity(double shown, double *past, const double *fixed);
double adaptive_velocity(double shown, double *past, const double *fixed);
double tracked_velocity(double shown, double *past, const double *fixed);

#endif
