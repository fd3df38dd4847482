/* Frames on the wire: COBS(body, CRC-32 of the body) and a zero byte. See docs/reference/wire.md. */
#ifndef FRAME_H
#define FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FRAME_BODY_MOST 1024u
#define FRAME_CRC 4u
/* Stuffing costs one byte, and another per 254; the zero at the end is not counted. */
#define FRAME_STUFFED_MOST (FRAME_BODY_MOST + FRAME_CRC + (FRAME_BODY_MOST + FRAME_CRC) / 254u + 1u)
#define FRAME_MOST (FRAME_STUFFED_MOST + 1u)

/* Bytes between two zeros, as they come in. */
struct frame_receiver {
    uint8_t bytes[FRAME_STUFFED_MOST];
    size_t count;
    bool too_long; /* all up to the next zero is dropped */
};

uint32_t frame_crc(const uint8_t *bytes, size_t count);

/* The frame of a body of at most FRAME_BODY_MOST bytes, zero at its end included; room for FRAME_MOST. Its length. */
size_t frame_encode(uint8_t *frame, const uint8_t *body, size_t count);

/* Undo stuffing in place and check the CRC; the zero is not among the bytes. Length of the body, 0 if it is no frame. */
size_t frame_decode(uint8_t *bytes, size_t count);

/* Take one byte. Length of the body if this byte ended a frame, which then is at the start of bytes; else 0. */
size_t frame_take(struct frame_receiver *receiver, uint8_t byte);

#endif
