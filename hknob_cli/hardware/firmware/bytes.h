/* Numbers from bytes and bytes from numbers, least significant first whatever the machine. */
#ifndef BYTES_H
#define BYTES_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

struct reader {
    const uint8_t *body;
    size_t at;
};

static inline uint64_t get(struct reader *r, unsigned bytes)
{
    uint64_t value = 0u;
    for (unsigned i = 0; i < bytes; i++) {
        value |= (uint64_t)r->body[r->at++] << (8u * i);
    }
    return value;
}

static inline double get_f64(struct reader *r)
{
    uint64_t bits = get(r, 8u);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline void get_f64s(struct reader *r, double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        values[i] = get_f64(r);
    }
}

static inline size_t put(uint8_t *body, size_t at, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++) {
        body[at++] = (uint8_t)(value >> (8u * i));
    }
    return at;
}

static inline size_t put_f64(uint8_t *body, size_t at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return put(body, at, bits, 8u);
}

static inline size_t put_f64s(uint8_t *body, size_t at, const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        at = put_f64(body, at, values[i]);
    }
    return at;
}

static inline size_t put_f32(uint8_t *body, size_t at, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return put(body, at, bits, 4u);
}

#endif
