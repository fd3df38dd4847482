/* The record: samples of a run in a ring, cut into blocks, kept until the host has them. */
#ifndef RECORD_H
#define RECORD_H

#include "messages.h"

/* 24 bytes each. A power of two, and at least 100 ms of the fastest sample clock. */
#ifndef RECORD_SAMPLES
#define RECORD_SAMPLES 4096u
#endif

/* The sample clock adds samples and closes blocks; the main loop reads closed blocks and forgets them. */
struct record {
    struct sample samples[RECORD_SAMPLES];
    uint32_t overruns[RECORD_SAMPLES]; /* so far, at each sample */
    uint32_t block_samples;
    uint32_t taken;  /* samples so far */
    uint32_t made;   /* blocks so far; all are of block_samples but the last, once the record is closed */
    uint32_t oldest; /* first block still kept */
};

void record_begin(struct record *record, uint32_t block_samples);

/* Whether another sample would still leave room for the rest of its block. */
bool record_has_room(const struct record *record);
void record_add(struct record *record, const struct sample *sample, uint32_t overruns);

/* No more samples: what is there becomes the last, short block. */
void record_close(struct record *record);

/* The host has all blocks before this one. */
void record_forget(struct record *record, uint32_t expected);

/* Body of a block that is made and kept; its length. `taken` so far, read while the sample clock did not run. */
size_t record_block(const struct record *record, uint32_t taken, uint8_t *body, uint32_t block, uint32_t boot, uint32_t run);

#endif
