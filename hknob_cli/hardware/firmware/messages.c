/* Messages: numbers from bytes and bytes from numbers, least significant first whatever the machine. */
#include "messages.h"

#include <string.h>

struct reader {
    const uint8_t *body;
    size_t at;
};

static uint64_t get(struct reader *r, unsigned bytes)
{
    uint64_t value = 0u;
    for (unsigned i = 0; i < bytes; i++) {
        value |= (uint64_t)r->body[r->at++] << (8u * i);
    }
    return value;
}

static double get_f64(struct reader *r)
{
    uint64_t bits = get(r, 8u);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static size_t put(uint8_t *body, size_t at, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++) {
        body[at++] = (uint8_t)(value >> (8u * i));
    }
    return at;
}

static size_t put_f64(uint8_t *body, size_t at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return put(body, at, bits, 8u);
}

static size_t put_f32(uint8_t *body, size_t at, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return put(body, at, bits, 4u);
}

/* The nine numbers of the simulated knob, in their order on the wire. */
static double *simulated_number(struct simulated *s, unsigned i)
{
    double *numbers[] = {&s->inertia, &s->damping, &s->stiffness,   &s->coulomb_nm,   &s->angle_rad,
                         &s->push_nm, &s->grip_n,  &s->grip_rise_s, &s->grip_offset_n};
    return numbers[i];
}
enum { SIMULATED_NUMBERS = 9, SIMULATE_SHORTEST = 6 + 9 * 8 + 2 };

static bool read_simulated(struct simulated *s, struct reader *r, size_t count)
{
    if (count < SIMULATE_SHORTEST) {
        return false;
    }
    for (unsigned i = 0; i < SIMULATED_NUMBERS; i++) {
        *simulated_number(s, i) = get_f64(r);
    }
    s->push_count = (uint8_t)get(r, 1u);
    s->grip_count = (uint8_t)get(r, 1u);
    unsigned sines = (unsigned)s->push_count + s->grip_count;
    if (s->push_count > SINES_MOST || s->grip_count > SINES_MOST || count != SIMULATE_SHORTEST + 24u * sines) {
        return false;
    }
    for (unsigned i = 0; i < sines; i++) {
        s->sines[i].amplitude = get_f64(r);
        s->sines[i].frequency_hz = get_f64(r);
        s->sines[i].phase = get_f64(r);
    }
    return true;
}

static void read_settings(struct settings *s, struct reader *r)
{
    s->period_ns = (uint32_t)get(r, 4u);
    s->counts_per_rev = (uint32_t)get(r, 4u);
    s->wall_stiffness = get_f64(r);
    s->wall_damping = get_f64(r);
    s->torque_limit_nm = get_f64(r);
    s->speed_limit_rad_s = get_f64(r);
    s->watchdog_us = (uint32_t)get(r, 4u);
    s->block_samples = (uint16_t)get(r, 2u);
}

enum { CONTROL_SHORTEST = 6 + 4 };

/* Counts beyond what there is room for are no message: no law takes so many. */
static bool read_control(struct control *c, struct reader *r, size_t count)
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
    for (unsigned i = 0; i < c->number_count; i++) {
        c->numbers[i] = get_f64(r);
    }
    for (unsigned i = 0; i < c->row_count; i++) {
        c->rows[i] = get_f64(r);
    }
    return true;
}

bool command_read(struct command *command, const uint8_t *body, size_t count)
{
    struct reader r = {body, 2u};
    if (count < 6u || body[0] != WIRE_VERSION) {
        return false;
    }
    command->type = body[1];
    command->nonce = (uint32_t)get(&r, 4u);
    switch (command->type) {
    case HELLO:
    case ARM:
    case START:
    case STOP:
    case RELEASE:
        return count == 6u;
    case ALIVE:
    case AGAIN:
        if (count != (command->type == ALIVE ? 10u : 12u)) {
            return false;
        }
        command->first = (uint32_t)get(&r, 4u);
        command->count = command->type == AGAIN ? (uint16_t)get(&r, 2u) : 0u;
        return true;
    case CONFIGURE:
        if (count != 52u) {
            return false;
        }
        read_settings(&command->settings, &r);
        return true;
    case ZERO:
        if (count != 10u) {
            return false;
        }
        command->angle = (int32_t)(uint32_t)get(&r, 4u);
        return true;
    case SIMULATE:
        return read_simulated(&command->simulated, &r, count);
    case CONTROL:
        return read_control(&command->control, &r, count);
    default:
        return false;
    }
}

size_t answer_write(uint8_t *body, const struct answer *a)
{
    size_t at = put(body, 0u, WIRE_VERSION, 1u);
    at = put(body, at, ACK, 1u);
    at = put(body, at, a->nonce, 4u);
    at = put(body, at, a->of, 1u);
    at = put(body, at, a->status, 1u);
    at = put(body, at, a->state, 1u);
    at = put(body, at, a->fault, 1u);
    at = put(body, at, a->boot, 4u);
    return put(body, at, a->blocks, 4u);
}

size_t event_write(uint8_t *body, const struct event *e)
{
    size_t at = put(body, 0u, WIRE_VERSION, 1u);
    at = put(body, at, EVENT, 1u);
    at = put(body, at, e->boot, 4u);
    at = put(body, at, e->run, 4u);
    at = put(body, at, e->fault, 1u);
    at = put(body, at, e->index, 4u);
    at = put(body, at, e->time_us, 4u);
    return put(body, at, e->blocks, 4u);
}

size_t block_write(uint8_t *body, const struct block *b)
{
    size_t at = put(body, 0u, WIRE_VERSION, 1u);
    at = put(body, at, BLOCK, 1u);
    at = put(body, at, b->boot, 4u);
    at = put(body, at, b->run, 4u);
    at = put(body, at, b->block, 4u);
    at = put(body, at, b->first, 4u);
    at = put(body, at, b->overruns, 4u);
    return put(body, at, b->count, 1u);
}

size_t sample_write(uint8_t *body, size_t at, const struct sample *s)
{
    at = put(body, at, s->time_us, 4u);
    at = put(body, at, (uint32_t)s->angle, 4u);
    at = put_f32(body, at, s->torque_nm);
    at = put_f32(body, at, s->grip_n);
    return put(body, at, s->flags, 1u);
}

size_t identity_write(uint8_t *body, size_t at, const struct identity *i)
{
    at = put(body, at, i->native_counts, 4u);
    at = put(body, at, i->shortest_period_ns, 4u);
    at = put(body, at, i->flags | (unsigned)KNOWS_ZERO | (unsigned)KNOWS_CONTROL, 1u);
    memcpy(body + at, i->name, NAME_BYTES);
    return at + NAME_BYTES;
}

size_t zero_write(uint8_t *body, size_t at, int32_t angle)
{
    return put(body, at, (uint32_t)angle, 4u);
}

size_t settings_write(uint8_t *body, size_t at, const struct settings *s)
{
    at = put(body, at, s->period_ns, 4u);
    at = put(body, at, s->counts_per_rev, 4u);
    at = put_f64(body, at, s->wall_stiffness);
    at = put_f64(body, at, s->wall_damping);
    at = put_f64(body, at, s->torque_limit_nm);
    at = put_f64(body, at, s->speed_limit_rad_s);
    at = put(body, at, s->watchdog_us, 4u);
    return put(body, at, s->block_samples, 2u);
}

size_t simulated_write(uint8_t *body, size_t at, const struct simulated *s)
{
    struct simulated copy = *s;
    for (unsigned i = 0; i < SIMULATED_NUMBERS; i++) {
        at = put_f64(body, at, *simulated_number(&copy, i));
    }
    at = put(body, at, s->push_count, 1u);
    at = put(body, at, s->grip_count, 1u);
    for (unsigned i = 0; i < (unsigned)s->push_count + s->grip_count; i++) {
        at = put_f64(body, at, s->sines[i].amplitude);
        at = put_f64(body, at, s->sines[i].frequency_hz);
        at = put_f64(body, at, s->sines[i].phase);
    }
    return at;
}

size_t control_write(uint8_t *body, size_t at, const struct control *c)
{
    at = put(body, at, c->law, 1u);
    at = put(body, at, c->places, 1u);
    at = put(body, at, c->number_count, 1u);
    at = put(body, at, c->row_count, 1u);
    for (unsigned i = 0; i < c->number_count; i++) {
        at = put_f64(body, at, c->numbers[i]);
    }
    for (unsigned i = 0; i < c->row_count; i++) {
        at = put_f64(body, at, c->rows[i]);
    }
    return at;
}

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
