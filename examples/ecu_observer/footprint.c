/* Measures the memory of one observer: its struct and, per method, the stack below the call of a start and of a step.
 *
 * The stack below this program's own frame is painted, a call is made, and the deepest byte that changed is looked for.
 * Run it on the processor that is meant: it needs printf only, and a stack of 64 KiB that grows downwards.
 */
#include "dct_observer.h"
#include <stdio.h>

#define DEPTH (48 * 1024)
#define PAINT 0xa5u

static dct_observer observer;
static dct_vehicle vehicle;
static dct_settings settings;
static dct_sample sample;
static dct_estimate estimate;

typedef int32_t (*call)(void);

static int32_t start(void)
{
    return dct_observer_start(&observer, &vehicle, &settings, &sample, &estimate);
}

static int32_t step(void)
{
    return dct_observer_step(&observer, &sample, 0.001, &estimate);
}

/* Bytes of stack that a call uses; 0: it was refused, or it used all that was painted. */
__attribute__((noinline)) static size_t used(call made)
{
    volatile unsigned char here = 0;
    uintptr_t top = (uintptr_t)&here - 256; /* below this frame and its red zone */
    for (uintptr_t at = top - DEPTH; at < top; at++)
        *(volatile unsigned char *)at = PAINT;
    if (made() != DCT_OK)
        return 0;
    uintptr_t deepest = top - DEPTH;
    while (deepest < top && *(volatile unsigned char *)deepest == PAINT)
        deepest++;
    return deepest == top - DEPTH ? 0 : (size_t)((uintptr_t)&here - deepest);
}

/* The largest of steps through an open, a slipping, a handing over and an engaged clutch. */
static size_t deepest_step(void)
{
    static const double drive[][4] = {/* clutch positions [m], clutch speeds [rad/s] */
        {0.0, 0.0, 0.0, 0.0}, {0.005, 0.0, 10.0, 6.4}, {0.005, 0.005, 40.0, 25.6}, {0.009, 0.0, 90.0, 57.6}};
    size_t most = 0;
    for (int k = 0; k < 400; k++) {
        const double *now = drive[k / 100];
        for (int i = 0; i < 2; i++) {
            sample.position[i] = now[i];
            sample.clutch_speed[i] = now[2 + i];
        }
        sample.wheel_speed = now[2] / 18.0;
        size_t bytes = used(step);
        if (bytes == 0)
            return 0;
        most = bytes > most ? bytes : most;
    }
    return most;
}

int main(void)
{
    printf("dct_observer,%zu\n", sizeof observer);
    for (int method = DCT_PAPER; method <= DCT_CALIBRATING; method++) {
        dct_table_1(&vehicle, &settings);
        settings.method = method;
        sample = (dct_sample){.gear = {1, 2}, .engine_speed = 90.0, .engine_torque = 60.0};
        size_t at_start = used(start), at_step = deepest_step();
        if (at_start == 0 || at_step == 0)
            return 1;
        printf("%d,%zu,%zu\n", method, at_start, at_step);
    }
    return 0;
}
