/* Messages: the bodies of frames, byte by byte as in docs/reference/wire.md. */
#ifndef MESSAGES_H
#define MESSAGES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define WIRE_VERSION 1u
#define BLOCK_SAMPLES_MOST 48u
#define SINES_MOST 4u
#define HANDS_MOST 10u
#define TORQUES_MOST 32u
#define NAME_BYTES 16u
#define LAW_NUMBERS_MOST 9u
#define LAW_ROWS_MOST 65u
#define PARTS_MOST 64u /* torques in a sample interval */
#define LOOKS_MOST 63u /* readings of the encoder within one, beside that of the sample */
#define SAMPLE_BYTES 17u
#define BLOCK_BYTES 1000u /* of samples in a block, with what was read between them */

enum { HELLO = 0x01, CONFIGURE = 0x02, ARM = 0x03, START = 0x04, STOP = 0x05, RELEASE = 0x06, ALIVE = 0x07,
       AGAIN = 0x08, ZERO = 0x09, SIMULATE = 0x10, CONTROL = 0x11, PULSE = 0x12, SQUEEZE = 0x13,
       OVER_ANGLE = 0x14, TORQUES = 0x15, ABILITIES = 0x16, CONVERTERS = 0x17, ACK = 0x81, BLOCK = 0x82, EVENT = 0x83,
       READINGS = 0x84 };
enum { DONE = 0, NOT_NOW = 1, OUT_OF_RANGE = 2, NOT_KNOWN = 3 };
enum { IDLE = 0, ARMED = 1, RUNNING = 2, TRIPPED = 3 };
enum { NO_FAULT = 0, FAULT_WATCHDOG = 1, FAULT_SPEED = 2, FAULT_NOT_A_NUMBER = 3, FAULT_EMERGENCY = 4, FAULT_NO_ROOM = 5 };
enum { WALL_ON = 1 };

struct settings {
    uint32_t period_ns, counts_per_rev;
    double wall_stiffness, wall_damping; /* N·m/rad, N·m·s/rad */
    double torque_limit_nm, speed_limit_rad_s;
    uint32_t watchdog_us;
    uint16_t block_samples;
};

struct sine {
    double amplitude, frequency_hz, phase;
};

/* Knob, hand and person, SI units; see hknob_cli/hardware/port.py. */
struct simulated {
    double inertia, damping, stiffness, coulomb_nm, angle_rad, push_nm, grip_n, grip_rise_s, grip_offset_n;
    uint8_t push_count, grip_count;
    struct sine sines[2u * SINES_MOST]; /* of the push first, then of the grip */
};

/* A controller: its law, 0 for the plain wall; the numbers of its function; its memory before the first sample, of which
   `places` rows begin with the place of the knob. */
struct control {
    uint8_t law, places, number_count, row_count;
    double numbers[LAW_NUMBERS_MOST], rows[LAW_ROWS_MOST];
};

/* A pulse that a grip fires (pulse.h): forces in N, torque in N·m, width and dwell in samples. Of width 0: none. */
struct pulse {
    double grip_n, band_n, release_n, torque_nm;
    uint32_t width, dwell;
};

/* How a simulated person squeezes a knob that pulses; hands by grip: N, inertia, damping, stiffness. Of none: nobody. */
struct squeeze {
    double aim_n, rise_s, overshoot, reaction_s, relax_s, strength_n;
    uint8_t climbs, hand_count, sine_count;
    double hands[HANDS_MOST][4];
    struct sine sines[SINES_MOST]; /* of shares */
};

/* Torque over the angle, whose counts come in pieces (over_angle.h). Of size 0: none. */
struct over_angle {
    int32_t first;
    uint32_t turn, size;
    double below, above;
};

struct torques {
    uint32_t at;
    uint8_t count;
    double values[TORQUES_MOST];
};

/* What lies between the angle and the wall, and between the wall and the motor (convert.h). All 0: nothing. */
struct converters {
    double offset_counts, dead_band_nm, step_nm, limit_nm, delay_samples;
    uint8_t rounding;
};

struct command {
    uint8_t type;
    uint32_t nonce;
    uint32_t first; /* of ALIVE: the block expected; of AGAIN: the first */
    uint16_t count; /* of AGAIN */
    int32_t angle;  /* of ZERO */
    struct settings settings;
    struct simulated simulated;
    struct control control;
    struct pulse pulse;
    struct squeeze squeeze;
    struct over_angle over_angle;
    struct torques torques;
    struct converters converters;
};

/* What a target is and can do, in its answer to HELLO. The target itself adds the last five. */
enum { SIMULATED = 1, NO_GRIP_CELL = 2, OWN_TIME = 4, KNOWS_ZERO = 8, KNOWS_CONTROL = 16, KNOWS_PULSES = 32,
       KNOWS_OVER_ANGLE = 64, KNOWS_ABILITIES = 128 };
/* Of the answer to ABILITIES: beside the laws, a bit each, what else it knows. */
enum { KNOWS_CONVERTERS = 1, KNOWS_PARTS = 2, KNOWS_LOOKS = 4 };

struct identity {
    uint32_t native_counts, shortest_period_ns;
    uint8_t flags;
    char name[NAME_BYTES];
};

struct answer {
    uint32_t nonce, boot, blocks;
    uint8_t of, status, state, fault;
};

struct sample {
    uint32_t time_us;
    int32_t angle;
    float torque_nm, grip_n;
    uint8_t flags;
};

struct block {
    uint32_t boot, run, block, first, overruns;
    uint8_t count, looks; /* looks: angles that follow each sample; of none the message is BLOCK, else READINGS */
};

struct event {
    uint32_t boot, run, index, time_us, blocks;
    uint8_t fault;
};

/* What a body from the host says. False if its version, type or length is not one of the host's. */
bool command_read(struct command *command, const uint8_t *body, size_t count);

/* Bodies from the target, written to room for FRAME_BODY_MOST; each returns its length. */
size_t answer_write(uint8_t *body, const struct answer *answer);
size_t event_write(uint8_t *body, const struct event *event);
size_t block_write(uint8_t *body, const struct block *block);

/* What follows in the body: after an answer with its length so far, after a block once per sample. The new length. */
size_t identity_write(uint8_t *body, size_t at, const struct identity *identity);
size_t settings_write(uint8_t *body, size_t at, const struct settings *settings);
size_t zero_write(uint8_t *body, size_t at, int32_t angle);
size_t simulated_write(uint8_t *body, size_t at, const struct simulated *simulated);
size_t control_write(uint8_t *body, size_t at, const struct control *control);
size_t pulse_write(uint8_t *body, size_t at, const struct pulse *pulse);
size_t over_angle_write(uint8_t *body, size_t at, const struct over_angle *over_angle);
size_t torques_write(uint8_t *body, size_t at, const struct torques *piece, const double *values);
size_t squeeze_write(uint8_t *body, size_t at, const struct squeeze *squeeze);
size_t abilities_write(uint8_t *body, size_t at, uint32_t laws);
size_t converters_write(uint8_t *body, size_t at, const struct converters *converters);
size_t sample_write(uint8_t *body, size_t at, const struct sample *sample);
size_t looks_write(uint8_t *body, size_t at, const int32_t *looks, size_t count);

bool settings_in_range(const struct settings *settings, const struct identity *identity);
bool simulated_in_range(const struct simulated *simulated);

/* Numbers in their order on the wire. */
enum { SIMULATED_NUMBERS = 9, SQUEEZE_NUMBERS = 6 };
double *simulated_number(struct simulated *simulated, unsigned i);
double *squeeze_number(struct squeeze *squeeze, unsigned i);

/* Whether a pulse is one that a target may fire under these settings. */
bool pulse_in_range(const struct pulse *pulse, const struct settings *settings);
bool squeeze_in_range(const struct squeeze *squeeze);
bool converters_in_range(const struct converters *converters);

#endif
