/* Frames on the wire: consistent-overhead byte stuffing, and the CRC-32 of zlib. */
#include "frame.h"

uint32_t frame_crc(const uint8_t *bytes, size_t count)
{
    /* Four bits at a time: 64 bytes of table, where a byte at a time would take 1024. */
    static const uint32_t table[16] = {
        0x00000000u, 0x1db71064u, 0x3b6e20c8u, 0x26d930acu, 0x76dc4190u, 0x6b6b51f4u, 0x4db26158u, 0x5005713cu,
        0xedb88320u, 0xf00f9344u, 0xd6d6a3e8u, 0xcb61b38cu, 0x9b64c2b0u, 0x86d3d2d4u, 0xa00ae278u, 0xbdbdf21cu,
    };
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < count; i++) {
        crc ^= bytes[i];
        crc = table[crc & 15u] ^ (crc >> 4);
        crc = table[crc & 15u] ^ (crc >> 4);
    }
    return ~crc;
}

/* Where the stuffing stands: the code byte that is still to be filled in, and the next free place. */
struct stuffing {
    uint8_t *frame;
    size_t code;
    size_t next;
};

static void end_run(struct stuffing *s)
{
    s->frame[s->code] = (uint8_t)(s->next - s->code);
    s->code = s->next++;
}

static void stuff(struct stuffing *s, uint8_t byte)
{
    /* A full run is ended only when more comes: 254 bytes at the very end need no empty run after them. */
    if (s->next - s->code == 255u) {
        end_run(s);
    }
    if (byte == 0u) {
        end_run(s);
    } else {
        s->frame[s->next++] = byte;
    }
}

size_t frame_encode(uint8_t *frame, const uint8_t *body, size_t count)
{
    struct stuffing s = {frame, 0u, 1u};
    uint32_t crc = frame_crc(body, count);
    for (size_t i = 0; i < count; i++) {
        stuff(&s, body[i]);
    }
    for (unsigned i = 0; i < FRAME_CRC; i++) {
        stuff(&s, (uint8_t)(crc >> (8u * i)));
    }
    end_run(&s);
    frame[s.code] = 0u;
    return s.next;
}

size_t frame_decode(uint8_t *bytes, size_t count)
{
    size_t from = 0u, to = 0u;
    while (from < count) {
        unsigned code = bytes[from++];
        if (code == 0u || code - 1u > count - from) {
            return 0u;
        }
        for (unsigned i = 1u; i < code; i++) {
            if (bytes[from] == 0u) {
                return 0u;
            }
            bytes[to++] = bytes[from++];
        }
        if (code < 255u && from < count) {
            bytes[to++] = 0u;
        }
    }
    if (to <= FRAME_CRC || to - FRAME_CRC > FRAME_BODY_MOST) {
        return 0u;
    }
    to -= FRAME_CRC;
    uint32_t crc = frame_crc(bytes, to);
    for (unsigned i = 0; i < FRAME_CRC; i++) {
        if (bytes[to + i] != (uint8_t)(crc >> (8u * i))) {
            return 0u;
        }
    }
    return to;
}

size_t frame_take(struct frame_receiver *receiver, uint8_t byte)
{
    if (byte != 0u) {
        if (receiver->count < FRAME_STUFFED_MOST) {
            receiver->bytes[receiver->count++] = byte;
        } else {
            receiver->too_long = true;
        }
        return 0u;
    }
    size_t length = receiver->too_long ? 0u : frame_decode(receiver->bytes, receiver->count);
    receiver->count = 0u;
    receiver->too_long = false;
    return length;
}
