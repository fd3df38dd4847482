/* The control loop: what the sample clock runs, from arming to its end. */
#ifndef LOOP_H
#define LOOP_H

#include <stdbool.h>
#include <stdint.h>

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
    double past[LAW_ROWS_MOST + 1u]; /* the controller's memory, then the last reading */
    double parts[PARTS_MOST];        /* torques of an interval */
    struct line line;
    uint32_t slot;   /* that is next within this interval; 0: a sample is */
    double passed; /* of this interval, when the last torque was set */
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
