/* Messages: the bodies of frames, read and written field by field. What acts in a trial beside the wall: acts.c. */
#include "messages.h"

#include <string.h>

#include "acts.h"
#include "bytes.h"

/* The nine numbers of the simulated knob, in their order on the wire. */
double *simulated_number(struct simulated *s, unsigned i)
{
    double *numbers[] = {&s->inertia, &s->damping, &s->stiffness,   &s->coulomb_nm,   &s->angle_rad,
                         &s->push_nm, &s->grip_n,  &s->grip_rise_s, &s->grip_offset_n};
    return numbers[i];
}
enum { SIMULATE_SHORTEST = 6 + 9 * 8 + 2 };

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
    sines_read(s->sines, sines, r);
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
    case ABILITIES:
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
        return control_read(&command->control, &r, count);
    case PULSE:
        return pulse_read(&command->pulse, &r, count);
    case SQUEEZE:
        return squeeze_read(&command->squeeze, &r, count);
    case OVER_ANGLE:
        return over_angle_read(&command->over_angle, &r, count);
    case TORQUES:
        return torques_read(&command->torques, &r, count);
    case CONVERTERS:
        return converters_read(&command->converters, &r, count);
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
    at = put(body, at, b->looks > 0u ? READINGS : BLOCK, 1u);
    at = put(body, at, b->boot, 4u);
    at = put(body, at, b->run, 4u);
    at = put(body, at, b->block, 4u);
    at = put(body, at, b->first, 4u);
    at = put(body, at, b->overruns, 4u);
    at = put(body, at, b->count, 1u);
    return b->looks > 0u ? put(body, at, b->looks, 1u) : at;
}

size_t sample_write(uint8_t *body, size_t at, const struct sample *s)
{
    at = put(body, at, s->time_us, 4u);
    at = put(body, at, (uint32_t)s->angle, 4u);
    at = put_f32(body, at, s->torque_nm);
    at = put_f32(body, at, s->grip_n);
    return put(body, at, s->flags, 1u);
}

size_t looks_write(uint8_t *body, size_t at, const int32_t *looks, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        at = put(body, at, (uint32_t)looks[i], 4u);
    }
    return at;
}

size_t identity_write(uint8_t *body, size_t at, const struct identity *i)
{
    unsigned pulses = (i->flags & NO_GRIP_CELL) == 0u ? KNOWS_PULSES : 0u;
    unsigned knows = (unsigned)KNOWS_ZERO | (unsigned)KNOWS_CONTROL | (unsigned)KNOWS_OVER_ANGLE |
                     (unsigned)KNOWS_ABILITIES | pulses;
    at = put(body, at, i->native_counts, 4u);
    at = put(body, at, i->shortest_period_ns, 4u);
    at = put(body, at, i->flags | knows, 1u);
    memcpy(body + at, i->name, NAME_BYTES);
    return at + NAME_BYTES;
}

size_t abilities_write(uint8_t *body, size_t at, uint32_t laws)
{
    at = put(body, at, laws, 4u);
    return put(body, at, (unsigned)KNOWS_CONVERTERS | (unsigned)KNOWS_PARTS | (unsigned)KNOWS_LOOKS, 4u);
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
    return sines_write(body, at, s->sines, (size_t)s->push_count + s->grip_count);
}
