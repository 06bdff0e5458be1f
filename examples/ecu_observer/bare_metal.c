/* The observer without an operating system and without a C library: it links with nothing else.
 *
 *     cc -ffreestanding -nostdlib -static bare_metal.c libdct_observer.a
 *
 * What a compiler expects of every target, memcpy and its kin, is here; on a control unit the vendor's
 * library has it. The end is Linux's exit, so that a test can see it: the one line to replace.
 */
#include "dct_observer.h"
#include <stddef.h>

void *memcpy(void *to, const void *from, size_t count)
{
    char *t = to;
    const char *f = from;
    while (count--)
        *t++ = *f++;
    return to;
}

void *memmove(void *to, const void *from, size_t count)
{
    char *t = to;
    const char *f = from;
    if (t <= f)
        return memcpy(to, from, count);
    while (count--)
        t[count] = f[count];
    return to;
}

void *memset(void *to, int value, size_t count)
{
    char *t = to;
    while (count--)
        *t++ = (char)value;
    return to;
}

int memcmp(const void *one, const void *other, size_t count)
{
    const unsigned char *a = one, *b = other;
    for (; count--; a++, b++)
        if (*a != *b)
            return *a < *b ? -1 : 1;
    return 0;
}

static dct_observer observer;
static dct_vehicle vehicle;
static dct_settings settings;
static dct_sample sample = {.gear = {1, 2}, .engine_speed = 90.0, .engine_torque = 60.0};
static dct_estimate estimate;

/* A second of a launch with clutch 1 half closed; 0 if every call went well. */
static int run(void)
{
    int32_t said = dct_table_1(&vehicle, &settings);
    said |= dct_observer_start(&observer, &vehicle, &settings, &sample, &estimate);
    sample.position[0] = 0.005;
    for (int k = 0; k < 1000; k++)
        said |= dct_observer_step(&observer, &sample, 0.001, &estimate);
    return said != DCT_OK || !(estimate.clutch_torque[0] > 0.0);
}

#if defined(__x86_64__)
#define REALIGN __attribute__((force_align_arg_pointer)) /* nobody called _start */
#define EXIT(status) __asm__ volatile("syscall" : : "a"(60L), "D"(status))
#elif defined(__aarch64__)
#define REALIGN
#define EXIT(status) \
    do { \
        register long number __asm__("x8") = 93, value __asm__("x0") = (status); \
        __asm__ volatile("svc 0" : : "r"(number), "r"(value)); \
    } while (0)
#elif defined(__arm__)
#define REALIGN
#define EXIT(status) \
    __asm__ volatile("mov r0, %0\n mov r7, #1\n svc 0" : : "r"(status) : "r0") /* r7 is lost: the end */
#else
#error "say how this processor ends a program"
#endif

REALIGN void _start(void)
{
    EXIT((long)run());
    for (;;)
        ;
}
