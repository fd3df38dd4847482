/* Start of a Cortex-M3: vectors, initial values of variables, then main(). */
#include <stddef.h>
#include <stdint.h>

extern uint32_t image_data[], data_begin[], data_end[], bss_begin[], bss_end[], stack_top[];

int main(void);
void board_timer_interrupt(void);
void board_wake_interrupt(void);
void reset(void);

/* Nothing that goes wrong leads on: the host sees silence. A board with a motor switches its torque off here. */
static void fault(void)
{
    for (;;) {
    }
}

void reset(void)
{
    const uint32_t *from = image_data;
    for (uint32_t *to = data_begin; to < data_end; to++) {
        *to = *from++;
    }
    for (uint32_t *to = bss_begin; to < bss_end; to++) {
        *to = 0u;
    }
    (void)main();
    fault();
}

/* The first words of the image: where the stack begins, then a function for each exception and interrupt. */
struct vectors {
    uint32_t *stack;
    void (*exceptions[15])(void);
    void (*interrupts[32])(void);
};

extern const struct vectors vectors;
__attribute__((section(".vectors"), used)) const struct vectors vectors = {
    stack_top,
    {reset, fault, fault, fault, fault, fault, NULL, NULL, NULL, NULL, fault, fault, NULL, fault, board_wake_interrupt},
    {[0] = board_wake_interrupt, [8] = board_timer_interrupt},
};
