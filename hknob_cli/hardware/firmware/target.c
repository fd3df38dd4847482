/* The target towards the host: commands, answers, blocks, events (docs/reference/wire.md).

   The sample clock calls target_sample(), the main loop target_serve(). What both touch, the main loop touches between
   board_lock() and board_unlock(); samples of a block once made change no more, and are read without the lock. */
#include "target.h"

#include <string.h>

#include "board.h"
#include "frame.h"
#include "law.h"
#include "loop.h"

#define EVENT_EVERY_NS 20000000u

static struct {
    bool configured, answered, answer_due;
    uint8_t last_type, last_status;
    uint32_t boot, run, last_nonce;
    uint32_t sent, again, again_end; /* next block to send first; blocks to send again */
    uint64_t event_due_ns;
    int32_t zero;
    struct simulated simulated;
    struct squeeze squeeze;
    struct torques piece; /* the last that was taken, of which the place and the count matter */
    struct command command;
    struct frame_receiver receiver;
    uint8_t body[FRAME_BODY_MOST], frame[FRAME_MOST];
    size_t frame_count, frame_sent;
} self;

void target_begin(void)
{
    memset(&self, 0, sizeof self);
    memset(&loop, 0, sizeof loop);
    board_torque(0.0);
    self.boot = board_boot();
    record_begin(&loop.record, 1u, 0u);
}

static uint8_t arm(uint32_t nonce)
{
    if (loop.state != IDLE || !self.configured || loop.over_angle.filled < loop.over_angle.head.size) {
        return NOT_NOW;
    }
    if (!loop_arm()) {
        return OUT_OF_RANGE;
    }
    self.run = nonce;
    self.sent = self.again = self.again_end = 0u;
    self.event_due_ns = 0u;
    return DONE;
}

static uint8_t configure(const struct settings *settings)
{
    if (loop.state != IDLE) {
        return NOT_NOW;
    }
    if (!settings_in_range(settings, &board_identity)) {
        return OUT_OF_RANGE;
    }
    /* What is still kept of the run before stays readable: the record has its own length of a block. */
    loop.settings = *settings;
    loop.control.law = 0u; /* its numbers are of other settings */
    loop.pulse.width = 0u;
    loop.over_angle.head.size = 0u;
    memset(&loop.converters, 0, sizeof loop.converters);
    self.configured = true;
    return DONE;
}

static uint8_t simulate(const struct simulated *simulated)
{
    if ((board_identity.flags & SIMULATED) == 0u) {
        return NOT_KNOWN;
    }
    if (loop.state != IDLE) {
        return NOT_NOW;
    }
    uint8_t status = simulated_in_range(simulated) ? board_simulate(simulated) : (uint8_t)OUT_OF_RANGE;
    if (status == DONE) {
        self.simulated = *simulated;
    }
    return status;
}

static uint8_t control(const struct control *control)
{
    if (loop.state != IDLE || !self.configured) {
        return NOT_NOW;
    }
    if (!control_in_range(control)) {
        return OUT_OF_RANGE;
    }
    loop.control = *control;
    return DONE;
}

static uint8_t pulse(const struct pulse *pulse)
{
    if ((board_identity.flags & NO_GRIP_CELL) != 0u) {
        return NOT_KNOWN;
    }
    if (loop.state != IDLE || !self.configured) {
        return NOT_NOW;
    }
    if (!pulse_in_range(pulse, &loop.settings)) {
        return OUT_OF_RANGE;
    }
    loop.pulse = *pulse;
    return DONE;
}

static uint8_t converters(const struct converters *converters)
{
    if (loop.state != IDLE || !self.configured) {
        return NOT_NOW;
    }
    if (!converters_in_range(converters)) {
        return OUT_OF_RANGE;
    }
    loop.converters = *converters;
    return DONE;
}

static uint8_t over_angle(const struct over_angle *head)
{
    if (loop.state != IDLE || !self.configured) {
        return NOT_NOW;
    }
    return over_angle_begin(&loop.over_angle, head) ? DONE : OUT_OF_RANGE;
}

static uint8_t torques(const struct torques *piece)
{
    if (loop.state != IDLE || loop.over_angle.head.size == 0u) {
        return NOT_NOW;
    }
    if (!over_angle_take(&loop.over_angle, piece)) {
        return OUT_OF_RANGE;
    }
    self.piece = *piece;
    return DONE;
}

static uint8_t squeeze(const struct squeeze *squeeze)
{
    if ((board_identity.flags & SIMULATED) == 0u) {
        return NOT_KNOWN;
    }
    if (loop.state != IDLE) {
        return NOT_NOW;
    }
    uint8_t status = squeeze_in_range(squeeze) ? board_squeeze(squeeze) : (uint8_t)OUT_OF_RANGE;
    if (status == DONE) {
        self.squeeze = *squeeze;
    }
    return status;
}

static uint8_t zero(int32_t angle)
{
    if (loop.state != IDLE) {
        return NOT_NOW;
    }
    loop.zero_counts = (int64_t)angle - board_angle();
    self.zero = angle;
    return DONE;
}

static uint8_t release(void)
{
    loop_halt(IDLE, NO_FAULT);
    record_begin(&loop.record, 1u, 0u);
    self.sent = self.again = self.again_end = 0u;
    return DONE;
}

/* Carry out a command, with the lock held; the status to answer. */
static uint8_t carry_out(const struct command *c)
{
    switch (c->type) {
    case CONFIGURE:
        return configure(&c->settings);
    case SIMULATE:
        return simulate(&c->simulated);
    case CONTROL:
        return control(&c->control);
    case PULSE:
        return pulse(&c->pulse);
    case SQUEEZE:
        return squeeze(&c->squeeze);
    case OVER_ANGLE:
        return over_angle(&c->over_angle);
    case TORQUES:
        return torques(&c->torques);
    case CONVERTERS:
        return converters(&c->converters);
    case ZERO:
        return zero(c->angle);
    case ARM:
        return arm(c->nonce);
    case START:
        if (loop.state != ARMED) {
            return NOT_NOW;
        }
        board_started();
        loop.state = RUNNING;
        return DONE;
    case STOP:
        if (!loop_on()) {
            return NOT_NOW;
        }
        loop_halt(IDLE, NO_FAULT);
        return DONE;
    case RELEASE:
        return release();
    default:
        return DONE; /* HELLO, ABILITIES */
    }
}

static void obey(const struct command *c)
{
    board_lock();
    loop.heard_ns = board_now_ns();
    if (c->type == ALIVE) {
        record_forget(&loop.record, c->first);
        if (loop.record.oldest - self.sent <= loop.record.made - self.sent) {
            self.sent = loop.record.oldest;
        }
    } else if (c->type == AGAIN) {
        /* Only what was sent before and is still kept; the rest comes by itself. */
        uint32_t end = c->first + c->count;
        self.again = c->first;
        self.again_end = end > self.sent ? self.sent : end;
    } else {
        if (!self.answered || c->nonce != self.last_nonce || c->type != self.last_type) {
            self.last_status = carry_out(c);
            self.last_nonce = c->nonce;
            self.last_type = c->type;
            self.answered = true;
        }
        self.answer_due = true;
    }
    board_unlock();
}

/* The answer to the last command: what was taken of its values, if any were. */
static size_t answer(void)
{
    struct answer a = {self.last_nonce, self.boot, loop.record.made, self.last_type, self.last_status, loop.state, loop.fault};
    size_t count = answer_write(self.body, &a);
    if (self.last_status != DONE) {
        return count;
    }
    switch (self.last_type) {
    case HELLO:
        return identity_write(self.body, count, &board_identity);
    case ABILITIES:
        return abilities_write(self.body, count, law_known());
    case CONFIGURE:
        return settings_write(self.body, count, &loop.settings);
    case ZERO:
        return zero_write(self.body, count, self.zero);
    case SIMULATE:
        return simulated_write(self.body, count, &self.simulated);
    case CONTROL:
        return control_write(self.body, count, &loop.control);
    case PULSE:
        return pulse_write(self.body, count, &loop.pulse);
    case SQUEEZE:
        return squeeze_write(self.body, count, &self.squeeze);
    case OVER_ANGLE:
        return over_angle_write(self.body, count, &loop.over_angle.head);
    case TORQUES:
        return torques_write(self.body, count, &self.piece, loop.over_angle.torques + self.piece.at);
    case CONVERTERS:
        return converters_write(self.body, count, &loop.converters);
    default:
        return count;
    }
}

/* Body of what is to be sent next, 0 if nothing: the answer, but that to STOP after the last block; blocks asked for
   again; blocks; the event after the last block, and from time to time again. */
static size_t next_body(uint64_t now)
{
    board_lock();
    uint32_t made = loop.record.made, taken = loop.record.taken, oldest = loop.record.oldest;
    bool last_sent = self.sent == made;
    size_t count = 0u;
    if (self.answer_due && (self.last_type != STOP || last_sent)) {
        self.answer_due = false;
        count = answer();
    } else if (loop.state == TRIPPED && last_sent && now >= self.event_due_ns) {
        struct event e = {self.boot, self.run, loop.tripped_index, loop.tripped_us, made, loop.fault};
        self.event_due_ns = now + EVENT_EVERY_NS;
        count = event_write(self.body, &e);
    }
    board_unlock();
    if (count > 0u) {
        return count;
    }
    if (self.again < oldest) {
        self.again = oldest;
    }
    if (self.again < self.again_end) {
        return record_block(&loop.record, taken, self.body, self.again++, self.boot, self.run);
    }
    if (!last_sent) {
        return record_block(&loop.record, taken, self.body, self.sent++, self.boot, self.run);
    }
    return 0u;
}

bool target_serve(void)
{
    uint8_t bytes[64];
    size_t count;
    while ((count = board_receive(bytes, sizeof bytes)) > 0u) {
        for (size_t i = 0; i < count; i++) {
            size_t length = frame_take(&self.receiver, bytes[i]);
            if (length > 0u && command_read(&self.command, self.receiver.bytes, length)) {
                obey(&self.command);
            }
        }
    }
    uint64_t now = board_now_ns();
    board_lock();
    loop_watch(now);
    board_unlock();
    for (;;) {
        if (self.frame_sent == self.frame_count) {
            size_t length = next_body(now);
            if (length == 0u) {
                return false;
            }
            self.frame_count = frame_encode(self.frame, self.body, length);
            self.frame_sent = 0u;
        }
        self.frame_sent += board_send(self.frame + self.frame_sent, self.frame_count - self.frame_sent);
        if (self.frame_sent < self.frame_count) {
            return true;
        }
    }
}

bool target_busy(void)
{
    board_lock();
    bool busy = loop.state != IDLE;
    board_unlock();
    return busy;
}
