/* Measures FMU libraries through their C interface; benches/run.py calls it and judges.
 *
 *   driver time ROUNDS H INPUTS LIBRARY...    per round: CPU time of an exchange of each [ns]
 *   driver steps ROUNDS H INPUTS LIBRARY...   per library: least time of each exchange [ns]
 *   driver count H INPUTS LIBRARY             one run, for callgrind; prints the last outputs
 *   driver heap H INPUTS LIBRARY              heap calls in exchanges, bytes of instances
 *   driver start ROUNDS COUNT LIBRARY         per round: CPU time of a start, known and new [ns]
 */
#define _GNU_SOURCE
#include "heap.h"
#include "importer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double cpu_ns(void) {
    return 1e9 * seconds(CLOCK_PROCESS_CPUTIME_ID);
}

static void time_rounds(int rounds, const Inputs *in, int n, Library *l) {
    for (int round = 0; round < rounds; round++)
        for (int k = 0; k < n; k++) {
            double y[PORTS];
            fmi2Component c = library_start(&l[k]);
            double before = cpu_ns();
            run_exchanges(&l[k], c, in, y);
            double spent = cpu_ns() - before;
            l[k].free_instance(c);
            printf("%.3f%c", spent / in->steps, k + 1 < n ? ' ' : '\n');
        }
}

/* What reading the clock twice costs at least [s]. */
static double clock_cost(void) {
    double least = 1.0;
    for (int k = 0; k < 10000; k++) {
        double before = seconds(CLOCK_MONOTONIC), spent = seconds(CLOCK_MONOTONIC) - before;
        least = fmin(least, spent);
    }
    return least;
}

static void time_steps(int rounds, const Inputs *in, const Library *l) {
    double *least = malloc(sizeof *least * (size_t)in->steps), y[PORTS], cost = clock_cost();
    for (int step = 0; step < in->steps; step++)
        least[step] = INFINITY;
    for (int round = 0; round < rounds; round++) {
        fmi2Component c = library_start(l);
        for (int step = 0; step < in->steps; step++) {
            double before = seconds(CLOCK_MONOTONIC);
            run_exchange(l, c, in, step, y);
            least[step] = fmin(least[step], seconds(CLOCK_MONOTONIC) - before);
        }
        l->free_instance(c);
    }
    for (int step = 0; step < in->steps; step++)
        printf("%.1f%c", 1e9 * (least[step] - cost), step + 1 < in->steps ? ' ' : '\n');
    free(least);
}

static void count(const Inputs *in, const Library *l) {
    double y[PORTS];
    fmi2Component c = library_start(l);
    run_exchanges(l, c, in, y);
    l->free_instance(c);
    for (int k = 0; k < PORTS; k++)
        printf("%.17g%c", y[k], k + 1 < PORTS ? ' ' : '\n');
}

/* Brakes to a standstill, holds and lets go, each for the first time; returns the time after it. */
static double brake_and_release(const Inputs *in, const Library *l, fmi2Component c, double t) {
    enum { BRAKE = 4, WHEEL = 3, MOST = 60000 };
    double y[PORTS] = {0}, brake = 3000.0, push = 400.0;
    int held = 0;
    l->set_real(c, l->set + BRAKE, 1, &brake);
    for (int k = 0; k < MOST && held < 100; k++, t += in->h) {
        if (l->do_step(c, t, in->h, fmi2True) | l->get_real(c, l->get, PORTS, y))
            fail("a step with the brake failed", l->path);
        held += y[WHEEL] == 0.0;
    }
    brake = 0.0;
    l->set_real(c, l->set + BRAKE, 1, &brake);
    l->set_real(c, l->set, 1, &push);
    for (int k = 0; k < 1000; k++, t += in->h)
        if (l->do_step(c, t, in->h, fmi2True) | l->get_real(c, l->get, PORTS, y))
            fail("a step after the brake failed", l->path);
    if (!held)
        fail("the brake never held the wheels", l->path);
    return t;
}

/* Heap calls of a run, of a first stop by the brake, of steps of sizes that are new to the instance. */
static void count_heap_calls(const Inputs *in, const Library *l, fmi2Component c) {
    static const double NEW_STEPS[] = {2e-3, 5e-3, 1e-4, 1e-2, 3e-4, 7e-3};
    double y[PORTS], t = in->steps * in->h;
    long before = heap.calls;
    run_exchanges(l, c, in, y);
    printf("exchanges %ld\n", heap.calls - before);
    before = heap.calls;
    t = brake_and_release(in, l, c, t);
    printf("brake %ld\n", heap.calls - before);
    before = heap.calls;
    for (size_t k = 0; k < sizeof NEW_STEPS / sizeof *NEW_STEPS; t += NEW_STEPS[k++])
        if (l->do_step(c, t, NEW_STEPS[k], fmi2True))
            fail("a step of another size failed", l->path);
    printf("new_steps %ld\n", heap.calls - before);
}

/* Bytes of the first instance, what a second one adds to them, and one with another parameter. */
static void measure_heap(const Inputs *in, Library *l) {
    fmi2Component warm = library_start(l);
    l->free_instance(warm);
    long start = heap.bytes;
    fmi2Component first = library_start(l);
    long one = heap.bytes - start;
    fmi2Component second = library_start(l);
    long two = heap.bytes - start;
    l->start_value[l->starts - 1] *= 1.01;
    fmi2Component other = library_start(l);
    printf("first_bytes %ld\nkin_bytes %ld\n", one, two - one);
    printf("other_bytes %ld\n", heap.bytes - start - two);
    count_heap_calls(in, l, first);
    l->free_instance(other);
    l->free_instance(second);
    l->free_instance(first);
    printf("leaked_bytes %ld\n", heap.bytes - start);
}

/* CPU time of `count` starts, each with its last parameter moved by `shift` relative to the last. */
static double time_starts(Library *l, int count, double shift, fmi2Component *made) {
    double spent = 0.0, before = cpu_ns();
    for (int k = 0; k < count; k++) {
        l->start_value[l->starts - 1] *= 1.0 + shift;
        made[k] = library_start(l);
    }
    spent = cpu_ns() - before;
    for (int k = 0; k < count; k++)
        l->free_instance(made[k]);
    return spent / count;
}

static void start_rounds(int rounds, int count, Library *l) {
    fmi2Component *made = malloc(sizeof *made * (size_t)count), kept = library_start(l);
    time_starts(l, count, 0.0, made);
    for (int round = 0; round < rounds; round++) {
        double known = time_starts(l, count, 0.0, made);
        printf("%.1f %.1f\n", known, time_starts(l, count / 16, 1e-9, made));
        l->free_instance(kept);
        kept = library_start(l); /* the parameters of the next round's known starts */
    }
    l->free_instance(kept);
    free(made);
}

int main(int argc, char **argv) {
    enum { MOST = 8 };
    Library l[MOST];
    int rounds = argc > 3 ? atoi(argv[2]) : 0;
    if (argc > 5 && argc <= 5 + MOST && !strcmp(argv[1], "time")) {
        Inputs in = inputs_read(argv[4], atof(argv[3]));
        for (int k = 5; k < argc; k++)
            l[k - 5] = library_open(argv[k]);
        time_rounds(rounds, &in, argc - 5, l);
    } else if (argc > 5 && !strcmp(argv[1], "steps")) {
        Inputs in = inputs_read(argv[4], atof(argv[3]));
        for (int k = 5; k < argc; k++)
            l[0] = library_open(argv[k]), time_steps(rounds, &in, l);
    } else if (argc == 5 && (!strcmp(argv[1], "count") || !strcmp(argv[1], "heap"))) {
        Inputs in = inputs_read(argv[3], atof(argv[2]));
        l[0] = library_open(argv[4]);
        argv[1][0] == 'c' ? count(&in, l) : measure_heap(&in, l);
    } else if (argc == 5 && !strcmp(argv[1], "start")) {
        l[0] = library_open(argv[4]);
        start_rounds(rounds, atoi(argv[3]), l);
    } else {
        fail("see the head of main.c", "usage");
    }
    return 0;
}
