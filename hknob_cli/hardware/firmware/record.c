/* The record: samples of a run in a ring, cut into blocks, kept until the host has them. */
#include "record.h"

typedef char samples_are_a_power_of_two[(RECORD_SAMPLES & (RECORD_SAMPLES - 1u)) == 0u ? 1 : -1];

uint32_t record_room(uint32_t looks)
{
    uint32_t room = RECORD_SAMPLES;
    while (room * looks > RECORD_LOOKS) {
        room /= 2u;
    }
    return room;
}

void record_begin(struct record *record, uint32_t block_samples, uint32_t looks)
{
    record->block_samples = block_samples;
    record->looks = looks;
    record->room = record_room(looks);
    record->taken = record->made = record->oldest = 0u;
}

bool record_has_room(const struct record *record)
{
    uint32_t begun = record->taken / record->block_samples;
    return (begun + 1u - record->oldest) * record->block_samples <= record->room;
}

void record_add(struct record *record, const struct sample *sample, const int32_t *looks, uint32_t overruns)
{
    uint32_t place = record->taken % record->room;
    for (uint32_t i = 0; i < record->looks; i++) {
        record->angles[place * record->looks + i] = looks[i];
    }
    record->samples[place] = *sample;
    record->overruns[place] = overruns;
    record->taken++;
    record->made = record->taken / record->block_samples;
}

void record_close(struct record *record)
{
    if (record->made * record->block_samples < record->taken) {
        record->made++;
    }
}

void record_forget(struct record *record, uint32_t expected)
{
    /* A number that was never made cannot be expected; the difference is right across a wrap. */
    if (expected - record->oldest <= record->made - record->oldest) {
        record->oldest = expected;
    }
}

size_t record_block(const struct record *record, uint32_t taken, uint8_t *body, uint32_t block, uint32_t boot, uint32_t run)
{
    uint32_t first = block * record->block_samples;
    uint32_t left = taken - first;
    uint32_t count = left < record->block_samples ? left : record->block_samples;
    struct block head = {boot, run, block, first, record->overruns[(first + count - 1u) % record->room], (uint8_t)count,
                         (uint8_t)record->looks};
    size_t at = block_write(body, &head);
    for (uint32_t i = first; i < first + count; i++) {
        uint32_t place = i % record->room;
        at = sample_write(body, at, &record->samples[place]);
        at = looks_write(body, at, record->angles + place * record->looks, record->looks);
    }
    return at;
}
