/* A process as a board: a pseudo-terminal that it opens itself, a thread as sample clock, a simulated knob.

   Prints the path of its pseudo-terminal as its first line, and ends when its standard input does, or on SIGTERM. SIGUSR1
   presses the emergency stop, SIGUSR2 lets go of it. Linux; runs its clock at real-time priority where it may. Compiled
   with -DSLOWER=N, its clock is N times slower than the computer's, so that a busy computer keeps up with it. */
#define _XOPEN_SOURCE 700
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/mman.h>
#include <sys/prctl.h>
#endif

#include "board.h"
#include "simulated_knob.h"
#include "target.h"

#ifndef SLOWER
#define SLOWER 1u
#endif

const struct identity board_identity = {SIMULATED_NATIVE_COUNTS, 40000u,
                                        SLOWER > 1u ? SIMULATED | OWN_TIME : SIMULATED, "hknob host"};

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t due_changed;
static uint64_t due = BOARD_NEVER;
static int terminal;
static volatile sig_atomic_t emergency, ended;

uint64_t board_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return ((uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec) / SLOWER;
}

uint32_t board_boot(void)
{
    /* Process numbers come round; with the time mixed in, not soon. */
    return (uint32_t)getpid() * 2654435761u ^ (uint32_t)(board_now_ns() >> 10);
}

void board_call_at(uint64_t time_ns)
{
    due = time_ns;
    pthread_cond_signal(&due_changed);
}

bool board_emergency(void)
{
    return emergency != 0;
}

void board_lock(void)
{
    pthread_mutex_lock(&mutex);
}

void board_unlock(void)
{
    pthread_mutex_unlock(&mutex);
}

size_t board_receive(uint8_t *bytes, size_t most)
{
    ssize_t count = read(terminal, bytes, most);
    return count > 0 ? (size_t)count : 0u;
}

size_t board_send(const uint8_t *bytes, size_t count)
{
    ssize_t sent = write(terminal, bytes, count);
    return sent > 0 ? (size_t)sent : 0u;
}

/* The sample clock: waits for the time of the next sample, or for another to be set, and holds the lock otherwise. */
static void *sample_clock(void *unused)
{
    (void)unused;
#ifdef __linux__
    prctl(PR_SET_TIMERSLACK, 1ul, 0ul, 0ul, 0ul);
#endif
    struct sched_param priority = {.sched_priority = 50};
    pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
    board_lock();
    for (;;) {
        if (due == BOARD_NEVER) {
            pthread_cond_wait(&due_changed, &mutex);
        } else if (board_now_ns() < due) {
            uint64_t there = due * SLOWER; /* by the computer's clock */
            struct timespec until = {.tv_sec = (time_t)(there / 1000000000u), .tv_nsec = (long)(there % 1000000000u)};
            pthread_cond_timedwait(&due_changed, &mutex, &until);
        } else {
            due = BOARD_NEVER;
            target_sample();
        }
    }
    return NULL;
}

static void on_signal(int number)
{
    if (number == SIGUSR1 || number == SIGUSR2) {
        emergency = number == SIGUSR1;
    } else {
        ended = 1;
    }
}

/* A pseudo-terminal that passes bytes as they are. Its other end stays open here too, so that it outlives the host. */
static bool open_terminal(void)
{
    terminal = posix_openpt(O_RDWR | O_NOCTTY);
    if (terminal < 0 || grantpt(terminal) != 0 || unlockpt(terminal) != 0) {
        return false;
    }
    const char *path = ptsname(terminal);
    int other = path ? open(path, O_RDWR | O_NOCTTY) : -1;
    struct termios raw;
    if (other < 0 || tcgetattr(other, &raw) != 0) {
        return false;
    }
    raw.c_iflag &= ~(tcflag_t)(BRKINT | ICRNL | IGNBRK | IGNCR | INLCR | INPCK | ISTRIP | IXON | PARMRK);
    raw.c_oflag &= ~(tcflag_t)OPOST;
    raw.c_lflag &= ~(tcflag_t)(ECHO | ECHONL | ICANON | IEXTEN | ISIG);
    raw.c_cflag = (raw.c_cflag & ~(tcflag_t)(CSIZE | PARENB)) | CS8;
    if (tcsetattr(other, TCSANOW, &raw) != 0 || fcntl(terminal, F_SETFL, O_NONBLOCK) != 0) {
        return false;
    }
    puts(path);
    return fflush(stdout) == 0;
}

static bool start_clock(void)
{
    pthread_t thread;
    pthread_condattr_t monotonic;
    return pthread_condattr_init(&monotonic) == 0 && pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC) == 0 &&
           pthread_cond_init(&due_changed, &monotonic) == 0 && pthread_create(&thread, NULL, sample_clock, NULL) == 0;
}

int main(void)
{
    const int signals[] = {SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGUSR2};
    struct sigaction action = {.sa_handler = on_signal};
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++) {
        sigaction(signals[i], &action, NULL);
    }
#ifdef __linux__
    mlockall(MCL_CURRENT | MCL_FUTURE);
#endif
    board_boot();
    if (!start_clock() || !open_terminal()) {
        perror("hknob target");
        return 1;
    }
    target_begin();
    while (!ended) {
        bool more = target_serve();
        struct pollfd ready[2] = {{.fd = terminal, .events = more ? POLLIN | POLLOUT : POLLIN}, {.fd = 0, .events = POLLIN}};
        if (poll(ready, 2, target_busy() ? 1 : 50) < 0 && errno != EINTR) {
            break;
        }
        char ignored[64];
        if (ready[1].revents != 0 && read(0, ignored, sizeof ignored) == 0) {
            break;
        }
    }
    return 0;
}
