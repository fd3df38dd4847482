/* A board to fill in: copy this file, and write what each comment asks for. docs/tutorials/your_firmware.md goes through it.

   As it stands it compiles, has no clock, and does nothing. */
#include "board.h"
#include "target.h"

/* Counts per revolution of the encoder as the machine counts them, four per line; a period that the sample, with all
   that board_angle() and board_torque() do, surely fits into twice; no flag, or NO_GRIP_CELL; a name of at most 15 letters.
   RECORD_SAMPLES (record.h) times this period must be at least 100 ms; OVER_ANGLE_MOST (over_angle.h) takes 8 bytes each,
   RECORD_LOOKS (record.h) 4: what it has no room for is refused. */
const struct identity board_identity = {4096u, 250000u, 0u, "my knob"};

/* Another number after every start: from a random number generator, a battery-backed clock, or a counter kept in flash.
   With nothing of the kind the host cannot tell a restart from a long silence. */
uint32_t board_boot(void)
{
    return 0u;
}

/* A free-running timer of 1 MHz or more, widened to 64 bits: called far more often than it comes round, from the sample
   clock's interrupt and from the main loop, so that widening must be done with interrupts off. */
uint64_t board_now_ns(void)
{
    return 0u;
}

/* Set a compare register of that timer, so that its interrupt comes at this time; at once if the time has gone by. The
   interrupt's function calls target_sample() if board_now_ns() has reached the time, and sets the register anew if not
   (a time may be further ahead than the register reaches). BOARD_NEVER switches the interrupt off. The interrupt has
   a higher priority than anything that may take longer than a tenth of a period, except for the emergency stop. */
void board_call_at(uint64_t time_ns)
{
    (void)time_ns;
}

/* The encoder's count, 32 bits or widened to them, latched once. 0 is the wall's edge: set it when the knob is at its
   mark, or let the host do it (ZERO). Turning outwards counts up; swap the encoder's lines if it does not. An absolute
   encoder tells where it is within one turn: add the difference to the reading before, taken between plus and minus half
   a turn, to a count of your own, so that the angle goes on across the place where the reading starts anew. A controller
   may ask for up to 63 readings between two samples: each must be of its own moment, not that of the last sample. */
int32_t board_angle(void)
{
    return 0;
}

/* Torque to amplifier command: divide by N·m per unit, add the amplifier's zero, round, stay within the converter. The
   target has cut it off at the trial's limit; cut it off here at what motor and fingers stand, whatever was asked for.
   Zero must take effect at once: open the amplifier's enable line as well. Positive torque turns the knob outwards; try
   that with the smallest torque that moves it before anything else. */
void board_torque(double torque_nm)
{
    (void)torque_nm;
}

/* The grip cell's last reading in N, without waiting for the converter; its zero is the host's business. */
double board_grip_n(void)
{
    return 0.0;
}

/* Whether the emergency stop is pressed. The stop itself opens the amplifier's supply without asking this program. */
bool board_emergency(void)
{
    return false;
}

/* Bytes from the serial line's receive buffer; fill that by interrupt or DMA, 512 bytes at least. */
size_t board_receive(uint8_t *bytes, size_t most)
{
    (void)bytes;
    (void)most;
    return 0u;
}

/* Bytes into the serial line's send buffer, as many as there is room for. 17 bytes a sample and 24 a block go out: at
   4 kHz, 48 samples a block, 70 kB/s, which is USB or a line of 1 Mbit/s. */
size_t board_send(const uint8_t *bytes, size_t count)
{
    (void)bytes;
    return count;
}

/* Interrupts off and on, or of the sample clock's only. */
void board_lock(void)
{
}

void board_unlock(void)
{
}

/* A real knob needs nothing here; an amplifier's enable line could be closed. False if these settings cannot be kept. */
bool board_armed(const struct settings *settings)
{
    (void)settings;
    return true;
}

void board_started(void)
{
}

void board_passed(double part, bool ends)
{
    (void)part;
    (void)ends;
}

uint8_t board_simulate(const struct simulated *simulated)
{
    (void)simulated;
    return NOT_KNOWN;
}

uint8_t board_squeeze(const struct squeeze *squeeze)
{
    (void)squeeze;
    return NOT_KNOWN;
}

int main(void)
{
    /* Clocks, pins, converters, timer, serial line; the amplifier stays disabled. Start a hardware watchdog of some 10 ms
       that resets the machine, amplifier disabled, unless the loop below feeds it. */
    target_begin();
    for (;;) {
        target_serve();
    }
}
