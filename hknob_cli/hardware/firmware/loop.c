/* The control loop: time, angle, limits, wall, torque out, record (docs/reference/wire.md, "What a target does"). */
#include "loop.h"

#include <string.h>

#include "board.h"
#include "convert.h"
#include "target.h"
#include "wall.h"

/* What a record must have room for. */
#define KEPT_NS 100000000u

struct loop loop;

bool loop_on(void)
{
    return loop.state == ARMED || loop.state == RUNNING;
}

/* Whether a block with so many readings beside each sample fits a frame, and 100 ms of them the record. */
static bool looks_fit(uint32_t looks)
{
    const struct settings *s = &loop.settings;
    return looks == 0u || (s->block_samples * (SAMPLE_BYTES + 4u * looks) <= BLOCK_BYTES &&
                           (uint64_t)record_room(looks) * s->period_ns >= KEPT_NS);
}

bool loop_arm(void)
{
    static const struct control none;
    bool other = loop.over_angle.head.size > 0u || loop.pulse.width > 0u;
    uint32_t parts = law_parts(loop.over_angle.head.size > 0u ? &none : &loop.control, loop.parts);
    uint32_t looks = law_looks(other ? &none : &loop.control);
    if (!looks_fit(looks) || !line_begin(&loop.line, parts, loop.parts, loop.converters.delay_samples) ||
        !board_armed(&loop.settings)) {
        return false;
    }
    loop.within = loop.look_late = false;
    loop.passed = 0.0;
    loop.look_count = looks;
    memset(loop.looks, 0, sizeof loop.looks);
    record_begin(&loop.record, loop.settings.block_samples, looks);
    loop.overruns = 0u;
    loop.control_begun = false;
    memset(&loop.pulsing, 0, sizeof loop.pulsing);
    loop.quantum_rad = TWO_PI / loop.settings.counts_per_rev;
    loop.native_rad = TWO_PI / board_identity.native_counts;
    loop.interval_s = loop.settings.period_ns * 1e-9;
    board_torque(0.0);
    loop.state = ARMED;
    loop.armed_ns = loop.due_ns = board_now_ns();
    board_call_at(loop.due_ns);
    return true;
}

void loop_halt(uint8_t state, uint8_t fault)
{
    board_torque(0.0);
    board_call_at(BOARD_NEVER);
    record_close(&loop.record);
    loop.state = state;
    loop.fault = fault;
}

static void trip(uint8_t fault, uint32_t index, uint64_t now)
{
    loop_halt(TRIPPED, fault);
    loop.tripped_index = index;
    loop.tripped_us = (uint32_t)((now - loop.armed_ns) / 1000u);
}

static bool unheard(uint64_t now)
{
    return now - loop.heard_ns >= (uint64_t)loop.settings.watchdog_us * 1000u;
}

void loop_watch(uint64_t now)
{
    if (loop_on() && unheard(now)) {
        trip(FAULT_WATCHDOG, loop.record.taken, now);
    }
}

/* Too fast from the sample before: over the time that passed, which is longer than a period after a late sample. */
static bool too_fast(int32_t angle, uint64_t now)
{
    double passed_s = (double)(now - loop.before_ns) * 1e-9;
    double moved = ((double)angle - (double)loop.angle_before) * loop.native_rad;
    double limit = loop.settings.speed_limit_rad_s * (passed_s > loop.interval_s ? passed_s : loop.interval_s);
    return moved > limit || moved < -limit;
}

static uint8_t fault_of(int32_t angle, double torque, uint64_t now)
{
    if (board_emergency()) {
        return FAULT_EMERGENCY;
    }
    if (too_fast(angle, now)) {
        return FAULT_SPEED;
    }
    if (unheard(now)) {
        return FAULT_WATCHDOG;
    }
    return torque - torque != 0.0 ? FAULT_NOT_A_NUMBER : NO_FAULT;
}

/* The board's angle from the zero that the host has set, at the end of what can be told where it is beyond. */
static int32_t angle_now(void)
{
    int64_t angle = board_angle() + loop.zero_counts;
    return angle < INT32_MIN ? INT32_MIN : angle > INT32_MAX ? INT32_MAX : (int32_t)angle;
}

/* Times rise: a sample that follows at once on a late one, in the same microsecond, is told one later. */
static uint32_t time_of(uint32_t index, uint64_t now)
{
    uint32_t time_us = (uint32_t)((now - loop.armed_ns) / 1000u);
    if (index > 0u && time_us == loop.told_us) {
        time_us++;
    }
    loop.told_us = time_us;
    return time_us;
}

/* Torques of the wall at a count, one a part of the interval, before converters and limit. */
static void torques_of_wall(int64_t count)
{
    const struct settings *s = &loop.settings;
    double *parts = loop.parts;
    if (loop.over_angle.head.size > 0u) {
        parts[0] = over_angle_torque(&loop.over_angle, count) -
                   wall_brake(count, loop.count_before, loop.quantum_rad, loop.interval_s, s->wall_damping);
        return;
    }
    if (loop.control.law == 0u) {
        parts[0] = wall_torque(count, loop.count_before, loop.converters.offset_counts, loop.quantum_rad, loop.interval_s,
                               s->wall_stiffness, s->wall_damping);
        return;
    }
    if (!loop.control_begun) {
        law_begin(&loop.control, loop.past, (double)loop.count_before);
        loop.control_begun = true;
    }
    (void)law_act(&loop.control, loop.past, (double)count, parts);
    for (uint32_t i = 0; i < loop.line.parts; i++) {
        parts[i] = wall_controlled(parts[i], count, loop.count_before, loop.quantum_rad, loop.interval_s,
                                   s->wall_stiffness, s->wall_damping);
    }
}

/* Torque from a sample on, before the limit: of the pulse, which follows the grip from arming on, or of the wall, as it
   comes out of converters and line. */
static double torque_at(int64_t count, float grip_n)
{
    bool running = loop.state == RUNNING;
    if (loop.pulse.width > 0u) {
        return pulse_step(&loop.pulse, &loop.pulsing, (double)grip_n, running);
    }
    if (!running) {
        return 0.0;
    }
    torques_of_wall(count);
    for (uint32_t i = 0; i < loop.line.parts; i++) {
        if (loop.parts[i] - loop.parts[i] != 0.0) {
            return loop.parts[i]; /* not a number: it trips, late or not */
        }
        loop.parts[i] = convert_send(&loop.converters, loop.parts[i]);
    }
    line_put(&loop.line, loop.parts);
    return line_torque(&loop.line, 0u);
}

/* When the next torque and the next reading of this interval are due, in parts of it; 1, its end, where none is left. */
static double next_torque(void)
{
    return loop.slot < loop.line.slot_count ? loop.line.slots[loop.slot].begins : 1.0;
}

static double next_look(void)
{
    return loop.looked < loop.look_count ? (double)(loop.looked + 1u) / (double)(loop.look_count + 1u) : 1.0;
}

static uint64_t time_within(double part)
{
    return loop.taken_ns + (uint64_t)(part * loop.settings.period_ns);
}

/* Have the clock call for the next torque or reading within this interval; for the next sample, if there is none. */
static void call_next(void)
{
    double torque = next_torque(), look = next_look(), next = look < torque ? look : torque;
    loop.within = loop.state == RUNNING && loop.pulse.width == 0u && next < 1.0;
    board_call_at(loop.within ? time_within(next) : loop.due_ns);
}

/* Another torque, within an interval. */
static void change_torque(double begins)
{
    board_passed(begins - loop.passed, false);
    loop.passed = begins;
    board_torque(wall_limit(line_torque(&loop.line, loop.slot), loop.settings.torque_limit_nm));
    loop.slot++;
}

/* A reading, within an interval: for the law, and for the record of the next sample. */
static void look_within(double at)
{
    const struct settings *s = &loop.settings;
    if (board_now_ns() > time_within(at) + s->period_ns / (2u * (loop.look_count + 1u))) {
        loop.look_late = true;
    }
    board_passed(at - loop.passed, false);
    loop.passed = at;
    int32_t angle = angle_now();
    loop.looks[loop.looked] = angle;
    loop.past[loop.control.row_count + 1u + loop.looked] =
        (double)convert_count(&loop.converters, angle, s->counts_per_rev, board_identity.native_counts);
    loop.looked++;
}

void target_sample(void)
{
    const struct settings *s = &loop.settings;
    if (!loop_on()) {
        return;
    }
    if (loop.within) {
        double torque = next_torque(), look = next_look();
        if (look <= torque) { /* of both at once the reading is first */
            look_within(look);
        } else {
            change_torque(torque);
        }
        call_next();
        return;
    }
    uint64_t now = board_now_ns();
    uint32_t index = loop.record.taken;
    if (now > loop.due_ns + s->period_ns / 2u || loop.look_late) {
        loop.overruns++;
    }
    loop.look_late = false;
    if (!record_has_room(&loop.record)) {
        trip(FAULT_NO_ROOM, index, now);
        return;
    }
    board_passed(1.0 - loop.passed, true);
    loop.passed = 0.0;
    int32_t angle = angle_now();
    int64_t count = convert_count(&loop.converters, angle, s->counts_per_rev, board_identity.native_counts);
    if (index == 0u) {
        loop.angle_before = angle;
        loop.count_before = count;
        loop.before_ns = now;
    }
    float grip_n = (float)board_grip_n();
    double torque = wall_limit(torque_at(count, grip_n), s->torque_limit_nm);
    uint8_t fault = fault_of(angle, torque, now);
    if (fault != NO_FAULT) {
        torque = 0.0;
    }
    board_torque(torque);
    struct sample sample = {time_of(index, now), angle, (float)torque, grip_n,
                            loop.state == RUNNING && fault == NO_FAULT ? WALL_ON : 0u};
    record_add(&loop.record, &sample, loop.looks, loop.overruns);
    if (fault != NO_FAULT) {
        trip(fault, index, now);
        return;
    }
    loop.angle_before = angle;
    loop.count_before = count;
    loop.before_ns = now;
    loop.taken_ns = loop.due_ns;
    /* Samples whose time has gone by are left out. */
    loop.due_ns += s->period_ns;
    if (loop.due_ns <= now) {
        loop.due_ns += ((now - loop.due_ns) / s->period_ns + 1u) * s->period_ns;
    }
    loop.slot = 1u;
    loop.looked = 0u;
    call_next();
}
