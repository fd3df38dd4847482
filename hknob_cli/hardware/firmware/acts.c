/* Bodies of what acts in a trial beside the plain wall. */
#include "acts.h"

void sines_read(struct sine *sines, size_t count, struct reader *r)
{
    for (size_t i = 0; i < count; i++) {
        sines[i].amplitude = get_f64(r);
        sines[i].frequency_hz = get_f64(r);
        sines[i].phase = get_f64(r);
    }
}

size_t sines_write(uint8_t *body, size_t at, const struct sine *sines, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        at = put_f64(body, at, sines[i].amplitude);
        at = put_f64(body, at, sines[i].frequency_hz);
        at = put_f64(body, at, sines[i].phase);
    }
    return at;
}

enum { CONTROL_SHORTEST = 6 + 4 };

/* Counts beyond what there is room for are no message: no law takes so many. */
bool control_read(struct control *c, struct reader *r, size_t count)
{
    if (count < CONTROL_SHORTEST) {
        return false;
    }
    c->law = (uint8_t)get(r, 1u);
    c->places = (uint8_t)get(r, 1u);
    c->number_count = (uint8_t)get(r, 1u);
    c->row_count = (uint8_t)get(r, 1u);
    if (c->number_count > LAW_NUMBERS_MOST || c->row_count > LAW_ROWS_MOST ||
        count != CONTROL_SHORTEST + 8u * ((unsigned)c->number_count + c->row_count)) {
        return false;
    }
    get_f64s(r, c->numbers, c->number_count);
    get_f64s(r, c->rows, c->row_count);
    return true;
}

enum { PULSE_BYTES = 6 + 4 * 8 + 2 * 4 };

bool pulse_read(struct pulse *p, struct reader *r, size_t count)
{
    if (count != PULSE_BYTES) {
        return false;
    }
    p->grip_n = get_f64(r);
    p->band_n = get_f64(r);
    p->release_n = get_f64(r);
    p->torque_nm = get_f64(r);
    p->width = (uint32_t)get(r, 4u);
    p->dwell = (uint32_t)get(r, 4u);
    return true;
}

/* The six numbers of a squeeze, in their order on the wire. */
double *squeeze_number(struct squeeze *s, unsigned i)
{
    double *numbers[] = {&s->aim_n, &s->rise_s, &s->overshoot, &s->reaction_s, &s->relax_s, &s->strength_n};
    return numbers[i];
}
enum { SQUEEZE_SHORTEST = 6 + 6 * 8 + 3 };

/* Counts beyond what there is room for are no message. */
bool squeeze_read(struct squeeze *s, struct reader *r, size_t count)
{
    if (count < SQUEEZE_SHORTEST) {
        return false;
    }
    for (unsigned i = 0; i < SQUEEZE_NUMBERS; i++) {
        *squeeze_number(s, i) = get_f64(r);
    }
    s->climbs = (uint8_t)get(r, 1u);
    s->hand_count = (uint8_t)get(r, 1u);
    s->sine_count = (uint8_t)get(r, 1u);
    if (s->hand_count > HANDS_MOST || s->sine_count > SINES_MOST ||
        count != SQUEEZE_SHORTEST + 32u * s->hand_count + 24u * s->sine_count) {
        return false;
    }
    for (unsigned i = 0; i < s->hand_count; i++) {
        get_f64s(r, s->hands[i], 4u);
    }
    sines_read(s->sines, s->sine_count, r);
    return true;
}

enum { OVER_ANGLE_BYTES = 6 + 3 * 4 + 2 * 8, TORQUES_SHORTEST = 6 + 5 };

bool over_angle_read(struct over_angle *o, struct reader *r, size_t count)
{
    if (count != OVER_ANGLE_BYTES) {
        return false;
    }
    o->first = (int32_t)(uint32_t)get(r, 4u);
    o->turn = (uint32_t)get(r, 4u);
    o->size = (uint32_t)get(r, 4u);
    o->below = get_f64(r);
    o->above = get_f64(r);
    return true;
}

bool torques_read(struct torques *t, struct reader *r, size_t count)
{
    if (count < TORQUES_SHORTEST) {
        return false;
    }
    t->at = (uint32_t)get(r, 4u);
    t->count = (uint8_t)get(r, 1u);
    if (t->count > TORQUES_MOST || count != TORQUES_SHORTEST + 8u * t->count) {
        return false;
    }
    get_f64s(r, t->values, t->count);
    return true;
}

enum { CONVERTERS_BYTES = 6 + 5 * 8 + 1 };

bool converters_read(struct converters *c, struct reader *r, size_t count)
{
    if (count != CONVERTERS_BYTES) {
        return false;
    }
    c->offset_counts = get_f64(r);
    c->dead_band_nm = get_f64(r);
    c->step_nm = get_f64(r);
    c->limit_nm = get_f64(r);
    c->delay_samples = get_f64(r);
    c->rounding = (uint8_t)get(r, 1u);
    return true;
}

size_t control_write(uint8_t *body, size_t at, const struct control *c)
{
    at = put(body, at, c->law, 1u);
    at = put(body, at, c->places, 1u);
    at = put(body, at, c->number_count, 1u);
    at = put(body, at, c->row_count, 1u);
    at = put_f64s(body, at, c->numbers, c->number_count);
    return put_f64s(body, at, c->rows, c->row_count);
}

size_t pulse_write(uint8_t *body, size_t at, const struct pulse *p)
{
    at = put_f64(body, at, p->grip_n);
    at = put_f64(body, at, p->band_n);
    at = put_f64(body, at, p->release_n);
    at = put_f64(body, at, p->torque_nm);
    at = put(body, at, p->width, 4u);
    return put(body, at, p->dwell, 4u);
}

size_t squeeze_write(uint8_t *body, size_t at, const struct squeeze *s)
{
    struct squeeze copy = *s;
    for (unsigned i = 0; i < SQUEEZE_NUMBERS; i++) {
        at = put_f64(body, at, *squeeze_number(&copy, i));
    }
    at = put(body, at, s->climbs, 1u);
    at = put(body, at, s->hand_count, 1u);
    at = put(body, at, s->sine_count, 1u);
    for (unsigned i = 0; i < s->hand_count; i++) {
        at = put_f64s(body, at, s->hands[i], 4u);
    }
    return sines_write(body, at, s->sines, s->sine_count);
}

size_t over_angle_write(uint8_t *body, size_t at, const struct over_angle *o)
{
    at = put(body, at, (uint32_t)o->first, 4u);
    at = put(body, at, o->turn, 4u);
    at = put(body, at, o->size, 4u);
    at = put_f64(body, at, o->below);
    return put_f64(body, at, o->above);
}

size_t torques_write(uint8_t *body, size_t at, const struct torques *piece, const double *values)
{
    at = put(body, at, piece->at, 4u);
    at = put(body, at, piece->count, 1u);
    return put_f64s(body, at, values, piece->count);
}

size_t converters_write(uint8_t *body, size_t at, const struct converters *c)
{
    at = put_f64(body, at, c->offset_counts);
    at = put_f64(body, at, c->dead_band_nm);
    at = put_f64(body, at, c->step_nm);
    at = put_f64(body, at, c->limit_nm);
    at = put_f64(body, at, c->delay_samples);
    return put(body, at, c->rounding, 1u);
}
