/* 100,000 frames that are none: random bytes, and good frames with bits turned, bytes lost and ends cut off; then 50,000
   good ones in any order, at a knob that jumps about. To be built with the sanitizers. Prints how many of the former were
   taken for frames, and what the target made of all. */
#include <stdio.h>
#include <string.h>

#include "frame.h"
#include "law.h"
#include "over_angle.h"
#include "scripted_board.h"
#include "target.h"

static uint64_t seed = 20260u;
static unsigned controllers, pulses, tables, conversions; /* that could be taken */

/* xorshift64*: the same numbers everywhere. */
static uint32_t chance(uint32_t below)
{
    seed ^= seed >> 12;
    seed ^= seed << 25;
    seed ^= seed >> 27;
    return (uint32_t)((seed * 2685821657736338717u) >> 33) % below;
}

static size_t good_frame(uint8_t *frame)
{
    static const uint8_t types[] = {HELLO, CONFIGURE, ARM, START, STOP, RELEASE, ALIVE, AGAIN, SIMULATE, CONTROL, PULSE, SQUEEZE, OVER_ANGLE,
                                    TORQUES, ABILITIES, CONVERTERS};
    static const size_t lengths[] = {6u, 52u, 6u, 6u, 6u, 6u, 10u, 12u, 80u, 42u, 46u, 121u, 34u, 27u, 6u, 47u};
    uint8_t body[121];
    uint32_t which = chance(16u);
    for (size_t i = 0; i < sizeof body; i++) {
        body[i] = (uint8_t)(chance(3u) == 0u ? 0u : chance(256u));
    }
    body[0] = WIRE_VERSION;
    body[1] = types[which];
    if (which == 9u) { /* four numbers of a controller, shared out between its numbers and rows */
        body[8] = (uint8_t)chance(5u);
        body[9] = (uint8_t)(4u - body[8]);
    }
    if (which == 11u) { /* a squeeze of two hands */
        body[55] = 2u;
        body[56] = 0u;
    }
    if (which == 13u) { /* two torques */
        body[10] = 2u;
    }
    return frame_encode(frame, body, lengths[which]);
}

static size_t storm(uint8_t *frame)
{
    size_t count;
    switch (chance(4u)) {
    case 0: /* anything, its zeros at random or none */
        count = 1u + chance(chance(8u) == 0u ? 1500u : 80u);
        for (size_t i = 0; i < count; i++) {
            frame[i] = (uint8_t)chance(256u);
        }
        break;
    case 1: { /* bits turned, in one or two bytes */
        count = good_frame(frame) - 1u;
        uint32_t place = chance((uint32_t)count);
        frame[place] ^= (uint8_t)(1u + chance(255u));
        if (chance(2u) == 0u) {
            frame[(place + 1u + chance((uint32_t)count - 1u)) % count] ^= (uint8_t)(1u + chance(255u));
        }
        break;
    }
    case 2: /* cut off */
        count = chance((uint32_t)good_frame(frame) - 1u);
        break;
    default: { /* a byte lost */
        count = good_frame(frame) - 2u;
        uint32_t lost = chance((uint32_t)count);
        memmove(frame + lost, frame + lost + 1u, count - lost);
        break;
    }
    }
    frame[count] = 0u;
    return count + 1u;
}

static void serve(size_t count)
{
    scripted_in_count = count;
    scripted_in_at = 0u;
    (void)target_serve();
}

/* A controller that can be taken, of any law, with any window. */
static struct control sensible_control(void)
{
    static const uint8_t numbers[] = {0u, 3u, 2u, 3u, 5u, 3u, 7u, 8u, 9u, 8u, 9u, 4u, 5u, 4u};
    static const uint8_t rows[] = {0u, 1u, 2u, 4u, 8u, 0u, 0u, 0u, 2u, 0u, 2u, 1u, 1u, 1u};
    struct control c = {(uint8_t)(1u + chance(13u)), 0u, 0u, 0u, {0.0}, {0.0}};
    unsigned window = 1u + chance(64u), filter = chance(2u);
    c.number_count = numbers[c.law];
    c.row_count = rows[c.law];
    for (unsigned i = 1u; i < c.number_count; i++) {
        c.numbers[i] = 0.01 * chance(200u);
    }
    if (c.law == 2u) { /* first-order hold */
        c.numbers[2] = 0.0;
        c.numbers[3] = chance(2u) == 0u ? 1.0 : window;
    } else if (c.law == 3u) { /* passivity */
        c.places = 1u;
    } else if (c.law >= 12u) { /* half sample, matched wall; without a sensor */
        c.places = 1u;
        c.numbers[c.number_count - 1u] = 0.0;
    } else if (c.law == 6u) { /* velocity damping */
        c.numbers[2] = 0.0;
        c.numbers[4] = window;
        c.numbers[5] = 0.5 * filter;
        c.places = (uint8_t)window;
        c.row_count = (uint8_t)(window + filter);
    } else if (c.law == 11u) { /* impulse damping */
        c.numbers[1] = 0.01 * (1u + chance(100u));
        c.numbers[3] = 0.0;
    } else if (c.law >= 7u) { /* of an estimated speed */
        c.numbers[3] = 0.5 * filter;
        c.numbers[5] = chance(2u);
        c.row_count = c.law == 7u || c.law == 9u ? (uint8_t)(window - 1u) : 2u;
        c.row_count = (uint8_t)(c.row_count + (c.law == 10u || filter == 0u ? 0u : c.numbers[5] > 0.0 ? 2u : 1u));
        c.numbers[6] = c.row_count;
        c.numbers[7] = c.law == 8u ? 1.0 : c.law == 10u ? 0.1 : window;
    }
    return c;
}

/* A pulse that can be taken by most settings: it fires at once, or is waited for. */
static size_t sensible_pulse(uint8_t *body)
{
    struct settings usual = {1000000u, 1u, 0.0, 0.0, 0.05, 1e4, 1000u, 1u};
    struct pulse pulse = {0.1 + 0.1 * chance(20u), 0.05, 0.05, 0.001 * (1u + chance(60u)), 1u + chance(50u), chance(3u)};
    pulses += pulse_in_range(&pulse, &usual) ? 1u : 0u;
    return pulse_write(body, 6u, &pulse);
}

/* A table of a few counts, or the next of its torques. */
static size_t sensible_table(uint8_t *body)
{
    static struct over_angle_table mine; /* what of it could be taken */
    if (chance(3u) == 0u || mine.filled == mine.head.size) {
        struct over_angle head = {(int32_t)chance(200u) - 100, 1u + chance(10u), 10u + chance(60u), -0.5, 0.01 * chance(3u)};
        tables += over_angle_begin(&mine, &head) ? 1u : 0u;
        return over_angle_write(body, 6u, &head);
    }
    struct torques piece = {mine.filled, (uint8_t)(1u + chance(32u)), {0.0}};
    for (unsigned i = 0; i < piece.count; i++) {
        piece.values[i] = 0.001 * chance(100u) - 0.05;
    }
    body[1] = TORQUES;
    tables += over_angle_take(&mine, &piece) ? 1u : 0u;
    return torques_write(body, 6u, &piece, piece.values);
}

/* Settings, a pulse, a table, converters or a controller that can be taken, else any good frame. */
static size_t sensible_frame(uint8_t *frame)
{
    uint8_t body[1024] = {WIRE_VERSION, CONFIGURE};
    if (chance(5u) == 0u) {
        struct control control = sensible_control();
        body[1] = CONTROL;
        for (size_t i = 2u; i < 6u; i++) {
            body[i] = (uint8_t)chance(256u);
        }
        controllers += control_in_range(&control) ? 1u : 0u;
        return frame_encode(frame, body, control_write(body, 6u, &control));
    }
    if (chance(6u) == 0u) {
        body[1] = PULSE;
        for (size_t i = 2u; i < 6u; i++) {
            body[i] = (uint8_t)chance(256u);
        }
        return frame_encode(frame, body, sensible_pulse(body));
    }
    if (chance(6u) == 0u) {
        body[1] = OVER_ANGLE;
        for (size_t i = 2u; i < 6u; i++) {
            body[i] = (uint8_t)chance(256u);
        }
        return frame_encode(frame, body, sensible_table(body));
    }
    if (chance(6u) == 0u) {
        struct converters one = {0.1 * chance(10u), 1e-4 * chance(5u), 1e-4 * chance(5u), 0.01 * chance(5u), 0.25 * chance(40u),
                                 (uint8_t)chance(4u)};
        body[1] = CONVERTERS;
        for (size_t i = 2u; i < 6u; i++) {
            body[i] = (uint8_t)chance(256u);
        }
        conversions += converters_in_range(&one) ? 1u : 0u;
        return frame_encode(frame, body, converters_write(body, 6u, &one));
    }
    if (chance(4u) != 0u) {
        return good_frame(frame);
    }
    for (size_t i = 2u; i < 6u; i++) {
        body[i] = (uint8_t)chance(256u);
    }
    struct settings settings = {40000u + chance(2000000u), 1u + chance(640000u), 0.1 * chance(100u), 1e-4 * chance(3u),
                                0.05, 1e4, 1000u + chance(49001u), (uint16_t)(1u + chance(48u))};
    return frame_encode(frame, body, settings_write(body, 6u, &settings));
}

/* Good frames in any order, samples and time between them; how often there was torque without a sample clock. */
static unsigned wander(unsigned *running)
{
    unsigned astray = 0u;
    for (unsigned i = 0; i < 50000u; i++) {
        scripted_out_count = 0u;
        serve(sensible_frame(scripted_in));
        for (uint32_t samples = chance(20u); samples > 0u && scripted_call_at != UINT64_MAX; samples--) {
            scripted_now = scripted_now > scripted_call_at ? scripted_now : scripted_call_at;
            scripted_now += chance(3u) == 0u ? chance(2000000u) : 0u;
            scripted_angle = chance(2000u) == 0u ? INT32_MIN : scripted_angle / 2 + (int32_t)chance(101u) - 52;
            scripted_grip = 0.1 * chance(25u);
            scripted_emergency = chance(2000u) == 0u;
            target_sample();
            *running += scripted_torque != 0.0 ? 1u : 0u;
        }
        astray += scripted_torque != 0.0 && scripted_call_at == UINT64_MAX ? 1u : 0u;
    }
    return astray;
}

int main(void)
{
    static uint8_t frame[2048];
    static struct frame_receiver receiver;
    const uint8_t hello[6] = {WIRE_VERSION, HELLO, 1u, 2u, 3u, 4u};
    unsigned taken = 0u;
    target_begin();
    for (unsigned i = 0; i < 100000u; i++) {
        size_t count = storm(frame);
        for (size_t k = 0; k < count; k++) {
            taken += frame_take(&receiver, frame[k]) > 0u ? 1u : 0u;
        }
        memcpy(scripted_in, frame, count);
        serve(count);
    }
    size_t answered = scripted_out_count;
    serve(frame_encode(scripted_in, hello, sizeof hello));
    printf("taken %u, trials %u, bytes answered %zu, to a good frame then %zu\n", taken, scripted_trials, answered,
           scripted_out_count - answered);
    unsigned running = 0u, astray = wander(&running);
    printf("torque without a clock %u, locks %s, torque seen %s\n", astray,
           scripted_locks < 100000000u && scripted_locks % 2u == 0u ? "in order" : "astray", running > 1000u ? "often" : "never");
    printf("controllers %s, pulses %s, tables %s, converters %s\n", controllers > 8000u ? "many" : "few", pulses > 4000u ? "many" : "few",
           tables > 2000u ? "many" : "few", conversions > 2000u ? "many" : "few");
    return 0;
}
