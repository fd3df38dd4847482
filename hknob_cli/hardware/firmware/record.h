/* The record: samples of a run in a ring, cut into blocks, kept until the host has them. */
#ifndef RECORD_H
#define RECORD_H

#include "messages.h"

/* 24 bytes each. A power of two, and at least 100 ms of the fastest sample clock. */
#ifndef RECORD_SAMPLES
#define RECORD_SAMPLES 4096u
#endif

/* Room for what is read within intervals, 4 bytes each: a board with less memory defines less. With so many readings that
   RECORD_SAMPLES samples have no room for theirs, there is room for fewer samples. */
#ifndef RECORD_LOOKS
#define RECORD_LOOKS 65536u
#endif

/* The sample clock adds samples and closes blocks; the main loop reads closed blocks and forgets them. */
struct record {
    struct sample samples[RECORD_SAMPLES];
    uint32_t overruns[RECORD_SAMPLES]; /* so far, at each sample */
    int32_t angles[RECORD_LOOKS];      /* read since the sample before, `looks` for each sample */
    uint32_t block_samples;
    uint32_t looks, room; /* room: samples that are kept, a power of two */
    uint32_t taken;  /* samples so far */
    uint32_t made;   /* blocks so far; all are of block_samples but the last, once the record is closed */
    uint32_t oldest; /* first block still kept */
};

/* How many samples are kept where so many readings are with each: a power of two. */
uint32_t record_room(uint32_t looks);

/* `looks`: readings within each interval. */
void record_begin(struct record *record, uint32_t block_samples, uint32_t looks);

/* Whether another sample would still leave room for the rest of its block. */
bool record_has_room(const struct record *record);
void record_add(struct record *record, const struct sample *sample, const int32_t *looks, uint32_t overruns);

/* No more samples: what is there becomes the last, short block. */
void record_close(struct record *record);

/* The host has all blocks before this one. */
void record_forget(struct record *record, uint32_t expected);

/* Body of a block that is made and kept; its length. `taken` so far, read while the sample clock did not run. */
size_t record_block(const struct record *record, uint32_t taken, uint8_t *body, uint32_t block, uint32_t boot, uint32_t run);

#endif
