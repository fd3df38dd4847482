/* The control loop: what the sample clock runs, from arming to its end. */
#ifndef LOOP_H
#define LOOP_H

#include <stdbool.h>
#include <stdint.h>

#include "law.h"
#include "line.h"
#include "over_angle.h"
#include "pulse.h"
#include "record.h"

/* Of the loop the main loop touches, between board_lock() and board_unlock(), only what is said here. */
struct loop {
    uint8_t state, fault;
    struct settings settings;
    struct control control; /* law 0: the plain wall */
    struct pulse pulse;     /* in place of any wall; of width 0: none */
    struct over_angle_table over_angle; /* the spring among it; of size 0: none */
    struct converters converters;
    uint64_t heard_ns; /* when a valid frame last came */
    uint32_t overruns, tripped_index, tripped_us;
    int64_t zero_counts; /* added to the board's angle */
    struct record record;
    /* The sample's own. */
    double quantum_rad, native_rad, interval_s;
    uint64_t armed_ns, due_ns, before_ns, taken_ns; /* taken_ns: when the last sample should have been taken */
    int64_t count_before;
    int32_t angle_before;
    uint32_t told_us; /* time of the sample before */
    bool control_begun;
    struct pulse_state pulsing;
    double past[LAW_PAST_MOST]; /* the controller's memory, then the last reading and those since */
    double parts[PARTS_MOST];   /* torques of an interval */
    struct line line;
    bool within;    /* a torque or a reading within this interval is next, not a sample */
    uint32_t slot;  /* the next torque of this interval */
    double passed;  /* of this interval, when the last torque was set or the encoder read */
    uint32_t look_count, looked; /* readings within an interval, and how many of this one were made */
    int32_t looks[LOOKS_MOST];   /* their angles; 0 where none were made */
    bool look_late;              /* one of them was, by more than half the time between two */
};

extern struct loop loop;

/* Whether samples are being taken: armed or running. */
bool loop_on(void);

/* Begin with index 0, time 0, block 0, torque off. False if the board cannot keep to these settings. */
bool loop_arm(void);

/* Torque off, clock off, last block closed. */
void loop_halt(uint8_t state, uint8_t fault);

/* Trip if the host has been silent for too long, samples or none. */
void loop_watch(uint64_t now);

#endif
