/* A Cortex-M3 as QEMU emulates it (machine mps2-an385, 25 MHz): a timer's interrupt as sample clock, a UART, a simulated
   knob. Registers: ARM, Cortex-M System Design Kit, "APB timer" and "APB UART". */
#include "board.h"
#include "simulated_knob.h"
#include "target.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define TICK_NS 40u

#define TIMER(offset) REGISTER(0x40000000u + (offset)) /* counts down to the next sample, once */
#define CLOCK(offset) REGISTER(0x40001000u + (offset)) /* counts down all the time */
#define CONTROL 0x0u
#define VALUE 0x4u
#define RELOAD 0x8u
#define INTERRUPT 0xcu

#define UART(offset) REGISTER(0x40004000u + (offset))
#define UART_DATA 0x0u
#define UART_STATE 0x4u
#define UART_CONTROL 0x8u
#define UART_INTERRUPT 0xcu
#define UART_BAUD_DIVIDER 0x10u
#define UART_SEND_FULL 1u
#define UART_RECEIVED 2u

#define INTERRUPT_ENABLE REGISTER(0xe000e100u)
#define SYSTICK_CONTROL REGISTER(0xe000e010u)
#define SYSTICK_RELOAD REGISTER(0xe000e014u)
#define UART_RECEIVE_LINE 0u
#define TIMER_LINE 8u

/* A word that whoever starts QEMU fills in anew: -device loader,addr=0x203ffff0,data=NUMBER,data-len=4. */
#define BOOT_WORD REGISTER(0x203ffff0u)

const struct identity board_identity = {SIMULATED_NATIVE_COUNTS, 250000u, SIMULATED | OWN_TIME, "hknob qemu m3"};

static uint64_t due = BOARD_NEVER;

uint32_t board_boot(void)
{
    return BOOT_WORD;
}

/* Ticks so far; interrupts off. The hardware's 32 bits come round after 171 s, and are read far more often. */
static uint64_t ticks(void)
{
    static uint64_t ticks_before;
    uint32_t now = ~CLOCK(VALUE);
    ticks_before += (uint32_t)(now - (uint32_t)ticks_before);
    return ticks_before;
}

uint64_t board_now_ns(void)
{
    uint32_t masked;
    __asm__ volatile("mrs %0, primask\n\tcpsid i" : "=r"(masked)::"memory");
    uint64_t now = ticks() * TICK_NS;
    __asm__ volatile("msr primask, %0" ::"r"(masked) : "memory");
    return now;
}

static void set_timer(void)
{
    TIMER(CONTROL) = 0u;
    if (due == BOARD_NEVER) {
        return;
    }
    uint64_t now = board_now_ns();
    /* Rounded up, so that it never calls early; at least one tick. A far sample is waited for in steps of a second. */
    uint64_t ahead = due > now ? (due - now + TICK_NS - 1u) / TICK_NS : 1u;
    TIMER(VALUE) = ahead < 25000000u ? (uint32_t)ahead : 25000000u;
    TIMER(CONTROL) = 9u; /* on, with interrupt; without a reload value it stops at zero */
}

void board_call_at(uint64_t time_ns)
{
    due = time_ns;
    set_timer();
}

void board_timer_interrupt(void);
void board_timer_interrupt(void)
{
    TIMER(INTERRUPT) = 1u;
    if (board_now_ns() < due) {
        set_timer();
        return;
    }
    due = BOARD_NEVER;
    target_sample();
}

/* A byte came, or the system tick: only to wake the main loop. */
void board_wake_interrupt(void);
void board_wake_interrupt(void)
{
    UART(UART_INTERRUPT) = 2u;
}

bool board_emergency(void)
{
    return false;
}

size_t board_receive(uint8_t *bytes, size_t most)
{
    size_t count = 0u;
    while (count < most && (UART(UART_STATE) & UART_RECEIVED) != 0u) {
        bytes[count++] = (uint8_t)UART(UART_DATA);
    }
    return count;
}

size_t board_send(const uint8_t *bytes, size_t count)
{
    size_t sent = 0u;
    while (sent < count && (UART(UART_STATE) & UART_SEND_FULL) == 0u) {
        UART(UART_DATA) = bytes[sent++];
    }
    return sent;
}

void board_lock(void)
{
    __asm__ volatile("cpsid i" ::: "memory");
}

void board_unlock(void)
{
    __asm__ volatile("cpsie i" ::: "memory");
}

int main(void)
{
    CLOCK(RELOAD) = 0xffffffffu;
    CLOCK(CONTROL) = 1u;
    TIMER(RELOAD) = 0u;
    UART(UART_BAUD_DIVIDER) = 16u;
    UART(UART_CONTROL) = 0xbu; /* send, receive, interrupt on receiving */
    SYSTICK_RELOAD = 25000u - 1u; /* 1 ms */
    SYSTICK_CONTROL = 7u;
    INTERRUPT_ENABLE = 1u << UART_RECEIVE_LINE | 1u << TIMER_LINE;
    target_begin();
    for (;;) {
        target_serve();
        board_lock(); /* a byte that comes after the look still ends the wait: an interrupt does, though it is held back */
        if ((UART(UART_STATE) & UART_RECEIVED) == 0u) {
            __asm__ volatile("wfi" ::: "memory");
        }
        board_unlock();
    }
}
