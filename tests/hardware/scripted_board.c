/* A board that does what a test says: its time, encoder and serial line are variables. Built with the target's sources
   into a library that Python loads, or with stormy_line.c into a program. */
#include "scripted_board.h"

#include <string.h>

#include "board.h"
#include "plant.h"
#include "pulse.h"

const struct identity board_identity = {640000u, 40000u, SIMULATED, "scripted"};

uint64_t scripted_now, scripted_call_at = BOARD_NEVER;
int32_t scripted_angle;
double scripted_torque, scripted_grip, scripted_passed;
uint32_t scripted_samples, scripted_boot = 7u, scripted_trials, scripted_starts, scripted_locks;
uint8_t scripted_emergency, scripted_unable, scripted_in[65536], scripted_out[262144];
size_t scripted_in_count, scripted_in_at, scripted_out_count, scripted_out_room = sizeof scripted_out;

uint32_t board_boot(void)
{
    return scripted_boot;
}

uint64_t board_now_ns(void)
{
    return scripted_now;
}

void board_call_at(uint64_t time_ns)
{
    scripted_call_at = time_ns;
}

int32_t board_angle(void)
{
    return scripted_angle;
}

void board_torque(double torque_nm)
{
    scripted_torque = torque_nm;
}

double board_grip_n(void)
{
    return scripted_grip;
}

bool board_emergency(void)
{
    return scripted_emergency != 0u;
}

size_t board_receive(uint8_t *bytes, size_t most)
{
    size_t count = scripted_in_count - scripted_in_at;
    count = count < most ? count : most;
    memcpy(bytes, scripted_in + scripted_in_at, count);
    scripted_in_at += count;
    return count;
}

size_t board_send(const uint8_t *bytes, size_t count)
{
    size_t room = scripted_out_room - scripted_out_count;
    count = count < room ? count : room;
    memcpy(scripted_out + scripted_out_count, bytes, count);
    scripted_out_count += count;
    return count;
}

/* Odd while the lock is held; a lock taken twice would hang a real board. */
void board_lock(void)
{
    scripted_locks += scripted_locks % 2u == 0u ? 1u : 100000001u;
}

void board_unlock(void)
{
    scripted_locks += scripted_locks % 2u == 1u ? 1u : 100000001u;
}

bool board_armed(const struct settings *settings)
{
    (void)settings;
    scripted_trials += scripted_unable ? 0u : 1u;
    return scripted_unable == 0u;
}

void board_started(void)
{
    scripted_starts++;
}

void board_passed(double part, bool ends)
{
    scripted_passed += part;
    scripted_samples += ends ? 1u : 0u;
}

uint8_t board_simulate(const struct simulated *simulated)
{
    (void)simulated;
    return DONE;
}

uint8_t board_squeeze(const struct squeeze *squeeze)
{
    (void)squeeze;
    return DONE;
}

int scripted_follow(const struct simulated *person, double interval_s, size_t count, const double *torque_nm,
                    double *angle_rad, double *speed_rad_s)
{
    struct plant plant;
    if (!plant_begin(&plant, person, interval_s)) {
        return 0;
    }
    plant_start(&plant);
    for (size_t i = 0; i < count; i++) {
        angle_rad[i] = plant.angle;
        speed_rad_s[i] = plant.speed / interval_s;
        plant_advance(&plant, torque_nm[i], 1.0, true);
    }
    angle_rad[count] = plant.angle;
    speed_rad_s[count] = plant.speed / interval_s;
    return 1;
}

void scripted_person(const struct simulated *person, double interval_s, size_t count, double *push_nm, double *grip_n)
{
    struct plant plant;
    plant_begin(&plant, person, interval_s);
    plant_start(&plant);
    for (size_t i = 0; i < count; i++) {
        push_nm[i] = plant_push(&plant);
        grip_n[i] = plant_grip(&plant);
        plant_advance(&plant, 0.0, 1.0, true);
    }
}

int scripted_squeezed(const struct simulated *person, const struct squeeze *squeeze, const struct pulse *pulse,
                      double interval_s, size_t before, size_t count, double *angle_rad, double *torque_nm, double *grip_n)
{
    struct plant plant;
    struct pulse_state state = {0.0, 0u, 0u, 0u};
    if (!plant_begin(&plant, person, interval_s) || !plant_squeezed(&plant, squeeze)) {
        return 0;
    }
    for (size_t i = 0; i < before + count; i++) {
        if (i == before) {
            plant_start(&plant);
        }
        grip_n[i] = plant_grip(&plant);
        angle_rad[i] = plant_angle(&plant);
        torque_nm[i] = pulse_step(pulse, &state, (double)(float)grip_n[i], i >= before);
        plant_advance(&plant, torque_nm[i], 1.0, true);
    }
    return 1;
}
